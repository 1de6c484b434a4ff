//! Values of shader parameters.

use super::guard::guard;
use super::pointer::{OutArray, answer, array, slice, text};
use super::types::*;
use crate::api::{Error, ParamValue};
use std::ffi::{c_char, c_void};

/// Sets a parameter of the bound shader to an integer. handle comes from rtParameterHandle(). A parameter of
/// type RT_TEXTURE takes the name of a texture as one integer. Values are read when a frame starts and hold for
/// all of it; parameters per triangle and per vertex are captured when a triangle is completed or a vertex
/// given, also between rtBegin() and rtEnd().
///
/// Forms: rtParameter1, 2, 3 and 4 with i (RTint) or f (RTfloat), rtParameter16f for matrices, column by
/// column; with v at the end, from an array of that many values at v.
///
/// Errors: RT_INVALID_VALUE when handle is none, v is NULL, a float is not a number, or there is no such
/// texture; RT_INVALID_OPERATION when no shader is bound, the handle belongs to another class, or the parameter
/// has another type or number of values.
#[unsafe(no_mangle)]
pub extern "C" fn rtParameter1i(handle: RTuint, x: RTint) {
    guard(|cx| cx.parameter_i(handle, &[x]))
}

/// Sets a parameter of the bound shader from 1 value at v: see rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameter1iv(handle: RTuint, v: *const RTint) {
    // SAFETY: `v` is NULL or points to 1 value, says the manual.
    let v = unsafe { array::<_, 1>(v) };
    guard(|cx| cx.parameter_i(handle, &v?))
}

/// Sets a parameter of the bound shader: see rtParameter1i().
#[unsafe(no_mangle)]
pub extern "C" fn rtParameter1f(handle: RTuint, x: RTfloat) {
    guard(|cx| cx.parameter_f(handle, &[x]))
}

/// Sets a parameter of the bound shader from 1 value at v: see rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameter1fv(handle: RTuint, v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 1 value, says the manual.
    let v = unsafe { array::<_, 1>(v) };
    guard(|cx| cx.parameter_f(handle, &v?))
}

/// Sets a parameter of the bound shader: see rtParameter1i().
#[unsafe(no_mangle)]
pub extern "C" fn rtParameter2i(handle: RTuint, x: RTint, y: RTint) {
    guard(|cx| cx.parameter_i(handle, &[x, y]))
}

/// Sets a parameter of the bound shader from 2 values at v: see rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameter2iv(handle: RTuint, v: *const RTint) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.parameter_i(handle, &v?))
}

/// Sets a parameter of the bound shader: see rtParameter1i().
#[unsafe(no_mangle)]
pub extern "C" fn rtParameter2f(handle: RTuint, x: RTfloat, y: RTfloat) {
    guard(|cx| cx.parameter_f(handle, &[x, y]))
}

/// Sets a parameter of the bound shader from 2 values at v: see rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameter2fv(handle: RTuint, v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 2 values, says the manual.
    let v = unsafe { array::<_, 2>(v) };
    guard(|cx| cx.parameter_f(handle, &v?))
}

/// Sets a parameter of the bound shader: see rtParameter1i().
#[unsafe(no_mangle)]
pub extern "C" fn rtParameter3i(handle: RTuint, x: RTint, y: RTint, z: RTint) {
    guard(|cx| cx.parameter_i(handle, &[x, y, z]))
}

/// Sets a parameter of the bound shader from 3 values at v: see rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameter3iv(handle: RTuint, v: *const RTint) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.parameter_i(handle, &v?))
}

/// Sets a parameter of the bound shader: see rtParameter1i().
#[unsafe(no_mangle)]
pub extern "C" fn rtParameter3f(handle: RTuint, x: RTfloat, y: RTfloat, z: RTfloat) {
    guard(|cx| cx.parameter_f(handle, &[x, y, z]))
}

/// Sets a parameter of the bound shader from 3 values at v: see rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameter3fv(handle: RTuint, v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 3 values, says the manual.
    let v = unsafe { array::<_, 3>(v) };
    guard(|cx| cx.parameter_f(handle, &v?))
}

/// Sets a parameter of the bound shader: see rtParameter1i().
#[unsafe(no_mangle)]
pub extern "C" fn rtParameter4i(handle: RTuint, x: RTint, y: RTint, z: RTint, w: RTint) {
    guard(|cx| cx.parameter_i(handle, &[x, y, z, w]))
}

/// Sets a parameter of the bound shader from 4 values at v: see rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameter4iv(handle: RTuint, v: *const RTint) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.parameter_i(handle, &v?))
}

