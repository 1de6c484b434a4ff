//! The builder for meshes that are built anew every frame: Morton order, then splits where the highest bit changes.
//!
//! After Lauterbach et al., *Fast BVH Construction on GPUs* (2009), and Pantaleoni and Luebke, *HLBVH* (2010): triangles are sorted along
//! a space-filling curve by the bits of their box centre; a range of the sorted order is a cell of an implicit octree, and is
//! split at the first position whose code has the highest differing bit set. Three such splits give eight children,
//! so the wide node is built directly. Boxes are filled by the refit pass.
//!
//! Codes have 10 bits per axis, in a 64-bit word with the triangle's number below, sorted by a radix sort of 3 passes.
//! A mesh of more than 2^20 triangles has several in a finest cell only where it is very uneven; cells with more
//! triangles than a leaf takes are halved by count.

use super::assemble::{Branch, Part, Piece, assemble};
use super::bvh::{BLOCK, Bvh, OutOfMemory, WIDTH, reserve};
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use glam::Vec3;
use rayon::prelude::*;

/// Bits per axis.
const BITS: u32 = 10;
/// Ranges above are split off as tasks of their own.
const TASK: usize = 4096;
/// Triangles per chunk of the parallel passes.
const CHUNK: usize = 1 << 14;
/// Bits per pass of the radix sort: 3 passes, and a table that stays in the first-level cache.
const DIGIT: u32 = 10;

/// Ranges up to this are left as leaves when a node has no lane to spare: a node for two blocks costs as much as a block.
const LEAF: usize = 2 * BLOCK;
/// Ranges up to this are split where it costs no block: a tenth of the memory for +1 % of cost. At 16: +3 %.
const FILL: usize = 2 * BLOCK;

/// Code above, triangle number below.
type Key = u64;

/// Builds the tree of all usable triangles of `mesh`. To be called inside the pool.
pub fn build_fast(mesh: &Mesh) -> Result<Bvh, OutOfMemory> {
    let count = mesh.triangles.len();
    let mut centers: Vec<Vec3> = reserve(count)?;
    (0..count as u32)
        .into_par_iter()
        .with_min_len(1024)
        .map(|prim| {
            let bounds = triangle_bounds(mesh.corners(prim));
            if bounds.is_empty() { Vec3::NAN } else { bounds.center() }
        })
        .collect_into_vec(&mut centers);
    let around = centers
        .par_chunks(CHUNK)
        .map(|chunk| {
            chunk.iter().fold(Aabb::EMPTY, |mut all, c| {
                if !c.x.is_nan() {
                    all.grow(*c);
                }
                all
            })
        })
        .reduce(|| Aabb::EMPTY, Aabb::union);
    let mut dropped: Vec<u32> = Vec::new();
    if around.is_empty() {
        dropped.extend(0..count as u32);
        return Ok(Bvh::from_topology(Vec::new(), Vec::new(), Vec::new(), dropped, count));
    }

    // One scale for all axes keeps the cells cubes; the curve then follows space, not the box.
    let extent = around.extent().max_element();
    let scale = if extent > 1e-30 { ((1 << BITS) as f32 * 0.9999) / extent } else { 0.0 };
    let key = |prim: usize| -> Key {
        let center = centers[prim];
        let cell = (center - around.lo) * scale;
        // Saturating casts: rounding cannot leave the range, and NaN becomes 0.
        let last = (1 << BITS) - 1;
        let spread = |x: f32| spread3((x as u32).min(last));
        let code = spread(cell.x) << 2 | spread(cell.y) << 1 | spread(cell.z);
        u64::from(code) << 32 | prim as u64
    };
    let mut keys: Vec<Key> = reserve(count)?;
    (0..count).into_par_iter().with_min_len(1024).map(key).collect_into_vec(&mut keys);
    dropped.extend((0..count as u32).filter(|&prim| centers[prim as usize].x.is_nan()));
    if !dropped.is_empty() {
        keys.retain(|&key| !centers[key as u32 as usize].x.is_nan());
    }
    drop(centers);
    let keys = radix_sort(keys)?;
    let part = build_part(&keys, 0);
    assemble(part, |i| keys[i] as u32, dropped, mesh)
}

