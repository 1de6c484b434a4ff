//! Building the object BSP, and sharing a bounded number of references among its cells.
//!
//! Where a cell is split is the matter of [`super::plane`]. The loop is depth first, with the references of the open cells on one stack. It is bounded in
//! depth by `8 + 1.3 log2 n` (Havran's rule), and in references by [`REFS_PER_TRIANGLE`]: *each cell has room for a number of them*. A cell that is split
//! gives its children the room for what they hold, and shares the rest in proportion to that. So a crowded corner uses up its own share and not that of the cells after
//! it, and 100,000 equal triangles cost linear time.
//!
//! A careful build cuts triangles at planes ([`cut_for_cells`]): a cell refers to those of which a part is in it or by the pad of parts beside it.
//! A fast build goes by boxes.
//!
//! *Cost.* n log n in practice; see [`super`] for figures. Boxes travel with their references, all axes of a border are evaluated as one vector, and
//! boxes are divided without branches.

use super::node::{BspNode, LEVELS};
use super::plane::{careful, fast};
use super::{BSP_MAX_DEPTH, BspTree, Quality};
use crate::accel::bvh::{BLOCK, ChildRef, MAX_LEAF_BLOCKS, WIDTH};
use crate::accel::corners::{Corners, block_of};
use crate::accel::prim_ref::PrimRef;
use crate::accel::spatial::cut_for_cells;
use crate::accel::{Aabb, triangle_bounds};
use crate::memory::{Room, collected, push};
use crate::simd::{self, Kernel, Level};
use glam::Vec4;

/// References of open cells and leaves together, per triangle. Ordinary meshes end with 3 to 5.
pub(super) const REFS_PER_TRIANGLE: usize = 12;
/// Splits in a row that leave a child with everything, before the cell is given up.
const FUTILE_SPLITS: u8 = 3;

/// Where a cell is in the tree: a plane of a node or, below the last level, a lane.
#[derive(Clone, Copy)]
struct Place {
    node: usize,
    level: usize,
    plane: usize,
    lane: usize,
}

impl Place {
    fn root_of(node: usize) -> Self {
        Self { node, level: 0, plane: 0, lane: 0 }
    }

    /// The places of both sides of its plane.
    fn sides(self) -> [Self; 2] {
        let Self { node, level, plane, lane } = self;
        let half = WIDTH >> (level + 1);
        [0, 1].map(|above| Self { node, level: level + 1, plane: 2 * plane + 1 + above, lane: lane + above * half })
    }
}

/// A cell still to be split; its references are the topmost of the stack.
struct Open {
    place: Place,
    first_ref: usize,
    cell: Aabb,
    depth: usize,
    futile: u8,
    /// References that it may hold, itself or all leaves below it.
    room: usize,
}

/// A tree being built.
struct Build {
    level: Level,
    quality: Quality,
    tree: BspTree,
    /// Of open cells, in the order of the stack of these. Boxes travel with their numbers: read in a row, where boxes elsewhere would be fetched one by one.
    open_refs: Vec<PrimRef>,
    /// The references of the lower side, while a cell is divided.
    lower: Vec<PrimRef>,
}

/// A tree over `triangles`, which come to lie in the order in which leaves refer to them first. Without memory for it they come back, in any order.
pub(super) fn build(triangles: Vec<Corners>, bounds: Aabb, quality: Quality) -> Result<BspTree, Vec<Corners>> {
    let tree = BspTree { triangles, ..BspTree::default() };
    let mut build = Build { level: Level::detect(), quality, tree, open_refs: Vec::new(), lower: Vec::new() };
    match build.run(bounds) {
        Some(()) => Ok(build.tree),
        None => Err(build.tree.triangles),
    }
}

impl Build {
    /// `None` when memory runs out.
    fn run(&mut self, bounds: Aabb) -> Option<()> {
        let n = self.tree.triangles.len();
        self.open_refs.try_reserve(n).ok()?;
        self.open_refs.extend((0..n as u32).zip(&self.tree.triangles).filter_map(|(index, triangle)| {
            let b = triangle_bounds(triangle.corners());
            (!b.is_empty()).then(|| PrimRef::new(index, b.lo.extend(0.0), b.hi.extend(0.0)))
        }));
        let max_depth = (8 + 13 * (n.max(1).ilog2() as usize + 1) / 10).min(BSP_MAX_DEPTH);
        let room = self.open_refs.len().checked_mul(REFS_PER_TRIANGLE)?;
        let root = self.add_node()?;
        let mut open =
            collected([Open { place: Place::root_of(root), first_ref: 0, cell: bounds, depth: 0, futile: 0, room }])
                .ok()?;
        while let Some(cell) = open.pop() {
            let split = if cell.depth < max_depth { self.split(&cell)? } else { None };
            match split {
                Some(sides) => {
                    open.room(sides.len()).ok()?;
                    open.extend(sides);
                }
                None => {
                    self.add_leaf(cell.place, cell.first_ref)?;
                    self.open_refs.truncate(cell.first_ref);
                }
            }
        }
        self.order_triangles()?;
        self.tree.nodes.shrink_to_fit();
        self.tree.blocks.shrink_to_fit();
        Some(())
    }