/// Sets a parameter of the bound shader: see rtParameter1i().
#[unsafe(no_mangle)]
pub extern "C" fn rtParameter4f(handle: RTuint, x: RTfloat, y: RTfloat, z: RTfloat, w: RTfloat) {
    guard(|cx| cx.parameter_f(handle, &[x, y, z, w]))
}

/// Sets a parameter of the bound shader from 4 values at v: see rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameter4fv(handle: RTuint, v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 4 values, says the manual.
    let v = unsafe { array::<_, 4>(v) };
    guard(|cx| cx.parameter_f(handle, &v?))
}

/// Sets a matrix parameter of the bound shader, column by column: see rtParameter1i().
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub extern "C" fn rtParameter16f(
    handle: RTuint,
    m00: RTfloat,
    m01: RTfloat,
    m02: RTfloat,
    m03: RTfloat,
    m10: RTfloat,
    m11: RTfloat,
    m12: RTfloat,
    m13: RTfloat,
    m20: RTfloat,
    m21: RTfloat,
    m22: RTfloat,
    m23: RTfloat,
    m30: RTfloat,
    m31: RTfloat,
    m32: RTfloat,
    m33: RTfloat,
) {
    let m = [m00, m01, m02, m03, m10, m11, m12, m13, m20, m21, m22, m23, m30, m31, m32, m33];
    guard(|cx| cx.parameter_matrix(handle, &m))
}

/// Sets a matrix parameter of the bound shader from 16 values at v, column by column: see rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameter16fv(handle: RTuint, v: *const RTfloat) {
    // SAFETY: `v` is NULL or points to 16 values, says the manual.
    let v = unsafe { array(v) };
    guard(|cx| cx.parameter_matrix(handle, &v?))
}

/// Sets a string parameter of the bound shader to a copy of text, which ends in a zero byte and is UTF-8.
/// Errors: as rtParameter1i().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameterString(handle: RTuint, text_: *const c_char) {
    // SAFETY: `text_` is NULL or a string, says the manual; it is copied before we return.
    let text = unsafe { text("text", text_) };
    guard(|cx| cx.parameter_string(handle, text?))
}

/// Sets a parameter of the bound shader, of any type but string, from a copy of size bytes at data; size must
/// be that of the parameter. Errors: as rtParameter1i(); RT_INVALID_VALUE also when size is negative.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameterRaw(handle: RTuint, data: *const c_void, size: RTsizei) {
    // SAFETY: `data` is NULL or points to `size` bytes, says the manual; they are copied before we return.
    let bytes = unsafe { slice("data", data.cast(), size) };
    guard(|cx| cx.parameter_raw(handle, bytes?))
}

/// Sets a texture parameter of the bound shader; 0 is no texture. Errors: as rtParameter1i().
#[unsafe(no_mangle)]
pub extern "C" fn rtParameterTexture(handle: RTuint, texture: RTuint) {
    guard(|cx| cx.parameter_texture(handle, texture))
}

/// Stores the value of an integer or texture parameter of the bound shader at params: always four numbers,
/// those that the parameter does not have being 0.
///
/// Errors: RT_INVALID_VALUE when handle is none or params is NULL; RT_INVALID_OPERATION when no shader is
/// bound, the handle belongs to another class, the parameter has another type, or between rtBegin() and
/// rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetParameteriv(handle: RTuint, params: *mut RTint) {
    // SAFETY: `params` is NULL or a place for four numbers, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard(|cx| match cx.get_parameter(handle)? {
        ParamValue::Int(values) => params.set(&values),
        ParamValue::Texture(name) => params.set(&[name as RTint, 0, 0, 0]),
        _ => Err(Error::invalid_operation(format_args!("parameter {handle} is not one of integers"))),
    })
}

/// Stores the value of a float parameter of the bound shader at params: always four numbers, those that the
/// parameter does not have being 0, or the sixteen of a matrix. Errors: as rtGetParameteriv().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetParameterfv(handle: RTuint, params: *mut RTfloat) {
    // SAFETY: `params` is NULL or a place for four numbers, or sixteen for a matrix, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard(|cx| match cx.get_parameter(handle)? {
        ParamValue::Float(values) => params.set(&values),
        ParamValue::Matrix(values) => params.set(&values),
        _ => Err(Error::invalid_operation(format_args!("parameter {handle} is not one of floats"))),
    })
}

/// Returns the value of a string parameter of the bound shader; NULL on failure. The text belongs to the library and
/// is valid until the process ends. Errors: as rtGetParameteriv().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetParameterString(handle: RTuint) -> *const c_char {
    guard(|cx| match cx.get_parameter(handle)? {
        ParamValue::String(text) => answer(&text),
        _ => Err(Error::invalid_operation(format_args!("parameter {handle} is not a string"))),
    })
}
