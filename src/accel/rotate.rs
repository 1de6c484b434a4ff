//! Refit with rotations (Kopta, Ize, Spjut, Brunvand, Davis, Kensler, *Fast, Effective BVH Updates for Animated Scenes*, 2012, §2).
//!
//! ```text
//! blocks, in parallel:              new corners and boxes
//! levels, last first, in parallel:  per node, boxes of the lanes and cost; and if it is worse than it has been:
//!                                   triangles of its leaves sorted into their blocks anew,
//!                                   grandchildren sorted into the inner children anew
//! ```
//!
//! The paper rotates a binary tree: per node the best of six exchanges in every frame, with one triangle per leaf or with leaves that
//! split and merge. Here both happen on the wide tree itself, as a binary one beside it would have to be refit as well and
//! collapsed every frame. Two things differ:
//!
//! * Instead of one exchange, all that are possible at once are made ([`super::regroup`]), but only where the areas of
//!   the children have grown against the node's own by [`WORSE`] since they were least. In a calm scene that is nowhere.
//! * Triangles move between the blocks below one node as nodes do between siblings. That takes the place of splitting leaves, and is what
//!   matters most where neighbours part: 146,000 triangles of flying spheres cost 419 after 11 frames of refit, 307 with
//!   nodes being sorted alone, 97 with both.
//!
//! Every exchange keeps depths, so the tree stays in level order ([`super::level_order`]). What has to go a long way through the
//! tree takes many frames, and in a chaos it never arrives. The true cost is summed up on the way, and whoever calls
//! builds anew when it says that the tree is worn ([`super::strategy`]).
//!
//! The tree is the same for any number of threads: a level's nodes are looked at independently, and what they
//! change below does not overlap.

use super::block_loader::{BlockBox, Load, load};
use super::bvh::{BLOCK, Bvh, ChildRef, Node8, Tri4, WIDTH};
use super::refit::{Keep, set_bounds};
use super::regroup::{GROUPS, Item, MOST, around, regroup};
use super::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use crate::simd::{self, Kernel, Level};
use rayon::prelude::*;

/// Blocks and nodes that are worked on together.
const BLOCKS: usize = 1024;
const NODES: usize = 64;

/// By how much the areas of inner children and of leaves may grow, against the node's, before they are sorted anew.
const WORSE: [f32; 2] = [1.1, 1.5];
/// What a new order has to save: the old one stays in a draw.
const WORTH: f32 = 0.98;

/// What the children of a node were at best: the areas of the inner ones and of the leaves (times their blocks), over the node's.
pub(super) type Best = [f32; 2];
const INNER: usize = 0;
const LEAVES: usize = 1;

impl Bvh {
    /// Brings bounds and corners in line with the mesh, as [`Bvh::refit`] does, and improves the tree where it is worse
    /// than before. For a tree in level order; `best` belongs to it and is empty after a build. Gives the tree's SAH cost, or nothing
    /// if the tree has to be built anew. To be called inside the pool.
    pub(super) fn rotate(&mut self, mesh: &Mesh, best: &mut Vec<Best>) -> Option<f64> {
        if !self.can_hold(mesh) {
            return None;
        }
        let Some(root) = self.nodes.first() else { return Some(0.0) };
        debug_assert!(!self.levels.is_empty() && root.child_count() > 0, "the tree is in level order");
        if best.len() != self.nodes.len() {
            *best = self.nodes.par_iter().map(|node| Shares::of(node).best()).collect();
        }
        let level = Level::detect();
        let leaves: Vec<Vec<BlockBox>> = self
            .blocks
            .par_chunks_mut(BLOCKS)
            .map(|blocks| {
                let mut boxes = Vec::with_capacity(blocks.len());
                load(Load { mesh, blocks, prims: &Keep, boxes: &mut boxes });
                boxes
            })
            .collect();
        let mut cost = 0.0;
        let mut boxes: Vec<BlockBox> = Vec::new();
        let mut end = self.nodes.len();
        for level_index in (0..self.levels.len()).rev() {
            let begin = self.levels[level_index];
            let (upper, below) = self.nodes.split_at_mut(end);
            let (below, blocks) = (&*below, &self.blocks[..]);
            let mut above = vec![BlockBox::EMPTY; end - begin];
            let changes: Vec<Changes> = upper[begin..]
                .par_chunks_mut(NODES)
                .zip(above.par_chunks_mut(NODES))
                .zip(best[begin..end].par_chunks_mut(NODES))
                .map(|((nodes, all), best)| {
                    let lower = Lower { first: end, nodes: below, boxes: &boxes, blocks, leaves: &leaves };
                    simd::run(level, Sweep { nodes, all, best, lower })
                })
                .collect();
            for change in changes {
                cost += change.cost;
                change.nodes.into_iter().for_each(|(index, node)| self.nodes[index] = node);
                change.blocks.into_iter().for_each(|(index, block)| self.blocks[index] = block);
            }
            (boxes, end) = (above, begin);
        }
        let bounds = Aabb { lo: boxes[0].lo.truncate(), hi: boxes[0].hi.truncate() };
        self.set_bounds(bounds);
        let root = f64::from(bounds.half_area());
        Some(if root > 0.0 { 1.0 + cost / root } else { 0.0 })
    }
}

