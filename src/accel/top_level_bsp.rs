//! The top-level BSP over the world-space boxes of instances, rebuilt every frame (Wald03 §4.5).
//!
//! The plane of a cell is chosen exactly as the paper does: in the dimension of the cell's largest extent that has a box
//! border inside the cell; on the side of the cell's middle that more instances reach into; there the border nearest to the middle. So it lies
//! between the cell's centre and the object median. Each split takes at least one border from both children, so splitting ends by itself.
//!
//! Where we differ: the paper splits until no border is left, which for n mutually overlapping boxes makes O(n³) cells. Here
//! cells are split level by level, and a cell stays whole when its children would exceed the budget of
//! [`REFS_PER_INSTANCE`] references per instance, or at depth [`TOP_MAX_DEPTH`]. Level by level, so that the budget
//! is spent evenly over the scene and not in its first corner. A single instance, and a cell that its instances
//! all fill, is a leaf at once.
//!
//! A box that only touches a plane lies on its own side of it (see [`super::bsp`]); a flat box in the plane goes below.
//! All memory is kept from frame to frame. Cost: n log n for scenes whose instances are mostly apart.

use super::Aabb;
use super::bvh::OutOfMemory;
use std::ops::Range;

/// Planes on a path from the root at most; bounds the traversal stack.
pub const TOP_MAX_DEPTH: usize = 64;

/// References of open cells and leaves together, per instance. On forests of overlapping trees (161 to 10,000) 6, 12, 32 and 100
/// trace equally fast, within noise: where boxes overlap a ray has to visit them all. Build time grows in proportion.
const REFS_PER_INSTANCE: usize = 8;

/// An inner node or a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TopNode {
    /// A plane; the upper child follows the lower one.
    Inner { axis: u8, plane: f32, lower: u32 },
    /// A run of [`TopLevelBsp::refs`].
    Leaf { first: u32, count: u32 },
}

/// The tree. Node 0 is the root; empty when there is nothing to hit.
#[derive(Debug)]
pub struct TopLevelBsp {
    nodes: Vec<TopNode>,
    refs: Vec<u32>,
    bounds: Aabb,
    workspace: Workspace,
}

/// The cells of one level of the tree, and those of the next.
#[derive(Debug, Default)]
struct Workspace {
    level: Level,
    next: Level,
}

#[derive(Debug, Default)]
struct Level {
    cells: Vec<Cell>,
    refs: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Cell {
    node: usize,
    refs: Range<usize>,
    voxel: Aabb,
}

impl Default for TopLevelBsp {
    fn default() -> Self {
        Self { nodes: Vec::new(), refs: Vec::new(), bounds: Aabb::EMPTY, workspace: Workspace::default() }
    }
}

impl TopLevelBsp {
    #[inline(always)]
    pub fn nodes(&self) -> &[TopNode] {
        &self.nodes
    }

    /// Numbers of boxes, by leaf.
    #[inline(always)]
    pub fn refs(&self) -> &[u32] {
        &self.refs
    }

    /// The box around all boxes.
    #[inline(always)]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Bytes held, workspace included.
    pub fn memory_bytes(&self) -> usize {
        let level = |l: &Level| l.cells.capacity() * size_of::<Cell>() + l.refs.capacity() * size_of::<u32>();
        self.nodes.capacity() * size_of::<TopNode>()
            + self.refs.capacity() * size_of::<u32>()
            + level(&self.workspace.level)
            + level(&self.workspace.next)
    }

