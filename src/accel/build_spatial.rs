//! The builder with spatial splits, for objects that are built once and traced for long.
//!
//! As [`super::build_sah`], but a range may also be split at a plane, triangles that reach through it being cut in two ([`super::spatial`]; Stich, Friedrich,
//! Dietrich 2009). That is tried where the boxes of the best object split overlap by more than [`OVERLAP`] of the root's
//! area, and done where it costs less. So long thin triangles and large ones among small ones no longer make boxes overlap.
//!
//! *Room.* There are at most [`MOST_REFERENCES`] references per triangle. The spare room belongs to ranges, as in Embree's builder: a split divides what is left of it
//! by the number of references, so that it does not depend on the order in which tasks run.
//! *Leaves.* Of several references to one triangle in a leaf one stays: a block must not hold a triangle twice but at its end.
//! *Where we differ.* Split planes are borders of 16 slices of the range's box on all three axes; blocks of four are counted, as everywhere here;
//! boxes of parts are padded by 1/8192 of their triangle, for hits that do not depend on the structure.
//!
//! *What it gives.* SAH cost against plain splits: 0.44 with beams or walls among clutter, 0.54 with a few large triangles among small ones, 0.89 in a soup of
//! triangles of a twentieth of the scene; nothing on smooth meshes, nor where needles fill all of space. *Cost.* 2 to 8 µs per triangle, five to twenty
//! times that of plain splits, most of it for slicing triangles.
//! *Tried.* 1.3 references per triangle: costs of 0.50 instead of 0.44; 2: 0.40–0.42. Asking for a gain of 1 %: nothing on beams, and 0.98 instead
//! of 0.89 on the soup; of 10 %: 0.57 instead of 0.45 on beams. A third of the range's area as least overlap: up to 2 % more cost.

use super::assemble::{MAX_LEAF, Order, Part, Piece, assemble};
use super::binning::{Split, blocks_of, find_split};
use super::block_loader::EachBox;
use super::build_sah::{CHUNK, Collect, NODE_COST, SAH_DEPTH, TASK, around, halve, unusable};
use super::bvh::{BLOCK, Bvh, OutOfMemory, WIDTH};
use super::memory::filled;
use super::partition::{self, From, Scratches, partition};
use super::prim_ref::{Box4, PrimRef};
use super::refit::SweepScratch;
use super::spatial::find_spatial_split;
use crate::memory::vec_of;
use crate::scene::Mesh;
use crate::simd::{self, Level};
use rayon::prelude::*;

/// References per triangle at most.
const MOST_REFERENCES: f64 = 1.5;
/// Share of the root's area by which the sides of an object split must overlap for a spatial split to be tried: the α of Stich et al.
const OVERLAP: f32 = 1e-5;
/// And of the range's own, as in Embree's builder, which has 0.1. Against 0: the same cost within 1 %, and a sphere, which gains nothing, in a third of the time.
const OVERLAP_OF_RANGE: f32 = 0.2;

/// References `start..start + count` of the order, with the box around them and room for more.
#[derive(Clone, Copy)]
struct Range {
    start: usize,
    count: usize,
    room: usize,
    bounds: Box4,
}

/// Builds the tree of all usable triangles of `mesh`. To be called inside the pool.
pub fn build_spatial(mesh: &Mesh) -> Result<Bvh, OutOfMemory> {
    let count = mesh.triangles.len();
    let level = Level::detect();
    let most = (count as f64 * MOST_REFERENCES) as usize;
    let mut all = filled(Vec::new(), most, PrimRef::EMPTY)?;
    all[..count].par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, refs)| {
        let (begin, end) = (chunk * CHUNK, chunk * CHUNK + refs.len());
        simd::run(level, EachBox { mesh, prims: begin..end, to: &mut Collect::new(refs, begin) });
    });
    let dropped = unusable(&all[..count])?;
    if !dropped.is_empty() {
        let mut next = 0;
        for i in 0..count {
            if all[i].is_usable() {
                all[next] = all[i];
                next += 1;
            }
        }
    }
    let usable = count - dropped.len();
    if usable == 0 {
        return Ok(Bvh::of_nothing(dropped, count));
    }
    let bounds = around(&all[..usable]);
    let root = Range { start: 0, count: usable, room: all.len(), bounds };
    let mut scratches = Scratches::default();
    partition::prepare(&mut scratches)?;
    let builder = Builder { mesh, level, least_overlap: bounds.half_area() * OVERLAP, scratches: &scratches };
    let part = builder.part(&mut all, root, 0)?;
    let mut bvh = assemble(part, Parts(&all), dropped, mesh, Bvh::default(), &mut SweepScratch::default())?;
    bvh.set_holds_parts();
    Ok(bvh)
}

