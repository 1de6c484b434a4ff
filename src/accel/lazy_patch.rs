//! Partial updates of a lazy tree: some vertices moved, the others are where they were.
//!
//! Segments that are up to date stay so: what changed in them is written at once, and goes up to the root as far as boxes change ([`super::links`]). For a
//! segment that no ray has reached, the lane above it grows by what moved; it is written as a whole when a ray comes. If a segment is up to date,
//! those above it are too, so there is one border between the two kinds on every path.

use super::Aabb;
use super::bvh::{ChildRef, OutOfMemory, Tri4, WIDTH};
use super::lazy::{LazyBvh, Source};
use super::links::{Below, Links, Upwards, set_lane, set_leaf, write_block};
use crate::scene::Mesh;

impl LazyBvh {
    /// Says that `vertices` moved, and no others. Returns the number of nodes looked at.
    ///
    /// # Errors
    /// No memory for the ways up the tree, which are made the first time; nothing has changed then.
    pub(super) fn moved_some(&mut self, mesh: &Mesh, source: Source, vertices: &[u32]) -> Result<usize, OutOfMemory> {
        let links = match self.links.take() {
            Some(links) => links,
            None => self.make_links(mesh)?,
        };
        self.set_source(source);
        let mut upwards = Upwards::default();
        let blocks = links.blocks_of(vertices);
        let mut last = None;
        for &block in &blocks {
            let block = block as usize;
            let (node, lane) = links.leaf(block);
            let segment = self.segment_of(node);
            if !self.parts.is_current(segment) {
                let mut moved = Tri4 { prims: self.topology.prims[block], ..Tri4::EMPTY };
                let bounds = write_block(&mut moved, mesh);
                self.grow_above(segment, &bounds, &links, &mut upwards);
                continue;
            }
            let (first_node, first_block) = self.first_of(segment);
            write_block(&mut self.parts.part_mut(segment).1[block - first_block], mesh);
            // The blocks of a leaf are neighbours; its box is taken when all are written.
            if last.replace((segment, node, lane)) != Some((segment, node, lane)) {
                upwards.push(node);
            }
            debug_assert!(node >= first_node);
        }
        self.set_leaves(&blocks, &links);
        let mut count = 0;
        while let Some(node) = upwards.pop() {
            count += 1;
            let segment = self.segment_of(node);
            let (first, _) = self.first_of(segment);
            let bounds = self.parts.part_mut(segment).0[node - first].union();
            match links.parent(node) {
                Some((parent, lane)) => {
                    if self.set_lane(parent, lane, &bounds) {
                        upwards.push(parent);
                    }
                }
                None => self.bounds = bounds,
            }
        }
        self.links = Some(links);
        Ok(count)
    }

    /// The boxes of the leaves of `blocks`, where they are up to date.
    fn set_leaves(&mut self, blocks: &[u32], links: &Links) {
        let mut last = None;
        for leaf in blocks.iter().map(|&block| links.leaf(block as usize)) {
            if last.replace(leaf) == Some(leaf) {
                continue;
            }
            let (node, lane) = leaf;
            let segment = self.segment_of(node);
            if self.parts.is_current(segment) {
                let (first, _) = self.first_of(segment);
                let (nodes, blocks) = self.parts.part_mut(segment);
                let node = &mut nodes[node - first];
                let run = node.children[lane].blocks();
                set_leaf(node, lane, &blocks[run]);
            }
        }
    }

    /// Makes room for `bounds` in the lowest lane above a segment that is up to date, or in the box of the whole.
    fn grow_above(&mut self, mut segment: usize, bounds: &Aabb, links: &Links, upwards: &mut Upwards) {
        while let Some((node, lane)) = links.parent(self.first_of(segment).0) {
            segment = self.segment_of(node);
            if self.parts.is_current(segment) {
                let (first, _) = self.first_of(segment);
                let own = &mut self.parts.part_mut(segment).0[node - first];
                let grown = own.child_bounds(lane).union(*bounds);
                if set_lane(own, lane, &grown) {
                    upwards.push(node);
                }
                return;
            }
        }
        self.bounds = self.bounds.union(*bounds);
    }

    fn set_lane(&mut self, node: usize, lane: usize, bounds: &Aabb) -> bool {
        let segment = self.segment_of(node);
        let (first, _) = self.first_of(segment);
        set_lane(&mut self.parts.part_mut(segment).0[node - first], lane, bounds)
    }

    /// The numbers of a segment's first node and block in the whole tree.
    fn first_of(&self, segment: usize) -> (usize, usize) {
        let segment = &self.topology.segments[segment];
        (segment.nodes.start, segment.blocks.start)
    }

    /// The segment of a node.
    fn segment_of(&self, node: usize) -> usize {
        self.topology.segments.partition_point(|s| s.nodes.end <= node)
    }

    fn make_links(&self, mesh: &Mesh) -> Result<Links, OutOfMemory> {
        let topology = &self.topology;
        let lanes = topology.segments.iter().flat_map(|segment| {
            segment.nodes.clone().flat_map(move |node| {
                let used = topology.children[node].iter().take_while(|c| !c.is_empty()).enumerate();
                used.map(move |(lane, child): (usize, &ChildRef)| {
                    let below = if !child.is_leaf() {
                        Below::Node(segment.nodes.start + child.index())
                    } else if child.blocks().start < segment.blocks.len() {
                        let run = child.blocks();
                        Below::Blocks(segment.blocks.start + run.start..segment.blocks.start + run.end)
                    } else {
                        let number = segment.below.start + child.blocks().start - segment.blocks.len();
                        Below::Node(topology.segments[number].nodes.start)
                    };
                    (WIDTH * node + lane, below)
                })
            })
        });
        Links::new(topology.children.len(), &topology.prims, lanes, mesh)
    }
}
