//! The one matrix stack, with OpenGL's conventions: column-major, post-multiplied, degrees.
//!
//! Matrices are kept in f64, so that a robot's long chains of rotations and thousands of accumulated `rotate` calls lose nothing
//! visible; vertices and instances see the product rounded once to f32.

use super::error::{Error, ErrorCode, Result};
use crate::scene::MAX_COORDINATE;
use glam::{Affine3A, DMat4, DVec3, Mat3, Mat4, Vec3, Vec4};
use std::cell::OnceCell;

/// Entries that the stack holds, the current matrix included. OpenGL guarantees 32, `OpenRT`'s successors had 1024.
pub const MAX_DEPTH: usize = 1024;

pub struct MatrixStack {
    below: Vec<DMat4>,
    current: DMat4,
    /// `current` as vertices and instances see it.
    rounded: Mat4,
    /// The bottom row of `rounded` is 0 0 0 1, so that no division by w is needed.
    affine: bool,
    /// Inverse transpose of the linear part, up to a positive factor; computed when a normal asks.
    normal_matrix: OnceCell<Mat3>,
}

/// Inverse transpose of the linear part of `m`, up to a positive factor.
fn normal_matrix(m: &DMat4) -> Mat3 {
    let (x, y, z) = (m.x_axis.truncate(), m.y_axis.truncate(), m.z_axis.truncate());
    // The matrix of cofactors is the inverse transpose times the determinant, and exists for singular matrices too.
    let (cx, cy, cz) = (y.cross(z), z.cross(x), x.cross(y));
    let sign = if x.dot(cx) < 0.0 { -1.0 } else { 1.0 };
    // Scaled to about 1, so that a matrix of scale 1e-20 does not underflow on the way to f32.
    let largest = cx.abs().max(cy.abs()).max(cz.abs()).max_element();
    let factor = if largest > 0.0 && largest.is_finite() { sign / largest } else { sign };
    let column = |c: DVec3| (c * factor).as_vec3();
    Mat3::from_cols(column(cx), column(cy), column(cz))
}

fn is_affine(matrix: &Mat4) -> bool {
    matrix.x_axis.w == 0.0 && matrix.y_axis.w == 0.0 && matrix.z_axis.w == 0.0 && matrix.w_axis.w == 1.0
}

/// `matrix`, whose bottom row is 0 0 0 1 if it is `affine`, as the transform of an instance.
///
/// # Errors
/// `InvalidOperation` for another bottom row, `InvalidValue` where no coordinate could be in range.
fn instance_matrix(matrix: &Mat4, affine: bool) -> Result<Affine3A> {
    if !affine {
        let [x, y, z, w] = matrix.row(3).to_array();
        return Err(Error::invalid_operation(format_args!(
            "the last row of the current matrix is {x} {y} {z} {w}, and that of an instance must be 0 0 0 1"
        )));
    }
    let [x, y, z, w] = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis].map(Vec4::abs);
    let largest = x.max(y).max(z.max(w)).max_element();
    if largest > MAX_COORDINATE {
        return Err(Error::invalid_value(format_args!(
            "the current matrix has an element of magnitude {largest:e}; coordinates reach to {MAX_COORDINATE:e}"
        )));
    }
    Ok(Affine3A::from_mat4(*matrix))
}

#[cold]
fn full() -> Error {
    let text = format_args!("the stack holds {MAX_DEPTH} matrices already, the most that it can");
    Error::new(ErrorCode::StackOverflow, text)
}

#[cold]
fn empty() -> Error {
    Error::new(ErrorCode::StackUnderflow, "the stack holds only one matrix")
}

#[cold]
fn not_finite(matrix: &Mat4, what: &str) -> Error {
    let elements = matrix.to_cols_array();
    let at = elements.iter().position(|e| !e.is_finite()).unwrap_or(0);
    let (row, column, value) = (at % 4, at / 4, elements[at]);
    Error::invalid_value(format_args!("{what} would have the element {value} in row {row}, column {column}"))
}

impl Default for MatrixStack {
    fn default() -> Self {
        Self {
            below: Vec::new(),
            current: DMat4::IDENTITY,
            rounded: Mat4::IDENTITY,
            affine: true,
            normal_matrix: OnceCell::new(),
        }
    }
}

impl MatrixStack {
    /// A vertex in the space that the current matrix leads to; w is divided out.
    #[inline]
    pub fn point(&self, p: Vec4) -> Vec3 {
        if self.affine && p.w == 1.0 {
            self.rounded.transform_point3(p.truncate())
        } else {
            let q = self.rounded * p;
            q.truncate() / q.w
        }
    }

    /// A normal in that space, not normalised.
    #[inline]
    pub fn normal(&self, n: Vec3) -> Vec3 {
        *self.normal_matrix.get_or_init(|| normal_matrix(&self.current)) * n
    }

