//! The children that one ray has still to visit, nearest on top.
//!
//! An entry is one 64-bit word, distance above and child below: distances are not negative, so their bits sort like numbers and a pair is
//! sorted by two conditional moves.

use crate::accel::{ChildRef, MAX_DEPTH, Node8, WIDTH};
use crate::simd::{Isa, Vector};
use std::mem::MaybeUninit;

/// A node leaves at most all children but one on the stack, and they are of one path.
pub(super) const STACK: usize = MAX_DEPTH * (WIDTH - 1) + 1;

/// Written below the `depth` that goes with it, which is a variable of its own so that it stays in a register.
pub(super) type Stack = [MaybeUninit<u64>; STACK];

/// Puts the children of `node` that are in `mask`, at the distances `enter`, on the stack, but for the nearest, which is returned.
///
/// # Safety
/// - The processor has the instruction set `I`.
/// - `mask` has a bit set, and none beyond the children of `node`.
/// - Nodes are visited from the root of one tree down, no path of which has more than `MAX_DEPTH`, and each but the root comes from this
///   stack: so there is room, and what is below `depth` has been written.
#[inline(always)]
pub(super) unsafe fn push<I: Isa>(
    stack: &mut Stack,
    depth: &mut usize,
    node: &Node8,
    mut mask: u32,
    enter: I::F8,
) -> ChildRef {
    let lane = |mask: u32| mask.trailing_zeros() as usize & (WIDTH - 1);
    let others = mask & (mask - 1);
    // SAFETY: the caller's promise; lanes are below WIDTH.
    unsafe {
        if others == 0 {
            return *node.children.get_unchecked(lane(mask));
        }
        let mut distance = [0.0f32; WIDTH];
        enter.store(&mut distance);
        let entry = |mask: u32| {
            let lane = lane(mask);
            u64::from(distance.get_unchecked(lane).to_bits()) << 32
                | u64::from(node.children.get_unchecked(lane).to_bits())
        };
        // Insertion from the top: the nearest stays in `carried`.
        let base = *depth;
        let mut carried = entry(mask);
        mask = others;
        while mask != 0 {
            let next = entry(mask);
            mask &= mask - 1;
            let (near, far) = if next < carried { (next, carried) } else { (carried, next) };
            carried = near;
            let mut at = *depth;
            while at > base && stack.get_unchecked(at - 1).assume_init() < far {
                *stack.get_unchecked_mut(at) = *stack.get_unchecked(at - 1);
                at -= 1;
            }
            stack.get_unchecked_mut(at).write(far);
            *depth += 1;
        }
        ChildRef::from_bits(carried as u32)
    }
}

/// Takes the next child off that is not beyond `limit`, dropping those that are; with `ANY` none is.
///
/// # Safety
/// - What is below `depth` has been written.
#[inline(always)]
pub(super) unsafe fn pop<const ANY: bool>(stack: &Stack, depth: &mut usize, limit: f32) -> Option<ChildRef> {
    while *depth > 0 {
        *depth -= 1;
        // SAFETY: the caller's promise.
        let entry = unsafe { stack.get_unchecked(*depth).assume_init() };
        if ANY || f32::from_bits((entry >> 32) as u32) <= limit {
            return Some(ChildRef::from_bits(entry as u32));
        }
    }
    None
}
