//! Refit with rotations (Kopta, Ize, Spjut, Brunvand, Davis, Kensler, *Fast, Effective BVH Updates for Animated Scenes*, 2012, §2).
//!
//! ```text
//! blocks, in parallel:     new corners and boxes
//! subtrees, in parallel:   boxes and areas of all lanes, and the tree's true cost
//! if that is worse:        what is worn is dissolved and sorted anew (super::restructure)
//! ```
//!
//! The paper rotates a binary tree: per node the best of six exchanges in every frame, with one triangle per leaf or with leaves that
//! split and merge. Here it happens on the wide tree itself, as a binary one beside it would have to be refit as well and
//! collapsed every frame. Three things differ:
//!
//! * Nothing is looked for while the tree costs what it did ([`WORSE`]): in a calm scene it is a refit, and the sum of areas.
//! * A rotation moves a subtree by one level, so what has to go a long way through the tree takes many frames. Here all that is worn
//!   goes to its place at once, and what moves are the largest subtrees that are in order: a body that flies through the others is a few of them.
//!   Triangles of worn leaves are sorted with them, which takes the place of splitting and merging leaves.
//! * It is given up where it does not pay. When triangles tumble each on its own, a tree is as bad after sorting as before, or everything would have to be
//!   sorted; then it is a refit, until whoever calls builds anew because the tree is worn ([`super::strategy`]). After a failure the next
//!   attempts are left out, one, three, seven … 31.
//!
//! *Cost* against a refit (one thread, updates alone; `papers kopta1 --quick`): 146,000 triangles of flying spheres 1.2 times where nothing is sorted, 1.6 in every third frame and 5 in the first,
//! over 20 frames 1.56 (1.92 before there was room to grow and small parts were split no more), without a single build: the first attempt
//! sorts 15,000 subtrees and triangles, those after it 500 to 2000, as whoever was mixed with others is so no more. Cost of the tree 23.6 where a
//! careful build gives 20.5, a fast one 24.8, refit alone 292. Calm scenes 1.05 to 1.2. What exceeds 1.6 are frames that build: every triangle for itself, as in
//! the key-framed soup, and bodies of which each frame is another heap.
//!
//! *Tried before*: per node of the wide tree the best of 1792 exchanges of grandchildren (670 ns per node, a sixth of what sorting all grandchildren
//! anew keeps off); sorting grandchildren, and triangles of leaves, per node whose children had grown, every depth kept: 2.7 times a refit among the spheres, and
//! worn every second frame all the same, as nothing gets further than one level. *Tried with this*: finding out with little, where it would cost much,
//! whether it pays (it never does: subtrees that straddle two bodies are near the leaves); lanes worn by their growth, 1.2 to 3 times, instead of by what they
//! add to the cost (twice to five times as many items for the same gain, and a build every few frames); trying at 1.05 to 1.2 times the cost (10 % better trees, 1.8 times a refit; since attempts are cheap, at 1.15 and 1.2, and with half and twice the excess: rays as fast within the noise, 1.7 to 1.9 times).
//!
//! The tree is the same for any number of threads: parts of the tree are looked at independently, and put in their places one after the other.

use super::Aabb;
use super::block_loader::{BlockBox, Load, load};
use super::bvh::{Bvh, MAX_DEPTH, Node8, OutOfMemory, WIDTH};
use super::memory::filled;
use super::partition::{Scratch, Scratches};
use super::refit::{Keep, set_bounds};
use super::restructure::Plan;
use super::treelet::Areas;
use crate::memory::Room;
use crate::scene::Mesh;
use crate::simd::{self, Kernel, Level, prefetch};
use crate::threads::Desks;
use rayon::prelude::*;
use std::ops::Range;

/// Blocks that are worked on together.
const BLOCKS: usize = 1024;
/// Nodes between asking for the boxes of leaves and reading them.
const AHEAD: usize = 3;

