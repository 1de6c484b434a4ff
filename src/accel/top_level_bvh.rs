//! The top-level bounding volume hierarchy over the world-space boxes of instances, rebuilt every frame.
//!
//! Nodes are those of the object trees ([`super::bvh`]), eight children each. A leaf is a run of [`TopLevelBvh::refs`];
//! the builder always makes runs of one, so that the box test of a lane *is* the box test of an instance, eight for
//! the price of one: to visit an instance costs a transform and the root of its object, more than any lane.
//!
//! ```text
//! node of up to 8 boxes: a lane each, no split is looked for
//! node of more:          children = [all]; while fewer than 8: split the one of largest area, if it holds two boxes
//! ```
//!
//! Splits are those of Wald 2007, see [`super::top_level_split`]. As the lowest three of log n binary levels need no split, a build takes about 100 ns per
//! instance (161 to 661 instances).
//!
//! *Tried without gain:* opening instances, their objects' root children as references of their own (Benthin et al., *Improved Two-Level BVHs using Partial
//! Re-Braiding*, 2017). With every instance opened once, rays per second fell to 0.74–0.96 on 661 overlapping trees and to 0.66–0.79 on 10,000 overlapping
//! spheres, at eight times the references to place: each of them asks for the transform of the ray anew.
//!
//! *Robustness.* Where centres coincide or areas overflow, a range is halved by count. Below [`SAH_DEPTH`] levels all are, the
//! fullest first: at least a factor of 4 per level, so no input reaches [`super::MAX_DEPTH`].
//! *Determinism.* The tree depends on the boxes alone: tasks are cut by size, never by threads.
//! *Memory.* All is kept from frame to frame. A node of more than 8 boxes has all 8 children, so m boxes need at most
//! `(4m - 1) / 7` nodes: `1 + Σ (4 mᵢ - 1) / 7 = (4m - 1) / 7` over 8 children. That many are set aside for a task, and what it
//! does not use stays as a gap that nothing refers to.

use super::Aabb;
use super::bvh::{ChildRef, MAX_DEPTH, Node8, OutOfMemory, WIDTH};
use super::top_level_split::{CHUNK, Item, Range, halve, split};
use rayon::prelude::*;

/// Levels of the tree that are split by the heuristic.
const SAH_DEPTH: usize = 44;
/// Ranges above are split off as tasks of their own.
const TASK: usize = 512;

/// The tree. Node 0 is the root; there is none when there is nothing to hit.
#[derive(Debug)]
pub struct TopLevelBvh {
    /// Of the last build, and behind them of larger ones.
    nodes: Vec<Node8>,
    refs: Vec<u32>,
    items: Vec<Item>,
    bounds: Aabb,
}

impl Default for TopLevelBvh {
    fn default() -> Self {
        Self { nodes: Vec::new(), refs: Vec::new(), items: Vec::new(), bounds: Aabb::EMPTY }
    }
}

impl TopLevelBvh {
    /// The nodes, root first; every child that is a node has a higher number than its parent. A leaf's
    /// [`ChildRef::blocks`] are a run of [`TopLevelBvh::refs`]. Not every node belongs to the tree.
    #[inline(always)]
    pub fn nodes(&self) -> &[Node8] {
        &self.nodes
    }

    /// Numbers of boxes, by leaf; each once.
    #[inline(always)]
    pub fn refs(&self) -> &[u32] {
        &self.refs
    }

