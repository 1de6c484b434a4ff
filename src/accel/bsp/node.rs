//! A node of the object BSP: three levels of planes and the eight cells between them, in 64 bytes.
//!
//! ```text
//!                plane 0
//!          plane 1     plane 2            lane = 4 (above the first plane) + 2 (above the second) + 1 (above the third)
//!        plane 3 4     plane 5 6
//! lanes   0 1 2 3       4 5 6 7
//! ```
//!
//! A plane's axis is the lowest two bits of its position: builders move a plane by up to three steps of the last digit for it. So a node is one line of
//! the cache, and a ray tests three levels at once where binary nodes would be three loads that wait for each other. Cells have no boxes.
//! A leaf above the third level leaves planes out, which both sides of are the same cell, and lanes empty.

use crate::accel::bvh::{ChildRef, WIDTH};

/// Levels of planes in a node.
pub const LEVELS: usize = 3;

/// Seven planes, and eight children: nodes, leaves of blocks of references, or nothing.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct BspNode {
    /// By level, and from below to above. The eighth is none: it tells which lanes are not empty.
    planes: [f32; WIDTH],
    children: [ChildRef; WIDTH],
}

const _: () = assert!(size_of::<BspNode>() == 64);

/// The bits of an axis in a plane.
const AXIS: u32 = 3;
/// No plane: its "axis" is the fourth. A normal number, as denormal ones are slow.
const NO_PLANE: u32 = 0x3f80_0000 | AXIS;
/// Where the mask of used lanes is in the eighth.
const USED_SHIFT: u32 = 8;

impl BspNode {
    /// Without planes or children.
    pub(super) const EMPTY: BspNode =
        BspNode { planes: [f32::from_bits(NO_PLANE); WIDTH], children: [ChildRef::EMPTY; WIDTH] };

    /// Plane `number`, if there is one: its axis and position.
    #[inline]
    pub fn plane(&self, number: usize) -> Option<(usize, f32)> {
        let plane = self.planes[number];
        let axis = plane.to_bits() & AXIS;
        (axis != AXIS).then_some((axis as usize, plane))
    }

    pub(super) fn set_plane(&mut self, number: usize, plane: f32) {
        debug_assert!(number < WIDTH - 1 && plane.to_bits() & AXIS != AXIS);
        self.planes[number] = plane;
    }

    pub(super) fn set_child(&mut self, lane: usize, child: ChildRef) {
        debug_assert!(!child.is_empty());
        self.children[lane] = child;
        let last = &mut self.planes[WIDTH - 1];
        *last = f32::from_bits(last.to_bits() | 1 << (USED_SHIFT as usize + lane));
    }

    #[inline(always)]
    pub fn children(&self) -> &[ChildRef; WIDTH] {
        &self.children
    }

    /// All planes as they are kept, and in the last lane anything.
    #[inline(always)]
    pub fn rows(&self) -> &[f32; WIDTH] {
        &self.planes
    }

    /// The lanes that are not empty, a bit each.
    #[inline(always)]
    pub fn used(&self) -> u32 {
        self.planes[WIDTH - 1].to_bits() >> USED_SHIFT & 0xff
    }
}

/// The greatest float not above `position`, or if `up` the least not below, that has `axis` as its lowest bits.
pub(super) fn tagged(position: f32, axis: usize, up: bool) -> f32 {
    debug_assert!(axis < 3 && position.is_finite());
    // In this order neighbours are neighbours, also around 0.
    let ordered = |bits: u32| if bits >> 31 == 1 { (bits ^ 0x7fff_ffff) as i32 } else { bits as i32 };
    let bits = |ordered: i32| if ordered < 0 { ordered as u32 ^ 0x7fff_ffff } else { ordered as u32 };
    let mut at = ordered(position.to_bits());
    while bits(at) & AXIS != axis as u32 {
        at += if up { 1 } else { -1 };
    }
    f32::from_bits(bits(at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_gives_back_what_was_put_in() {
        let mut node = BspNode::EMPTY;
        assert_eq!(node.used(), 0);
        assert!((0..WIDTH).all(|number| node.plane(number).is_none()));
        let plane = tagged(-1.5e-30, 2, false);
        node.set_plane(6, plane);
        node.set_child(3, ChildRef::leaf(7, 2));
        node.set_child(7, ChildRef::node(123));
        assert_eq!(node.plane(6), Some((2, plane)));
        assert_eq!(node.plane(5), None);
        assert_eq!(node.used(), 1 << 3 | 1 << 7);
        assert_eq!((node.children()[3].blocks(), node.children()[7].index()), (7..9, 123));
    }

    #[test]
    fn a_tagged_plane_is_near_and_on_its_side() {
        for position in [0.0, -0.0, 1.0, -1.0, 1.0e-45, -1.0e-45, 3.1e-38, 1.8e18, -7.3, f32::MIN_POSITIVE] {
            for axis in 0..3 {
                for up in [false, true] {
                    let plane = tagged(position, axis, up);
                    assert_eq!(plane.to_bits() & 3, axis as u32);
                    assert!(if up { plane >= position } else { plane <= position }, "{position:e}: {plane:e}");
                    let steps = (plane - position).abs() / (position.abs() * f32::EPSILON).max(f32::from_bits(1));
                    assert!(steps <= 4.0, "{position:e}: {plane:e}");
                }
            }
        }
    }
}