/// Everything below some nodes of one level.
#[derive(Clone, Copy)]
struct Lower<'a> {
    /// The number of the first node below.
    first: usize,
    nodes: &'a [Node8],
    boxes: &'a [BlockBox],
    blocks: &'a [Tri4],
    /// Boxes of the blocks.
    leaves: &'a [Vec<BlockBox>],
}

/// What some nodes of a level cost, and what they put in the place of nodes and blocks below.
#[derive(Default)]
struct Changes {
    cost: f64,
    nodes: Vec<(usize, Node8)>,
    blocks: Vec<(usize, Tri4)>,
}

/// How the children of a node share its area.
#[derive(Clone, Copy)]
struct Shares {
    whole: f32,
    areas: [f32; 2],
    /// Inner children, and blocks of leaves.
    counts: [usize; 2],
}

impl Shares {
    const NONE: Shares = Shares { whole: 0.0, areas: [0.0; 2], counts: [0; 2] };

    fn of(node: &Node8) -> Self {
        let mut shares = Shares { whole: node.union().half_area(), ..Shares::NONE };
        for lane in 0..node.child_count() {
            shares.add(node.children[lane], node.child_bounds(lane).half_area());
        }
        shares
    }

    #[inline(always)]
    fn add(&mut self, child: ChildRef, area: f32) {
        let (kind, visits) = if child.is_leaf() { (LEAVES, child.blocks().len()) } else { (INNER, 1) };
        self.areas[kind] += area * visits as f32;
        self.counts[kind] += visits;
    }

    fn best(&self) -> Best {
        // Of a node without area nothing can be said.
        self.areas.map(|area| if self.whole > 0.0 { area / self.whole } else { f32::INFINITY })
    }

    #[inline(always)]
    fn is_worse(&self, kind: usize, best: &Best) -> bool {
        self.counts[kind] > 1 && self.areas[kind] > best[kind] * self.whole * WORSE[kind]
    }
}

/// Some nodes of one level.
struct Sweep<'a> {
    nodes: &'a mut [Node8],
    /// Their boxes, to be found.
    all: &'a mut [BlockBox],
    best: &'a mut [Best],
    lower: Lower<'a>,
}

