//! Calls on the matrix stack.

use super::context::Context;
use super::error::{Error, Result};
use glam::{DMat4, DVec3};

/// One stack; what is current is baked into vertices and becomes the transform of instances. Defining an object neither saves nor
/// restores it. All of these fail with `InvalidOperation` between begin and end, and with `InvalidValue` when an element would not be finite.
impl Context {
    /// # Errors
    /// `StackOverflow` at a depth of [`super::MAX_MATRIX_DEPTH`].
    pub fn push_matrix(&mut self) -> Result<()> {
        self.outside_begin()?;
        self.matrices.push()
    }

    /// # Errors
    /// `StackUnderflow` when only one matrix is left.
    pub fn pop_matrix(&mut self) -> Result<()> {
        self.outside_begin()?;
        self.matrices.pop()
    }

    /// # Errors
    /// See above.
    pub fn load_identity(&mut self) -> Result<()> {
        self.outside_begin()?;
        self.matrices.load(DMat4::IDENTITY)
    }

    /// # Errors
    /// See above.
    pub fn load_matrix(&mut self, matrix: DMat4) -> Result<()> {
        self.outside_begin()?;
        self.matrices.load(matrix)
    }

    /// current ← current · matrix, as OpenGL.
    ///
    /// # Errors
    /// See above.
    pub fn mult_matrix(&mut self, matrix: DMat4) -> Result<()> {
        self.outside_begin()?;
        self.matrices.multiply(matrix)
    }

    /// # Errors
    /// See above.
    pub fn load_transpose_matrix(&mut self, matrix: DMat4) -> Result<()> {
        self.load_matrix(matrix.transpose())
    }

    /// # Errors
    /// See above.
    pub fn mult_transpose_matrix(&mut self, matrix: DMat4) -> Result<()> {
        self.mult_matrix(matrix.transpose())
    }

    /// # Errors
    /// See above.
    pub fn translate(&mut self, offset: DVec3) -> Result<()> {
        self.outside_begin()?;
        self.matrices.translate(offset)
    }

    /// Counter-clockwise about `axis` (any length but 0) seen against it.
    ///
    /// # Errors
    /// Also `InvalidValue` for an axis of length 0.
    pub fn rotate(&mut self, degrees: f64, axis: DVec3) -> Result<()> {
        self.outside_begin()?;
        if !degrees.is_finite() {
            return Err(Error::invalid_value(format_args!("the angle is {degrees}")));
        }
        self.matrices.rotate(degrees, axis)
    }

    /// # Errors
    /// See above. Factors of 0 are allowed.
    pub fn scale(&mut self, factors: DVec3) -> Result<()> {
        self.outside_begin()?;
        self.matrices.scale(factors)
    }
}