    /// Whether there is nothing to hit.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.refs.is_empty()
    }

    /// The box around all boxes.
    #[inline(always)]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Bytes held, workspace included.
    pub fn memory_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node8>()
            + self.refs.capacity() * size_of::<u32>()
            + self.items.capacity() * size_of::<Item>()
    }

    /// Builds the tree anew over `boxes[i]` for the numbers `i` in `numbers`; all finite, none empty.
    /// To be called inside the pool.
    ///
    /// # Errors
    /// No memory; the tree is then empty.
    pub fn build(&mut self, numbers: &[u32], boxes: &[Aabb]) -> Result<(), OutOfMemory> {
        let Self { nodes, refs, items, bounds } = self;
        refs.clear();
        items.clear();
        *bounds = Aabb::EMPTY;
        let count = numbers.len();
        if count == 0 {
            return Ok(());
        }
        let needed = node_bound(count);
        let bytes = needed * size_of::<Node8>() + count * (size_of::<u32>() + size_of::<Item>());
        let out_of_memory = |_| OutOfMemory { bytes };
        if count >= ChildRef::MAX_INDEX {
            return Err(OutOfMemory { bytes });
        }
        nodes.try_reserve(needed.saturating_sub(nodes.len())).map_err(out_of_memory)?;
        refs.try_reserve(count).and(items.try_reserve(count)).map_err(out_of_memory)?;
        if nodes.len() < needed {
            nodes.resize(needed, Node8::EMPTY);
        }

        let item = |&i: &u32| Item::new(i, &boxes[i as usize]);
        let root = if count > CHUNK {
            numbers.par_iter().with_min_len(CHUNK / 2).map(item).collect_into_vec(items);
            let none = || Range::of(&[], 0);
            items.par_chunks(CHUNK).map(|chunk| Range::of(chunk, 0)).reduce(none, Range::join)
        } else {
            items.extend(numbers.iter().map(item));
            Range::of(items, 0)
        };
        *bounds = root.bounds.to_aabb();
        build_node(nodes, 0, items, 0, root, 0);
        if count > CHUNK {
            items.par_iter().with_min_len(CHUNK).map(Item::index).collect_into_vec(refs);
        } else {
            refs.extend(items.iter().map(Item::index));
        }
        Ok(())
    }

    /// Checks the tree against the boxes it was built over: every number is in exactly one leaf, the box of its lane and all boxes above contain
    /// its own, inner boxes are the union of their children's, unused lanes are empty and come last, the depth is
    /// bounded. Describes the first violation.
    pub fn validate(&self, numbers: &[u32], boxes: &[Aabb]) -> Result<(), String> {
        let mut seen = vec![false; boxes.len()];
        let mut stack = if self.is_empty() { vec![] } else { vec![(0usize, 1usize, self.bounds)] };
        while let Some((index, depth, expected)) = stack.pop() {
            if depth > MAX_DEPTH {
                return Err(format!("node {index} is at depth {depth}"));
            }
            let node = self.nodes.get(index).ok_or(format!("node {index} does not exist"))?;
            if node.union() != expected {
                return Err(format!("the box of node {index} is {expected:?}, its children's {:?}", node.union()));
            }
            for lane in 0..WIDTH {
                let (child, aabb) = (node.children[lane], node.child_bounds(lane));
                if lane >= node.child_count() {
                    if !child.is_empty() || aabb != Aabb::EMPTY {
                        return Err(format!("lane {lane} of node {index} is unused but not empty"));
                    }
                } else if child.is_leaf() {
                    let run = self.refs.get(child.blocks()).ok_or(format!("leaf {lane} of node {index}"))?;
                    let all = run.iter().fold(Aabb::EMPTY, |all, &i| all.union(boxes[i as usize]));
                    if aabb != all {
                        return Err(format!("leaf {lane} of node {index} has the box {aabb:?}, its instances {all:?}"));
                    }
                    if let Some(i) = run.iter().find(|&&i| std::mem::replace(&mut seen[i as usize], true)) {
                        return Err(format!("instance {i} has two places"));
                    }
                } else if child.index() <= index {
                    return Err(format!("child {} of node {index} has no higher number", child.index()));
                } else {
                    stack.push((child.index(), depth + 1, aabb));
                }
            }
        }
        match numbers.iter().find(|&&i| !seen[i as usize]) {
            Some(i) => Err(format!("instance {i} is not in the tree")),
            None if seen.iter().filter(|&&s| s).count() == numbers.len() => Ok(()),
            None => Err("there are more instances in the tree than were given".into()),
        }
    }
}

/// Nodes that so many boxes need at most, see the module head. One for the root, even of a single box.
fn node_bound(count: usize) -> usize {
    ((4 * count).saturating_sub(1) / 7).max(1)
}

