//! Leaves of a tree against packets of rays.
//!
//! Two ways, which give the same bits, chosen by how densely the rays fill their vectors:
//!
//! * *dense*: 8 rays against one triangle. All of the test is done in lanes, up to the clamped distance; only hits that come before a ray's best
//!   one are written ray by ray.
//! * *sparse*: one ray against the four triangles of a block, as in [`super::triangle4`].
//!
//! The dense test permutes the axes of all 8 rays alike, so it is run for each axis on which some of them are longest.

use super::one_ray::InPacket;
use super::packet::{Found, LANES, Packet, RAYS, groups, groups_of, splat3};
use super::shells::Shells;
use super::traverse_packet::Alike;
use super::triangle4::{Boxes, RayLanes, edges4};
use super::{Hit, SLAB_PAD, triangle};
use crate::accel::{BLOCK, Tri4};
use crate::simd::{Isa, Vector, bits};

/// Rays per vector of rays that are longest on the same axis, from which the dense way is the cheaper one.
const DENSE: u32 = 3;

/// Tests the rays in `mask` against the blocks of a leaf. With `ANY`, rays that hit something leave `found.open`; else their best hits are replaced. Returns whether any did.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn intersect_leaf<I: Shells, const ANY: bool>(
    packet: &Packet,
    mask: u64,
    alike: Alike,
    blocks: &[Tri4],
    object: u32,
    instance: u32,
    found: &mut Found,
) -> bool {
    let mut any = false;
    let mut vectors = 0;
    for of_axis in &packet.dominant {
        vectors += groups_of(mask & of_axis).count_ones();
    }
    let dense = mask.count_ones() >= DENSE * vectors;
    for block in blocks {
        let mask = if ANY { mask & found.open } else { mask };
        if dense {
            for axis in 0..3 {
                let these = mask & packet.dominant[axis];
                if these != 0 {
                    // SAFETY: the caller's promise.
                    any |= unsafe {
                        if alike.one_origin {
                            dense_block::<I, ANY, true>(packet, these, axis, alike.down, block, object, instance, found)
                        } else {
                            dense_block::<I, ANY, false>(
                                packet, these, axis, alike.down, block, object, instance, found,
                            )
                        }
                    };
                }
            }
        } else {
            // SAFETY: the caller's promise.
            any |= unsafe { sparse_block::<I, ANY>(packet, mask, alike.down, block, object, instance, found) };
        }
    }
    any
}

/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn sparse_block<I: Shells, const ANY: bool>(
    packet: &Packet,
    mask: u64,
    down: [bool; 3],
    block: &Tri4,
    object: u32,
    instance: u32,
    found: &mut Found,
) -> bool {
    let mut any = false;
    for r in bits(mask) {
        let (g, l) = (r / LANES, r % LANES);
        let ray = InPacket::new(packet, r, down);
        // SAFETY: the caller's promise.
        unsafe {
            let Some((candidates, edges)) = edges4::<I>(&RayLanes::new(ray), block) else { continue };
            if ANY {
                let mut none = Hit::none(found.t[g][l]);
                if I::resolve::<true, _>(ray, block, candidates, &edges, (object, instance), &mut none) {
                    found.open &= !(1 << r);
                    any = true;
                }
            } else {
                let best = &mut found.hits[r];
                if I::resolve::<false, _>(ray, block, candidates, &edges, (object, instance), best) {
                    found.t[g][l] = best.t;
                    any = true;
                }
            }
        }
    }
    any
}

