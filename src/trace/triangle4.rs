//! The triangle test of [`super::triangle`], four triangles at a time.
//!
//! The operations are the scalar ones, one by one, so the result is that of the scalar test, bit for bit. A lane is out when one of its
//! edge functions is below 0 and another above: both signs are exact (see there), so a third one that is 0 or not a number
//! cannot change it. Lanes that f32 does not tell well (there) take the scalar way by f64, the others go on up to the clamped distance:
//! a ray that starts on a surface meets the edge functions of the triangle it has left, and with the rest of the
//! test in scalars that alone was a quarter of all instructions of a diffuse bounce.
//!
//! # Hits that are surely beyond the ray's interval
//!
//! The triangle that a ray has left, and those behind the best hit, need no box: half of what is resolved of a diffuse bounce. Let `R` be the largest
//! coordinate of the sheared corners (`reach`), `Z` the largest distance of a corner along the ray's longest axis, and `T` the exact weighed
//! distance. An edge function is wrong by at most `2^-22 R^2`. So if their sum is at least `R^2 / 64`, the weighed distance, by f32 or by f64, is
//! within `6 * 2^-16 Z + 2^-20 Z` of `T`; below a sum of 1e-30 underflow would add to that. And the ray meets the padded box at `T`, or by rounding
//! of shear and slab (see [`SLAB_PAD`]) within `16 * 2^-24 Z` of it. The clamped distance lies between the weighed one and there, so it
//! is within `Z / 4096` of the weighed one, twice that and more. 1e-12 covers what the denormals of a meeting point near the origin lose.

use super::one_ray::OneRay;
use super::{Hit, PreparedRay, SLAB_PAD, triangle};
use crate::accel::{BLOCK, LEAST_SEEN, PAD_ABSOLUTE, PAD_EXTENT, PAD_ULP, Tri4};
use crate::simd::{Isa, Vector};

/// What the four-wide test derives from a ray, in registers.
#[derive(Clone, Copy)]
pub(super) struct RayLanes<I: Isa> {
    /// Origin and shear, in the order of the ray's permuted axes.
    org: [I::F4; 3],
    shear: [I::F4; 2],
    /// Where in a corner of [`Tri4`] the rows of these axes begin, in bytes.
    rows: [usize; 3],
}

/// By the axis on which a ray is longest: the order of its axes, and [`RayLanes::rows`] of it. (A fourth, so that two bits need no check.)
const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];
const ROW: usize = size_of::<[f32; BLOCK]>();
const ROWS: [[usize; 3]; 4] = [[ROW, 2 * ROW, 0], [2 * ROW, 0, ROW], [0, ROW, 2 * ROW], [0, ROW, 2 * ROW]];

impl<I: Isa> RayLanes<I> {
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn new(ray: impl OneRay) -> Self {
        let longest = ray.longest_axis() & 3;
        let [x, y, z] = ray.permuted_org(AXES[longest]);
        // SAFETY: the caller's promise.
        unsafe {
            Self {
                org: [I::F4::splat(x), I::F4::splat(y), I::F4::splat(z)],
                shear: [I::F4::splat(ray.shear(0)), I::F4::splat(ray.shear(1))],
                rows: ROWS[longest],
            }
        }
    }
}

/// The edge functions of four triangles: `u, v, w`, the corners' depths before the shear, of opposite sign, and the largest of the corners'
/// other coordinates after it.
pub(super) struct Edges<I: Isa> {
    weights: [I::F4; 3],
    neg_depth: [I::F4; 3],
    reach: I::F4,
}

/// Share of the square of `reach` that the sum of the edge functions has where the distance is well known (see the module's head).
const WELL_SEEN: f32 = 1.0 / 64.0;
const LEAST_SUM: f32 = 1e-30;
/// The reciprocal of a larger one loses bits.
const LARGEST_SUM: f32 = 1e37;
/// How far a clamped distance is from the weighed one at most, as a share of the farthest corner's distance, and at least.
const MARGIN: f32 = 1.0 / 4096.0;
const LEAST_MARGIN: f32 = 1e-12;