/// Writes the node of `items`, whose range starts at `base` of the whole order, as `nodes[0]`, which has the number `number`; and all
/// below it behind. Returns how many nodes are in use. The recursion is bounded by the depth of the tree.
fn build_node(
    nodes: &mut [Node8],
    number: usize,
    items: &mut [Item],
    base: usize,
    range: Range,
    depth: usize,
) -> usize {
    let Some((node, mut free)) = nodes.split_first_mut() else { unreachable!("node_bound() is an upper bound") };
    *node = Node8::EMPTY;
    if items.len() <= WIDTH {
        for (lane, item) in items.iter().enumerate() {
            node.set_child_bounds(lane, &item.to_aabb());
            node.children[lane] = ChildRef::leaf(base + lane, 1);
        }
        return 1;
    }
    let parallel = items.len() > TASK;
    let children = split_wide(items, range, depth);
    let mut tasks = [const { None }; WIDTH];
    let mut rest = items;
    let mut used = 1;
    for (lane, mut child) in children.into_iter().enumerate() {
        let (these, others) = rest.split_at_mut(child.count);
        rest = others;
        node.set_child_bounds(lane, &child.bounds.to_aabb());
        let child_base = base + child.start;
        child.start = 0;
        if child.count == 1 {
            node.children[lane] = ChildRef::leaf(child_base, 1);
            continue;
        }
        node.children[lane] = ChildRef::node(number + used);
        if parallel {
            let (own, others) = free.split_at_mut(node_bound(child.count));
            free = others;
            tasks[lane] = Some((own, number + used, these, child_base, child));
            used += node_bound(child.count);
        } else {
            let taken = build_node(free, number + used, these, child_base, child, depth + 1);
            free = &mut free[taken..];
            used += taken;
        }
    }
    if parallel {
        tasks.par_iter_mut().with_max_len(1).for_each(|task| {
            if let Some((nodes, number, items, base, range)) = task.take() {
                build_node(nodes, number, items, base, range, depth + 1);
            }
        });
    }
    used
}

