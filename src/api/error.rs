//! What went wrong, in OpenGL's vocabulary.
//!
//! Every method of [`super::Context`] returns an [`Error`] and has then changed nothing. The C face hands it to
//! [`super::Context::latch`], which keeps the first one until [`super::Context::get_error`] reads it.

use crate::frame::ImageFileError;
use crate::memory::OutOfMemory;
use std::borrow::Cow;
use std::{fmt, io};

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

/// The reason of an [`Error`]: a text, or the arguments of one.
pub struct Message(Cow<'static, str>);

impl From<&'static str> for Message {
    fn from(text: &'static str) -> Self {
        Self(Cow::Borrowed(text))
    }
}

impl From<String> for Message {
    fn from(text: String) -> Self {
        Self(Cow::Owned(text))
    }
}

impl From<Cow<'static, str>> for Message {
    fn from(text: Cow<'static, str>) -> Self {
        Self(text)
    }
}

impl From<fmt::Arguments<'_>> for Message {
    /// As long as there is memory: an error must not fail.
    fn from(arguments: fmt::Arguments<'_>) -> Self {
        Self(match arguments.as_str() {
            Some(text) => Cow::Borrowed(text),
            None => {
                let mut text = Bounded(String::new());
                // What did not fit is left out.
                let _ = fmt::write(&mut text, arguments);
                Cow::Owned(text.0)
            }
        })
    }
}

/// Takes what there is memory for.
struct Bounded(String);

impl fmt::Write for Bounded {
    fn write_str(&mut self, part: &str) -> fmt::Result {
        self.0.try_reserve(part.len()).map_err(|_| fmt::Error)?;
        self.0.push_str(part);
        Ok(())
    }
}

impl Error {
    #[cold]
    pub fn new(code: ErrorCode, message: impl Into<Message>) -> Self {
        Self { code, message: message.into().0 }
    }

    #[cold]
    pub fn invalid_enum(message: impl Into<Message>) -> Self {
        Self::new(ErrorCode::InvalidEnum, message)
    }

    #[cold]
    pub fn invalid_value(message: impl Into<Message>) -> Self {
        Self::new(ErrorCode::InvalidValue, message)
    }

    #[cold]
    pub fn invalid_operation(message: impl Into<Message>) -> Self {
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

impl From<ImageFileError> for Error {
    fn from(error: ImageFileError) -> Self {
        let code = match &error {
            ImageFileError::OutOfMemory { .. } => ErrorCode::OutOfMemory,
            ImageFileError::Io { cause, .. } if cause.kind() == io::ErrorKind::OutOfMemory => ErrorCode::OutOfMemory,
            ImageFileError::NotBuilt { .. } => ErrorCode::InvalidOperation,
            _ => ErrorCode::Io,
        };
        Self::new(code, error.to_string())
    }
}