    pub fn current(&self) -> &DMat4 {
        &self.current
    }

    /// Number of matrices on the stack, at least 1.
    pub fn depth(&self) -> usize {
        self.below.len() + 1
    }

    /// The current matrix as the transform of an instance.
    pub fn affine(&self) -> Result<Affine3A> {
        instance_matrix(&self.rounded, self.affine)
    }

    /// The current matrix times `matrix` as the transform of an instance.
    pub fn affine_times(&self, matrix: &DMat4) -> Result<Affine3A> {
        let product = (self.current * *matrix).as_mat4();
        if !product.is_finite() {
            return Err(not_finite(&product, "the product with the current matrix"));
        }
        instance_matrix(&product, is_affine(&product))
    }

    pub fn push(&mut self) -> Result<()> {
        if self.depth() == MAX_DEPTH {
            return Err(full());
        }
        self.below.try_reserve(1)?;
        self.below.push(self.current);
        Ok(())
    }

    pub fn pop(&mut self) -> Result<()> {
        let Some(matrix) = self.below.pop() else { return Err(empty()) };
        self.set(matrix, matrix.as_mat4());
        Ok(())
    }

    /// Replaces the current matrix. NaN, infinite and (in f32) overflowing elements are refused.
    pub fn load(&mut self, matrix: DMat4) -> Result<()> {
        let rounded = matrix.as_mat4();
        if !rounded.is_finite() {
            return Err(not_finite(&rounded, "the matrix"));
        }
        self.set(matrix, rounded);
        Ok(())
    }

    fn set(&mut self, matrix: DMat4, rounded: Mat4) {
        self.current = matrix;
        self.rounded = rounded;
        self.affine = is_affine(&rounded);
        self.normal_matrix = OnceCell::new();
    }

    /// current ← current · matrix.
    pub fn multiply(&mut self, matrix: DMat4) -> Result<()> {
        self.load(self.current * matrix)
    }

    /// current ← current · translation: its last column alone changes, and not the matrix of normals.
    pub fn translate(&mut self, offset: DVec3) -> Result<()> {
        let column = self.current * offset.extend(1.0);
        let rounded = column.as_vec4();
        if !rounded.is_finite() {
            let product = Mat4 { w_axis: rounded, ..self.rounded };
            return Err(not_finite(&product, "the matrix"));
        }
        self.current.w_axis = column;
        self.rounded.w_axis = rounded;
        self.affine = is_affine(&self.rounded);
        Ok(())
    }

    /// current ← current · scaling.
    pub fn scale(&mut self, factors: DVec3) -> Result<()> {
        let DMat4 { x_axis, y_axis, z_axis, w_axis } = self.current;
        self.load(DMat4::from_cols(x_axis * factors.x, y_axis * factors.y, z_axis * factors.z, w_axis))
    }

