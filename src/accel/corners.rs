//! Triangles for structures whose leaves refer to them by number: [`super::Bsp`] and [`super::Grid`].
//!
//! 48 bytes, so that each corner is one load of four numbers, and four triangles are four loads and a transposition per corner. A triangle in
//! three leaves takes 48 bytes and three references, where copies in blocks would take 120.

use super::bvh::BLOCK;
use glam::{Vec3, Vec4};

/// The corners of a triangle, and its number in the mesh.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct Corners {
    /// Three coordinates each; the fourth of the first is the bits of the number, the others are 0.
    rows: [Vec4; 3],
}

const _: () = assert!(size_of::<Corners>() == 48);

impl Corners {
    pub(super) const NONE: Corners = Corners { rows: [Vec4::ZERO; 3] };

    #[inline(always)]
    pub(super) fn new(prim: u32, [a, b, c]: [Vec3; 3]) -> Self {
        Self { rows: [a.extend(f32::from_bits(prim)), b.extend(0.0), c.extend(0.0)] }
    }

    /// The triangle's number in the mesh.
    #[inline(always)]
    pub fn prim(&self) -> u32 {
        self.rows[0].w.to_bits()
    }

    #[inline(always)]
    pub fn corners(&self) -> [Vec3; 3] {
        self.rows.map(Vec4::truncate)
    }

    /// The corners with their fourth numbers.
    #[inline(always)]
    pub fn rows(&self) -> &[Vec4; 3] {
        &self.rows
    }
}

/// Up to four references as a block: a shorter one repeats its last, which finds the same hit again.
///
/// # Panics
/// If there is none, or more than four.
#[inline(always)]
pub fn block_of(refs: &[u32]) -> [u32; BLOCK] {
    let last = refs.len() - 1;
    assert!(last < BLOCK, "a block has up to four triangles");
    [refs[0], refs[1.min(last)], refs[2.min(last)], refs[last]]
}