    /// Builds the tree anew over the boxes `box_of(i)` for the numbers `i` in `items`; all finite, none empty.
    ///
    /// # Errors
    /// No memory for the references; the tree is then empty.
    pub fn build(&mut self, items: &[u32], box_of: impl Fn(u32) -> Aabb) -> Result<(), OutOfMemory> {
        let Self { nodes, refs, bounds, workspace: Workspace { level, next } } = self;
        nodes.clear();
        refs.clear();
        level.clear();
        next.clear();
        let count = items.len();
        *bounds = items.iter().fold(Aabb::EMPTY, |all, &i| all.union(box_of(i)));
        if count == 0 {
            return Ok(());
        }
        let budget = count.saturating_mul(REFS_PER_INSTANCE);
        // A cell may write the references of both children before it learns that they are over the budget.
        let bytes = budget.saturating_mul(3 * size_of::<u32>());
        let reserved = refs.try_reserve(budget).and(level.refs.try_reserve(budget));
        let reserved = reserved.and(nodes.try_reserve(1)).and(level.cells.try_reserve(1));
        reserved.and(next.refs.try_reserve(budget + 2 * count)).map_err(|_| OutOfMemory { bytes })?;
        level.refs.extend_from_slice(items);
        level.cells.push(Cell { node: 0, refs: 0..count, voxel: *bounds });
        nodes.push(TopNode::Leaf { first: 0, count: 0 });
        // References that are not in `next`: leaves, and the cells of this level still to come.
        let mut kept = count;

        for depth in 0.. {
            for cell in &level.cells {
                let here = &level.refs[cell.refs.clone()];
                let plane = if here.len() < 2 || depth == TOP_MAX_DEPTH {
                    None
                } else {
                    split_plane(here, &cell.voxel, &box_of)
                };
                let split = plane.and_then(|(axis, plane)| {
                    let lower = next.push_side(here, |i| is_below(&box_of(i), axis, plane));
                    let upper = next.push_side(here, |i| box_of(i).hi[axis] > plane);
                    let fits = kept - here.len() + next.refs.len() <= budget
                        && nodes.try_reserve(2).is_ok()
                        && next.cells.try_reserve(2).is_ok();
                    if !fits {
                        next.refs.truncate(lower.start);
                    }
                    fits.then_some((axis, plane, lower, upper))
                });
                let Some((axis, plane, lower, upper)) = split else {
                    nodes[cell.node] = TopNode::Leaf { first: refs.len() as u32, count: here.len() as u32 };
                    refs.extend_from_slice(here);
                    continue;
                };
                kept -= here.len();
                let child = nodes.len();
                nodes[cell.node] = TopNode::Inner { axis: axis as u8, plane, lower: child as u32 };
                nodes.extend([TopNode::Leaf { first: 0, count: 0 }; 2]);
                let (mut below, mut above) = (cell.voxel, cell.voxel);
                below.hi[axis] = plane;
                above.lo[axis] = plane;
                next.cells.push(Cell { node: child, refs: lower, voxel: below });
                next.cells.push(Cell { node: child + 1, refs: upper, voxel: above });
            }
            if next.cells.is_empty() {
                break;
            }
            kept += next.refs.len();
            std::mem::swap(level, next);
            next.clear();
        }
        Ok(())
    }
}

impl Level {
    fn clear(&mut self) {
        self.cells.clear();
        self.refs.clear();
    }

