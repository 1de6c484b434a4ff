//! Which parts of a tree are worn, and putting new ones in their place.
//!
//! A lane is worn when its area is larger than it was when it was made, measured by the root's area then and now, by more than a share of the root.
//! What is worn is dissolved, from the top down and as far as it hangs together: the subtrees below that are not worn, and the triangles of worn
//! leaves, are sorted under the nearest node above that is not ([`super::treelet`]). This is where many rotations one after the other would
//! lead (a rotation moves a subtree by one level), it goes through many levels at once, and it costs what is dissolved, not the tree.
//! Restructuring only what is worn is the idea of Yoon, Curtis and Manocha, *Ray tracing dynamic scenes using selective restructuring* (2007), and of
//! Garanzha, *Efficient clustered BVH update algorithm* (2008), who go by pairs of nodes.
//!
//! Nodes then go to other memory in a good order, parents before children and subtrees together: a few per cent of the memory that the blocks are, and the
//! next sweep and rays find them where they look for them. New blocks and nodes first go into room that the builder leaves ([`Bvh::with_room_to_grow`]): copying
//! all blocks to where there are 65 more took longer than all else of an attempt. (Tried: level by level, which lets exchanges stay in place. The sweep then took twice as
//! long, as the boxes of the blocks were no longer met in order.) Blocks stay where they are, new ones take the place of dissolved ones.

use super::block_loader::BlockBox;
use super::bvh::{Bvh, ChildRef, Node8, OutOfMemory, WIDTH};
use super::memory::{filled, more, recycled};
use super::partition;
use super::rotate::Wear;
use super::treelet::{Areas, Items, Treelet};
use crate::memory::{Room, push, vec_of};
use crate::simd::{self, Kernel, Level};
use rayon::prelude::*;

/// Nodes that are looked at together.
const NODES: usize = 4096;
/// So many subtrees, if there are, can be worked on independently.
const PARTS: usize = 8;
/// What a new part has to save of its cost: the old one stays in a draw.
const GAIN: f64 = 0.02;

/// What is to be built anew.
pub(super) struct Plan {
    /// Per node, the lanes that are not kept.
    worn: Vec<u8>,
    /// Nodes that are kept and have such lanes.
    roots: Vec<u32>,
    /// Subtrees and triangles that would be sorted.
    pub items: usize,
}

/// Finds lanes whose area is more than `most` above what it was times `growth`.
struct Look<'a> {
    was: &'a [Areas],
    now: &'a [Areas],
    growth: f32,
    most: f32,
    worn: &'a mut [u8],
}

impl Kernel for Look<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { was, now, growth, most, worn } = self;
        for ((was, now), worn) in was.iter().zip(now).zip(worn) {
            let mut mask = 0;
            for lane in 0..WIDTH {
                mask |= u8::from(now[lane] > was[lane] * growth + most) << lane;
            }
            *worn = mask;
        }
    }
}

impl Plan {
    /// Finds lanes that are larger than in order by more than `most`.
    pub fn new(bvh: &Bvh, wear: &Wear, most: f32) -> Result<Plan, OutOfMemory> {
        let (growth, level) = (wear.growth(bvh), Level::detect());
        let mut worn = filled(Vec::new(), bvh.nodes.len(), 0u8)?;
        worn.par_chunks_mut(NODES)
            .zip(wear.was.par_chunks(NODES))
            .zip(wear.now.par_chunks(NODES))
            .for_each(|((worn, was), now)| simd::run(level, Look { was, now, growth, most, worn }));
        let mut gone = filled(Vec::new(), worn.len(), false)?;
        let (mut roots, mut items) = (Vec::new(), 0);
        for (index, &mask) in worn.iter().enumerate() {
            if mask == 0 && !gone[index] {
                continue;
            }
            if !gone[index] {
                push(&mut roots, index as u32)?;
            }
            for (lane, child) in bvh.nodes[index].children.iter().enumerate() {
                if child.is_empty() {
                    break;
                }
                match (mask >> lane & 1 != 0, child.is_leaf()) {
                    (true, true) => items += 4 * child.blocks().len(),
                    (true, false) => gone[child.index()] = true,
                    (false, _) => items += 1,
                }
            }
        }
        Ok(Plan { worn, roots, items })
    }