impl Kernel for Sweep<'_> {
    type Output = Changes;

    #[inline(always)]
    fn run(self) -> Changes {
        let Self { nodes, all, best, lower } = self;
        let mut changes = Changes::default();
        for ((node, all), best) in nodes.iter_mut().zip(all).zip(best) {
            let mut lanes = [BlockBox::EMPTY; WIDTH];
            let mut shares = Shares::NONE;
            for (&child, lane) in node.children.iter().zip(&mut lanes) {
                if child.is_empty() {
                    break;
                }
                *lane = if child.is_leaf() {
                    child.blocks().fold(BlockBox::EMPTY, |all, b| all.union(&lower.leaves[b / BLOCKS][b % BLOCKS]))
                } else {
                    lower.boxes[child.index() - lower.first]
                };
                *all = all.union(lane);
                shares.add(child, item(lane, 0).half_area());
            }
            shares.whole = item(all, 0).half_area();
            if shares.is_worse(LEAVES, best) && shares.counts[LEAVES] <= GROUPS {
                shares.areas[LEAVES] = sort_triangles(node, &shares, &lower, &mut lanes, &mut changes.blocks);
                best[LEAVES] = shares.best()[LEAVES];
            }
            if shares.is_worse(INNER, best) {
                shares.areas[INNER] = sort_grandchildren(node, &shares, &lower, &mut lanes, &mut changes.nodes);
                best[INNER] = shares.best()[INNER];
            }
            for (best, now) in best.iter_mut().zip(shares.best()) {
                *best = if now < *best { now } else { *best };
            }
            changes.cost += f64::from(shares.areas[INNER]) + f64::from(shares.areas[LEAVES]);
            set_bounds(node, &lanes);
        }
        changes
    }
}

#[inline(always)]
fn item(bounds: &BlockBox, tag: u32) -> Item {
    Item { lo: bounds.lo, hi: bounds.hi, tag }
}

fn item_of(bounds: &Aabb, tag: u32) -> Item {
    Item { lo: bounds.lo.extend(0.0), hi: bounds.hi.extend(0.0), tag }
}

#[inline(always)]
fn box_of(item: &Item) -> BlockBox {
    BlockBox { lo: item.lo, hi: item.hi }
}

/// Sorts the children of a node's inner children into these anew, if that makes them smaller. Gives the sum of their areas.
#[inline(never)]
fn sort_grandchildren(
    node: &Node8,
    shares: &Shares,
    lower: &Lower,
    lanes: &mut [BlockBox; WIDTH],
    changes: &mut Vec<(usize, Node8)>,
) -> f32 {
    let inner = || (0..node.child_count()).filter(|&lane| !node.children[lane].is_leaf());
    let mut items = [Item::EMPTY; MOST];
    let mut count = 0;
    for lane in inner() {
        let child = &lower.nodes[node.children[lane].index() - lower.first];
        for lane in 0..child.child_count() {
            items[count] = item_of(&child.child_bounds(lane), child.children[lane].to_bits());
            count += 1;
        }
    }
    let groups = regroup(&mut items[..count], shares.counts[INNER], WIDTH);
    let mut after = *lanes;
    let (mut area, mut begin) = (0.0, 0);
    for (lane, len) in inner().zip(groups.lengths()) {
        let all = around(&items[begin..begin + len]);
        after[lane] = box_of(&all);
        area += all.half_area();
        begin += len;
    }
    if area > shares.areas[INNER] * WORTH {
        return shares.areas[INNER];
    }
    *lanes = after;
    let mut begin = 0;
    for (lane, len) in inner().zip(groups.lengths()) {
        let mut fresh = Node8::EMPTY;
        let mut boxes = [BlockBox::EMPTY; WIDTH];
        for (place, item) in items[begin..begin + len].iter().enumerate() {
            fresh.children[place] = ChildRef::from_bits(item.tag);
            boxes[place] = box_of(item);
        }
        set_bounds(&mut fresh, &boxes);
        changes.push((node.children[lane].index(), fresh));
        begin += len;
    }
    area
}

