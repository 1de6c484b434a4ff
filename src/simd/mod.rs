//! Vectors and instruction sets: a shelf that knows nothing of rays.
//!
//! A kernel is written once, generic over [`Isa`], as an `#[inline(always)]` function. A shell per instruction set
//! (`trace/kernels.rs`) carries the `#[target_feature]` and calls the kernel with that set's type; everything inlines
//! into the shell, where the intrinsics become single instructions (the pattern of BurntSushi/memchr).
//! Which shell runs is decided by [`Level`], once per context.
//!
//! [`Vector`] has only the operations that the kernels need, and none that would let the instruction sets
//! differ by a bit: no fused multiply-add, no approximate reciprocal.
//!
//! [`prefer_huge_pages`] and [`box_at`] are here as well: large trees wait for memory more than for arithmetic.

mod dispatch;
mod level;
mod mask;
mod memory;
mod places;
mod scalar;
mod vector;
mod wide;

#[cfg(target_arch = "x86_64")]
mod x86;
#[cfg(target_arch = "x86_64")]
mod x86_eight;

pub use dispatch::{Kernel, run};
pub use level::Level;
pub use mask::bits;
pub use memory::{components, prefer_huge_pages, prefetch, prefetch_at};
pub use places::{FewPlaces, Places, box_at, box_at_few, corners_at, few_place_of, number_at, place_of};
pub use scalar::Scalar;
pub use vector::{Eight, Isa, Vector};
pub use wide::{LANES, Proof, Wide, Wide3, WideKernel, run_wide};
#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2, Avx512, Sse41};

#[cfg(test)]
#[path = "../../tests/common/skip.rs"]
pub(crate) mod skip;
#[cfg(test)]
mod tests;