    /// Gives the cost of what is worn.
    fn gather(&self, bvh: &Bvh, wear: &Wear, index: usize, items: &mut Items) -> Result<f64, OutOfMemory> {
        let node = &bvh.nodes[index];
        let mut cost = 0.0;
        for lane in 0..node.child_count() {
            let child = node.children[lane];
            let visits = if child.is_leaf() { child.blocks().len() } else { 1 };
            cost += f64::from(wear.now[index][lane]) * visits as f64;
            if self.worn[index] >> lane & 1 == 0 {
                let b = node.child_bounds(lane);
                let bounds = BlockBox { lo: b.lo.extend(0.0), hi: b.hi.extend(0.0) };
                items.keep(child, bounds, wear.was[index][lane])?;
            } else if child.is_leaf() {
                child.blocks().try_for_each(|block| items.dissolve(block, &bvh.blocks[block]))?;
            } else {
                cost += self.gather(bvh, wear, child.index(), items)?;
            }
        }
        Ok(cost)
    }

    /// Builds what is worn anew, where that makes it smaller. Gives by how much the sum of areas has become so. Without memory nothing
    /// changes.
    pub fn carry_out(&self, bvh: &mut Bvh, wear: &mut Wear) -> Result<f64, OutOfMemory> {
        partition::prepare(&mut wear.scratches)?;
        let (tree, areas, growth) = (&*bvh, &*wear, wear.growth(bvh));
        let make = |&root: &u32| {
            let mut items = Items::default();
            let before = self.gather(tree, areas, root as usize, &mut items)?;
            let treelet = items.build(&tree.blocks, growth, &areas.scratches)?;
            let saved = before - treelet.cost;
            if saved <= treelet.cost * GAIN {
                return Ok(None);
            }
            let places = vec_of(treelet.blocks.len())?;
            Ok(Some(Made { root: root as usize, treelet, freed: items.freed, places, saved }))
        };
        let mut tried: Vec<Result<Option<Made>, OutOfMemory>> = vec_of(self.roots.len())?;
        self.roots.par_iter().map(make).collect_into_vec(&mut tried);
        let mut made = vec_of(tried.len())?;
        for one in tried {
            made.extend(one?);
        }
        if made.is_empty() {
            return Ok(0.0);
        }
        wear.free.room(made.iter().map(|m: &Made| m.freed.len()).sum())?;
        let nodes = made.iter().map(|m| m.treelet.nodes.len()).sum::<usize>();
        let blocks = made.iter().map(|m| m.treelet.blocks.len().saturating_sub(m.freed.len())).sum::<usize>();
        let order = Order::with_room_for(bvh.nodes.len() + nodes, wear)?;
        more(&mut bvh.nodes, nodes)?;
        more(&mut wear.was, nodes)?;
        more(&mut wear.now, nodes)?;
        more(&mut bvh.blocks, blocks.saturating_sub(wear.free.len()))?;
        let saved = made.iter().map(|m| m.saved).sum();
        made.drain(..).for_each(|made| made.put(bvh, wear));
        order.copy(bvh, wear);
        Ok(saved)
    }
}

/// A treelet for the node `root`, and what it saves.
struct Made {
    root: usize,
    treelet: Treelet,
    freed: Vec<u32>,
    /// Room for where its blocks go.
    places: Vec<usize>,
    saved: f64,
}

