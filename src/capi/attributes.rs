//! Normals and texture coordinates.

use super::guard::guard;
use super::pointer::array;
use super::types::*;
use glam::{Vec3, Vec4};

/// A component of a normal. Integers are fractions of the largest one, as for colours in OpenGL: only their
/// ratio counts in the end.
trait NormalComponent: Copy {
    fn component(self) -> f32;
}

impl NormalComponent for RTbyte {
    fn component(self) -> f32 {
        (f32::from(self) / 127.0).max(-1.0)
    }
}

impl NormalComponent for RTshort {
    fn component(self) -> f32 {
        (f32::from(self) / 32767.0).max(-1.0)
    }
}

impl NormalComponent for RTint {
    fn component(self) -> f32 {
        ((f64::from(self) / 2147483647.0) as f32).max(-1.0)
    }
}

impl NormalComponent for RTfloat {
    fn component(self) -> f32 {
        self
    }
}

impl NormalComponent for RTdouble {
    fn component(self) -> f32 {
        self as f32
    }
}

fn normal<T: NormalComponent>(v: [T; 3]) -> Vec3 {
    Vec3::from_array(v.map(T::component))
}

/// A texture coordinate; integers count whole repetitions of the image.
trait TexComponent: Copy {
    fn component(self) -> f32;
}

impl TexComponent for RTshort {
    fn component(self) -> f32 {
        self.into()
    }
}

impl TexComponent for RTint {
    fn component(self) -> f32 {
        self as f32
    }
}

impl TexComponent for RTfloat {
    fn component(self) -> f32 {
        self
    }
}

impl TexComponent for RTdouble {
    fn component(self) -> f32 {
        self as f32
    }
}

/// Fills up with t = 0, r = 0 and q = 1.
fn tex_coord<T: TexComponent, const N: usize>(v: [T; N]) -> Vec4 {
    let mut p = [0.0, 0.0, 0.0, 1.0];
    for (to, from) in p.iter_mut().zip(v) {
        *to = from.component();
    }
    Vec4::from_array(p)
}

/// Sets the normal of the vertices that follow. It is transformed by the inverse transpose of the matrix that
/// is current at the vertex, and need not have unit length. Objects without normals are shaded flat.
/// rtNewObject() begins without a normal.
///
/// Forms: b (RTbyte), s (RTshort) and i (RTint), which are fractions of the largest value, f (RTfloat) and d
/// (RTdouble); with v at the end, from an array of 3 values at v.
///
/// Errors: RT_INVALID_VALUE when v is NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rtNormal3b(x: RTbyte, y: RTbyte, z: RTbyte) {
    guard(|cx| cx.normal(normal([x, y, z])))
}

/// Sets the normal from 3 values at v: see rtNormal3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtNormal3bv(v: *const RTbyte) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.normal(normal(v?)))
}

/// Sets the normal: see rtNormal3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtNormal3s(x: RTshort, y: RTshort, z: RTshort) {
    guard(|cx| cx.normal(normal([x, y, z])))
}

/// Sets the normal from 3 values at v: see rtNormal3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtNormal3sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.normal(normal(v?)))
}

/// Sets the normal: see rtNormal3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtNormal3i(x: RTint, y: RTint, z: RTint) {
    guard(|cx| cx.normal(normal([x, y, z])))
}

/// Sets the normal from 3 values at v: see rtNormal3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtNormal3iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.normal(normal(v?)))
}

/// Sets the normal: see rtNormal3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtNormal3f(x: RTfloat, y: RTfloat, z: RTfloat) {
    guard(|cx| cx.normal(normal([x, y, z])))
}

/// Sets the normal from 3 values at v: see rtNormal3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtNormal3fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.normal(normal(v?)))
}

/// Sets the normal: see rtNormal3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtNormal3d(x: RTdouble, y: RTdouble, z: RTdouble) {
    guard(|cx| cx.normal(normal([x, y, z])))
}

/// Sets the normal from 3 values at v: see rtNormal3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtNormal3dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.normal(normal(v?)))
}