    pub fn rotate(&mut self, degrees: f64, axis: DVec3) -> Result<()> {
        // Scaled first: the squared length of 1e-200 or 1e200 is not representable.
        let scaled = axis / axis.abs().max_element();
        let unit = scaled.normalize();
        if !unit.is_finite() {
            return Err(Error::invalid_value(format_args!("the axis is {axis}; it must be finite and not 0")));
        }
        let (sin, cos) = sin_cos_degrees(degrees);
        let (x, y, z) = (unit.x, unit.y, unit.z);
        let versine = 1.0 - cos;
        self.multiply(DMat4::from_cols_array(&[
            x * x * versine + cos,
            y * x * versine + z * sin,
            z * x * versine - y * sin,
            0.0,
            x * y * versine - z * sin,
            y * y * versine + cos,
            z * y * versine + x * sin,
            0.0,
            x * z * versine + y * sin,
            y * z * versine - x * sin,
            z * z * versine + cos,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0,
        ]))
    }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90° so that quarter turns keep boxes axis-aligned.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let reduced = degrees % 360.0;
    match reduced {
        0.0 => (0.0, 1.0),
        90.0 | -270.0 => (1.0, 0.0),
        180.0 | -180.0 => (0.0, -1.0),
        270.0 | -90.0 => (-1.0, 0.0),
        _ => reduced.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec4;

    #[test]
    fn stack_limits_are_reported_and_change_nothing() {
        let mut stack = MatrixStack::default();
        stack.multiply(DMat4::from_translation(DVec3::X)).unwrap();
        let before = *stack.current();
        assert_eq!(stack.pop().unwrap_err().code, ErrorCode::StackUnderflow);
        for _ in 1..MAX_DEPTH {
            stack.push().unwrap();
        }
        assert_eq!(stack.push().unwrap_err().code, ErrorCode::StackOverflow);
        assert_eq!((stack.depth(), *stack.current()), (MAX_DEPTH, before));
        for bad in [f64::NAN, f64::INFINITY, 1e39] {
            assert_eq!(stack.load(DMat4::from_scale(DVec3::splat(bad))).unwrap_err().code, ErrorCode::InvalidValue);
        }
        assert_eq!(stack.rotate(30.0, DVec3::ZERO).unwrap_err().code, ErrorCode::InvalidValue);
        assert_eq!(*stack.current(), before);
    }

    #[test]
    fn rotation_is_right_handed_and_axis_length_does_not_matter() {
        let mut stack = MatrixStack::default();
        stack.rotate(90.0, DVec3::new(0.0, 0.0, 1e-200)).unwrap();
        assert_eq!(stack.point(Vec4::new(1.0, 0.0, 0.0, 1.0)), Vec3::Y);
        stack.rotate(-450.0, DVec3::Z * 1e200).unwrap();
        assert_eq!(*stack.current(), DMat4::IDENTITY);
    }

    #[test]
    fn normals_stay_perpendicular_under_any_matrix() {
        let mut stack = MatrixStack::default();
        stack.rotate(33.0, DVec3::new(1.0, 2.0, 3.0)).unwrap();
        stack.multiply(DMat4::from_scale(DVec3::new(-1.0, 50.0, 0.01))).unwrap();
        let (n, t) = (Vec3::new(1.0, 2.0, 0.5), Vec3::new(2.0, -1.0, 0.0));
        let tangent = stack.rounded.transform_vector3(t);
        assert!(stack.normal(n).normalize().dot(tangent.normalize()).abs() < 1e-5);
        // A mirror keeps the outside outside.
        assert!(stack.rounded.transform_vector3(n).dot(stack.normal(n)) > 0.0);
        // A flattening matrix still has a normal: the one across the plane.
        stack.load(DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0))).unwrap();
        assert_eq!(stack.normal(Vec3::Z), Vec3::Z);
    }

    #[test]
    fn the_matrix_of_normals_follows_the_current_one() {
        let mut stack = MatrixStack::default();
        let normal = |stack: &MatrixStack| stack.normal(Vec3::ONE).normalize();
        let at_first = normal(&stack);
        stack.push().unwrap();
        stack.translate(DVec3::new(3.0, 4.0, 5.0)).unwrap();
        assert_eq!((normal(&stack), stack.point(Vec4::W)), (at_first, Vec3::new(3.0, 4.0, 5.0)));
        stack.scale(DVec3::new(1.0, 1.0, 2.0)).unwrap();
        let scaled = normal(&stack);
        assert!((scaled - Vec3::new(2.0, 2.0, 1.0) / 3.0).length() < 1e-6);
        stack.rotate(90.0, DVec3::Z).unwrap();
        assert!((normal(&stack) - Vec3::new(-2.0, 2.0, 1.0) / 3.0).length() < 1e-6);
        stack.load(DMat4::IDENTITY).unwrap();
        assert_eq!(normal(&stack), at_first);
        stack.scale(DVec3::new(1.0, 1.0, 2.0)).unwrap();
        assert_eq!(normal(&stack), scaled);
        stack.pop().unwrap();
        assert_eq!((normal(&stack), stack.point(Vec4::W)), (at_first, Vec3::ZERO));
    }

    #[test]
    fn translations_and_scalings_are_products() {
        let mut stack = MatrixStack::default();
        stack.rotate(33.0, DVec3::new(1.0, 2.0, 3.0)).unwrap();
        let perspective =
            DMat4::from_cols(DVec4::X, DVec4::Y * 1.5, DVec4::new(0.0, 0.0, -1.02, -1.0), DVec4::Z * -0.2);
        stack.multiply(perspective).unwrap();
        let (offset, factors) = (DVec3::new(0.3, -7.0, 1e-3), DVec3::new(-2.0, 0.0, 1e5));
        let product = *stack.current() * DMat4::from_translation(offset);
        stack.translate(offset).unwrap();
        assert_eq!((*stack.current(), stack.rounded), (product, product.as_mat4()));
        assert!(!stack.affine && stack.affine().is_err());
        let product = product * DMat4::from_diagonal(factors.extend(1.0));
        stack.scale(factors).unwrap();
        assert_eq!((*stack.current(), stack.rounded), (product, product.as_mat4()));
        for bad in [f64::NAN, f64::INFINITY, 1e39] {
            assert_eq!(stack.translate(DVec3::splat(bad)).unwrap_err().code, ErrorCode::InvalidValue);
            assert_eq!(stack.scale(DVec3::splat(bad)).unwrap_err().code, ErrorCode::InvalidValue);
        }
        assert_eq!((*stack.current(), stack.rounded), (product, product.as_mat4()));
    }

    #[test]
    fn homogeneous_vertices_are_divided() {
        let stack = MatrixStack::default();
        assert_eq!(stack.point(Vec4::new(2.0, 4.0, 6.0, 2.0)), Vec3::new(1.0, 2.0, 3.0));
    }
}
