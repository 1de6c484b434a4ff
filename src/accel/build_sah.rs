//! The builder for trees that are traced often: binned surface area heuristic, built 8-wide at once.
//!
//! ```text
//! children = [all triangles]
//! while fewer than 8: split the child of largest area at the best of its bin borders
//! leaf, or recurse, per child
//! ```
//!
//! Binning after Wald, *On Fast Construction of SAH-based Bounding Volume Hierarchies* (2007): triangles are counted into a few
//! equal bins of their box centres along each axis, and only bin borders are tried. Filling a wide node by splitting its largest
//! child is Embree's way; it needs no binary tree in between. Costs count blocks of four triangles, as the leaves hold them.
//!
//! *Robustness.* Centres that coincide are halved by count. Below [`SAH_DEPTH`] levels every split halves by count, and the
//! fullest child is split first: at least a factor of 4 per level, so no input reaches [`super::MAX_DEPTH`].
//! *Determinism.* The tree depends on the mesh alone: tasks and chunks are cut by size, never by threads.
//! *Cost.* About 20 bytes × log(n) of traffic per triangle and 32 bytes of scratch.

use super::assemble::{Branch, MAX_LEAF, Part, Piece, assemble};
use super::bvh::{BLOCK, Bvh, OutOfMemory, WIDTH, reserve};
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Bins per axis for large ranges; Wald 2007 finds no gain beyond.
const BINS: usize = 16;
/// Levels of the wide tree that are split by the heuristic.
const SAH_DEPTH: usize = 44;
/// Ranges above are split off as tasks of their own.
const TASK: usize = 4096;
/// Ranges above are binned in parallel, in chunks of this size.
const CHUNK: usize = 1 << 15;
/// Cost of a node and of a block. Equal, as measured by Embree for the same layout.
const NODE_COST: f64 = 1.0;
const BLOCK_COST: f64 = 1.0;

/// A triangle's box, 32 bytes. The number sits in the unused lane of `lo`.
#[derive(Clone, Copy)]
struct PrimRef {
    lo: Vec4,
    hi: Vec4,
}

impl PrimRef {
    #[inline]
    fn new(prim: u32, bounds: &Aabb) -> Self {
        Self { lo: bounds.lo.extend(f32::from_bits(prim)), hi: bounds.hi.extend(0.0) }
    }

    #[inline]
    fn prim(&self) -> u32 {
        self.lo.w.to_bits()
    }

    /// Twice the centre of the box; the fourth lane is meaningless.
    #[inline]
    fn center2(&self) -> Vec4 {
        self.lo + self.hi
    }
}

/// A box of four lanes, of which the last is meaningless.
#[derive(Clone, Copy)]
struct Box4 {
    lo: Vec4,
    hi: Vec4,
}

impl Box4 {
    const EMPTY: Box4 = Box4 { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline]
    fn grow(&mut self, lo: Vec4, hi: Vec4) {
        self.lo = self.lo.min(lo);
        self.hi = self.hi.max(hi);
    }

    #[inline]
    fn half_area(&self) -> f64 {
        let e = (self.hi - self.lo).max(Vec4::ZERO);
        f64::from(e.x * e.y + (e.y * e.z + e.z * e.x))
    }
}

/// Triangles `start..end` of the order, with the boxes around them and around their doubled centres.
#[derive(Clone, Copy)]
struct Range {
    start: usize,
    end: usize,
    bounds: Box4,
    centers: Box4,
}

impl Range {
    fn len(&self) -> usize {
        self.end - self.start
    }

    fn blocks(&self) -> f64 {
        self.len().div_ceil(BLOCK) as f64
    }
}

/// Builds the tree of all usable triangles of `mesh`. To be called inside the pool.
pub fn build_sah(mesh: &Mesh) -> Result<Bvh, OutOfMemory> {
    let count = mesh.triangles.len();
    let mut all: Vec<PrimRef> = reserve(count)?;
    (0..count as u32)
        .into_par_iter()
        .with_min_len(1024)
        .map(|prim| PrimRef::new(prim, &triangle_bounds(mesh.corners(prim))))
        .collect_into_vec(&mut all);
    let usable = |r: &PrimRef| r.lo.x <= r.hi.x;
    let dropped: Vec<u32> = all.iter().filter(|r| !usable(r)).map(|r| r.prim()).collect();
    if !dropped.is_empty() {
        all.retain(usable);
    }
    if all.is_empty() {
        return Ok(Bvh::from_topology(Vec::new(), Vec::new(), Vec::new(), dropped, count));
    }
    let root = range_of(&all, 0);
    let part = build_part(&mut all, root, 0);
    assemble(part, |i| all[i].prim(), dropped, mesh)
}

