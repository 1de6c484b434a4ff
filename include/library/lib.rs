//! The C libraries. The exports of `openrt::capi` become theirs because this crate links that one.
//!
//! What a C program does with malloc() is not touched: the allocator is that of this library alone.

/// Small blocks do not fail where the system has no memory left, see there.
#[global_allocator]
static ALLOCATOR: openrt::memory::Allocator = openrt::memory::Allocator;

pub use openrt::capi;
