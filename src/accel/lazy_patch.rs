//! Partial updates of a lazy tree: some vertices moved, the others are where they were.
//!
//! Segments that are up to date stay so: what changed in them is written at once, and goes up to the root as far as boxes change ([`super::links`]). For a
//! segment that no ray has reached, the lane above it grows by what moved; it is written as a whole when a ray comes. If a segment is up to date,
//! those above it are too, so there is one border between the two kinds on every path.

use super::Aabb;
use super::bvh::{ChildRef, OutOfMemory, WIDTH};
use super::lazy::{LazyBvh, Source};
use super::lazy_cut::LazyBlock;
use super::lazy_write::box_of_triangles;
use super::links::{Below, Links, Upwards, set_lane};
use crate::memory::collected;
use crate::scene::Mesh;
use crate::simd::number_at;

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
        let blocks = links.blocks_of(vertices)?;
        let mut upwards = Upwards::from_leaves(blocks.len())?;
        self.set_source(source);
        let mut last = None;
        for &block in &blocks {
            let (node, lane) = links.leaf(block as usize);
            let segment = self.segment_of(node);
            let is_current = self.parts.is_current(segment);
            if is_current {
                self.write_corners(block as usize, segment, mesh);
            }
            // The blocks of a leaf are neighbours.
            if last.replace((node, lane)) == Some((node, lane)) {
                continue;
            }
            let run = self.topology.children[node][lane].blocks();
            let bounds = box_of_triangles(&self.topology.blocks[run], mesh);
            if !is_current {
                self.grow_above(segment, &bounds, &links, &mut upwards);
            } else if self.set_lane(node, lane, &bounds) {
                upwards.push(node);
            }
        }
        let mut count = 0;
        while let Some(node) = upwards.pop() {
            count += 1;
            let segment = self.segment_of(node);
            let first = self.first_of(segment);
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

    /// Writes those of a segment's vertices that are corners of a block.
    fn write_corners(&mut self, block: usize, segment: usize, mesh: &Mesh) {
        let LazyBlock { corners, prims } = &self.topology.blocks[block];
        let first = self.topology.segments[segment].held.start;
        let vertices = self.parts.part_mut(segment).1;
        for (lane, &prim) in prims.iter().enumerate() {
            for (corner, places) in mesh.corners(prim).into_iter().zip(corners) {
                vertices[number_at(places[lane]) - first] = corner.extend(0.0);
            }
        }
    }

    /// Makes room for `bounds` in the lowest lane above a segment that is up to date, or in the box of the whole.
    fn grow_above(&mut self, mut segment: usize, bounds: &Aabb, links: &Links, upwards: &mut Upwards) {
        while let Some((node, lane)) = links.parent(self.first_of(segment)) {
            segment = self.segment_of(node);
            if self.parts.is_current(segment) {
                let first = self.first_of(segment);
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
        let first = self.first_of(segment);
        set_lane(&mut self.parts.part_mut(segment).0[node - first], lane, bounds)
    }

    /// The number of a segment's first node.
    fn first_of(&self, segment: usize) -> usize {
        self.topology.segments[segment].nodes.start
    }

    /// The segment of a node.
    fn segment_of(&self, node: usize) -> usize {
        self.topology.segments.partition_point(|s| s.nodes.end <= node)
    }

    fn make_links(&self, mesh: &Mesh) -> Result<Links, OutOfMemory> {
        let topology = &self.topology;
        let below = |child: &ChildRef| {
            if !child.is_leaf() {
                Below::Node(child.index())
            } else if let Some(segment) = topology.segment_of_leaf(*child) {
                Below::Node(self.first_of(segment))
            } else {
                Below::Blocks(child.blocks())
            }
        };
        let lanes = topology.children.iter().enumerate().flat_map(|(node, children)| {
            let used = children.iter().take_while(|c| !c.is_empty()).enumerate();
            used.map(move |(lane, child)| (WIDTH * node + lane, below(child)))
        });
        let prims = collected(topology.blocks.iter().map(|block| block.prims))?;
        Links::new(topology.children.len(), &prims, lanes, mesh)
    }
}
