//! Boxes against packets of rays: all rays at once, 8 rays against one box, or one ray against 8 boxes.
//!
//! # Why no ray misses a box
//!
//! A ray's own test is [`super::PreparedRay::slab`], operation by operation, in the latter two. The interval test leaves out a child only
//! if every ray's own test would: rounded subtraction and multiplication are monotone in each argument, so a product over intervals is
//! bounded by the products of their ends, in floating point too. Best distances are padded as in the world's tests of `traverse_scene`, which
//! need it; an object's do not, and visit a box more now and then.

use super::SLAB_PAD;
use super::packet::{Found, GROUPS, LANES, Packet, Rows, groups, spread};
use crate::accel::{Aabb, Node8, WIDTH};
use crate::simd::{Eight, Isa, Vector, bits};

/// What box tests read of a packet. In the world, near planes are seen from an origin moved forward and far ones from one moved back (see
/// `traverse_scene`); in an object's space both are the origin.
pub(super) struct Slabs<'a> {
    pub near_org: &'a [Rows; 3],
    pub far_org: &'a [Rows; 3],
    pub inv_dir: &'a [Rows; 3],
    pub tmin: &'a Rows,
}

/// What all rays of a packet have in common: intervals of their origins and reciprocal directions.
pub(super) struct Bounds<I: Isa> {
    /// The origin that makes near planes nearest, and the one that makes far planes farthest.
    near_org: [I::F8; 3],
    far_org: [I::F8; 3],
    least_inv: [I::F8; 3],
    most_inv: [I::F8; 3],
    tmin: I::F8,
    tmin_most: I::F8,
    /// Rows of [`Node8::bounds`] with the near planes; the far ones are the other of each pair.
    pub near: [usize; 3],
    /// All rays begin at one point.
    pub one_origin: bool,
}

impl<I: Isa> Bounds<I> {
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn new(slabs: &Slabs, mask: u64, down: [bool; 3]) -> Self {
        // SAFETY: the caller's promise.
        unsafe {
            let zero = [I::F8::splat(0.0); 3];
            let mut one_origin = true;
            let (mut near_org, mut far_org, mut least_inv, mut most_inv) = (zero, zero, zero, zero);
            for k in 0..3 {
                let near = range::<I>(&slabs.near_org[k], mask);
                let same = std::ptr::eq(slabs.near_org, slabs.far_org);
                let far = if same { near } else { range::<I>(&slabs.far_org[k], mask) };
                one_origin &= near.0 == near.1 && far.0 == far.1;
                near_org[k] = I::F8::splat(if down[k] { near.0 } else { near.1 });
                far_org[k] = I::F8::splat(if down[k] { far.1 } else { far.0 });
                let (least, most) = range::<I>(&slabs.inv_dir[k], mask);
                (least_inv[k], most_inv[k]) = (I::F8::splat(least), I::F8::splat(most));
            }
            let (tmin, tmin_most) = range::<I>(slabs.tmin, mask);
            let (tmin, tmin_most) = (I::F8::splat(tmin), I::F8::splat(tmin_most));
            let near = [usize::from(down[0]), 2 + usize::from(down[1]), 4 + usize::from(down[2])];
            Self { near_org, far_org, least_inv, most_inv, tmin, tmin_most, near, one_origin }
        }
    }

    /// The children that some ray may enter, those that every ray enters for sure (asked only of rays with one origin), and where the first would.
    /// Best distances are from `least` to `most`.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn test(&self, node: &Node8, least: I::F8, most: I::F8) -> (u32, u32, [f32; WIDTH]) {
        // SAFETY: the caller's promise; rows are below 6 by construction, and `^ 1` stays inside their pairs.
        unsafe {
            let (mut enter, mut exit) = (self.tmin, I::F8::splat(f32::INFINITY));
            let (mut last_enter, mut first_exit) = (self.tmin_most, exit);
            for k in 0..3 {
                let row = self.near[k];
                let near = I::F8::load(node.bounds.get_unchecked(row)).sub(self.near_org[k]);
                let far = I::F8::load(node.bounds.get_unchecked(row ^ 1)).sub(self.far_org[k]);
                let (near_a, near_b) = (near.mul(self.least_inv[k]), near.mul(self.most_inv[k]));
                let (far_a, far_b) = (far.mul(self.least_inv[k]), far.mul(self.most_inv[k]));
                enter = near_a.min(near_b).max(enter);
                exit = far_a.max(far_b).min(exit);
                if self.one_origin {
                    last_enter = near_a.max(near_b).max(last_enter);
                    first_exit = far_a.min(far_b).min(first_exit);
                }
            }
            let mut distance = [0.0; WIDTH];
            enter.store(&mut distance);
            let pad = I::F8::splat(SLAB_PAD);
            let some = enter.le(exit.min(most).mul(pad));
            let all = if self.one_origin { last_enter.le(first_exit.min(least).mul(pad)) } else { 0 };
            (some, all, distance)
        }
    }

    /// The rays of `mask` that enter one child, 8 at a time.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`; these are bounds of `slabs` and the rays of `mask`.
    #[inline(always)]
    pub(super) unsafe fn entering(&self, slabs: &Slabs, found: &Found, mask: u64, node: &Node8, lane: usize) -> u64 {
        // SAFETY: the caller's promise.
        unsafe {
            if self.one_origin {
                entering::<I, true>(slabs, found, mask, node, lane, self)
            } else {
                entering::<I, false>(slabs, found, mask, node, lane, self)
            }
        }
    }
}

