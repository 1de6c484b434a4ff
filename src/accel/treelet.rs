//! Building the nodes between a node and what stays together below it anew.
//!
//! Items are subtrees that are kept as they are, and single triangles of leaves that are not. They are split from the top down as
//! the SAH builder splits triangles ([`super::build_sah`]), until a part is one subtree, or triangles that fit in one block. Up to eight subtrees are a
//! node as they are: most splits were of these.

use super::binning::find_split;
use super::block_loader::BlockBox;
use super::build_sah::{SAH_DEPTH, halve};
use super::bvh::{BLOCK, ChildRef, Node8, Tri4, WIDTH};
use super::partition::{From, Scratches, partition};
use super::prim_ref::PrimRef;
use super::refit::set_bounds;
use super::triangle_bounds;
use crate::memory::{OutOfMemory, collected, push};
use crate::simd::Level;
use glam::Vec4;
use std::ops::Range;

/// Half the areas of a node's lanes.
pub(super) type Areas = [f32; WIDTH];

/// A subtree that is kept, or a triangle.
#[derive(Clone, Copy)]
struct Item {
    bounds: BlockBox,
    what: What,
}

#[derive(Clone, Copy)]
enum What {
    /// With its area when it was in order.
    Subtree(ChildRef, f32),
    /// The place: block times [`BLOCK`] plus lane.
    Triangle(u32),
}

/// What is between a node and the subtrees below it that are kept.
#[derive(Default)]
pub(super) struct Items {
    items: Vec<Item>,
    /// Blocks whose triangles are among the items.
    pub freed: Vec<u32>,
}

impl Items {
    pub fn keep(&mut self, child: ChildRef, bounds: BlockBox, was: f32) -> Result<(), OutOfMemory> {
        push(&mut self.items, Item { bounds, what: What::Subtree(child, was) })
    }

    /// Adds the triangles of a block.
    pub fn dissolve(&mut self, index: usize, block: &Tri4) -> Result<(), OutOfMemory> {
        push(&mut self.freed, index as u32)?;
        for lane in 0..BLOCK {
            // One that repeats the one before is padding.
            if lane == 0 || block.prims[lane] != block.prims[lane - 1] {
                let bounds = triangle_bounds(block.corners(lane));
                let bounds = BlockBox { lo: bounds.lo.extend(0.0), hi: bounds.hi.extend(0.0) };
                push(&mut self.items, Item { bounds, what: What::Triangle((index * BLOCK + lane) as u32) })?;
            }
        }
        Ok(())
    }

    /// Builds over all items, whose triangles are in `blocks`. New parts count as in order, having grown by `growth`.
    pub fn build(&self, blocks: &[Tri4], growth: f32, scratches: &Scratches) -> Result<Treelet, OutOfMemory> {
        // What cannot be hit has no box, and has to be somewhere.
        let somewhere = self.items.iter().map(|item| item.bounds.lo).find(|lo| lo.x.is_finite()).unwrap_or(Vec4::ZERO);
        let mut refs = collected((0u32..).zip(&self.items).map(|(number, item)| {
            let BlockBox { lo, hi } = item.bounds;
            if lo.x <= hi.x { PrimRef::new(number, lo, hi) } else { PrimRef::new(number, somewhere, somewhere) }
        }))?;
        let treelet = Treelet { nodes: Vec::new(), was: Vec::new(), fresh: Vec::new(), blocks: Vec::new(), cost: 0.0 };
        let mut builder = Builder { level: Level::detect(), items: &self.items, blocks, growth, scratches, treelet };
        builder.node(&mut refs, 0)?;
        Ok(builder.treelet)
    }
}

/// New nodes and blocks. The first node is to replace the one above the items.
pub(super) struct Treelet {
    pub nodes: Vec<Node8>,
    pub was: Vec<Areas>,
    /// Per node, the lanes whose children are new: numbers of `nodes` and `blocks`.
    pub fresh: Vec<u8>,
    pub blocks: Vec<Tri4>,
    /// Sum of the areas of all lanes, times the blocks of leaves.
    pub cost: f64,
}

struct Builder<'a> {
    level: Level,
    items: &'a [Item],
    blocks: &'a [Tri4],
    growth: f32,
    scratches: &'a Scratches,
    treelet: Treelet,
}

