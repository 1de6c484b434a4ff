//! The builder for trees that are traced often: binned surface area heuristic, built 8-wide at once.
//!
//! ```text
//! children = [all triangles]
//! while fewer than 8: split the child of largest area at the best of its bin borders
//! leaf, or recurse, per child
//! ```
//!
//! Where a range is split is found by binning ([`super::binning`]), how it is divided is told in [`super::partition`]. Filling a wide node by splitting
//! its largest child is Embree's way; it needs no binary tree in between. Costs count blocks of four triangles, as the leaves hold them.
//!
//! *Robustness.* Centres that coincide are halved by count. Below [`SAH_DEPTH`] levels every split halves by count, and the
//! fullest child is split first: at least a factor of 4 per level, so no input reaches [`super::MAX_DEPTH`].
//! *Determinism.* The tree depends on the mesh alone: tasks and chunks are cut by size, never by threads.
//! *Cost.* 250–340 ns per triangle on a core where Embree 3.13 takes 360–490 (medium quality, the same meshes of 20 thousand to 1.3 million triangles); 32
//! bytes of scratch per triangle. What made it twice as fast as a plain loop per axis and triangle, most important first: all three axes of a border
//! evaluated as one vector; dividing without branches; boxes of ranges taken from the bins instead of the triangles; old memory used again; four triangles' boxes at a time.

use super::assemble::{MAX_LEAF, Part, Piece, assemble};
use super::binning::{Split, blocks_of, centers_of, find_split};
use super::block_loader::{EachBox, TakeBox};
use super::bvh::{BLOCK, Bvh, OutOfMemory, WIDTH};
use super::memory::filled;
use super::partition::{self, From, Scratch, Scratches, partition};
use super::prim_ref::{Box4, PrimRef};
use super::refit::SweepScratch;
use crate::memory::vec_of;
use crate::scene::Mesh;
use crate::simd::{self, Level};
use glam::Vec4;
use rayon::prelude::*;

/// Levels of the wide tree that are split by the heuristic.
pub(super) const SAH_DEPTH: usize = 44;
/// Ranges above are split off as tasks of their own.
pub(super) const TASK: usize = 4096;
/// Triangles per chunk of the first pass.
pub(super) const CHUNK: usize = 4096;
/// Cost of a node and of a block. Equal, as measured by Embree for the same layout.
pub(super) const NODE_COST: f32 = 1.0;
const BLOCK_COST: f32 = 1.0;

/// Triangles `start..end` of the order, with the box around them.
#[derive(Clone, Copy)]
struct Range {
    start: u32,
    end: u32,
    half_area: f32,
}

impl Range {
    fn new(start: usize, end: usize, bounds: &Box4) -> Self {
        Self { start: start as u32, end: end as u32, half_area: bounds.half_area() }
    }

    fn len(&self) -> usize {
        (self.end - self.start) as usize
    }
}

/// What a build works with, kept for the next one.
#[derive(Debug, Default)]
pub(super) struct SahScratch {
    refs: Vec<PrimRef>,
    scratches: Scratches,
    sweeps: SweepScratch,
}

impl SahScratch {
    pub(super) fn memory_bytes(&self) -> usize {
        self.refs.capacity() * size_of::<PrimRef>()
            + self.scratches.sum(Scratch::memory_bytes)
            + self.sweeps.memory_bytes()
    }
}

/// Builds the tree of all usable triangles of `mesh`. To be called inside the pool.
pub fn build_sah(mesh: &Mesh) -> Result<Bvh, OutOfMemory> {
    rebuild_sah(mesh, Bvh::default(), &mut SahScratch::default())
}

/// Likewise, in the memory of a former tree.
pub(super) fn rebuild_sah(mesh: &Mesh, old: Bvh, scratch: &mut SahScratch) -> Result<Bvh, OutOfMemory> {
    let count = mesh.triangles.len();
    let level = Level::detect();
    let mut all = filled(std::mem::take(&mut scratch.refs), count, PrimRef::EMPTY)?;
    all.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, refs)| {
        let (begin, end) = (chunk * CHUNK, chunk * CHUNK + refs.len());
        simd::run(level, EachBox { mesh, prims: begin..end, to: &mut Collect::new(refs, begin) });
    });
    let dropped = unusable(&all)?;
    if !dropped.is_empty() {
        all.retain(PrimRef::is_usable);
    }
    if all.is_empty() {
        return Ok(Bvh::of_nothing(dropped, count));
    }
    // The whole range is split in any case, so its area does not matter.
    let root = Range { start: 0, end: all.len() as u32, half_area: 0.0 };
    partition::prepare(&mut scratch.scratches)?;
    let builder = Builder { level, scratches: &scratch.scratches };
    let part = builder.part(&mut all, root, 0)?;
    let bvh = assemble(part, |i: usize| all[i].prim(), dropped, mesh, old, &mut scratch.sweeps);
    scratch.refs = all;
    bvh
}

/// The triangles of those that no ray can hit.
pub(super) fn unusable(refs: &[PrimRef]) -> Result<Vec<u32>, OutOfMemory> {
    let count = refs.par_iter().filter(|r| !r.is_usable()).count();
    let mut prims = vec_of(count)?;
    if count > 0 {
        prims.extend(refs.iter().filter(|r| !r.is_usable()).map(PrimRef::prim));
    }
    Ok(prims)
}

/// Writes boxes and numbers of the triangles from `begin` on.
pub(super) struct Collect<'a> {
    refs: &'a mut [PrimRef],
    begin: usize,
    next: usize,
}

