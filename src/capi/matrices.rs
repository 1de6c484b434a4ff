//! The matrix stack.

use super::guard::guard;
use super::pointer::array_at;
use super::types::*;
use glam::{DMat4, DVec3};

fn matrix<T: Into<f64> + Copy>(m: [T; 16]) -> DMat4 {
    DMat4::from_cols_array(&m.map(Into::into))
}

/// Copies the current matrix on top of the stack. The stack holds at least 64 matrices; see
/// RT_MAX_MATRIX_STACK_DEPTH.
///
/// Errors: RT_STACK_OVERFLOW when it is full, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtPushMatrix() {
    guard(|cx| cx.push_matrix())
}

/// Makes the matrix below the top the current one.
///
/// Errors: RT_STACK_UNDERFLOW when there is none, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtPopMatrix() {
    guard(|cx| cx.pop_matrix())
}

/// Replaces the current matrix by the identity.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtLoadIdentity() {
    guard(|cx| cx.load_identity())
}

/// Replaces the current matrix by the 16 values at m, column by column.
///
/// Errors: RT_INVALID_VALUE when m is NULL or an element of the product is not finite, RT_INVALID_OPERATION
/// between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtLoadMatrixf(m: *const RTfloat) {
    // SAFETY: `m` is NULL or points to 16 values, says the manual.
    let m = unsafe { array_at("m", m) };
    guard(|cx| cx.load_matrix(matrix(m?)))
}

/// See rtLoadMatrixf().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtLoadMatrixd(m: *const RTdouble) {
    // SAFETY: `m` is NULL or points to 16 values, says the manual.
    let m = unsafe { array_at("m", m) };
    guard(|cx| cx.load_matrix(matrix(m?)))
}

/// Multiplies the current matrix from the right by the 16 values at m, column by column.
///
/// Errors: RT_INVALID_VALUE when m is NULL or an element of the product is not finite, RT_INVALID_OPERATION
/// between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtMultMatrixf(m: *const RTfloat) {
    // SAFETY: `m` is NULL or points to 16 values, says the manual.
    let m = unsafe { array_at("m", m) };
    guard(|cx| cx.mult_matrix(matrix(m?)))
}

/// See rtMultMatrixf().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtMultMatrixd(m: *const RTdouble) {
    // SAFETY: `m` is NULL or points to 16 values, says the manual.
    let m = unsafe { array_at("m", m) };
    guard(|cx| cx.mult_matrix(matrix(m?)))
}

/// Replaces the current matrix by the 16 values at m, row by row.
///
/// Errors: RT_INVALID_VALUE when m is NULL or an element of the product is not finite, RT_INVALID_OPERATION
/// between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtLoadTransposeMatrixf(m: *const RTfloat) {
    // SAFETY: `m` is NULL or points to 16 values, says the manual.
    let m = unsafe { array_at("m", m) };
    guard(|cx| cx.load_transpose_matrix(matrix(m?)))
}

/// See rtLoadTransposeMatrixf().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtLoadTransposeMatrixd(m: *const RTdouble) {
    // SAFETY: `m` is NULL or points to 16 values, says the manual.
    let m = unsafe { array_at("m", m) };
    guard(|cx| cx.load_transpose_matrix(matrix(m?)))
}

/// Multiplies the current matrix from the right by the 16 values at m, row by row.
///
/// Errors: RT_INVALID_VALUE when m is NULL or an element of the product is not finite, RT_INVALID_OPERATION
/// between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtMultTransposeMatrixf(m: *const RTfloat) {
    // SAFETY: `m` is NULL or points to 16 values, says the manual.
    let m = unsafe { array_at("m", m) };
    guard(|cx| cx.mult_transpose_matrix(matrix(m?)))
}

/// See rtMultTransposeMatrixf().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtMultTransposeMatrixd(m: *const RTdouble) {
    // SAFETY: `m` is NULL or points to 16 values, says the manual.
    let m = unsafe { array_at("m", m) };
    guard(|cx| cx.mult_transpose_matrix(matrix(m?)))
}

/// Multiplies the current matrix from the right by a translation.
///
/// Errors: RT_INVALID_VALUE when an element of the product is not finite, RT_INVALID_OPERATION between
/// rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtTranslatef(x: RTfloat, y: RTfloat, z: RTfloat) {
    guard(|cx| cx.translate(DVec3::new(x.into(), y.into(), z.into())))
}

/// See rtTranslatef().
#[unsafe(no_mangle)]
pub extern "C" fn rtTranslated(x: RTdouble, y: RTdouble, z: RTdouble) {
    guard(|cx| cx.translate(DVec3::new(x, y, z)))
}

/// Multiplies the current matrix from the right by a rotation of angle degrees about the axis (x, y, z),
/// counter-clockwise when the axis points at the viewer.
///
/// Errors: RT_INVALID_VALUE when the axis has no length or a number is not finite, RT_INVALID_OPERATION between
/// rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtRotatef(angle: RTfloat, x: RTfloat, y: RTfloat, z: RTfloat) {
    guard(|cx| cx.rotate(angle.into(), DVec3::new(x.into(), y.into(), z.into())))
}

/// See rtRotatef().
#[unsafe(no_mangle)]
pub extern "C" fn rtRotated(angle: RTdouble, x: RTdouble, y: RTdouble, z: RTdouble) {
    guard(|cx| cx.rotate(angle, DVec3::new(x, y, z)))
}

/// Multiplies the current matrix from the right by a scaling. Factors of 0 flatten.
///
/// Errors: RT_INVALID_VALUE when an element of the product is not finite, RT_INVALID_OPERATION between
/// rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtScalef(x: RTfloat, y: RTfloat, z: RTfloat) {
    guard(|cx| cx.scale(DVec3::new(x.into(), y.into(), z.into())))
}

/// See rtScalef().
#[unsafe(no_mangle)]
pub extern "C" fn rtScaled(x: RTdouble, y: RTdouble, z: RTdouble) {
    guard(|cx| cx.scale(DVec3::new(x, y, z)))
}
