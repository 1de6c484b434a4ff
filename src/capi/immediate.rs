//! Vertices between `rtBegin` and `rtEnd`.

use super::constants::*;
use super::guard::guard;
use super::pointer::array;
use super::refusal::unknown;
use super::types::*;
use crate::api::{Primitive, Result};
use glam::Vec4;

/// A number as the engine computes with it. Doubles beyond the range of floats become infinite: such vertices
/// are allowed and never hit.
trait Coordinate: Copy {
    fn coordinate(self) -> f32;
}

impl Coordinate for RTshort {
    fn coordinate(self) -> f32 {
        self.into()
    }
}

impl Coordinate for RTint {
    fn coordinate(self) -> f32 {
        self as f32
    }
}

impl Coordinate for RTfloat {
    fn coordinate(self) -> f32 {
        self
    }
}

impl Coordinate for RTdouble {
    fn coordinate(self) -> f32 {
        self as f32
    }
}

/// Fills up with z = 0 and w = 1.
#[inline]
fn point<T: Coordinate, const N: usize>(v: [T; N]) -> Vec4 {
    let mut p = [0.0, 0.0, 0.0, 1.0];
    for (to, from) in p.iter_mut().zip(v) {
        *to = from.coordinate();
    }
    Vec4::from_array(p)
}

pub(super) fn primitive(mode: RTenum) -> Result<Primitive> {
    Ok(match mode {
        RT_TRIANGLES => Primitive::Triangles,
        RT_TRIANGLE_STRIP => Primitive::TriangleStrip,
        RT_TRIANGLE_FAN => Primitive::TriangleFan,
        RT_QUADS => Primitive::Quads,
        RT_QUAD_STRIP => Primitive::QuadStrip,
        RT_POLYGON => Primitive::Polygon,
        _ => return Err(unknown("mode", mode, "a primitive")),
    })
}

/// Opens a primitive: RT_TRIANGLES, RT_TRIANGLE_STRIP, RT_TRIANGLE_FAN, RT_QUADS, RT_QUAD_STRIP or RT_POLYGON.
/// Its triangles belong to the object between rtNewObject() and rtEndObject(); outside of that they are drawn
/// once, in the frame being assembled. They are coloured by the shader that is bound now. Between rtBegin() and
/// rtEnd() only vertices, their attributes and shader parameters may be given.
///
/// Errors: RT_INVALID_ENUM for another mode, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtBegin(mode: RTenum) {
    guard(|cx| cx.begin(primitive(mode)?))
}

/// Closes the primitive. Vertices that complete no triangle are dropped.
///
/// Errors: RT_INVALID_OPERATION without rtBegin().
#[unsafe(no_mangle)]
pub extern "C" fn rtEnd() {
    guard(|cx| cx.end())
}

/// A vertex of the primitive that is open. The current matrix is applied now (moving an object later is the
/// business of rtInstantiateObject()), then x, y and z are divided by w. Missing coordinates are 0 for z and
/// 1 for w. The vertex takes the current normal, texture coordinate and colour. Triangles with a corner that is
/// infinite or not a number keep their place in the numbering, and no ray hits them.
///
/// Forms: rtVertex2, 3 and 4 with s (RTshort), i (RTint), f (RTfloat) or d (RTdouble); with v at the end, from
/// an array of that many values at v.
///
/// Errors: RT_INVALID_OPERATION outside rtBegin() and rtEnd(), RT_INVALID_VALUE when v is NULL,
/// RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex2s(x: RTshort, y: RTshort) {
    guard(|cx| cx.vertex(point([x, y])))
}

/// A vertex from 2 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex2sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex2i(x: RTint, y: RTint) {
    guard(|cx| cx.vertex(point([x, y])))
}

/// A vertex from 2 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex2iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex2f(x: RTfloat, y: RTfloat) {
    guard(|cx| cx.vertex(point([x, y])))
}

/// A vertex from 2 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex2fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex2d(x: RTdouble, y: RTdouble) {
    guard(|cx| cx.vertex(point([x, y])))
}

/// A vertex from 2 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex2dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex3s(x: RTshort, y: RTshort, z: RTshort) {
    guard(|cx| cx.vertex(point([x, y, z])))
}

/// A vertex from 3 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex3sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex3i(x: RTint, y: RTint, z: RTint) {
    guard(|cx| cx.vertex(point([x, y, z])))
}

/// A vertex from 3 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex3iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex3f(x: RTfloat, y: RTfloat, z: RTfloat) {
    guard(|cx| cx.vertex(point([x, y, z])))
}

/// A vertex from 3 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex3fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex3d(x: RTdouble, y: RTdouble, z: RTdouble) {
    guard(|cx| cx.vertex(point([x, y, z])))
}

/// A vertex from 3 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex3dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex4s(x: RTshort, y: RTshort, z: RTshort, w: RTshort) {
    guard(|cx| cx.vertex(point([x, y, z, w])))
}

/// A vertex from 4 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex4sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex4i(x: RTint, y: RTint, z: RTint, w: RTint) {
    guard(|cx| cx.vertex(point([x, y, z, w])))
}

/// A vertex from 4 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex4iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex4f(x: RTfloat, y: RTfloat, z: RTfloat, w: RTfloat) {
    guard(|cx| cx.vertex(point([x, y, z, w])))
}

/// A vertex from 4 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex4fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.vertex(point(v?)))
}

/// A vertex: see rtVertex2s().
#[unsafe(no_mangle)]
pub extern "C" fn rtVertex4d(x: RTdouble, y: RTdouble, z: RTdouble, w: RTdouble) {
    guard(|cx| cx.vertex(point([x, y, z, w])))
}

/// A vertex from 4 values at v: see rtVertex2s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertex4dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.vertex(point(v?)))
}