/// Splits more than eight items into eight ranges.
fn split_wide(items: &mut [Item], range: Range, depth: usize) -> [Range; WIDTH] {
    let mut children = [range; WIDTH];
    let mut weights = [f32::NEG_INFINITY; WIDTH];
    for count in 1..WIDTH {
        let mut widest = 0;
        for i in 1..count {
            if weights[i] > weights[widest] {
                widest = i;
            }
        }
        let child = children[widest];
        let these = &mut items[child.start..child.start + child.count];
        let sides = if depth < SAH_DEPTH { split(these, &child) } else { halve(these, &child) };
        // In place of the child and at the end; sorted below.
        for (slot, side) in [(widest, sides.0), (count, sides.1)] {
            children[slot] = side;
            let area = side.bounds.half_area();
            weights[slot] = match side.count {
                1 => f32::NEG_INFINITY,
                many if depth >= SAH_DEPTH => many as f32,
                // A number, so that every range of two is above those of one.
                _ if area < f32::MAX => area,
                _ => f32::MAX,
            };
        }
    }
    children.sort_unstable_by_key(|child| child.start);
    children
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::Random;
    use glam::Vec3;

    fn cube(center: Vec3, half: f32) -> Aabb {
        Aabb { lo: center - half, hi: center + half }
    }

    fn all_numbers(boxes: &[Aabb]) -> Vec<u32> {
        (0..boxes.len() as u32).collect()
    }

    fn scattered(count: usize, half: f32) -> Vec<Aabb> {
        let mut random = Random::new(Random::seed(count as u64));
        (0..count).map(|_| cube(random.vec() * 10.0, half)).collect()
    }

    #[test]
    fn every_tree_is_valid_and_the_memory_is_used_again() {
        let mut tree = TopLevelBvh::default();
        let check = |tree: &mut TopLevelBvh, name: &str, boxes: &[Aabb]| {
            let numbers = all_numbers(boxes);
            tree.build(&numbers, boxes).expect("memory");
            tree.validate(&numbers, boxes).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(tree.bounds(), boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b)), "{name}");
        };
        for count in (0..70).chain([500, 511, 512, 513, 2000, 4097, 10_000, 40_000]) {
            for half in [0.0, 0.1, 8.0] {
                check(&mut tree, &format!("{count} boxes of {half}"), &scattered(count, half));
            }
        }
        let held = tree.memory_bytes();
        check(&mut tree, "again", &scattered(40_000, 0.1));
        assert_eq!(tree.memory_bytes(), held);
        check(&mut tree, "identical", &vec![cube(Vec3::ONE, 1.0); 10_000]);
        check(
            &mut tree,
            "huge",
            &scattered(100, 1.0).iter().map(|b| cube(b.center() * 1e37, 1e37)).collect::<Vec<_>>(),
        );
        check(
            &mut tree,
            "denormal",
            &scattered(100, 1.0).iter().map(|b| cube(b.center() * 1e-40, 0.0)).collect::<Vec<_>>(),
        );
        // Distances that double: every split takes one off.
        check(
            &mut tree,
            "doubling",
            &(0..250).map(|i| cube(Vec3::splat(2.0f32.powi(i - 125)), 2.0f32.powi(i - 127))).collect::<Vec<_>>(),
        );
        check(&mut tree, "one far", &[scattered(300, 0.1), vec![cube(Vec3::splat(1e30), 1.0)]].concat());
    }

    #[test]
    fn only_the_numbers_given_are_in_the_tree() {
        let boxes = scattered(1000, 0.1);
        let some: Vec<u32> = all_numbers(&boxes).into_iter().filter(|i| i % 3 == 0).collect();
        let mut tree = TopLevelBvh::default();
        tree.build(&some, &boxes).expect("memory");
        tree.validate(&some, &boxes).expect("valid");
        tree.validate(&some[1..], &boxes).expect_err("one too many");
        tree.validate(&[&some[..], &[1]].concat(), &boxes).expect_err("one is missing");
        let mut moved = boxes.clone();
        moved[some[7] as usize].hi.x += 0.5;
        tree.validate(&some, &moved).expect_err("a box has grown");
        tree.build(&[], &boxes).expect("memory");
        assert!(tree.is_empty() && tree.bounds().is_empty());
    }

    #[test]
    fn any_number_of_threads_builds_the_same_tree() {
        let boxes = scattered(20_000, 0.3);
        let numbers = all_numbers(&boxes);
        let built = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut tree = TopLevelBvh::default();
            pool.install(|| tree.build(&numbers, &boxes)).expect("memory");
            (format!("{:?}", tree.nodes()), tree.refs().to_vec())
        };
        let one = built(1);
        for threads in [2, 3, 7] {
            assert!(built(threads) == one, "{threads} threads");
        }
    }

    #[test]
    fn nodes_are_full_and_neighbours_share_them() {
        let boxes: Vec<Aabb> = (0..4096)
            .map(|i| cube(Vec3::new((i % 16) as f32, (i / 16 % 16) as f32, (i / 256) as f32) * 3.0, 1.0))
            .collect();
        let mut tree = TopLevelBvh::default();
        tree.build(&all_numbers(&boxes), &boxes).expect("memory");
        let mut stack = vec![0usize];
        let (mut nodes, mut area) = (0, 0.0);
        while let Some(node) = stack.pop() {
            let node = &tree.nodes()[node];
            nodes += 1;
            area += f64::from(node.union().half_area());
            stack.extend(node.children.iter().filter(|c| !c.is_empty() && !c.is_leaf()).map(|c| c.index()));
        }
        // The regular tree has 512 + 64 + 8 + 1 nodes, with 2, 4, 8 and 16 boxes along an edge.
        let face = |boxes: f64| (3.0 * boxes - 1.0).powi(2) * 3.0;
        let regular = 512.0 * face(2.0) + 64.0 * face(4.0) + 8.0 * face(8.0) + face(16.0);
        assert!(nodes <= 700 && area <= 1.1 * regular, "{nodes} nodes of area {area}, regular {regular}");
    }
}