/// How much the cost may grow before something is done about it.
const WORSE: f64 = 1.3;
/// By how much a lane may be larger than in order, as a part of the mean lane's area at the calm cost.
const EXCESS: f64 = 0.2;
/// That and so many powers of four times it are tried until there is not too much to do.
const COARSER: u32 = 3;
/// What may be sorted in one frame, as a part of the triangles, and in any case.
const MOST_SORTED: f64 = 0.12;
const FEW: f64 = 64.0;
/// After so many failures in a row, 31 attempts are left out.
const MOST_FAILURES: u32 = 5;
/// The part of the blocks by which they may become more, and the depth, before the tree is built anew.
const MORE_BLOCKS: usize = 4;
const DEEP: usize = MAX_DEPTH - 16;

/// What rotations remember of a tree; cleared when there is another one.
#[derive(Debug, Default)]
pub(super) struct Wear {
    /// Areas of the lanes of each node when they were in order, and now; and of the root.
    pub was: Vec<Areas>,
    pub now: Vec<Areas>,
    pub root_was: f32,
    /// The cost after the last attempt to improve it, or the least since.
    calm: f64,
    /// Nodes and blocks at first, and blocks alone.
    lanes: usize,
    blocks: usize,
    /// Nodes of independent subtrees; before the first are those above.
    pub parts: Vec<Range<usize>>,
    /// Nodes have changed places in the last update.
    restructured: bool,
    /// Attempts in a row that did not pay, and how often the next one is left out.
    failures: u32,
    pause: u32,
    /// Boxes of the blocks.
    /// The boxes of blocks.
    leaves: Vec<BlockBox>,
    /// Room for the boxes of the nodes of a part.
    boxes: Desks<Vec<BlockBox>>,
    /// What sweeps over the parts gave.
    lower: Vec<Swept>,
    pub scratches: Scratches,
    /// Blocks that are in no leaf.
    pub free: Vec<u32>,
    /// Memory for the next time that nodes are put in order.
    pub spare_nodes: Vec<Node8>,
    pub spare_was: Vec<Areas>,
}

impl Wear {
    pub fn memory_bytes(&self) -> usize {
        (self.was.capacity() + self.now.capacity() + self.spare_was.capacity()) * size_of::<Areas>()
            + self.spare_nodes.capacity() * size_of::<Node8>()
            + self.free.capacity() * size_of::<u32>()
            + (self.leaves.capacity() + self.boxes.sum(Vec::capacity)) * size_of::<BlockBox>()
            + self.lower.capacity() * size_of::<Swept>()
            + self.scratches.sum(Scratch::memory_bytes)
    }

    /// Whether the last update changed more than boxes.
    pub fn was_restructured(&self) -> bool {
        self.restructured
    }

    /// Forgets the tree.
    pub fn clear(&mut self) {
        self.was.clear();
    }

    fn begin(&mut self, bvh: &Bvh) -> Result<(), OutOfMemory> {
        self.was = filled(std::mem::take(&mut self.was), bvh.nodes.len(), [0.0; WIDTH])?;
        self.now = filled(std::mem::take(&mut self.now), bvh.nodes.len(), [0.0; WIDTH])?;
        self.was.par_iter_mut().zip(&bvh.nodes).for_each(|(was, node)| *was = half_areas(&node.bounds));
        self.root_was = bvh.bounds().half_area();
        self.calm = bvh.sah_cost();
        (self.lanes, self.blocks) = (bvh.nodes.len() + bvh.blocks.len(), bvh.blocks.len());
        self.free.clear();
        self.parts.clear();
        self.parts.room(bvh.subtrees.len())?;
        self.parts.extend(bvh.subtrees.iter().map(|s| s.nodes.clone()));
        if self.parts.first().is_some_and(|part| part.start == 0) {
            // There is nothing above it.
            self.parts.clear();
        }
        Ok(())
    }

    /// By how much the root's area has grown.
    pub fn growth(&self, bvh: &Bvh) -> f32 {
        let growth = bvh.bounds().half_area() / self.root_was;
        if growth > 0.0 && growth.is_finite() { growth } else { 1.0 }
    }
}

