//! The C libraries. The exports of `openrt::capi` become theirs because this crate links that one.

pub use openrt::capi;
