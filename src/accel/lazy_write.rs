//! Writes a segment of a lazy tree: its vertices, and the boxes of its nodes from them.
//!
//! A segment holds a copy of its vertices, each once, in a row; its blocks refer to these by number. So to bring it up to date, each vertex is
//! fetched once from the mesh, wherever it is there, and all else is done in the nearest cache: a leaf's box is the box of its vertices, padded as a
//! whole. Blocks are not looked at for that, but lists of the eight vertices or fewer that each has, a quarter as large: whole trees are written without
//! reading a block. What rays do not test is not laid out for them: who tests a block gathers its corners.
//!
//! Boxes are padded in lanes, eight at a time, when they are written.
//!
//! *Measured* on nine bodies (`cargo bench --bench papers -- larsson1`, 10x10): from the blocks, rays and what they update take 1.08 times as long. Where nodes were asked for
//! ahead by one for two vertices, and not by one for eight, three of four that came were of other segments: 190 instead of 150 ns per node written.
//!
//! *Why not blocks with corners copied in, as other trees have*: they were, and to write them took three quarters of the time of a segment, most
//! of it waiting for memory: 53 bytes per triangle to be fetched, changed and put back, where vertices take 9. See [`super::lazy`] for what both cost.

use super::Aabb;
use super::aabb::{PAD_ABSOLUTE, PAD_EXTENT, PAD_ULP};
use super::block_loader::{BlockBox, vertex};
use super::bvh::{Node8, WIDTH};
use super::lazy_cut::{LazyBlock, Segment, Topology};
use super::lazy_number::{MANY, Outline};
use super::refit::set_bounds;
use super::triangle_bounds;
use super::vertex_box::{AHEAD, LIMIT, ask_for_first, box_of_set, each_listed};
use crate::scene::Mesh;
use crate::simd::{Kernel, box_at, box_at_few, components, prefetch_at};
use glam::{BVec4A, Vec4};
use std::ops::Range;

/// Vertices between asking for more of what is needed after them.
const STEP: usize = 8;
/// Outlines in a line of the cache.
const OUTLINES: usize = 64 / size_of::<Outline>();

/// Nodes and vertices are those of the segment, `below` knows the boxes of the segments below. Returns whether a triangle can be hit that was unusable at
/// the build.
pub(super) struct Write<'a, B> {
    pub topology: &'a Topology,
    pub segment: &'a Segment,
    pub mesh: &'a Mesh,
    pub nodes: &'a mut [Node8],
    pub vertices: &'a mut [Vec4],
    pub below: B,
}

impl<B: Below> Kernel for Write<'_, B> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { topology, segment, mesh, nodes, vertices, below } = self;
        let outlines = &topology.outlines[segment.blocks.clone()];
        let (first_outline, first_node, first_vertex) = (outlines.as_ptr(), nodes.as_ptr(), vertices.as_ptr());
        let (last_line, last_node) = (outlines.len() / OUTLINES * OUTLINES, nodes.len() - 1);
        // So many vertices have one node at least and a line of outlines, by and large. The last are needed first. To ask for others does no harm.
        let usable = fetch(mesh, &topology.vertices, segment.held.clone(), vertices, |i| {
            let step = i / STEP;
            prefetch_at(first_vertex.wrapping_add(i + STEP).cast::<[Vec4; STEP]>());
            prefetch_at(first_outline.wrapping_add(last_line).wrapping_sub(step * OUTLINES));
            if step <= last_node {
                prefetch_at(first_node.wrapping_add(last_node - step));
            }
        });
        // Not closures: these would be compiled for any processor.
        if usable && !segment.dropped {
            let leaves = Vertices { vertices, segment, outlines };
            write_nodes(topology, segment, nodes, &below, leaves);
            return false;
        }
        let mut any = false;
        write_nodes(topology, segment, nodes, &below, Triangles { mesh, any: &mut any });
        any && segment.dropped
    }
}

/// Where the box of a segment below comes from, around its vertices.
pub(super) trait Below {
    /// Of segment `number`.
    fn of(&self, number: usize) -> BlockBox;
}

/// From a list that begins with that of segment `first`.
pub(super) struct Known<'a> {
    pub boxes: &'a [BlockBox],
    pub first: usize,
}

impl Below for Known<'_> {
    #[inline(always)]
    fn of(&self, number: usize) -> BlockBox {
        self.boxes[number - self.first]
    }
}

/// From the vertices.
pub(super) struct Asked<'a> {
    pub topology: &'a Topology,
    pub mesh: &'a Mesh,
}

impl Below for Asked<'_> {
    fn of(&self, number: usize) -> BlockBox {
        let Self { topology, mesh } = self;
        let Aabb { lo, hi } = box_of_set(&mesh.positions, &topology.around, &topology.segments[number].around);
        BlockBox { lo: lo.extend(0.0), hi: hi.extend(0.0) }
    }
}

/// Where the box of a leaf comes from, which is then padded.
trait Leaves {
    /// Of these blocks.
    fn leaf(&mut self, topology: &Topology, blocks: Range<usize>) -> BlockBox;
}

/// From the vertices of a segment.
struct Vertices<'a> {
    vertices: &'a [Vec4],
    segment: &'a Segment,
    /// Of its blocks.
    outlines: &'a [Outline],
}