impl Bvh {
    /// Brings bounds and corners in line with the mesh, as [`Bvh::refit`] does, and improves the tree where it is worse
    /// than before. `wear` belongs to the tree and is cleared after a build. Gives the tree's SAH cost, infinite when it should not go on growing,
    /// or nothing if the tree has to be built anew. To be called inside the pool.
    pub(super) fn rotate(&mut self, mesh: &Mesh, wear: &mut Wear) -> Option<f64> {
        if !self.can_hold(mesh) {
            return None;
        }
        if self.nodes.is_empty() {
            return Some(0.0);
        }
        if wear.was.len() != self.nodes.len() {
            wear.begin(self).ok()?;
        }
        wear.prepare(self).ok()?;
        self.blocks.par_chunks_mut(BLOCKS).zip(wear.leaves.par_chunks_mut(BLOCKS)).for_each(|(blocks, boxes)| {
            load(Load { mesh, blocks, prims: &Keep, boxes });
        });
        let sum = self.sweep(wear);
        let sum = self.improve(wear, sum);
        if self.depth() > MAX_DEPTH {
            // Parts that are each within bounds need not be so on top of each other.
            return None;
        }
        let cost = self.cost_of(sum);
        wear.calm = wear.calm.min(cost);
        let grown = self.blocks.len() > wear.blocks + wear.blocks / MORE_BLOCKS + 64 || self.depth() > DEEP;
        Some(if grown { f64::INFINITY } else { cost })
    }

    /// The SAH cost of a tree whose lanes have areas of that sum.
    fn cost_of(&self, sum: f64) -> f64 {
        let root = f64::from(self.bounds().half_area());
        if root > 0.0 { 1.0 + sum / root } else { 0.0 }
    }

    /// Builds what is worn anew if the tree is worse than it was. Takes and gives the sum of the areas of all lanes.
    fn improve(&mut self, wear: &mut Wear, mut sum: f64) -> f64 {
        wear.restructured = false;
        if self.cost_of(sum) <= wear.calm * WORSE {
            return sum;
        }
        if wear.pause > 0 {
            wear.pause -= 1;
            return sum;
        }
        let root = f64::from(self.bounds().half_area());
        let few = (MOST_SORTED * self.prim_count as f64).max(FEW);
        let mut pays = false;
        for coarser in 0..COARSER {
            let most = wear.calm * root / wear.lanes as f64 * EXCESS * f64::from(1 << (2 * coarser));
            // Without memory the tree stays as it is.
            let Ok(plan) = Plan::new(self, wear, most as f32) else { break };
            if plan.items as f64 <= few {
                let saved = plan.carry_out(self, wear).unwrap_or(0.0);
                wear.restructured = saved > 0.0;
                pays = saved / sum > plan.items as f64 / self.prim_count as f64;
                sum -= saved;
                break;
            }
        }
        wear.failures = if pays { 0 } else { (wear.failures + 1).min(MOST_FAILURES) };
        wear.pause = (1 << wear.failures) - 1;
        if !pays {
            // It is the shape that costs more now, not the tree.
            wear.calm = wear.calm.max(self.cost_of(sum));
        }
        sum
    }

    /// Boxes of nodes from those of the blocks. Gives the sum of the areas of all lanes, times the blocks of leaves.
    fn sweep(&mut self, wear: &mut Wear) -> f64 {
        let Wear { now, parts, leaves, boxes, lower, .. } = wear;
        let top = parts.first().map_or(self.nodes.len(), |part| part.start);
        let (top_nodes, nodes) = self.nodes.split_at_mut(top);
        let (top_areas, areas) = now.split_at_mut(top);
        let sweeps = Sweeps { level: Level::detect(), leaves, boxes };
        sweeps.run(parts, nodes, areas, lower);
        let sum: f64 = lower.iter().map(|(.., cost)| cost).sum();
        let (_, all, cost) = sweeps.one(0, top_nodes, top_areas, lower);
        self.set_bounds(Aabb::from(all));
        sum + cost
    }
}