/// Sorts the triangles of a node's leaves into their blocks anew, if that makes the leaves smaller. Gives the sum of the areas of
/// leaves times their blocks.
#[inline(never)]
fn sort_triangles(
    node: &Node8,
    shares: &Shares,
    lower: &Lower,
    lanes: &mut [BlockBox; WIDTH],
    changes: &mut Vec<(usize, Tri4)>,
) -> f32 {
    let leaves = || (0..node.child_count()).filter(|&lane| node.children[lane].is_leaf());
    let mut items = [Item::EMPTY; MOST];
    let mut count = 0;
    for index in leaves().flat_map(|lane| node.children[lane].blocks()) {
        let block = &lower.blocks[index];
        for lane in 0..BLOCK {
            // One that repeats the one before is padding.
            if lane == 0 || block.prims[lane] != block.prims[lane - 1] {
                items[count] = item_of(&triangle_bounds(block.corners(lane)), (index * BLOCK + lane) as u32);
                count += 1;
            }
        }
    }
    let groups = regroup(&mut items[..count], shares.counts[LEAVES], BLOCK);
    let mut after = *lanes;
    let (mut area, mut begin) = (0.0, 0);
    let mut lengths = groups.lengths();
    for lane in leaves() {
        let blocks = node.children[lane].blocks().len();
        let len: usize = lengths.by_ref().take(blocks).sum();
        let all = around(&items[begin..begin + len]);
        after[lane] = box_of(&all);
        area += all.half_area() * blocks as f32;
        begin += len;
    }
    if area > shares.areas[LEAVES] * WORTH {
        return shares.areas[LEAVES];
    }
    *lanes = after;
    let mut begin = 0;
    let places = leaves().flat_map(|lane| node.children[lane].blocks());
    for (place, len) in places.zip(groups.lengths()) {
        let mut fresh = Tri4::EMPTY;
        for lane in 0..BLOCK {
            let from = items[begin + lane.min(len - 1)].tag as usize;
            let (block, at) = (&lower.blocks[from / BLOCK], from % BLOCK);
            fresh.prims[lane] = block.prims[at];
            fresh.set_corners(lane, block.corners(at));
        }
        changes.push((place, fresh));
        begin += len;
    }
    area
}

#[cfg(test)]
mod tests {
    use crate::accel::test_meshes::{Random, bumpy_sphere, mesh, soup};
    use crate::accel::{Refit, build_sah, validate};
    use crate::scene::Mesh;
    use glam::Vec3;

    /// The triangles of a mesh, each gone one of four ways.
    fn parted(whole: &Mesh, far: f32) -> Mesh {
        let triangles = (0..whole.triangles.len() as u32).map(|prim| {
            let way = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z][prim as usize % 4] * far;
            whole.corners(prim).map(|p| p + way)
        });
        mesh(triangles)
    }

    #[test]
    fn what_parts_is_sorted_and_what_rests_is_left_alone() {
        let whole = soup(&mut Random::new(Random::seed(8)), 6000, 0.02);
        let mut refitted = build_sah(&whole).expect("memory");
        let mut rotated = refitted.clone().in_level_order().expect("memory");
        let mut best = Vec::new();
        let built = refitted.sah_cost();
        for far in [0.0, 0.5, 1.0, 2.0, 4.0, 4.0, 4.0] {
            let moved = parted(&whole, far);
            assert_eq!(refitted.refit(&moved), Refit::Done);
            let before: Vec<u32> = rotated.blocks().iter().flat_map(|b| b.prims).collect();
            let cost = rotated.rotate(&moved, &mut best).expect("the same triangles");
            validate(&rotated, &moved).unwrap_or_else(|e| panic!("{far} apart: {e}"));
            assert!((cost - rotated.sah_cost()).abs() < 1e-4 * cost, "{far} apart: {cost}, {}", rotated.sah_cost());
            let after: Vec<u32> = rotated.blocks().iter().flat_map(|b| b.prims).collect();
            if far == 0.0 {
                assert!((cost - built).abs() < 1e-4 * built && before == after, "nothing moved");
            }
        }
        let (with, without) = (rotated.sah_cost(), refitted.sah_cost());
        assert!(with < 0.3 * without, "{with} with rotations, {without} without, {built} at first");
    }

    #[test]
    fn a_triangle_that_had_no_place_asks_for_a_build() {
        let mut moved = bumpy_sphere(9, 12);
        let at = moved.positions[5];
        moved.positions[5] = Vec3::NAN;
        let mut tree = build_sah(&moved).and_then(|t| t.in_level_order()).expect("memory");
        let mut best = Vec::new();
        assert!(tree.rotate(&moved, &mut best).is_some());
        moved.positions[7] = Vec3::NAN;
        assert!(tree.rotate(&moved, &mut best).is_some());
        validate(&tree, &moved).expect("valid");
        moved.positions[5] = at;
        assert!(tree.rotate(&moved, &mut best).is_none());
    }
}
