//! Picking and batches of rays.

use super::constants::*;
use super::guard::guard;
use super::pointer::{Out, slice, slice_mut};
use super::types::*;
use crate::api::{Error, Hit, Ray, Result};

fn hit_of(hit: Option<Hit>) -> RThit {
    match hit {
        Some(h) => RThit { t: h.t, u: h.u, v: h.v, primitive: h.prim, object: h.object, instance: h.instance },
        None => RThit { t: -1.0, ..RThit::default() },
    }
}

fn is_coherent(flags: RTbitfield) -> Result<bool> {
    if flags & !RT_COHERENT != 0 {
        return Err(Error::invalid_value("an unknown flag"));
    }
    Ok(flags & RT_COHERENT != 0)
}

/// The engine's rays of the application's.
fn rays_of(rays: &[RTray]) -> Result<Vec<Ray>> {
    let mut out = Vec::new();
    out.try_reserve_exact(rays.len())?;
    out.extend(rays.iter().map(|r| Ray { org: r.origin.into(), tmin: r.tmin, dir: r.direction.into(), tmax: r.tmax }));
    Ok(out)
}

/// Stores at hit what the camera of the last frame sees at the window coordinates (x, y), and returns RT_TRUE
/// if it is anything. Pixel centres are at .5, and the origin is at the lower left, or at the upper left when
/// RT_ORIGIN_TOP_LEFT is enabled. Waits for a frame that is being rendered.
///
/// Errors: RT_INVALID_VALUE when hit is NULL or a number is not finite; RT_INVALID_OPERATION before the first
/// frame, between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtPick(x: RTfloat, y: RTfloat, hit: *mut RThit) -> RTboolean {
    // SAFETY: `hit` is NULL or a place for a hit, says the manual.
    let out = unsafe { Out::new(hit) };
    guard(|cx| {
        cx.is_object(0)?;
        let out = out.check()?;
        let found = cx.pick(x, y)?;
        out.set(hit_of(found));
        Ok(found.is_some().into())
    })
}

/// Stores at hits, for each of the n rays at rays, what it meets first in the scene of the last frame or
/// rtCommitScene(). flags is 0 or RT_COHERENT. Rays that are not finite, or have no direction, hit nothing.
/// Waits for a frame that is being rendered.
///
/// Errors: RT_INVALID_VALUE when n is negative, a pointer is NULL, or flags are unknown; RT_INVALID_OPERATION
/// between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject(); RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtIntersectRays(n: RTsizei, rays: *const RTray, hits: *mut RThit, flags: RTbitfield) {
    guard(|cx| {
        cx.is_object(0)?;
        let coherent = is_coherent(flags)?;
        // SAFETY: `rays` is NULL or points to n rays, says the manual; they are copied before anything is written.
        let rays = rays_of(unsafe { slice(rays, n)? })?;
        // SAFETY: `hits` is NULL or a place for n hits, says the manual.
        let hits = unsafe { slice_mut(hits, n)? };
        for (to, hit) in hits.iter_mut().zip(cx.intersect_rays(&rays, coherent)?) {
            *to = hit_of(hit);
        }
        Ok(())
    })
}

/// Stores at occluded, for each of the n rays at rays, RT_TRUE when anything is in its way, else RT_FALSE.
/// Quicker than rtIntersectRays(), and otherwise as that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtOccludedRays(n: RTsizei, rays: *const RTray, occluded: *mut RTubyte, flags: RTbitfield) {
    guard(|cx| {
        cx.is_object(0)?;
        let coherent = is_coherent(flags)?;
        // SAFETY: `rays` is NULL or points to n rays, says the manual; they are copied before anything is written.
        let rays = rays_of(unsafe { slice(rays, n)? })?;
        // SAFETY: `occluded` is NULL or a place for n bytes, says the manual.
        let occluded = unsafe { slice_mut(occluded, n)? };
        for (to, hit) in occluded.iter_mut().zip(cx.occluded_rays(&rays, coherent)?) {
            *to = hit.into();
        }
        Ok(())
    })
}
