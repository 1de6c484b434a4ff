//! What went wrong, in OpenGL's vocabulary.
//!
//! Every method of [`super::Context`] returns an [`Error`] and has then changed nothing. The C face hands it to
//! [`super::Context::latch`], which keeps the first one until [`super::Context::get_error`] reads it.

use crate::memory::OutOfMemory;
use std::borrow::Cow;
use std::fmt;

/// Kind of an [`Error`]; the C face gives each a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ErrorCode {
    #[default]
    NoError,
    /// A constant that the call does not know.
    InvalidEnum,
    /// A number out of range, or a name that does not exist.
    InvalidValue,
    /// Not allowed in the current state, for example between begin and end.
    InvalidOperation,
    StackOverflow,
    StackUnderflow,
    OutOfMemory,
    /// A file could not be read or written, or the system refused something.
    Io,
    /// A defect of this library. The context is unusable afterwards.
    InternalError,
}

/// A refused call: its kind and, for people, the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    pub code: ErrorCode,
    pub message: Cow<'static, str>,
}

/// Result of every method of [`super::Context`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    pub fn new(code: ErrorCode, message: impl Into<Cow<'static, str>>) -> Self {
        Self { code, message: message.into() }
    }

    pub fn invalid_enum(message: impl Into<Cow<'static, str>>) -> Self {
        Self::new(ErrorCode::InvalidEnum, message)
    }

    pub fn invalid_value(message: impl Into<Cow<'static, str>>) -> Self {
        Self::new(ErrorCode::InvalidValue, message)
    }

    pub fn invalid_operation(message: impl Into<Cow<'static, str>>) -> Self {
        Self::new(ErrorCode::InvalidOperation, message)
    }

    pub fn out_of_memory() -> Self {
        Self::new(ErrorCode::OutOfMemory, "out of memory")
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

impl From<OutOfMemory> for Error {
    fn from(_: OutOfMemory) -> Self {
        Self::out_of_memory()
    }
}

impl From<std::collections::TryReserveError> for Error {
    fn from(_: std::collections::TryReserveError) -> Self {
        Self::out_of_memory()
    }
}