impl Builder<'_> {
    /// Appends the node above `refs` and all below it; gives its number and its box.
    fn node(&mut self, refs: &mut [PrimRef], depth: usize) -> Result<(usize, BlockBox), OutOfMemory> {
        let index = self.treelet.nodes.len();
        push(&mut self.treelet.nodes, Node8::EMPTY)?;
        push(&mut self.treelet.was, [0.0; WIDTH])?;
        push(&mut self.treelet.fresh, 0)?;
        let (parts, count) = self.split_wide(refs, depth)?;
        let mut node = Node8::EMPTY;
        let (mut was, mut fresh) = ([0.0; WIDTH], 0);
        let mut lanes = [BlockBox::EMPTY; WIDTH];
        let mut all = BlockBox::EMPTY;
        for (lane, part) in parts[..count].iter().enumerate() {
            let refs = &mut refs[part.clone()];
            let bounds = match *refs {
                [only] if matches!(self.items[only.prim() as usize].what, What::Subtree(..)) => {
                    let Item { bounds, what } = self.items[only.prim() as usize];
                    if let What::Subtree(child, area) = what {
                        (node.children[lane], was[lane]) = (child, area);
                    }
                    bounds
                }
                _ => {
                    fresh |= 1 << lane;
                    let (child, bounds) = if self.is_unit(refs) {
                        let (block, bounds) = self.block(refs)?;
                        (ChildRef::leaf(block, 1), bounds)
                    } else {
                        let (below, bounds) = self.node(refs, depth + 1)?;
                        (ChildRef::node(below), bounds)
                    };
                    node.children[lane] = child;
                    was[lane] = bounds.half_area() / self.growth;
                    bounds
                }
            };
            let visits = if node.children[lane].is_leaf() { node.children[lane].blocks().len() } else { 1 };
            self.treelet.cost += f64::from(bounds.half_area()) * visits as f64;
            lanes[lane] = bounds;
            all = all.union(&bounds);
        }
        set_bounds(&mut node, &lanes);
        let Treelet { nodes, was: areas, fresh: new, .. } = &mut self.treelet;
        (nodes[index], areas[index], new[index]) = (node, was, fresh);
        Ok((index, all))
    }

    /// Whether it needs no node: one subtree, or triangles for one block.
    fn is_unit(&self, refs: &[PrimRef]) -> bool {
        let triangle = |r: &PrimRef| matches!(self.items[r.prim() as usize].what, What::Triangle(_));
        refs.len() == 1 || (refs.len() <= BLOCK && refs.iter().all(triangle))
    }

    /// Appends a block of triangles.
    fn block(&mut self, refs: &[PrimRef]) -> Result<(usize, BlockBox), OutOfMemory> {
        let mut block = Tri4::EMPTY;
        let mut all = BlockBox::EMPTY;
        for lane in 0..BLOCK {
            let item = &self.items[refs[lane.min(refs.len() - 1)].prim() as usize];
            if let What::Triangle(place) = item.what {
                let (from, at) = (&self.blocks[place as usize / BLOCK], place as usize % BLOCK);
                block.prims[lane] = from.prims[at];
                block.set_corners(lane, from.corners(at));
                all = all.union(&item.bounds);
            }
        }
        push(&mut self.treelet.blocks, block)?;
        Ok((self.treelet.blocks.len() - 1, all))
    }

    /// Splits a range into up to eight, the one of largest area first.
    fn split_wide(
        &mut self,
        refs: &mut [PrimRef],
        depth: usize,
    ) -> Result<([Range<usize>; WIDTH], usize), OutOfMemory> {
        let subtree = |r: &PrimRef| matches!(self.items[r.prim() as usize].what, What::Subtree(..));
        if refs.len() <= WIDTH && refs.iter().all(subtree) {
            // However they were split, each would get a lane.
            return Ok((std::array::from_fn(|i| i..i + 1), refs.len()));
        }
        let mut parts: [Range<usize>; WIDTH] = std::array::from_fn(|_| 0..refs.len());
        // What can be split no further has none.
        let mut areas = [f32::INFINITY; WIDTH];
        let mut count = 1;
        while count < WIDTH {
            let widest = (0..count).fold(0, |most, i| if areas[i] > areas[most] { i } else { most });
            if areas[widest] < 0.0 {
                break;
            }
            let Range { start, end } = parts[widest];
            let these = &mut refs[start..end];
            let found = if depth < SAH_DEPTH { find_split(self.level, these) } else { None };
            let (middle, bounds) = match found {
                Some(split) => (partition(self.level, these, &mut From::Any(self.scratches), &split)?, split.bounds),
                None => halve(self.level, these),
            };
            let middle = start + middle;
            for (at, part, bounds) in [(widest, start..middle, bounds[0]), (count, middle..end, bounds[1])] {
                areas[at] = if self.is_unit(&refs[part.clone()]) { -1.0 } else { bounds.half_area() };
                parts[at] = part;
            }
            count += 1;
        }
        Ok((parts, count))
    }
}