impl<'a> Collect<'a> {
    pub(super) fn new(refs: &'a mut [PrimRef], begin: usize) -> Self {
        Self { refs, begin, next: 0 }
    }
}

impl TakeBox for Collect<'_> {
    #[inline(always)]
    fn take(&mut self, lo: Vec4, hi: Vec4) {
        self.refs[self.next] = PrimRef::new((self.begin + self.next) as u32, lo, hi);
        self.next += 1;
    }
}

struct Builder<'a> {
    level: Level,
    scratches: &'a Scratches,
}

impl Builder<'_> {
    /// Large ranges become branches with a task per child, others pieces.
    fn part(&self, refs: &mut [PrimRef], range: Range, depth: usize) -> Result<Part, OutOfMemory> {
        if range.len() <= TASK {
            let mut piece = Piece::with_room_for(range.len())?;
            self.scratches
                .at_one(|scratch| self.node(&mut piece, refs, &mut From::One(scratch), range, depth, None))?;
            return Ok(Part::Piece(piece));
        }
        let (children, count) = self.split_wide(refs, &mut From::Any(self.scratches), range, depth, None)?;
        let mut tasks = vec_of(count)?;
        let mut rest = refs;
        for child in &children[..count] {
            let (these, others) = rest.split_at_mut(child.len());
            tasks.push((these, *child));
            rest = others;
        }
        Part::branch(tasks, |(refs, child)| match self.judge(refs, &child, depth + 1) {
            Verdict::Leaf => Ok(Part::Leaf { start: child.start as usize, count: child.len() }),
            Verdict::Node(_) => self.part(refs, child, depth + 1),
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
        first: Option<Split>,
    ) -> Result<usize, OutOfMemory> {
        let node = piece.push_node()?;
        let (children, count) = self.split_wide(refs, scratch, range, depth, first)?;
        let mut rest = refs;
        for (lane, child) in children[..count].iter().enumerate() {
            let (these, others) = rest.split_at_mut(child.len());
            rest = others;
            match self.judge(these, child, depth + 1) {
                Verdict::Leaf => piece.set_leaf(node, lane, child.start as usize, child.len())?,
                Verdict::Node(found) => {
                    let below = self.node(piece, these, scratch, *child, depth + 1, found)?;
                    piece.set_node(node, lane, below);
                }
            }
        }
        Ok(node)
    }

    /// Splits a range, whose triangles are `refs`, into up to eight, in the order of the triangles. `first` is the split of
    /// the whole range if it has been found before.
    fn split_wide(
        &self,
        refs: &mut [PrimRef],
        scratch: &mut From<'_>,
        range: Range,
        depth: usize,
        mut first: Option<Split>,
    ) -> Result<([Range; WIDTH], usize), OutOfMemory> {
        let mut children = [range; WIDTH];
        let mut count = 1;
        while count < WIDTH {
            let weight = |child: &Range| {
                if child.len() <= BLOCK {
                    f32::NEG_INFINITY
                } else if depth >= SAH_DEPTH {
                    child.len() as f32
                } else {
                    child.half_area
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
            let (start, end) = (child.start as usize, child.end as usize);
            let these = &mut refs[start - range.start as usize..end - range.start as usize];
            let found = match first.take() {
                None if depth < SAH_DEPTH => find_split(self.level, these),
                known => known,
            };
            let (middle, [left, right]) = match found {
                Some(split) => (partition(self.level, these, scratch, &split)?, split.bounds),
                None => halve(self.level, these),
            };
            let middle = start + middle;
            children.copy_within(widest + 1..count, widest + 2);
            children[widest] = Range::new(start, middle, &left);
            children[widest + 1] = Range::new(middle, end, &right);
            count += 1;
        }
        Ok((children, count))
    }

    /// Whether a child is better left as a leaf than made a node.
    fn judge(&self, refs: &[PrimRef], range: &Range, depth: usize) -> Verdict {
        if range.len() <= BLOCK {
            return Verdict::Leaf;
        }
        if range.len() > MAX_LEAF || depth >= SAH_DEPTH {
            return Verdict::Node(None);
        }
        let found = find_split(self.level, refs);
        let blocks = blocks_of(range.len());
        let split = match &found {
            Some(split) if range.half_area > 0.0 => split.cost / range.half_area,
            // No split separates anything.
            _ => blocks,
        };
        if BLOCK_COST * blocks <= NODE_COST + BLOCK_COST * split { Verdict::Leaf } else { Verdict::Node(found) }
    }
}

/// Divides by count, along the axis in which the centres spread most, a range of at least two triangles.
pub(super) fn halve(level: Level, refs: &mut [PrimRef]) -> (usize, [Box4; 2]) {
    let extent = centers_of(level, refs).extent();
    let middle = refs.len() / 2;
    if extent.max_element() > 0.0 {
        let axis = extent.max_position();
        refs.select_nth_unstable_by(middle, |a, b| {
            a.center2()[axis].total_cmp(&b.center2()[axis]).then(a.prim().cmp(&b.prim()))
        });
    }
    (middle, [around(&refs[..middle]), around(&refs[middle..])])
}

/// The box around triangles.
pub(super) fn around(refs: &[PrimRef]) -> Box4 {
    refs.iter().fold(Box4::EMPTY, |mut all, r| {
        all.grow(r.bounds());
        all
    })
}

/// What becomes of a child.
enum Verdict {
    Leaf,
    /// A node, and its first split if that is known already.
    Node(Option<Split>),
}