/// The range that starts at `start` of the order and holds `refs`.
fn range_of(refs: &[PrimRef], start: usize) -> Range {
    let fold = |refs: &[PrimRef]| {
        let (mut bounds, mut centers) = (Box4::EMPTY, Box4::EMPTY);
        for r in refs {
            bounds.grow(r.lo, r.hi);
            let c = r.center2();
            centers.grow(c, c);
        }
        (bounds, centers)
    };
    let join = |(mut b, mut c): (Box4, Box4), (ob, oc): (Box4, Box4)| {
        b.grow(ob.lo, ob.hi);
        c.grow(oc.lo, oc.hi);
        (b, c)
    };
    let (bounds, centers) = if refs.len() > 2 * CHUNK {
        refs.par_chunks(CHUNK).map(fold).reduce(|| (Box4::EMPTY, Box4::EMPTY), join)
    } else {
        fold(refs)
    };
    Range { start, end: start + refs.len(), bounds, centers }
}

/// Large ranges become branches with a task per child, others pieces.
fn build_part(refs: &mut [PrimRef], range: Range, depth: usize) -> Part {
    if range.len() <= TASK {
        let mut piece = Piece::default();
        build_node(&mut piece, refs, range, depth, None);
        return Part::Piece(piece);
    }
    let (children, count) = split_wide(refs, range, depth, None);
    let mut tasks = Vec::with_capacity(count);
    let mut rest = refs;
    for child in &children[..count] {
        let (these, others) = rest.split_at_mut(child.len());
        tasks.push((these, *child));
        rest = others;
    }
    let children = tasks
        .into_par_iter()
        .with_max_len(1)
        .map(|(refs, child)| match judge(refs, &child, depth + 1) {
            Verdict::Leaf => Part::Leaf { start: child.start, count: child.len() },
            Verdict::Node(_) => build_part(refs, child, depth + 1),
        })
        .collect();
    Part::Branch(Branch { children })
}

/// Appends the node of `range` and all below it. The recursion is bounded by the depth of the tree.
fn build_node(piece: &mut Piece, refs: &mut [PrimRef], range: Range, depth: usize, first: Option<Split>) -> usize {
    let node = piece.push_node();
    let (children, count) = split_wide(refs, range, depth, first);
    let mut rest = refs;
    for (lane, child) in children[..count].iter().enumerate() {
        let (these, others) = rest.split_at_mut(child.len());
        rest = others;
        match judge(these, child, depth + 1) {
            Verdict::Leaf => piece.set_leaf(node, lane, child.start, child.len()),
            Verdict::Node(found) => {
                let below = build_node(piece, these, *child, depth + 1, found);
                piece.set_node(node, lane, below);
            }
        }
    }
    node
}

