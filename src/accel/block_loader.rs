//! Copying the corners of triangles into blocks, and the boxes around them: most of the work of a refit.
//!
//! Blocks are written in the order in which they lie, while their triangles are scattered over the mesh. So the loop runs in three
//! stages: far ahead of the block that is written it asks for the triangles' vertex numbers, nearer it reads these and asks
//! for the vertices. Corners are loaded as vectors of four coordinates, the last belonging to the next vertex, and
//! transposed to lanes.

use super::Aabb;
use super::aabb::{MAX_COORDINATE, PAD_ABSOLUTE, PAD_EXTENT, PAD_ULP};
use super::bvh::{BLOCK, Tri4};
use crate::scene::Mesh;
use crate::simd::{self, Kernel, components, prefetch};
use glam::{BVec4A, Mat4, Vec4};
use std::ops::Range;

/// Blocks between asking for vertices and loading them; twice as many before, their numbers are asked for.
const AHEAD: usize = 4;

/// A box; the last lanes are meaningless.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockBox {
    pub lo: Vec4,
    pub hi: Vec4,
}

impl BlockBox {
    pub const EMPTY: BlockBox = BlockBox { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub fn union(self, other: &Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Half the surface area; 0 for an empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let e = (self.hi - self.lo).max(Vec4::ZERO);
        e.x * e.y + (e.y * e.z + e.z * e.x)
    }
}

impl From<BlockBox> for Aabb {
    fn from(b: BlockBox) -> Aabb {
        Aabb { lo: b.lo.truncate(), hi: b.hi.truncate() }
    }
}

/// Where the numbers of the triangles of a block come from.
pub(super) trait Prims {
    /// Of the block at an index of `blocks`.
    fn prims(&self, blocks: &[Tri4], index: usize) -> [u32; BLOCK];
}

/// Sets numbers and corners of all blocks, and their boxes, of which there are as many.
pub(super) struct Load<'a, P> {
    pub mesh: &'a Mesh,
    pub blocks: &'a mut [Tri4],
    pub prims: &'a P,
    pub boxes: &'a mut [BlockBox],
}

/// Vertex numbers of the triangles of a block.
type Rows = [[u32; 3]; BLOCK];

impl<P: Prims> Kernel for Load<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { mesh, blocks, prims, boxes } = self;
        let coordinates = components(&mesh.positions);
        let mut ring = [[[0u32; 3]; BLOCK]; AHEAD];
        for index in 0..AHEAD.min(blocks.len()) {
            ring[index % AHEAD] = rows(mesh, prims.prims(blocks, index));
        }
        for (index, bounds_of_block) in boxes.iter_mut().enumerate().take(blocks.len()) {
            let triangles = ring[index % AHEAD];
            if index + 2 * AHEAD < blocks.len() {
                for prim in prims.prims(blocks, index + 2 * AHEAD) {
                    prefetch(&mesh.triangles, prim as usize);
                }
            }
            if index + AHEAD < blocks.len() {
                ring[index % AHEAD] = rows(mesh, prims.prims(blocks, index + AHEAD));
            }
            let numbers = prims.prims(blocks, index);
            let block = &mut blocks[index];
            block.prims = numbers;
            let corners = [
                corner(coordinates, &triangles, 0),
                corner(coordinates, &triangles, 1),
                corner(coordinates, &triangles, 2),
            ];
            for (to, from) in block.corners.iter_mut().zip(&corners) {
                for (to, from) in to.iter_mut().zip(from) {
                    *to = from.to_array();
                }
            }
            *bounds_of_block = bounds(&corners);
        }
    }
}

/// Reads the vertex numbers of four triangles and asks for the vertices.
#[inline(always)]
fn rows(mesh: &Mesh, [a, b, c, d]: [u32; BLOCK]) -> Rows {
    let t = &mesh.triangles[..];
    let rows = [t[a as usize], t[b as usize], t[c as usize], t[d as usize]];
    for row in &rows {
        for vertex in row {
            prefetch(&mesh.positions, *vertex as usize);
        }
    }
    rows
}

/// One corner of four triangles, a vector per axis.
#[inline(always)]
fn corner(coordinates: &[f32], triangles: &Rows, corner: usize) -> [Vec4; 3] {
    let [a, b, c, d] = [triangles[0][corner], triangles[1][corner], triangles[2][corner], triangles[3][corner]];
    let lanes =
        Mat4::from_cols(vertex(coordinates, a), vertex(coordinates, b), vertex(coordinates, c), vertex(coordinates, d))
            .transpose();
    [lanes.x_axis, lanes.y_axis, lanes.z_axis]
}

/// A vertex; the last lane is meaningless.
#[inline(always)]
pub(super) fn vertex(coordinates: &[f32], index: u32) -> Vec4 {
    let start = 3 * index as usize;
    // One comparison, where a slice from `start` on and its length would be two.
    match coordinates.get(start..start + 4) {
        Some(point) => Vec4::from_slice(point),
        // The last vertex of the mesh.
        None => Vec4::new(coordinates[start], coordinates[start + 1], coordinates[start + 2], 0.0),
    }
}