/// Sets the texture coordinate of the vertices that follow: the image's lower left corner is (0, 0), its upper
/// right one (1, 1). Missing coordinates are t = 0, r = 0 and q = 1; s and t are divided by q, r is not used.
///
/// Forms: rtTexCoord1, 2, 3 and 4 with s (RTshort), i (RTint), f (RTfloat) or d (RTdouble); with v at the end,
/// from an array of that many values at v.
///
/// Errors: RT_INVALID_VALUE when v is NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord1s(s: RTshort) {
    guard(|cx| cx.tex_coord(tex_coord([s])))
}

/// Sets the texture coordinate from 1 value at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord1sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 1 value, says the manual.
    let v = unsafe { array::<_, 1>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord1i(s: RTint) {
    guard(|cx| cx.tex_coord(tex_coord([s])))
}

/// Sets the texture coordinate from 1 value at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord1iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 1 value, says the manual.
    let v = unsafe { array::<_, 1>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord1f(s: RTfloat) {
    guard(|cx| cx.tex_coord(tex_coord([s])))
}

/// Sets the texture coordinate from 1 value at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord1fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 1 value, says the manual.
    let v = unsafe { array::<_, 1>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord1d(s: RTdouble) {
    guard(|cx| cx.tex_coord(tex_coord([s])))
}

/// Sets the texture coordinate from 1 value at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord1dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 1 value, says the manual.
    let v = unsafe { array::<_, 1>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord2s(s: RTshort, t: RTshort) {
    guard(|cx| cx.tex_coord(tex_coord([s, t])))
}

/// Sets the texture coordinate from 2 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord2sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord2i(s: RTint, t: RTint) {
    guard(|cx| cx.tex_coord(tex_coord([s, t])))
}

/// Sets the texture coordinate from 2 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord2iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord2f(s: RTfloat, t: RTfloat) {
    guard(|cx| cx.tex_coord(tex_coord([s, t])))
}

/// Sets the texture coordinate from 2 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord2fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord2d(s: RTdouble, t: RTdouble) {
    guard(|cx| cx.tex_coord(tex_coord([s, t])))
}

/// Sets the texture coordinate from 2 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord2dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord3s(s: RTshort, t: RTshort, r: RTshort) {
    guard(|cx| cx.tex_coord(tex_coord([s, t, r])))
}

/// Sets the texture coordinate from 3 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord3sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord3i(s: RTint, t: RTint, r: RTint) {
    guard(|cx| cx.tex_coord(tex_coord([s, t, r])))
}

/// Sets the texture coordinate from 3 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord3iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord3f(s: RTfloat, t: RTfloat, r: RTfloat) {
    guard(|cx| cx.tex_coord(tex_coord([s, t, r])))
}

/// Sets the texture coordinate from 3 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord3fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord3d(s: RTdouble, t: RTdouble, r: RTdouble) {
    guard(|cx| cx.tex_coord(tex_coord([s, t, r])))
}

/// Sets the texture coordinate from 3 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord3dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord4s(s: RTshort, t: RTshort, r: RTshort, q: RTshort) {
    guard(|cx| cx.tex_coord(tex_coord([s, t, r, q])))
}

/// Sets the texture coordinate from 4 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord4sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord4i(s: RTint, t: RTint, r: RTint, q: RTint) {
    guard(|cx| cx.tex_coord(tex_coord([s, t, r, q])))
}

/// Sets the texture coordinate from 4 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord4iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord4f(s: RTfloat, t: RTfloat, r: RTfloat, q: RTfloat) {
    guard(|cx| cx.tex_coord(tex_coord([s, t, r, q])))
}

/// Sets the texture coordinate from 4 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord4fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}

/// Sets the texture coordinate: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub extern "C" fn rtTexCoord4d(s: RTdouble, t: RTdouble, r: RTdouble, q: RTdouble) {
    guard(|cx| cx.tex_coord(tex_coord([s, t, r, q])))
}

/// Sets the texture coordinate from 4 values at v: see rtTexCoord1s().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoord4dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.tex_coord(tex_coord(v?)))
}
