//! Picking and batches of rays, in the scene of the current context.

use super::constants::*;
use super::guard::guard;
use super::pointer::{Out, slice, slice_mut};
use super::types::*;
use crate::api::{Context, Error, Hit, Ray, Result};

// Rays and hits are read and written where the application has them.
const _: () = {
    use std::mem::offset_of;
    assert!(size_of::<RTray>() == size_of::<Ray>() && align_of::<RTray>() == align_of::<Ray>());
    assert!(offset_of!(RTray, origin) == offset_of!(Ray, origin) && offset_of!(RTray, tmin) == offset_of!(Ray, tmin));
    assert!(
        offset_of!(RTray, direction) == offset_of!(Ray, direction) && offset_of!(RTray, tmax) == offset_of!(Ray, tmax)
    );
    assert!(size_of::<RThit>() == size_of::<Hit>() && align_of::<RThit>() == align_of::<Hit>());
    assert!(offset_of!(RThit, t) == offset_of!(Hit, t) && offset_of!(RThit, u) == offset_of!(Hit, u));
    assert!(offset_of!(RThit, v) == offset_of!(Hit, v) && offset_of!(RThit, primitive) == offset_of!(Hit, primitive));
    assert!(offset_of!(RThit, object) == offset_of!(Hit, object));
    assert!(offset_of!(RThit, instance) == offset_of!(Hit, instance));
};

pub(super) fn hit_of(hit: Hit) -> RThit {
    RThit { t: hit.t, u: hit.u, v: hit.v, primitive: hit.primitive, object: hit.object, instance: hit.instance }
}

pub(super) fn is_coherent(flags: RTbitfield) -> Result<bool> {
    if flags & !RT_COHERENT != 0 {
        return Err(Error::invalid_value(format_args!("flags {flags:#x} are neither 0 nor RT_COHERENT")));
    }
    Ok(flags & RT_COHERENT != 0)
}

/// The `n` rays at `p`.
///
/// # Safety
/// `p` is NULL or points to n rays, which stay unchanged for `'a`.
#[inline]
pub(super) unsafe fn rays_at<'a>(p: *const RTray, n: RTsizei) -> Result<&'a [Ray]> {
    // SAFETY: the caller's promise; the layouts agree, see the top.
    unsafe { slice("rays", p.cast::<Ray>(), n) }
}

/// The places for `n` hits at `p`.
///
/// # Safety
/// `p` is NULL or a place for n hits, with no other reference for `'a`.
#[inline]
pub(super) unsafe fn hits_at<'a>(p: *mut RThit, n: RTsizei) -> Result<&'a mut [Hit]> {
    // SAFETY: the caller's promise; the layouts agree, see the top, and any bits are a hit.
    unsafe { slice_mut("hits", p.cast::<Hit>(), n) }
}

/// The places for `n` truths at `p`.
///
/// # Safety
/// `p` is NULL or a place for n bytes, with no other reference for `'a`.
#[inline]
pub(super) unsafe fn truths_at<'a>(p: *mut RTubyte, n: RTsizei) -> Result<&'a mut [bool]> {
    // SAFETY: the caller's promise. What is there may be no truth value, so it is written first.
    unsafe {
        slice_mut("occluded", p, n)?.fill(RT_FALSE);
        slice_mut("occluded", p.cast::<bool>(), n)
    }
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
    let out = unsafe { Out::new("hit", hit) };
    guard(|cx| {
        cx.is_object(0)?;
        let out = out.check()?;
        let found = cx.pick(x, y)?;
        out.set(hit_of(found.unwrap_or(Hit::MISS)));
        Ok(found.is_some().into())
    })
}

/// Stores at hits, for each of the n rays at rays, what it meets first in the scene of the last frame or
/// rtCommitScene(). flags is 0 or RT_COHERENT: neighbours in the array are neighbours in space. Rays that are not finite, or have no direction, hit
/// nothing. Up to some hundred rays are traced on the calling thread, without memory, lock or system call; more by all threads of the context. The two arrays must
/// not overlap. Waits for a frame that is being rendered. Other threads ask by rtAcquireScene().
///
/// Errors: RT_INVALID_VALUE when n is negative, a pointer is NULL, or flags are unknown; RT_INVALID_OPERATION
/// between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtIntersectRays(n: RTsizei, rays: *const RTray, hits: *mut RThit, flags: RTbitfield) {
    // SAFETY: `rays` is NULL or points to n rays, says the manual, and `hits` is NULL or a place for n hits elsewhere.
    guard(|cx| unsafe { intersect(cx, n, rays, hits, flags) })
}

/// Closest hits in the scene of a context.
///
/// # Safety
/// As [`rays_at`] and [`hits_at`], for arrays that do not overlap.
pub(super) unsafe fn intersect(
    cx: &mut Context,
    n: RTsizei,
    rays: *const RTray,
    hits: *mut RThit,
    flags: RTbitfield,
) -> Result<()> {
    cx.outside_object()?;
    let coherent = is_coherent(flags)?;
    // SAFETY: the caller's promises.
    let (rays, hits) = unsafe { (rays_at(rays, n)?, hits_at(hits, n)?) };
    cx.intersect_into(rays, hits, coherent)
}

/// Stores at occluded, for each of the n rays at rays, RT_TRUE when anything is in its way, else RT_FALSE.
/// Quicker than rtIntersectRays(), and otherwise as that.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtOccludedRays(n: RTsizei, rays: *const RTray, occluded: *mut RTubyte, flags: RTbitfield) {
    // SAFETY: `rays` is NULL or points to n rays, says the manual, and `occluded` is NULL or a place for n bytes elsewhere.
    guard(|cx| unsafe { occlude(cx, n, rays, occluded, flags) })
}

/// Whether rays are occluded in the scene of a context.
///
/// # Safety
/// As [`rays_at`] and [`truths_at`], for arrays that do not overlap.
pub(super) unsafe fn occlude(
    cx: &mut Context,
    n: RTsizei,
    rays: *const RTray,
    occluded: *mut RTubyte,
    flags: RTbitfield,
) -> Result<()> {
    cx.outside_object()?;
    let coherent = is_coherent(flags)?;
    // SAFETY: the caller's promises.
    let (rays, occluded) = unsafe { (rays_at(rays, n)?, truths_at(occluded, n)?) };
    cx.occluded_into(rays, occluded, coherent)
}