/// The boxes of four triangles, a lane each, as [`super::triangle_bounds`] has them: empty for unusable ones.
#[derive(Clone, Copy, Debug)]
struct Boxes4 {
    lo: [Vec4; 3],
    hi: [Vec4; 3],
}

impl Boxes4 {
    #[inline(always)]
    fn new(corners: &[[Vec4; 3]; 3]) -> Self {
        let [a, b, c] = corners;
        let mut lo = [Vec4::ZERO; 3];
        let mut hi = [Vec4::ZERO; 3];
        let mut usable = BVec4A::new(true, true, true, true);
        for axis in 0..3 {
            let reach = (a[axis].abs() + b[axis].abs()) + c[axis].abs();
            usable &= reach.cmple(Vec4::splat(3.0 * MAX_COORDINATE));
            lo[axis] = a[axis].min(b[axis]).min(c[axis]);
            hi[axis] = a[axis].max(b[axis]).max(c[axis]);
        }
        let extent = (hi[0] - lo[0]).max(hi[1] - lo[1]).max(hi[2] - lo[2]);
        for axis in 0..3 {
            let largest = lo[axis].abs().max(hi[axis].abs());
            let pad = (extent * PAD_EXTENT + largest * PAD_ULP) + Vec4::splat(PAD_ABSOLUTE);
            lo[axis] -= pad;
            hi[axis] += pad;
        }
        if !usable.all() {
            for axis in 0..3 {
                lo[axis] = Vec4::select(usable, lo[axis], Vec4::INFINITY);
                hi[axis] = Vec4::select(usable, hi[axis], Vec4::NEG_INFINITY);
            }
        }
        Self { lo, hi }
    }

    /// A vector per triangle: lower and upper corners. The last lanes are 0.
    #[inline(always)]
    fn transposed(&self) -> [Mat4; 2] {
        [self.lo, self.hi].map(|rows| Mat4::from_cols(rows[0], rows[1], rows[2], Vec4::ZERO).transpose())
    }
}

/// Takes the boxes of triangles, one after another.
pub(super) trait TakeBox {
    /// Lower and upper corner, whose last lane is 0; an unusable triangle has an empty box.
    fn take(&mut self, lo: Vec4, hi: Vec4);
}

/// Hands the boxes of the triangles `prims` to `to`.
pub(super) struct EachBox<'a, T> {
    pub mesh: &'a Mesh,
    pub prims: Range<usize>,
    pub to: &'a mut T,
}

impl<T: TakeBox> Kernel for EachBox<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { mesh, prims, to } = self;
        let coordinates = components(&mesh.positions);
        for rows in mesh.triangles[prims].chunks(BLOCK) {
            let last = rows.len() - 1;
            let triangles = [rows[0], rows[1.min(last)], rows[2.min(last)], rows[3.min(last)]];
            let corners = [
                corner(coordinates, &triangles, 0),
                corner(coordinates, &triangles, 1),
                corner(coordinates, &triangles, 2),
            ];
            let [lo, hi] = Boxes4::new(&corners).transposed();
            to.take(lo.x_axis, hi.x_axis);
            if last >= 1 {
                to.take(lo.y_axis, hi.y_axis);
            }
            if last >= 2 {
                to.take(lo.z_axis, hi.z_axis);
            }
            if last >= 3 {
                to.take(lo.w_axis, hi.w_axis);
            }
        }
    }
}

/// The union of the boxes of four triangles.
#[inline(always)]
fn bounds(corners: &[[Vec4; 3]; 3]) -> BlockBox {
    let [lo, hi] = Boxes4::new(corners).transposed();
    BlockBox {
        lo: lo.x_axis.min(lo.y_axis).min(lo.z_axis.min(lo.w_axis)),
        hi: hi.x_axis.max(hi.y_axis).max(hi.z_axis.max(hi.w_axis)),
    }
}

/// The box of a block, from the corners in it.
pub(super) fn block_bounds(block: &Tri4) -> Aabb {
    bounds(&block.corners.map(|axes| axes.map(Vec4::from_array))).into()
}

/// Loads with what this processor has.
pub(super) fn load(work: Load<'_, impl Prims>) {
    simd::run(simd::Level::detect(), work);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::triangle_bounds;
    use glam::Vec3;

    #[test]
    fn a_block_has_the_bounds_of_its_triangles() {
        let tri = [Vec3::new(1.0, 2.0, -3.0), Vec3::new(1e-40, 5.0, 0.0), Vec3::new(-7.5, 1.0, 1e6)];
        let mut triangles = [1.0, 0.1, 1e-20, 3.0].map(|scale| tri.map(|p| p * scale));
        triangles[1][1].y = f32::NAN;
        let rows = |axis: usize, corner: usize| Vec4::from_array(triangles.map(|t| t[corner][axis]));
        let corners: [[Vec4; 3]; 3] = std::array::from_fn(|corner| std::array::from_fn(|axis| rows(axis, corner)));
        let expected = triangles.iter().fold(Aabb::EMPTY, |all, t| all.union(triangle_bounds(*t)));
        let found = bounds(&corners);
        assert_eq!(Aabb { lo: found.lo.truncate(), hi: found.hi.truncate() }, expected);
    }
}