/// References, whose boxes are those of parts.
struct Parts<'a>(&'a [PrimRef]);

impl Order for Parts<'_> {
    #[inline(always)]
    fn prim(&self, position: usize) -> u32 {
        self.0[position].prim()
    }

    #[inline(always)]
    fn part(&self, position: usize) -> Option<Box4> {
        Some(*self.0[position].bounds())
    }
}

struct Builder<'a> {
    mesh: &'a Mesh,
    level: Level,
    least_overlap: f32,
    scratches: &'a Scratches,
}

impl Builder<'_> {
    /// Large ranges become branches with a task per child, others pieces. `refs` is the room of the range.
    fn part(&self, refs: &mut [PrimRef], range: Range, depth: usize) -> Result<Part, OutOfMemory> {
        if range.count <= TASK {
            let mut piece = Piece::with_room_for(range.count)?;
            self.scratches.at_one(|scratch| self.node(&mut piece, refs, &mut From::One(scratch), range, depth))?;
            return Ok(Part::Piece(piece));
        }
        let (children, count) = self.split_wide(refs, &mut From::Any(self.scratches), range, depth)?;
        let mut tasks = vec_of(count)?;
        let mut rest = refs;
        for child in &children[..count] {
            let (these, others) = rest.split_at_mut(child.room);
            tasks.push((these, *child));
            rest = others;
        }
        Part::branch(tasks, |(refs, child): (&mut [PrimRef], Range)| {
            if self.is_leaf(&refs[..child.count], &child, depth + 1) {
                Ok(Part::Leaf { start: child.start, count: without_repetition(&mut refs[..child.count]) })
            } else {
                self.part(refs, child, depth + 1)
            }
        })
    }

    /// Appends the node of `range` and all below it. The recursion is bounded by the depth of the tree.
    fn node(
        &self,
        piece: &mut Piece,
        refs: &mut [PrimRef],
        scratch: &mut From<'_>,
        range: Range,
        depth: usize,
    ) -> Result<usize, OutOfMemory> {
        let node = piece.push_node()?;
        let (children, count) = self.split_wide(refs, scratch, range, depth)?;
        let mut rest = refs;
        for (lane, child) in children[..count].iter().enumerate() {
            let (these, others) = rest.split_at_mut(child.room);
            rest = others;
            if self.is_leaf(&these[..child.count], child, depth + 1) {
                piece.set_leaf(node, lane, child.start, without_repetition(&mut these[..child.count]))?;
            } else {
                let below = self.node(piece, these, scratch, *child, depth + 1)?;
                piece.set_node(node, lane, below);
            }
        }
        Ok(node)
    }

    /// Splits a range into up to eight.
    fn split_wide(
        &self,
        refs: &mut [PrimRef],
        scratch: &mut From<'_>,
        range: Range,
        depth: usize,
    ) -> Result<([Range; WIDTH], usize), OutOfMemory> {
        let mut children = [range; WIDTH];
        let mut count = 1;
        while count < WIDTH {
            let weight = |child: &Range| {
                if child.count <= BLOCK {
                    f32::NEG_INFINITY
                } else if depth >= SAH_DEPTH {
                    child.count as f32
                } else {
                    child.bounds.half_area()
                }
            };
            let mut widest = 0;
            for i in 1..count {
                if weight(&children[i]) > weight(&children[widest]) {
                    widest = i;
                }
            }
            let child = children[widest];
            if child.count <= BLOCK {
                break;
            }
            let at = child.start - range.start;
            let these = &mut refs[at..at + child.room];
            let [left, right] = self.split(these, scratch, child, depth)?;
            children.copy_within(widest + 1..count, widest + 2);
            children[widest] = left;
            children[widest + 1] = right;
            count += 1;
        }
        Ok((children, count))
    }

    /// Splits a range in two, of which the first keeps its place.
    fn split(
        &self,
        refs: &mut [PrimRef],
        scratch: &mut From<'_>,
        range: Range,
        depth: usize,
    ) -> Result<[Range; 2], OutOfMemory> {
        let live = &mut refs[..range.count];
        let found = if depth < SAH_DEPTH { find_split(self.level, live) } else { None };
        if depth < SAH_DEPTH && range.room > range.count && self.overlaps(found.as_ref(), &range.bounds) {
            let plane = find_spatial_split(self.mesh, live, &range.bounds);
            let cheaper = plane.filter(|plane| found.as_ref().is_none_or(|object| plane.cost < object.cost));
            if let Some(sides) = cheaper.and_then(|plane| plane.divide(self.mesh, live, range.room)) {
                let (left, right) = (sides.below.len(), sides.above.len());
                let start = left + share(range.room - left - right, left, right);
                refs[..left].copy_from_slice(&sides.below);
                refs[start..start + right].copy_from_slice(&sides.above);
                return Ok(range.divided(start, [(left, around(&sides.below)), (right, around(&sides.above))]));
            }
        }
        let (middle, bounds) = match found {
            Some(split) => (partition(self.level, live, scratch, &split)?, split.bounds),
            None => halve(self.level, live),
        };
        let right = range.count - middle;
        let start = middle + share(range.room - range.count, middle, right);
        refs.copy_within(middle..range.count, start);
        Ok(range.divided(start, [(middle, bounds[0]), (right, bounds[1])]))
    }

    /// Whether the sides of an object split have so much in common that a spatial split is worth trying.
    fn overlaps(&self, split: Option<&Split>, bounds: &Box4) -> bool {
        let least = self.least_overlap.max(bounds.half_area() * OVERLAP_OF_RANGE);
        split.is_none_or(|split| split.bounds[0].intersection(&split.bounds[1]).half_area() > least)
    }

    /// Whether a child is better left as a leaf than made a node.
    fn is_leaf(&self, refs: &[PrimRef], range: &Range, depth: usize) -> bool {
        if range.count <= BLOCK {
            return true;
        }
        if range.count > MAX_LEAF || depth >= SAH_DEPTH {
            return false;
        }
        let blocks = blocks_of(range.count);
        let area = range.bounds.half_area();
        let split = match find_split(self.level, refs) {
            Some(split) if area > 0.0 => split.cost / area,
            // No split separates anything.
            _ => blocks,
        };
        blocks <= NODE_COST + split
    }
}

impl Range {
    /// The ranges of a split: the first begins where this one does, the second `start` later.
    fn divided(&self, start: usize, [left, right]: [(usize, Box4); 2]) -> [Range; 2] {
        [
            Range { start: self.start, count: left.0, room: start, bounds: left.1 },
            Range { start: self.start + start, count: right.0, room: self.room - start, bounds: right.1 },
        ]
    }
}

/// The left side's share of spare room.
fn share(spare: usize, left: usize, right: usize) -> usize {
    (spare as u64 * left as u64 / (left + right) as u64) as usize
}

/// Makes one reference of those to the same triangle, and returns how many are left, at the front.
fn without_repetition(refs: &mut [PrimRef]) -> usize {
    refs.sort_unstable_by_key(PrimRef::prim);
    let mut last = 0;
    for i in 1..refs.len() {
        if refs[i].prim() == refs[last].prim() {
            refs[last] = refs[last].union(&refs[i]);
        } else {
            last += 1;
            refs[last] = refs[i];
        }
    }
    last + 1
}
