//! Vertex colours.

use super::guard::guard;
use super::pointer::array;
use super::types::*;
use glam::Vec4;

/// A colour component. Integers are fractions of the largest one.
trait ColorComponent: Copy {
    fn component(self) -> f32;
}

impl ColorComponent for RTbyte {
    fn component(self) -> f32 {
        (f32::from(self) / 127.0).max(-1.0)
    }
}

impl ColorComponent for RTubyte {
    fn component(self) -> f32 {
        f32::from(self) / 255.0
    }
}

impl ColorComponent for RTshort {
    fn component(self) -> f32 {
        (f32::from(self) / 32767.0).max(-1.0)
    }
}

impl ColorComponent for RTushort {
    fn component(self) -> f32 {
        f32::from(self) / 65535.0
    }
}

impl ColorComponent for RTint {
    fn component(self) -> f32 {
        ((f64::from(self) / 2147483647.0) as f32).max(-1.0)
    }
}

impl ColorComponent for RTuint {
    fn component(self) -> f32 {
        (f64::from(self) / 4294967295.0) as f32
    }
}

impl ColorComponent for RTfloat {
    fn component(self) -> f32 {
        self
    }
}

impl ColorComponent for RTdouble {
    fn component(self) -> f32 {
        self as f32
    }
}

/// Fills up with an opacity of 1.
fn color<T: ColorComponent, const N: usize>(v: [T; N]) -> Vec4 {
    let mut p = [0.0, 0.0, 0.0, 1.0];
    for (to, from) in p.iter_mut().zip(v) {
        *to = from.component();
    }
    Vec4::from_array(p)
}

/// Sets the colour of the vertices that follow: linear red, green and blue, and opacity, 1 if not given. It is
/// interpolated and multiplies the colour of the shader. It begins as white.
///
/// Forms: rtColor3 and rtColor4 with b (RTbyte), ub (RTubyte), s (RTshort), us (RTushort), i (RTint) and ui
/// (RTuint), which are fractions of the largest value, f (RTfloat) and d (RTdouble); with v at the end, from an
/// array of that many values at v.
///
/// Errors: RT_INVALID_VALUE when v is NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rtColor3b(red: RTbyte, green: RTbyte, blue: RTbyte) {
    guard(|cx| cx.color(color([red, green, blue])))
}

/// Sets the colour from 3 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor3bv(v: *const RTbyte) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor3ub(red: RTubyte, green: RTubyte, blue: RTubyte) {
    guard(|cx| cx.color(color([red, green, blue])))
}

/// Sets the colour from 3 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor3ubv(v: *const RTubyte) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor3s(red: RTshort, green: RTshort, blue: RTshort) {
    guard(|cx| cx.color(color([red, green, blue])))
}

/// Sets the colour from 3 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor3sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor3us(red: RTushort, green: RTushort, blue: RTushort) {
    guard(|cx| cx.color(color([red, green, blue])))
}

/// Sets the colour from 3 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor3usv(v: *const RTushort) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor3i(red: RTint, green: RTint, blue: RTint) {
    guard(|cx| cx.color(color([red, green, blue])))
}

/// Sets the colour from 3 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor3iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor3ui(red: RTuint, green: RTuint, blue: RTuint) {
    guard(|cx| cx.color(color([red, green, blue])))
}

/// Sets the colour from 3 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor3uiv(v: *const RTuint) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor3f(red: RTfloat, green: RTfloat, blue: RTfloat) {
    guard(|cx| cx.color(color([red, green, blue])))
}

/// Sets the colour from 3 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor3fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor3d(red: RTdouble, green: RTdouble, blue: RTdouble) {
    guard(|cx| cx.color(color([red, green, blue])))
}

/// Sets the colour from 3 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor3dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor4b(red: RTbyte, green: RTbyte, blue: RTbyte, alpha: RTbyte) {
    guard(|cx| cx.color(color([red, green, blue, alpha])))
}

/// Sets the colour from 4 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor4bv(v: *const RTbyte) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor4ub(red: RTubyte, green: RTubyte, blue: RTubyte, alpha: RTubyte) {
    guard(|cx| cx.color(color([red, green, blue, alpha])))
}

/// Sets the colour from 4 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor4ubv(v: *const RTubyte) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor4s(red: RTshort, green: RTshort, blue: RTshort, alpha: RTshort) {
    guard(|cx| cx.color(color([red, green, blue, alpha])))
}

/// Sets the colour from 4 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor4sv(v: *const RTshort) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor4us(red: RTushort, green: RTushort, blue: RTushort, alpha: RTushort) {
    guard(|cx| cx.color(color([red, green, blue, alpha])))
}

/// Sets the colour from 4 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor4usv(v: *const RTushort) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor4i(red: RTint, green: RTint, blue: RTint, alpha: RTint) {
    guard(|cx| cx.color(color([red, green, blue, alpha])))
}

/// Sets the colour from 4 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor4iv(v: *const RTint) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor4ui(red: RTuint, green: RTuint, blue: RTuint, alpha: RTuint) {
    guard(|cx| cx.color(color([red, green, blue, alpha])))
}

/// Sets the colour from 4 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor4uiv(v: *const RTuint) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor4f(red: RTfloat, green: RTfloat, blue: RTfloat, alpha: RTfloat) {
    guard(|cx| cx.color(color([red, green, blue, alpha])))
}

/// Sets the colour from 4 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor4fv(v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.color(color(v?)))
}

/// Sets the colour: see rtColor3b().
#[unsafe(no_mangle)]
pub extern "C" fn rtColor4d(red: RTdouble, green: RTdouble, blue: RTdouble, alpha: RTdouble) {
    guard(|cx| cx.color(color([red, green, blue, alpha])))
}

/// Sets the colour from 4 values at v: see rtColor3b().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColor4dv(v: *const RTdouble) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.color(color(v?)))
}