/// Least and greatest of the rays in `mask`.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn range<I: Isa>(rows: &[[f32; LANES]; GROUPS], mask: u64) -> (f32, f32) {
    // SAFETY: the caller's promise.
    unsafe {
        let (none_least, none_most) = (I::F8::splat(f32::INFINITY), I::F8::splat(f32::NEG_INFINITY));
        let (mut least, mut most) = (none_least, none_most);
        if mask == u64::MAX {
            for row in rows {
                let row = I::F8::load(row);
                (least, most) = (least.min(row), most.max(row));
            }
        } else {
            for g in groups(mask) {
                let here = (mask >> (LANES * g)) as u32;
                let row = I::F8::load(&rows[g]);
                least = least.min(row.select_bits(none_least, here));
                most = most.max(row.select_bits(none_most, here));
            }
        }
        (least.least(), most.greatest())
    }
}

/// Bounds of the distances that the rays of `mask` still look at.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn best_range<I: Isa>(found: &Found, mask: u64) -> (f32, f32) {
    // SAFETY: the caller's promise.
    unsafe {
        let (mut least, mut most) = (I::F8::splat(f32::INFINITY), I::F8::splat(0.0));
        // Lanes out of the mask only widen the bounds, or have no end at all (NaN): then what the others gave stays, as the second operand.
        for g in groups(mask) {
            let row = I::F8::load(&found.t[g]);
            (least, most) = (row.min(least), row.max(most));
        }
        (least.least(), most.greatest())
    }
}

/// The rays of `mask` whose best hit is not before `enter`.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn still_before<I: Isa>(found: &Found, mask: u64, enter: f32) -> u64 {
    let mut before = 0;
    // SAFETY: the caller's promise.
    let enter = unsafe { I::F8::splat(enter) };
    for g in groups(mask) {
        // SAFETY: the caller's promise.
        let these = unsafe { enter.le(I::F8::load(&found.t[g]).mul(I::F8::splat(SLAB_PAD))) };
        before |= u64::from(these) << (LANES * g);
    }
    mask & before
}

/// The rays of `mask` that enter one child, 8 at a time. With `ONE_ORIGIN`, `near_org` and `far_org` are those of all rays.
///
/// # Safety
/// - The processor has the instruction set `I`; `near` are rows of near planes.
#[inline(always)]
unsafe fn entering<I: Isa, const ONE_ORIGIN: bool>(
    slabs: &Slabs,
    found: &Found,
    mask: u64,
    node: &Node8,
    lane: usize,
    bounds: &Bounds<I>,
) -> u64 {
    let mut all = 0;
    // SAFETY: the caller's promise; `^ 1` stays inside the pairs of rows.
    unsafe {
        let (mut near_planes, mut far_planes) = ([I::F8::splat(0.0); 3], [I::F8::splat(0.0); 3]);
        for k in 0..3 {
            near_planes[k] = I::F8::splat(node.bounds.get_unchecked(bounds.near[k])[lane]);
            far_planes[k] = I::F8::splat(node.bounds.get_unchecked(bounds.near[k] ^ 1)[lane]);
            if ONE_ORIGIN {
                near_planes[k] = near_planes[k].sub(bounds.near_org[k]);
                far_planes[k] = far_planes[k].sub(bounds.far_org[k]);
            }
        }
        for g in groups(mask) {
            let (mut enter, mut exit) = (I::F8::load(&slabs.tmin[g]), I::F8::splat(f32::INFINITY));
            for k in 0..3 {
                let inv = I::F8::load(&slabs.inv_dir[k][g]);
                let (mut near, mut far) = (near_planes[k], far_planes[k]);
                if !ONE_ORIGIN {
                    near = near.sub(I::F8::load(&slabs.near_org[k][g]));
                    far = far.sub(I::F8::load(&slabs.far_org[k][g]));
                }
                enter = near.mul(inv).max(enter);
                exit = far.mul(inv).min(exit);
            }
            let limit = exit.min(I::F8::load(&found.t[g])).mul(I::F8::splat(SLAB_PAD));
            all |= u64::from(enter.le(limit)) << (LANES * g);
        }
    }
    all & mask
}