    /// Splits a cell, if that pays and there is room. Of both sides the lower comes last: it is handled next, and its references lie on top.
    fn split(&mut self, open: &Open) -> Option<Option<[Open; 2]>> {
        let &Open { first_ref, cell, depth, futile, room, .. } = open;
        let here = &self.open_refs[first_ref..];
        let count = here.len();
        let is_futile = |(below, above): (usize, usize)| below.max(above) == count && below.min(above) > 0;
        let both_sides = |(axis, plane): (usize, f32)| simd::run(self.level, Count { refs: here, axis, plane });
        let chosen = match self.quality {
            Quality::Sah => careful(self.level, here, &cell),
            Quality::Fast => match fast(self.level, here, &cell, depth, false) {
                // A sample may be of one kind only.
                Some((plane, true)) if is_futile(both_sides(plane)) => {
                    fast(self.level, here, &cell, depth, true).map(|(plane, _)| plane)
                }
                chosen => chosen.map(|(plane, _)| plane),
            },
        };
        let Some((axis, plane)) = chosen else { return Some(None) };
        let (below, above) = both_sides((axis, plane));
        let futile = if is_futile((below, above)) { futile + 1 } else { 0 };
        if below + above > room || futile == FUTILE_SPLITS {
            return Some(None);
        }

        if self.lower.len() < count {
            self.lower.try_reserve(count - self.lower.len()).ok()?;
            self.lower.resize(count, PrimRef::EMPTY);
        }
        let (below, above) = self.divide(first_ref, axis, plane);
        self.open_refs.truncate(first_ref + above);
        self.open_refs.try_reserve(below).ok()?;
        self.open_refs.extend_from_slice(&self.lower[..below]);

        let place = if open.place.level == LEVELS {
            let node = self.add_node()?;
            self.tree.nodes[open.place.node].set_child(open.place.lane, ChildRef::node(node));
            Place::root_of(node)
        } else {
            open.place
        };
        self.tree.nodes[place.node].set_plane(place.plane, plane);
        let (mut below_cell, mut above_cell) = (cell, cell);
        below_cell.hi[axis] = plane;
        above_cell.lo[axis] = plane;
        let spare = (room - below - above) as u128;
        let share = (spare * below as u128 / (below + above).max(1) as u128) as usize;
        let [lower, upper] = place.sides();
        let depth = depth + 1;
        let room_above = above + (spare as usize - share);
        Some(Some([
            Open { place: upper, first_ref, cell: above_cell, depth, futile, room: room_above },
            Open { place: lower, first_ref: first_ref + above, cell: below_cell, depth, futile, room: below + share },
        ]))
    }

    /// Leaves the references of a cell that are above a plane in their place, and copies those below to `lower`; says how many these and those are.
    fn divide(&mut self, first_ref: usize, axis: usize, plane: f32) -> (usize, usize) {
        let refs = &mut self.open_refs[first_ref..];
        if self.quality == Quality::Fast {
            return simd::run(self.level, Divide { refs, lower: &mut self.lower, axis, plane });
        }
        let (mut below, mut above) = (0, 0);
        for i in 0..refs.len() {
            let r = refs[i];
            let (lo, hi) = (r.bounds().lo()[axis], r.bounds().hi()[axis]);
            let mut parts = [r, r];
            if lo < plane && plane < hi {
                parts = cut_for_cells(self.tree.triangles[r.prim() as usize].corners(), &r, axis, plane);
                if parts.iter().all(|part| !part.is_usable()) {
                    parts = [r, r];
                }
            }
            let [lower_part, upper_part] = parts;
            // What is flat and in the plane is below it.
            if (lo < plane || hi <= plane) && lower_part.is_usable() {
                self.lower[below] = lower_part;
                below += 1;
            }
            if hi > plane && upper_part.is_usable() {
                refs[above] = upper_part;
                above += 1;
            }
        }
        (below, above)
    }

    fn add_node(&mut self) -> Option<usize> {
        let nodes = &mut self.tree.nodes;
        if nodes.len() >= ChildRef::MAX_INDEX {
            return None;
        }
        nodes.try_reserve(1).ok()?;
        nodes.push(BspNode::EMPTY);
        Some(nodes.len() - 1)
    }