/// The lanes that the edge functions leave, if any, and what they have computed.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn edges4<I: Isa>(lanes: &RayLanes<I>, block: &Tri4) -> Option<(u32, Edges<I>)> {
    let [kx, ky, kz] = lanes.rows;
    // SAFETY: the caller's promise; a corner has three rows, and `rows` are where they begin.
    unsafe {
        // Of opposite sign, all three: the operand that comes from memory is the one that is subtracted. In products of two the sign is gone.
        let sheared = |corner: usize| {
            let p = (&raw const block.corners[corner]).cast::<u8>();
            let row = |at: usize| I::F4::load(&*p.add(at).cast::<[f32; BLOCK]>());
            let z = lanes.org[2].sub(row(kz));
            let x = lanes.org[0].sub(row(kx)).sub(lanes.shear[0].mul(z));
            let y = lanes.org[1].sub(row(ky)).sub(lanes.shear[1].mul(z));
            [x, y, z]
        };
        let (a, b, c) = (sheared(0), sheared(1), sheared(2));
        let u = c[0].mul(b[1]).sub(c[1].mul(b[0]));
        let v = a[0].mul(c[1]).sub(a[1].mul(c[0]));
        let w = b[0].mul(a[1]).sub(b[1].mul(a[0]));
        // A minimum below 0 is one of the three, even if another is NaN; the same for the maximum.
        let zero = I::F4::splat(0.0);
        let least = u.min(v).min(w);
        let most = u.max(v).max(w);
        let candidates = !(least.lt(zero) & zero.lt(most)) & 0xf;
        if candidates == 0 {
            return None;
        }
        let reach = a[0].abs().max(a[1].abs()).max(b[0].abs()).max(b[1].abs()).max(c[0].abs()).max(c[1].abs());
        Some((candidates, Edges { weights: [u, v, w], neg_depth: [a[2], b[2], c[2]], reach }))
    }
}

/// The rest: tests the candidates of a block against the ray's own interval and `best`, which every hit that comes before it replaces
/// (with the number of the triangle and of `best`'s candidate object and instance). With `ANY` the first hit ends the test.
/// Returns whether there was a hit that counts.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn resolve<I: Isa, const ANY: bool, R: OneRay>(
    ray: R,
    block: &Tri4,
    candidates: u32,
    edges: &Edges<I>,
    object: u32,
    instance: u32,
    best: &mut Hit,
) -> bool {
    let mut found = false;
    // SAFETY: the caller's promise.
    unsafe {
        let (zero, infinity) = (I::F4::splat(0.0), I::F4::splat(f32::INFINITY));
        // `triangle::weigh`. Of edge functions that are not finite, the sum is not either.
        let [u, v, w] = edges.weights;
        let [a, b, c] = edges.neg_depth;
        let scale = I::F4::splat(-ray.shear(2));
        let (az, bz, cz) = (scale.mul(a), scale.mul(b), scale.mul(c));
        let det = u.add(v).add(w);
        let numerator = u.mul(az).add(v.mul(bz)).add(w.mul(cz));
        let inv_det = I::F4::splat(1.0).div(det);
        let t = numerator.mul(inv_det);
        let (size, top) = (det.abs(), numerator.abs());
        // Those that the module's head tells of; comparisons with NaN leave a lane in.
        let tmin = I::F4::splat(ray.tmin());
        let well_seen = edges.reach.mul(edges.reach).mul(I::F4::splat(WELL_SEEN)).add(I::F4::splat(LEAST_SUM));
        let margin = az.abs().max(bz.abs()).max(cz.abs()).mul(I::F4::splat(MARGIN)).add(I::F4::splat(LEAST_MARGIN));
        let beyond = t.add(margin).lt(tmin) | I::F4::splat(best.t).lt(t.sub(margin));
        let known = well_seen.le(size) & size.le(I::F4::splat(LARGEST_SUM)) & top.lt(infinity);
        let candidates = candidates & !(beyond & known);
        if candidates == 0 {
            return false;
        }
        let Boxes { lo, hi, least_area } = Boxes::<I>::new(block);
        let good = zero.lt(u.abs().min(v.abs()).min(w.abs()))
            & least_area.le(size)
            & size.lt(infinity)
            & I::F4::splat(triangle::LEAST_NUMERATOR).le(top)
            & top.lt(infinity);
        let others = candidates & !good;
        if others != 0 {
            found |= resolve_alone::<ANY>(&ray.prepared(best.t), block, others, object, instance, best);
            if ANY && found {
                return true;
            }
        }
        let candidates = candidates & good;
        // `triangle::accept`.
        let (mut enter, mut exit) = (I::F4::splat(f32::NEG_INFINITY), infinity);
        for k in 0..3 {
            let (org, inv) = (I::F4::splat(ray.org(k)), I::F4::splat(ray.inv_dir(k)));
            let (from_lo, from_hi) = (lo[k].sub(org).mul(inv), hi[k].sub(org).mul(inv));
            enter = from_lo.min(from_hi).max(enter);
            exit = from_lo.max(from_hi).min(exit);
        }
        let exit = exit.mul(I::F4::splat(SLAB_PAD));
        let meets = enter.le(exit) & t.le(t);
        let t = exit.min(enter.max(t));
        let mut hits = candidates & meets & tmin.le(t) & t.le(I::F4::splat(best.t));
        if ANY {
            return hits != 0;
        }
        if hits == 0 {
            return found;
        }
        let mut out = [[0.0; BLOCK]; 3];
        t.store(&mut out[0]);
        v.mul(inv_det).store(&mut out[1]);
        w.mul(inv_det).store(&mut out[2]);
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize & (BLOCK - 1);
            hits &= hits - 1;
            let [t, u, v] = out.map(|row| row[lane]);
            let prim = block.prims[lane];
            found |=
                !ray.excludes(t, instance, prim) && Hit { t, u, v, primitive: prim, object, instance }.replaces(best);
        }
    }
    found
}