impl Wear {
    /// Makes room for a sweep.
    fn prepare(&mut self, bvh: &Bvh) -> Result<(), OutOfMemory> {
        self.leaves = filled(std::mem::take(&mut self.leaves), bvh.blocks.len(), BlockBox::EMPTY)?;
        let more = bvh.nodes.len().saturating_sub(self.now.len());
        self.now.room(more)?;
        self.now.resize(bvh.nodes.len(), [0.0; WIDTH]);
        let top = self.parts.first().map_or(bvh.nodes.len(), |part| part.start);
        let largest = self.parts.iter().map(Range::len).fold(top, usize::max);
        self.boxes.prepare(self.parts.len().max(1), |boxes| boxes.room(largest.saturating_sub(boxes.len())))?;
        self.lower.clear();
        self.lower.room(self.parts.len())?;
        self.lower.resize(self.parts.len(), (0, BlockBox::EMPTY, 0.0));
        Ok(())
    }
}

/// Of a part of a tree its root, the box around it, and the sum of all areas times visits.
type Swept = (usize, BlockBox, f64);

/// Sweeps over parts that follow one another.
struct Sweeps<'a> {
    level: Level,
    leaves: &'a [BlockBox],
    boxes: &'a Desks<Vec<BlockBox>>,
}

impl Sweeps<'_> {
    fn run(&self, parts: &[Range<usize>], nodes: &mut [Node8], areas: &mut [Areas], swept: &mut [Swept]) {
        match parts {
            [] => {}
            [part] => swept[0] = self.one(part.start, nodes, areas, &[]),
            _ => {
                let middle = parts.len() / 2;
                let (left, right) = parts.split_at(middle);
                let border = right[0].start - left[0].start;
                let (left_nodes, right_nodes) = nodes.split_at_mut(border);
                let (left_areas, right_areas) = areas.split_at_mut(border);
                let (left_swept, right_swept) = swept.split_at_mut(middle);
                rayon::join(
                    || self.run(left, left_nodes, left_areas, left_swept),
                    || self.run(right, right_nodes, right_areas, right_swept),
                );
            }
        }
    }

    fn one(&self, first: usize, nodes: &mut [Node8], areas: &mut [Areas], below: &[Swept]) -> Swept {
        let Self { level, leaves, boxes } = *self;
        boxes.at_one(|boxes| {
            // Whatever was there will be written over.
            boxes.resize(nodes.len().max(boxes.len()), BlockBox::EMPTY);
            let boxes = &mut boxes[..nodes.len()];
            simd::run(level, Sweep { first, nodes, areas, boxes, below, leaves })
        })
    }
}

/// Some nodes, parents before children.
struct Sweep<'a> {
    /// The number of the first.
    first: usize,
    nodes: &'a mut [Node8],
    /// Areas of their lanes, to be found.
    areas: &'a mut [Areas],
    /// And boxes around them.
    boxes: &'a mut [BlockBox],
    /// Roots of subtrees beyond these nodes, in order: their numbers and boxes.
    below: &'a [Swept],
    /// Boxes of the blocks.
    leaves: &'a [BlockBox],
}

impl Kernel for Sweep<'_> {
    /// Number and box of the first node, and the sum of all areas.
    type Output = Swept;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { first, nodes, areas, boxes, below, leaves } = self;
        let mut cost = 0.0;
        for i in (0..nodes.len()).rev() {
            if let Some(soon) = i.checked_sub(AHEAD) {
                for child in nodes[soon].children.iter().filter(|child| child.is_leaf()) {
                    // An unused lane leads nowhere.
                    prefetch(leaves, child.blocks().start);
                }
            }
            let node = &mut nodes[i];
            let mut lanes = [BlockBox::EMPTY; WIDTH];
            let mut all = BlockBox::EMPTY;
            let mut visits = [0.0; WIDTH];
            for ((&child, lane), visits) in node.children.iter().zip(&mut lanes).zip(&mut visits) {
                if child.is_empty() {
                    break;
                }
                *lane = if child.is_leaf() {
                    let Range { start, end } = child.blocks();
                    *visits = (end - start) as f32;
                    leaves[start + 1..end].iter().fold(leaves[start], |all, block| all.union(block))
                } else {
                    *visits = 1.0;
                    match boxes.get(child.index() - first) {
                        Some(bounds) => *bounds,
                        None => {
                            let at = below.binary_search_by_key(&child.index(), |(node, ..)| *node);
                            below[at.expect("the child is the root of a part")].1
                        }
                    }
                };
                all = all.union(lane);
            }
            set_bounds(node, &lanes);
            boxes[i] = all;
            areas[i] = half_areas(&node.bounds);
            let mut parts = [0.0; WIDTH];
            for lane in 0..WIDTH {
                parts[lane] = areas[i][lane] * visits[lane];
            }
            cost += f64::from(parts.iter().sum::<f32>());
        }
        (first, boxes[0], cost)
    }
}