    /// Makes a leaf of the references from `first` on, or leaves the lane empty if there are none.
    fn add_leaf(&mut self, place: Place, first: usize) -> Option<()> {
        let end = self.open_refs.len();
        const MOST: usize = MAX_LEAF_BLOCKS * BLOCK;
        if end - first <= MOST {
            return self.add_run(place, first..end);
        }
        // More than a lane leads to: a node without planes, all lanes of which are this cell.
        let mut pending = collected([(place, first..end)]).ok()?;
        while let Some((place, refs)) = pending.pop() {
            if refs.len() <= MOST {
                self.add_run(place, refs)?;
                continue;
            }
            let node = self.add_node()?;
            self.tree.nodes[place.node].set_child(place.lane, ChildRef::node(node));
            let part = refs.len().div_ceil(WIDTH).next_multiple_of(BLOCK).max(MOST);
            for (lane, start) in refs.clone().step_by(part).enumerate() {
                let place = Place { node, level: LEVELS, plane: 0, lane };
                push(&mut pending, (place, start..refs.end.min(start + part))).ok()?;
            }
        }
        Some(())
    }

    fn add_run(&mut self, place: Place, refs: std::ops::Range<usize>) -> Option<()> {
        if refs.is_empty() {
            return Some(());
        }
        let blocks = &mut self.tree.blocks;
        let (first, count) = (blocks.len(), refs.len().div_ceil(BLOCK));
        if first + count >= ChildRef::MAX_INDEX {
            return None;
        }
        blocks.try_reserve(count).ok()?;
        let mut prims = [0; MAX_LEAF_BLOCKS * BLOCK];
        for (prim, r) in prims.iter_mut().zip(&self.open_refs[refs.clone()]) {
            *prim = r.prim();
        }
        blocks.extend(prims[..refs.len()].chunks(BLOCK).map(block_of));
        self.tree.nodes[place.node].set_child(place.lane, ChildRef::leaf(first, count));
        Some(())
    }

    /// Orders the triangles as blocks refer to them first, so that those of a leaf lie together, and drops those that no leaf refers to.
    fn order_triangles(&mut self) -> Option<()> {
        let BspTree { blocks, triangles, .. } = &mut self.tree;
        const NEW: u32 = u32::MAX;
        let mut place: Vec<u32> = Vec::new();
        place.try_reserve_exact(triangles.len()).ok()?;
        place.resize(triangles.len(), NEW);
        let mut used = 0;
        for index in blocks.as_flattened_mut() {
            let place = &mut place[*index as usize];
            if *place == NEW {
                *place = used;
                used += 1;
            }
            *index = *place;
        }
        let unused = place.iter_mut().filter(|place| **place == NEW);
        for (place, next) in unused.zip(used..) {
            *place = next;
        }
        for i in 0..triangles.len() {
            while place[i] as usize != i {
                let to = place[i] as usize;
                triangles.swap(i, to);
                place.swap(i, to);
            }
        }
        triangles.truncate(used as usize);
        Some(())
    }
}

// Boxes are never flat, so each goes at least one way. Touching the plane is not reaching beyond it: such a box has its interval on its own side
// of the plane's distance.

/// How many boxes reach below the plane, and how many above it.
struct Count<'a> {
    refs: &'a [PrimRef],
    axis: usize,
    plane: f32,
}

impl Kernel for Count<'_> {
    type Output = (usize, usize);

    #[inline(always)]
    fn run(self) -> (usize, usize) {
        let plane = Vec4::splat(self.plane);
        let (mut below, mut above) = (0, 0);
        for r in self.refs {
            below += (r.bounds().lo().cmplt(plane).bitmask() >> self.axis & 1) as usize;
            above += (r.bounds().hi().cmpgt(plane).bitmask() >> self.axis & 1) as usize;
        }
        (below, above)
    }
}

/// Leaves the boxes that reach above the plane, in their order, and copies those that reach below it. Without branches: which way a box
/// goes is hard to predict. Returns how many were copied, and are left.
struct Divide<'a> {
    refs: &'a mut [PrimRef],
    lower: &'a mut [PrimRef],
    axis: usize,
    plane: f32,
}

impl Kernel for Divide<'_> {
    type Output = (usize, usize);

    #[inline(always)]
    fn run(self) -> (usize, usize) {
        let Self { refs, lower, axis, plane } = self;
        let plane = Vec4::splat(plane);
        let (mut below, mut above) = (0, 0);
        for i in 0..refs.len() {
            let r = refs[i];
            refs[above] = r;
            lower[below] = r;
            below += (r.bounds().lo().cmplt(plane).bitmask() >> axis & 1) as usize;
            above += (r.bounds().hi().cmpgt(plane).bitmask() >> axis & 1) as usize;
        }
        (below, above)
    }
}
