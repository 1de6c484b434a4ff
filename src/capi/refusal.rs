//! What is wrong with an argument, by its name and its value. (The name of the call comes before, see `guard`.)

use super::types::RTenum;
use crate::api::Error;

/// A constant that the call does not know; `wanted` with its article.
#[cold]
pub(super) fn unknown(argument: &str, value: RTenum, wanted: &str) -> Error {
    Error::invalid_enum(format_args!("{argument} is 0x{value:04X}, which is not {wanted}"))
}

#[cold]
pub(super) fn null(argument: &str) -> Error {
    Error::invalid_value(format_args!("{argument} is NULL"))
}

#[cold]
pub(super) fn negative(argument: &str, value: i32) -> Error {
    Error::invalid_value(format_args!("{argument} is {value}; it must not be negative"))
}

/// `value`, unless it is negative.
pub(super) fn not_negative(argument: &str, value: i32) -> Result<u32, Error> {
    u32::try_from(value).map_err(|_| negative(argument, value))
}