impl Leaves for Vertices<'_> {
    #[inline(always)]
    fn leaf(&mut self, topology: &Topology, blocks: Range<usize>) -> BlockBox {
        let (mut lo, mut hi) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        for block in blocks {
            let outline = &self.outlines[block - self.segment.blocks.start];
            let (least, most) = if outline[0] != MANY[0] {
                box_at_few(self.vertices, outline)
            } else {
                box_at(self.vertices, self.segment.held.start, &topology.blocks[block].corners)
            };
            (lo, hi) = (lo.min(least), hi.max(most));
        }
        BlockBox { lo, hi }
    }
}

/// From triangles some of which may be unusable; `any` tells if one was not.
struct Triangles<'a> {
    mesh: &'a Mesh,
    any: &'a mut bool,
}

impl Leaves for Triangles<'_> {
    fn leaf(&mut self, topology: &Topology, blocks: Range<usize>) -> BlockBox {
        let bounds = box_of_triangles(&topology.blocks[blocks], self.mesh);
        *self.any |= !bounds.is_empty();
        BlockBox { lo: bounds.lo.extend(0.0), hi: bounds.hi.extend(0.0) }
    }
}

/// Copies the vertices of a list, and calls `also` at every [`STEP`]th; the last lanes are meaningless. Returns whether all may be of usable triangles.
#[inline(always)]
fn fetch(mesh: &Mesh, lists: &[u32], which: Range<usize>, vertices: &mut [Vec4], also: impl Fn(usize)) -> bool {
    let mut usable = BVec4A::new(true, true, true, true);
    let mut to = vertices.iter_mut().enumerate();
    ask_for_first(&mesh.positions, &lists[which.clone()]);
    let coordinates = components(&mesh.positions);
    each_listed(&mesh.positions, lists, which, AHEAD, |index| {
        let p = vertex(coordinates, index);
        // NaN fails.
        usable &= p.abs().cmple(Vec4::splat(LIMIT));
        if let Some((i, to)) = to.next() {
            if i % STEP == 0 {
                also(i);
            }
            *to = p;
        }
    });
    usable.bitmask() & 7 == 7
}

/// Writes the boxes of all lanes, last node first, and then pads them, as [`super::aabb::padded`] does: those around vertices then contain the boxes of the
/// triangles between them. What is passed on to nodes above is not padded: they pad it themselves, by more.
#[inline(always)]
fn write_nodes(
    topology: &Topology,
    segment: &Segment,
    nodes: &mut [Node8],
    below: &impl Below,
    mut leaves: impl Leaves,
) {
    for i in (0..nodes.len()).rev() {
        let (before, after) = nodes.split_at_mut(i + 1);
        let node = &mut before[i];
        let mut lanes = [BlockBox::EMPTY; WIDTH];
        for (child, lane) in node.children.iter().zip(&mut lanes) {
            if child.is_empty() {
                break;
            }
            *lane = if !child.is_leaf() {
                around(&after[child.index() - segment.nodes.start - (i + 1)])
            } else if let Some(number) = topology.segment_of_leaf(*child) {
                below.of(number)
            } else {
                leaves.leaf(topology, child.blocks())
            };
        }
        set_bounds(node, &lanes);
    }
    nodes.iter_mut().for_each(pad);
}

/// The box around all lanes.
#[inline(always)]
fn around(node: &Node8) -> BlockBox {
    let row = |row: usize| {
        let half = |at: usize| Vec4::from_slice(&node.bounds[row][at..at + 4]);
        [half(0), half(4)]
    };
    let least = |at: usize| {
        let [a, b] = row(2 * at);
        a.min(b).min_element()
    };
    let most = |at: usize| {
        let [a, b] = row(2 * at + 1);
        a.max(b).max_element()
    };
    BlockBox { lo: Vec4::new(least(0), least(1), least(2), 0.0), hi: Vec4::new(most(0), most(1), most(2), 0.0) }
}

/// Boxes that are padded already grow a little more. Empty ones stay empty.
#[inline(always)]
fn pad(node: &mut Node8) {
    for half in 0..2 {
        let lanes = 4 * half..4 * half + 4;
        let row = |row: usize| Vec4::from_slice(&node.bounds[row][lanes.clone()]);
        let rows = [0, 1, 2].map(|axis| (row(2 * axis), row(2 * axis + 1)));
        let [(x, far_x), (y, far_y), (z, far_z)] = rows;
        let extent = (far_x - x).max(far_y - y).max(far_z - z).max(Vec4::ZERO);
        for (axis, (lo, hi)) in rows.into_iter().enumerate() {
            // The limit keeps the pad of an empty box finite.
            let largest = lo.abs().max(hi.abs()).min(Vec4::splat(LIMIT));
            let pad = (extent * PAD_EXTENT + largest * PAD_ULP) + Vec4::splat(PAD_ABSOLUTE);
            node.bounds[2 * axis][lanes.clone()].copy_from_slice(&(lo - pad).to_array());
            node.bounds[2 * axis + 1][lanes.clone()].copy_from_slice(&(hi + pad).to_array());
        }
    }
}

/// The box of a leaf some of whose triangles may be unusable.
pub(super) fn box_of_triangles(blocks: &[LazyBlock], mesh: &Mesh) -> Aabb {
    let prims = blocks.iter().flat_map(|block| block.prims);
    prims.fold(Aabb::EMPTY, |all, prim| all.union(triangle_bounds(mesh.corners(prim))))
}