/// 8 rays that are longest on `axis` against one triangle after the other. With `ONE_ORIGIN` all rays of `mask` begin at one point.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // one call, inlined
unsafe fn dense_block<I: Isa, const ANY: bool, const ONE_ORIGIN: bool>(
    packet: &Packet,
    mask: u64,
    axis: usize,
    down: [bool; 3],
    block: &Tri4,
    object: u32,
    instance: u32,
    found: &mut Found,
) -> bool {
    let (kz, kx, ky) = (axis % 3, (axis + 1) % 3, (axis + 2) % 3);
    let first = mask.trailing_zeros() as usize % RAYS;
    let mut any = false;
    // Of all its triangles at once, and only if some ray meets one.
    let (mut boxes, mut boxed) = ([[0.0; BLOCK]; 7], false);
    for lane in 0..BLOCK {
        // A block that is not full repeats its last triangle.
        if lane > 0 && block.prims[lane] == block.prims[lane - 1] {
            break;
        }
        // SAFETY: the caller's promise.
        unsafe {
            let mut corners = [[I::F8::splat(0.0); 3]; 3];
            for (to, from) in corners.iter_mut().zip(&block.corners) {
                *to = splat3::<I>([from[kx][lane], from[ky][lane], from[kz][lane]]);
                if ONE_ORIGIN {
                    for (x, axis) in to.iter_mut().zip([kx, ky, kz]) {
                        *x = x.sub(I::F8::splat(packet.org[axis][first / LANES][first % LANES]));
                    }
                }
            }
            for g in groups(mask) {
                let here = (mask >> (LANES * g)) as u32 & 0xff;
                let mut sheared = corners;
                if !ONE_ORIGIN {
                    let (ox, oy) = (I::F8::load(&packet.org[kx][g]), I::F8::load(&packet.org[ky][g]));
                    let oz = I::F8::load(&packet.org[kz][g]);
                    for p in &mut sheared {
                        *p = [p[0].sub(ox), p[1].sub(oy), p[2].sub(oz)];
                    }
                }
                let (sx, sy) = (I::F8::load(&packet.shear[0][g]), I::F8::load(&packet.shear[1][g]));
                for p in &mut sheared {
                    *p = [p[0].sub(sx.mul(p[2])), p[1].sub(sy.mul(p[2])), p[2]];
                }
                let [a, b, c] = sheared;
                let u = c[0].mul(b[1]).sub(c[1].mul(b[0]));
                let v = a[0].mul(c[1]).sub(a[1].mul(c[0]));
                let w = b[0].mul(a[1]).sub(b[1].mul(a[0]));
                let zero = I::F8::splat(0.0);
                let out = u.min(v).min(w).lt(zero) & zero.lt(u.max(v).max(w));
                let candidates = here & !out;
                if candidates == 0 {
                    continue;
                }
                // `triangle::weigh`, computed for all and used where it is good. As in `triangle::all_exact`, NaN fails.
                let infinity = I::F8::splat(f32::INFINITY);
                if !boxed {
                    boxed = true;
                    Boxes::<I>::new(block).store(&mut boxes);
                }
                let det = u.add(v).add(w);
                let inv_det = I::F8::splat(1.0).div(det);
                let scale = I::F8::load(&packet.shear[2][g]);
                let (az, bz, cz) = (scale.mul(a[2]), scale.mul(b[2]), scale.mul(c[2]));
                let numerator = u.mul(az).add(v.mul(bz)).add(w.mul(cz));
                let (au, av, aw) = (u.abs(), v.abs(), w.abs());
                let (size, top) = (det.abs(), numerator.abs());
                let good = zero.lt(au.min(av).min(aw))
                    & au.lt(infinity)
                    & av.lt(infinity)
                    & aw.lt(infinity)
                    & I::F8::splat(boxes[6][lane]).le(size)
                    & size.lt(infinity)
                    & I::F8::splat(triangle::LEAST_NUMERATOR).le(top)
                    & top.lt(infinity);
                if candidates & !good != 0 {
                    any |= inexact::<ANY>(packet, candidates & !good, g, block, lane, object, instance, found);
                }
                let candidates = candidates & good;
                if candidates == 0 {
                    continue;
                }
                let t = numerator.mul(inv_det);
                // `triangle::accept`.
                let mut enter = I::F8::splat(f32::NEG_INFINITY);
                let mut exit = infinity;
                for (k, down) in down.into_iter().enumerate() {
                    let org = I::F8::load(&packet.org[k][g]);
                    let inv = I::F8::load(&packet.inv_dir[k][g]);
                    let (near, far) = if down { (3 + k, k) } else { (k, 3 + k) };
                    enter = I::F8::splat(boxes[near][lane]).sub(org).mul(inv).max(enter);
                    exit = I::F8::splat(boxes[far][lane]).sub(org).mul(inv).min(exit);
                }
                let exit = exit.mul(I::F8::splat(SLAB_PAD));
                let meets = enter.le(exit) & t.le(t);
                let t = exit.min(enter.max(t));
                let limit = I::F8::load(&found.t[g]);
                let tmin = I::F8::load(&packet.tmin[g]);
                let hits = candidates & meets & tmin.le(t) & t.le(limit);
                if hits == 0 {
                    continue;
                }
                if ANY {
                    found.open &= !(u64::from(hits) << (LANES * g));
                    any = true;
                    continue;
                }
                let mut out = [[0.0; LANES]; 3];
                t.store(&mut out[0]);
                v.mul(inv_det).store(&mut out[1]);
                w.mul(inv_det).store(&mut out[2]);
                for l in bits(u64::from(hits)).map(|l| l % LANES) {
                    let hit = Hit {
                        t: out[0][l],
                        u: out[1][l],
                        v: out[2][l],
                        primitive: block.prims[lane],
                        object,
                        instance,
                    };
                    let best = &mut found.hits[LANES * g + l];
                    if hit.replaces(best) {
                        found.t[g][l] = hit.t;
                        any = true;
                    }
                }
            }
        }
    }
    any
}

/// Rays through an edge or a vertex or nearly in the triangle's plane, and overflows: the scalar test.
#[cold]
#[inline(never)]
#[allow(clippy::too_many_arguments)] // one call, from the lanes' loop
fn inexact<const ANY: bool>(
    packet: &Packet,
    candidates: u32,
    g: usize,
    block: &Tri4,
    lane: usize,
    object: u32,
    instance: u32,
    found: &mut Found,
) -> bool {
    let mut any = false;
    for l in bits(u64::from(candidates)).map(|l| l % LANES) {
        let r = LANES * g + l;
        let ray = packet.ray(r, found.t[g][l]);
        let Some(h) = triangle::intersect(&ray, block.corners(lane)) else { continue };
        if ANY {
            found.open &= !(1 << r);
            any = true;
            continue;
        }
        let hit = Hit { t: h.t, u: h.u, v: h.v, primitive: block.prims[lane], object, instance };
        if hit.replaces(&mut found.hits[r]) {
            found.t[g][l] = hit.t;
            any = true;
        }
    }
    any
}