    fn push_side(&mut self, from: &[u32], belongs: impl Fn(u32) -> bool) -> Range<usize> {
        let start = self.refs.len();
        self.refs.extend(from.iter().copied().filter(|&i| belongs(i)));
        start..self.refs.len()
    }
}

/// Whether a box reaches below the plane; a flat one in the plane does.
#[inline]
fn is_below(aabb: &Aabb, axis: usize, plane: f32) -> bool {
    aabb.lo[axis] < plane || aabb.hi[axis] <= plane
}

/// The rule of Wald03 §4.5.
fn split_plane(refs: &[u32], voxel: &Aabb, box_of: &impl Fn(u32) -> Aabb) -> Option<(usize, f32)> {
    let extent = voxel.extent();
    let mut axes = [0, 1, 2];
    axes.sort_unstable_by(|&a, &b| extent[b].total_cmp(&extent[a]));
    for axis in axes {
        let (lo, hi, center) = (voxel.lo[axis], voxel.hi[axis], voxel.center()[axis]);
        let (mut on_left, mut on_right) = (0usize, 0usize);
        // Borders strictly inside the cell, nearest to the middle: the largest below it, and the smallest that is not.
        let (mut left, mut right) = (f32::NEG_INFINITY, f32::INFINITY);
        for &i in refs {
            let b = box_of(i);
            on_left += usize::from(b.lo[axis] < center);
            on_right += usize::from(b.hi[axis] >= center);
            for border in [b.lo[axis], b.hi[axis]] {
                if border > lo && border < hi {
                    if border < center {
                        left = left.max(border);
                    } else {
                        right = right.min(border);
                    }
                }
            }
        }
        // Borders may all lie on the side with fewer instances: then the nearest of those.
        let plane = match (left > f32::NEG_INFINITY, right < f32::INFINITY) {
            (false, false) => continue,
            (true, false) => left,
            (false, true) => right,
            (true, true) if on_left > on_right => left,
            (true, true) => right,
        };
        return Some((axis, plane));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn build(boxes: &[Aabb]) -> TopLevelBsp {
        let mut tree = TopLevelBsp::default();
        rebuild(&mut tree, boxes);
        tree
    }

    fn rebuild(tree: &mut TopLevelBsp, boxes: &[Aabb]) {
        let items: Vec<u32> = (0..boxes.len() as u32).collect();
        tree.build(&items, |i| boxes[i as usize]).expect("memory");
    }

    /// Every box is in every leaf that it reaches into; returns (leaves, largest leaf, depth).
    fn check(boxes: &[Aabb], tree: &TopLevelBsp) -> (usize, usize, usize) {
        let mut stack = vec![(0usize, tree.bounds(), 0usize)];
        let (mut leaves, mut largest, mut deepest) = (0, 0, 0);
        while let Some((node, cell, depth)) = stack.pop() {
            deepest = deepest.max(depth);
            match tree.nodes()[node] {
                TopNode::Leaf { first, count } => {
                    leaves += 1;
                    largest = largest.max(count as usize);
                    let refs = &tree.refs()[first as usize..][..count as usize];
                    for (i, b) in boxes.iter().enumerate() {
                        if (0..3).all(|k| b.lo[k] < cell.hi[k] && b.hi[k] > cell.lo[k]) {
                            assert!(refs.contains(&(i as u32)), "box {i} is missing in {cell:?}");
                        }
                    }
                    for &i in refs {
                        let b = boxes[i as usize];
                        assert!((0..3).all(|k| b.lo[k] <= cell.hi[k] && b.hi[k] >= cell.lo[k]), "box {i} in {cell:?}");
                    }
                }
                TopNode::Inner { axis, plane, lower } => {
                    let axis = axis as usize;
                    assert!(plane > cell.lo[axis] && plane < cell.hi[axis]);
                    let (mut below, mut above) = (cell, cell);
                    below.hi[axis] = plane;
                    above.lo[axis] = plane;
                    stack.push((lower as usize, below, depth + 1));
                    stack.push((lower as usize + 1, above, depth + 1));
                }
            }
        }
        assert_eq!(tree.nodes().len(), 2 * leaves - 1);
        (leaves, largest, deepest)
    }

    fn cube(center: Vec3, half: f32) -> Aabb {
        Aabb { lo: center - half, hi: center + half }
    }

    #[test]
    fn the_plane_is_the_papers() {
        // Cell 0..12 in x, middle 6. Three boxes reach left of it, one right: the largest border below 6 is 4.
        let x = |lo: f32, hi: f32| Aabb { lo: Vec3::new(lo, 0.0, 0.0), hi: Vec3::new(hi, 1.0, 1.0) };
        let boxes = [x(0.0, 1.0), x(2.0, 3.0), x(3.5, 4.0), x(9.0, 12.0)];
        let tree = build(&boxes);
        assert_eq!(tree.nodes()[0], TopNode::Inner { axis: 0, plane: 4.0, lower: 1 });
        // Mirrored, more instances are right of the middle: the smallest border from 6 on is 8.
        let mirrored = boxes.map(|b| x(12.0 - b.hi.x, 12.0 - b.lo.x));
        assert_eq!(build(&mirrored).nodes()[0], TopNode::Inner { axis: 0, plane: 8.0, lower: 1 });
        // The longest side has no border inside: the next one is taken.
        let slabs = [0.0, 2.0].map(|y| Aabb { lo: Vec3::new(0.0, y, 0.0), hi: Vec3::new(9.0, y + 1.0, 1.0) });
        assert!(matches!(build(&slabs).nodes()[0], TopNode::Inner { axis: 1, .. }));
    }

    #[test]
    fn few_overlapping_and_identical_boxes() {
        assert!(build(&[]).nodes().is_empty());
        assert_eq!(check(&[cube(Vec3::ONE, 1.0)], &build(&[cube(Vec3::ONE, 1.0)])), (1, 1, 0));
        let same = vec![cube(Vec3::ONE, 1.0); 100_000];
        assert_eq!(check(&same[..1000], &build(&same[..1000])), (1, 1000, 0));
        assert_eq!(build(&same).nodes().len(), 1);
        // All boxes overlap in the middle: the paper's recursion would make n³ cells.
        let nested: Vec<Aabb> = (0..300)
            .map(|i| cube(Vec3::new((i % 17) as f32, (i % 13) as f32, (i % 11) as f32), 20.0 + 0.01 * i as f32))
            .collect();
        let tree = build(&nested);
        check(&nested, &tree);
        assert!(tree.refs().len() <= REFS_PER_INSTANCE * nested.len());
        let flat: Vec<Aabb> = (0..50)
            .map(|i| {
                let p = Vec3::new((i / 5) as f32, 0.0, 0.0);
                Aabb { lo: p, hi: p + Vec3::new(0.0, 1.0, 1.0) }
            })
            .collect();
        check(&flat, &build(&flat));
    }

    #[test]
    fn separate_boxes_end_in_small_leaves_and_memory_is_reused() {
        let boxes: Vec<Aabb> = (0..4096)
            .map(|i| cube(Vec3::new((i % 16) as f32, (i / 16 % 16) as f32, (i / 256) as f32) * 3.0, 1.0))
            .collect();
        let mut tree = build(&boxes);
        let (_, largest, depth) = check(&boxes, &tree);
        assert!(largest <= 2 && depth <= 32, "leaf of {largest}, depth {depth}");
        let held = tree.memory_bytes();
        rebuild(&mut tree, &boxes);
        assert_eq!(tree.memory_bytes(), held);
        // Distances that double: every split takes one box off, and the depth ends it.
        let doubling: Vec<Aabb> =
            (0..120).map(|i| cube(Vec3::splat(2.0f32.powi(i - 60)), 2.0f32.powi(i - 63))).collect();
        let tree = build(&doubling);
        assert!(check(&doubling, &tree).2 <= TOP_MAX_DEPTH);
    }
}