/// `triangle_bounds` and `least_area` of four triangles. Their corners must be finite and in range, as all in a block are but those that have
/// become NaN (which make edge functions that are not good).
pub(super) struct Boxes<I: Isa> {
    lo: [I::F4; 3],
    hi: [I::F4; 3],
    least_area: I::F4,
}

impl<I: Isa> Boxes<I> {
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn new(block: &Tri4) -> Self {
        // SAFETY: the caller's promise.
        unsafe {
            // No closures or `map`: they would be functions without the instruction set.
            let zero = [I::F4::splat(0.0); 3];
            let (mut lo, mut hi, mut pad) = (zero, zero, zero);
            let mut extent = zero[0];
            for k in 0..3 {
                let [a, b, c] = &block.corners;
                let (a, b, c) = (I::F4::load(&a[k]), I::F4::load(&b[k]), I::F4::load(&c[k]));
                (lo[k], hi[k]) = (a.min(b).min(c), a.max(b).max(c));
                extent = hi[k].sub(lo[k]).max(extent);
                pad[k] = lo[k].abs().max(hi[k].abs()).mul(I::F4::splat(PAD_ULP));
            }
            let extent = extent.mul(I::F4::splat(PAD_EXTENT));
            for k in 0..3 {
                let pad = extent.add(pad[k]).add(I::F4::splat(PAD_ABSOLUTE));
                (lo[k], hi[k]) = (lo[k].sub(pad), hi[k].add(pad));
            }
            let side = hi[0].sub(lo[0]).max(hi[1].sub(lo[1])).max(hi[2].sub(lo[2]));
            let least_area = side.mul(side).mul(I::F4::splat(LEAST_SEEN)).add(I::F4::splat(f32::MIN_POSITIVE));
            Self { lo, hi, least_area }
        }
    }

    /// The rows of `lo`, of `hi`, and `least_area`.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn store(self, to: &mut [[f32; BLOCK]; 7]) {
        // SAFETY: the caller's promise.
        unsafe {
            for k in 0..3 {
                self.lo[k].store(&mut to[k]);
                self.hi[k].store(&mut to[3 + k]);
            }
            self.least_area.store(&mut to[6]);
        }
    }
}

/// The scalar test, for what f32 does not tell well.
#[cold]
#[inline(never)]
fn resolve_alone<const ANY: bool>(
    ray: &PreparedRay,
    block: &Tri4,
    mut candidates: u32,
    object: u32,
    instance: u32,
    best: &mut Hit,
) -> bool {
    let mut found = false;
    while candidates != 0 {
        let lane = candidates.trailing_zeros() as usize & (BLOCK - 1);
        candidates &= candidates - 1;
        let Some(h) = triangle::intersect(ray, block.corners(lane)) else { continue };
        if ANY {
            return true;
        }
        let prim = block.prims[lane];
        let hit = Hit { t: h.t, u: h.u, v: h.v, primitive: prim, object, instance };
        found |= !ray.excludes(h.t, instance, prim) && hit.replaces(best);
    }
    found
}
