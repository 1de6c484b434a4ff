//! Blocks of triangles gathered from where they lie, for leaves that refer to triangles by number.

use crate::accel::{BLOCK, Corners, Tri4};
use glam::Mat4;

/// The triangles `refs` of a list, as a block.
///
/// # Safety
/// - All of `refs` are below the length of the list.
#[inline(always)]
pub(super) unsafe fn gather(triangles: &[Corners], [a, b, c, d]: [u32; BLOCK]) -> Tri4 {
    // SAFETY: the caller's promise.
    let [a, b, c, d] = unsafe {
        [
            triangles.get_unchecked(a as usize),
            triangles.get_unchecked(b as usize),
            triangles.get_unchecked(c as usize),
            triangles.get_unchecked(d as usize),
        ]
    };
    let mut block = Tri4 { corners: [[[0.0; BLOCK]; 3]; 3], prims: [a.prim(), b.prim(), c.prim(), d.prim()] };
    // Written out: closures given to `array::map` would not be compiled for the caller's instruction set.
    for corner in 0..3 {
        let lanes = Mat4::from_cols(a.rows()[corner], b.rows()[corner], c.rows()[corner], d.rows()[corner]).transpose();
        block.corners[corner] = [lanes.x_axis.to_array(), lanes.y_axis.to_array(), lanes.z_axis.to_array()];
    }
    block
}