/// Half the areas of all lanes; 0 of unused ones.
#[inline(always)]
pub(super) fn half_areas(bounds: &[[f32; WIDTH]; 6]) -> Areas {
    std::array::from_fn(|lane| {
        let side = |axis: usize| {
            let extent = bounds[2 * axis + 1][lane] - bounds[2 * axis][lane];
            if extent > 0.0 { extent } else { 0.0 }
        };
        let (x, y, z) = (side(0), side(1), side(2));
        x * y + (y * z + z * x)
    })
}

#[cfg(test)]
mod tests {
    use super::Wear;
    use crate::accel::test_meshes::{Random, bumpy_sphere, mesh};
    use crate::accel::{Refit, build_sah, validate};
    use crate::scene::Mesh;
    use glam::Vec3;

    /// Small bodies that have flown so far, to and fro.
    fn bodies(far: f32) -> Mesh {
        let mut random = Random::new(8);
        let body = bumpy_sphere(6, 8);
        let places: Vec<(Vec3, Vec3)> = (0..150).map(|_| (random.vec(), random.vec())).collect();
        let all = places.iter().flat_map(|(from, way)| {
            let corners = (0..body.triangles.len() as u32).map(|prim| body.corners(prim));
            corners.map(|corners| corners.map(|p| p * 0.05 + (*from * 2.0 + *way * far).map(f32::sin)))
        });
        mesh(all)
    }

    #[test]
    fn bodies_that_part_are_sorted_and_what_rests_is_left_alone() {
        let mut refitted = build_sah(&bodies(0.0)).expect("memory");
        let mut rotated = refitted.clone();
        let mut wear = Wear::default();
        let built = refitted.sah_cost();
        let (mut worst, mut last) = (0.0f64, 0.0);
        for frame in 0..40 {
            let moved = bodies(frame as f32 * 0.1);
            assert_eq!(refitted.refit_once(&moved), Refit::Done);
            let before: Vec<u32> = rotated.blocks().iter().flat_map(|b| b.prims).collect();
            let cost = rotated.rotate(&moved, &mut wear).expect("the same triangles");
            validate(&rotated, &moved).unwrap_or_else(|e| panic!("frame {frame}: {e}"));
            assert!((cost - rotated.sah_cost()).abs() < 1e-4 * cost, "frame {frame}: {cost}, {}", rotated.sah_cost());
            let after: Vec<u32> = rotated.blocks().iter().flat_map(|b| b.prims).collect();
            if frame == 0 {
                assert!((cost - built).abs() < 1e-4 * built && before == after, "nothing moved");
            }
            let fresh = build_sah(&moved).expect("memory").sah_cost();
            worst = worst.max(cost / fresh);
            last = fresh;
        }
        let without = refitted.sah_cost() / last;
        assert!(worst < 1.5 && without > 4.0, "{worst} of a fresh tree with rotations, {without} without");
    }

    #[test]
    fn a_triangle_that_had_no_place_asks_for_a_build() {
        let mut moved = bumpy_sphere(9, 12);
        let at = moved.positions[5];
        moved.positions[5] = Vec3::NAN;
        let mut tree = build_sah(&moved).expect("memory");
        let mut best = Wear::default();
        assert!(tree.rotate(&moved, &mut best).is_some());
        moved.positions[7] = Vec3::NAN;
        assert!(tree.rotate(&moved, &mut best).is_some());
        validate(&tree, &moved).expect("valid");
        moved.positions[5] = at;
        assert!(tree.rotate(&moved, &mut best).is_none());
    }
}