impl Made {
    /// Appends its nodes but the first, and puts its blocks where there is room.
    fn put(self, bvh: &mut Bvh, wear: &mut Wear) {
        let Made { root, treelet, mut freed, mut places, .. } = self;
        freed.sort_unstable();
        let mut own = freed.iter().copied();
        for block in treelet.blocks {
            let place = own.next().or_else(|| wear.free.pop()).unwrap_or(bvh.blocks.len() as u32);
            match bvh.blocks.get_mut(place as usize) {
                Some(to) => *to = block,
                None => bvh.blocks.push(block),
            }
            places.push(place as usize);
        }
        wear.free.extend(own);
        let first = bvh.nodes.len();
        let parts = treelet.nodes.into_iter().zip(treelet.was).zip(treelet.fresh);
        for (i, ((mut node, was), fresh)) in parts.enumerate() {
            for (_, child) in node.children.iter_mut().enumerate().filter(|(lane, _)| fresh >> lane & 1 != 0) {
                *child = if child.is_leaf() {
                    ChildRef::leaf(places[child.blocks().start], 1)
                } else {
                    // The first one is not appended.
                    ChildRef::node(first + child.index() - 1)
                };
            }
            if i == 0 {
                (bvh.nodes[root], wear.was[root]) = (node, was);
            } else {
                bvh.nodes.push(node);
                wear.was.push(was);
            }
        }
    }
}

/// Copies what hangs on the root to other memory: some top nodes, then one subtree after another.
struct Order {
    nodes: Vec<Node8>,
    was: Vec<Areas>,
    /// Places whose children are numbers of the old order yet.
    open: Vec<usize>,
    below: Vec<(usize, usize, usize)>,
}

impl Order {
    /// In the memory of the last time.
    fn with_room_for(count: usize, wear: &mut Wear) -> Result<Self, OutOfMemory> {
        let mut nodes = recycled(std::mem::take(&mut wear.spare_nodes), count)?;
        let mut was = recycled(std::mem::take(&mut wear.spare_was), count)?;
        nodes.clear();
        was.clear();
        wear.parts.clear();
        wear.parts.room(PARTS * WIDTH)?;
        Ok(Self { nodes, was, open: vec_of(PARTS)?, below: vec_of(PARTS * WIDTH)? })
    }

    fn copy(mut self, bvh: &mut Bvh, wear: &mut Wear) {
        let (mut open, mut below) = (std::mem::take(&mut self.open), std::mem::take(&mut self.below));
        open.push(self.push(bvh, wear, 0));
        let mut depth = 0;
        while !open.is_empty() {
            depth += 1;
            for parent in open.drain(..) {
                below.extend((0..WIDTH).filter_map(|lane| Some((parent, lane, self.inner(parent, lane)?))));
            }
            let are_parts = below.len() >= PARTS;
            let mut deepest = 0;
            for (parent, lane, child) in below.drain(..) {
                let begin = self.nodes.len();
                self.nodes[parent].children[lane] = ChildRef::node(begin);
                if are_parts {
                    deepest = deepest.max(self.subtree(bvh, wear, child));
                    wear.parts.push(begin..self.nodes.len());
                } else {
                    open.push(self.push(bvh, wear, child));
                }
            }
            depth += deepest;
        }
        bvh.set_depth(depth);
        bvh.subtrees.clear();
        wear.spare_nodes = std::mem::replace(&mut bvh.nodes, self.nodes);
        wear.spare_was = std::mem::replace(&mut wear.was, self.was);
    }

    fn push(&mut self, bvh: &Bvh, wear: &Wear, index: usize) -> usize {
        self.nodes.push(bvh.nodes[index]);
        self.was.push(wear.was[index]);
        self.nodes.len() - 1
    }

    fn inner(&self, parent: usize, lane: usize) -> Option<usize> {
        let child = self.nodes[parent].children[lane];
        (!child.is_leaf() && !child.is_empty()).then(|| child.index())
    }

    /// Appends a subtree, parents before children; gives its depth, which bounds the recursion.
    fn subtree(&mut self, bvh: &Bvh, wear: &Wear, index: usize) -> usize {
        let place = self.push(bvh, wear, index);
        let mut deepest = 0;
        for lane in 0..WIDTH {
            if let Some(child) = self.inner(place, lane) {
                self.nodes[place].children[lane] = ChildRef::node(self.nodes.len());
                deepest = deepest.max(self.subtree(bvh, wear, child));
            }
        }
        deepest + 1
    }
}