/// The rays of `mask` that meet `aabb` before their best hit, seen from their own origins.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn enters_box<I: Isa>(packet: &Packet, found: &Found, mask: u64, aabb: &Aabb) -> u64 {
    let mut all = 0;
    // SAFETY: the caller's promise.
    unsafe {
        for g in groups(mask) {
            let (mut enter, mut exit) = (I::F8::load(&packet.tmin[g]), I::F8::splat(f32::INFINITY));
            for k in 0..3 {
                let org = I::F8::load(&packet.org[k][g]);
                let inv = I::F8::load(&packet.inv_dir[k][g]);
                let from_lo = I::F8::splat(aabb.lo[k]).sub(org).mul(inv);
                let from_hi = I::F8::splat(aabb.hi[k]).sub(org).mul(inv);
                enter = from_lo.min(from_hi).max(enter);
                exit = from_lo.max(from_hi).min(exit);
            }
            let limit = exit.min(I::F8::load(&found.t[g])).mul(I::F8::splat(SLAB_PAD));
            all |= u64::from(enter.le(limit)) << (LANES * g);
        }
    }
    all & mask
}

/// The rays of `mask` that enter each child, and where the first of them does; one ray against all children at a time.
///
/// # Safety
/// - The processor has the instruction set `I`; `near` are rows of near planes.
#[inline(always)]
pub(super) unsafe fn ray_by_ray<I: Isa>(
    slabs: &Slabs,
    found: &Found,
    mask: u64,
    node: &Node8,
    near: [usize; 3],
) -> ([u64; WIDTH], [f32; WIDTH]) {
    let mut entering = [0u64; WIDTH];
    let mut distance = [0.0; WIDTH];
    // SAFETY: the caller's promise; `^ 1` stays inside the pairs of rows.
    unsafe {
        let infinity = I::F8::splat(f32::INFINITY);
        let mut first = infinity;
        for g in groups(mask) {
            // Byte c: the rays of this group that enter child c.
            let mut here = 0u64;
            for l in bits(mask >> (LANES * g) & 0xff).map(|l| l % LANES) {
                let (mut enter, mut exit) = (I::F8::splat(slabs.tmin[g][l]), infinity);
                for k in 0..3 {
                    let near_org = I::F8::splat(slabs.near_org[k][g][l]);
                    let far_org = I::F8::splat(slabs.far_org[k][g][l]);
                    let inv = I::F8::splat(slabs.inv_dir[k][g][l]);
                    let (near, far) = (node.bounds.get_unchecked(near[k]), node.bounds.get_unchecked(near[k] ^ 1));
                    enter = I::F8::load(near).sub(near_org).mul(inv).max(enter);
                    exit = I::F8::load(far).sub(far_org).mul(inv).min(exit);
                }
                let limit = exit.min(I::F8::splat(found.t[g][l])).mul(I::F8::splat(SLAB_PAD));
                first = first.min(enter.select_le(limit, enter, infinity));
                here |= spread(enter.le(limit)) << l;
            }
            for (c, rays) in entering.iter_mut().enumerate() {
                *rays |= (here >> (8 * c) & 0xff) << (LANES * g);
            }
        }
        first.store(&mut distance);
    }
    (entering, distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_spread_to_bytes_and_groups_are_found() {
        for byte in 0..=255u32 {
            let expected = (0..8).fold(0u64, |all, i| all | u64::from(byte >> i & 1) << (8 * i));
            assert_eq!(spread(byte), expected, "{byte:08b}");
        }
        for mask in [0, 1, 0x80, 0x8000_0000_0000_0000, 0x0100_ff00_0080_0001, u64::MAX] {
            let expected = (0..8).filter(|g| mask >> (8 * g) & 0xff != 0).fold(0u64, |all, g| all | 1 << (8 * g));
            assert_eq!(crate::trace::packet::groups_of(mask), expected, "{mask:016x}");
        }
    }
}