/// Puts two zero bits between the ten lowest bits.
#[inline]
fn spread3(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Sorts by code, stably, least significant digit first.
fn radix_sort(mut keys: Vec<Key>) -> Result<Vec<Key>, OutOfMemory> {
    if keys.len() < 2 * CHUNK {
        keys.sort_unstable();
        return Ok(keys);
    }
    let mut other: Vec<Key> = reserve(keys.len())?;
    other.resize(keys.len(), 0);
    for pass in 0..(3 * BITS).div_ceil(DIGIT) {
        radix_pass(&keys, &mut other, 32 + pass * DIGIT);
        std::mem::swap(&mut keys, &mut other);
    }
    Ok(keys)
}

/// Scatters `from` to `to` in the order of one digit. Each chunk counts its digits; prefix sums tell it where in `to` its
/// keys of a digit go, and these places are disjoint slices.
fn radix_pass(from: &[Key], to: &mut [Key], shift: u32) {
    const BUCKETS: usize = 1 << DIGIT;
    let digit = |key: Key| (key >> shift) as usize & (BUCKETS - 1);
    // Few large chunks: each has a slice per bucket.
    let chunk = from.len().div_ceil(16).max(CHUNK);
    let counts: Vec<Vec<u32>> = from
        .par_chunks(chunk)
        .map(|keys| {
            let mut counts = vec![0u32; BUCKETS];
            for &key in keys {
                counts[digit(key)] += 1;
            }
            counts
        })
        .collect();
    let mut places: Vec<Vec<std::slice::IterMut<'_, Key>>> =
        counts.iter().map(|_| Vec::with_capacity(BUCKETS)).collect();
    let mut rest = to;
    for bucket in 0..BUCKETS {
        for (counts, places) in counts.iter().zip(&mut places) {
            let (these, others) = rest.split_at_mut(counts[bucket] as usize);
            places.push(these.iter_mut());
            rest = others;
        }
    }
    from.par_chunks(chunk).zip(places).for_each(|(keys, mut places)| {
        for &key in keys {
            *places[digit(key)].next().expect("the digits were counted") = key;
        }
    });
}

/// Large ranges become branches with a task per child, others pieces.
fn build_part(keys: &[Key], start: usize) -> Part {
    if keys.len() <= LEAF {
        return Part::Leaf { start, count: keys.len() };
    }
    if keys.len() <= TASK {
        let mut piece = Piece::default();
        build_node(&mut piece, keys, start);
        return Part::Piece(piece);
    }
    let (borders, count) = split_wide(keys);
    let children = (0..count)
        .into_par_iter()
        .with_max_len(1)
        .map(|lane| build_part(&keys[borders[lane]..borders[lane + 1]], start + borders[lane]))
        .collect();
    Part::Branch(Branch { children })
}

/// Appends the node of a range and all below it. Every level consumes code bits or halves the count, which bounds the recursion.
fn build_node(piece: &mut Piece, keys: &[Key], start: usize) -> usize {
    let node = piece.push_node();
    let (borders, count) = split_wide(keys);
    for lane in 0..count {
        let (begin, end) = (borders[lane], borders[lane + 1]);
        if end - begin <= LEAF {
            piece.set_leaf(node, lane, start + begin, end - begin);
        } else {
            let below = build_node(piece, &keys[begin..end], start + begin);
            piece.set_node(node, lane, below);
        }
    }
    node
}

/// Borders of up to eight children: three rounds that split every part which is too large for a leaf.
fn split_wide(keys: &[Key]) -> ([usize; WIDTH + 1], usize) {
    let mut borders = [0; WIDTH + 1];
    borders[1] = keys.len();
    let mut count = 1;
    while count < WIDTH {
        // The fullest part: small ones are leaves soon anyway.
        let fullest = (0..count).max_by_key(|&i| (borders[i + 1] - borders[i], WIDTH - i)).expect("there is a part");
        let (begin, end) = (borders[fullest], borders[fullest + 1]);
        if end - begin <= BLOCK {
            break;
        }
        let middle = begin + split(&keys[begin..end]);
        borders.copy_within(fullest + 1..=count, fullest + 2);
        borders[fullest + 1] = middle;
        count += 1;
    }
    (borders, count)
}

/// The first key that has the highest differing bit set, or the middle when all codes are equal.
fn split(keys: &[Key]) -> usize {
    let (first, last) = (keys[0] >> 32, keys[keys.len() - 1] >> 32);
    if first == last {
        return keys.len() / 2;
    }
    let bit = 63 - (first ^ last).leading_zeros();
    let at = keys.partition_point(|key| key >> 32 >> bit & 1 == 0);
    if keys.len() > FILL {
        return at;
    }
    fill_blocks(keys.len(), at)
}

/// The split nearest to `at` that costs no block: at a multiple of the block from either end.
fn fill_blocks(count: usize, at: usize) -> usize {
    let down = |x: usize| x / BLOCK * BLOCK;
    let up = |x: usize| x.next_multiple_of(BLOCK);
    let rest = count - at;
    [down(at), up(at), count - down(rest), count.saturating_sub(up(rest))]
        .into_iter()
        .filter(|&k| k > 0 && k < count)
        .min_by_key(|&k| k.abs_diff(at))
        .unwrap_or(at)
}