/// Splits a range, whose triangles are `refs`, into up to eight, in the order of the triangles. `first` is the split of
/// the whole range if it has been found before.
fn split_wide(refs: &mut [PrimRef], range: Range, depth: usize, mut first: Option<Split>) -> ([Range; WIDTH], usize) {
    let mut children = [range; WIDTH];
    let mut count = 1;
    while count < WIDTH {
        let weight = |child: &Range| {
            if child.len() <= BLOCK {
                f64::NEG_INFINITY
            } else if depth >= SAH_DEPTH {
                child.len() as f64
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
        if child.len() <= BLOCK {
            break;
        }
        let these = &mut refs[child.start - range.start..child.end - range.start];
        let found = match first.take() {
            None if depth < SAH_DEPTH => find_split(these, &child),
            known => known,
        };
        let (left, right) = split(these, &child, found);
        children.copy_within(widest + 1..count, widest + 2);
        children[widest] = left;
        children[widest + 1] = right;
        count += 1;
    }
    (children, count)
}

/// What becomes of a child.
enum Verdict {
    Leaf,
    /// A node, and its first split if that is known already.
    Node(Option<Split>),
}

/// Whether a child is better left as a leaf than made a node.
fn judge(refs: &[PrimRef], range: &Range, depth: usize) -> Verdict {
    if range.len() <= BLOCK {
        return Verdict::Leaf;
    }
    if range.len() > MAX_LEAF || depth >= SAH_DEPTH {
        return Verdict::Node(None);
    }
    let found = find_split(refs, range);
    let area = range.bounds.half_area();
    let split = match &found {
        Some(split) if area > 0.0 => split.cost / area,
        // No split separates anything.
        _ => range.blocks(),
    };
    if BLOCK_COST * range.blocks() <= NODE_COST + BLOCK_COST * split { Verdict::Leaf } else { Verdict::Node(found) }
}

/// A bin border: triangles whose bin along `axis` is below `bin` go left.
struct Split {
    axis: usize,
    bin: u32,
    /// Sum over both sides of half area times blocks.
    cost: f64,
    map: BinMap,
}

/// How centres fall into bins. The same operations decide when counting and when dividing.
#[derive(Clone, Copy)]
struct BinMap {
    origin: Vec4,
    scale: Vec4,
    last: Vec4,
}

impl BinMap {
    /// None if the centres coincide (nearly, in the range of denormals).
    fn new(range: &Range, bins: usize) -> Option<Self> {
        let extent = (range.centers.hi - range.centers.lo).truncate();
        let scale = |e: f32| if e > 1e-30 { bins as f32 * 0.9999 / e } else { 0.0 };
        let scale = Vec3::new(scale(extent.x), scale(extent.y), scale(extent.z));
        (scale != Vec3::ZERO).then(|| Self {
            origin: range.centers.lo.truncate().extend(0.0),
            scale: scale.extend(0.0),
            last: Vec4::splat(bins as f32 - 1.0),
        })
    }

    /// The bins of a triangle along the three axes.
    #[inline]
    fn bins(&self, r: &PrimRef) -> [u32; 4] {
        // Rounding to an integer by way of the mantissa: vectorises, where a saturating cast does not.
        const MAGIC: f32 = (1 << 23) as f32;
        let position = ((r.center2() - self.origin) * self.scale - Vec4::splat(0.499)).max(Vec4::ZERO).min(self.last);
        (position + Vec4::splat(MAGIC)).to_array().map(|x| x.to_bits() & 0xff)
    }
}

/// Boxes and counts of the bins of all axes.
struct Bins {
    boxes: [[Box4; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Bins = Bins { boxes: [[Box4::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    fn add(mut self, refs: &[PrimRef], map: &BinMap) -> Self {
        for r in refs {
            let bins = map.bins(r);
            for (axis, bin) in bins[..3].iter().enumerate() {
                let bin = *bin as usize & (BINS - 1);
                self.boxes[axis][bin].grow(r.lo, r.hi);
                self.counts[axis][bin] += 1;
            }
        }
        self
    }

    fn merge(mut self, other: Bins) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                let from = &other.boxes[axis][bin];
                self.boxes[axis][bin].grow(from.lo, from.hi);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }
}

/// The cheapest bin border with triangles on both sides.
fn find_split(refs: &[PrimRef], range: &Range) -> Option<Split> {
    // Few triangles do not fill many bins: against 16 for all, +0.1 % cost and a fifth of the time saved (1.3 M triangles).
    let bins = (4 + refs.len() / 8).min(BINS);
    let map = BinMap::new(range, bins)?;
    let filled = if refs.len() > 2 * CHUNK {
        refs.par_chunks(CHUNK).map(|chunk| Bins::EMPTY.add(chunk, &map)).reduce(|| Bins::EMPTY, Bins::merge)
    } else {
        Bins::EMPTY.add(refs, &map)
    };
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        if map.scale[axis] == 0.0 {
            continue;
        }
        // From the right: cost of what lies at and beyond each border.
        let mut right = [0.0f64; BINS];
        let (mut bounds, mut count) = (Box4::EMPTY, 0usize);
        for bin in (1..bins).rev() {
            bounds.grow(filled.boxes[axis][bin].lo, filled.boxes[axis][bin].hi);
            count += filled.counts[axis][bin] as usize;
            right[bin] = bounds.half_area() * count.div_ceil(BLOCK) as f64;
        }
        let (mut bounds, mut count) = (Box4::EMPTY, 0usize);
        for (bin, right) in right.iter().enumerate().take(bins).skip(1) {
            bounds.grow(filled.boxes[axis][bin - 1].lo, filled.boxes[axis][bin - 1].hi);
            count += filled.counts[axis][bin - 1] as usize;
            if count == 0 || count == refs.len() {
                continue;
            }
            let cost = bounds.half_area() * count.div_ceil(BLOCK) as f64 + right;
            if best.as_ref().is_none_or(|b| cost < b.cost) {
                best = Some(Split { axis, bin: bin as u32, cost, map });
            }
        }
    }
    best
}

/// Divides a range of at least two triangles in two, neither empty: where it says, or by count.
fn split(refs: &mut [PrimRef], range: &Range, found: Option<Split>) -> (Range, Range) {
    let Some(found) = found else { return halve(refs, range) };
    let goes_left = |r: &PrimRef| found.map.bins(r)[found.axis] < found.bin;
    let mut sides = [(Box4::EMPTY, Box4::EMPTY); 2];
    let mut note = |side: usize, r: &PrimRef| {
        let (bounds, centers) = &mut sides[side];
        bounds.grow(r.lo, r.hi);
        let c = r.center2();
        centers.grow(c, c);
    };
    let (mut i, mut j) = (0, refs.len());
    loop {
        while i < j && goes_left(&refs[i]) {
            note(0, &refs[i]);
            i += 1;
        }
        while i < j && !goes_left(&refs[j - 1]) {
            note(1, &refs[j - 1]);
            j -= 1;
        }
        if i >= j {
            break;
        }
        refs.swap(i, j - 1);
    }
    let middle = range.start + i;
    (
        Range { start: range.start, end: middle, bounds: sides[0].0, centers: sides[0].1 },
        Range { start: middle, end: range.end, bounds: sides[1].0, centers: sides[1].1 },
    )
}

/// Divides by count, along the axis in which the centres spread most.
fn halve(refs: &mut [PrimRef], range: &Range) -> (Range, Range) {
    let extent = (range.centers.hi - range.centers.lo).truncate();
    let middle = refs.len() / 2;
    if extent.max_element() > 0.0 {
        let axis = extent.max_position();
        refs.select_nth_unstable_by(middle, |a, b| {
            a.center2()[axis].total_cmp(&b.center2()[axis]).then(a.prim().cmp(&b.prim()))
        });
    }
    let (left, right) = refs.split_at(middle);
    (range_of(left, range.start), range_of(right, range.start + middle))
}
