//! One ray through one 8-wide tree.
//!
//! ```text
//! loop: node  → slab test of all children at once → go to the nearest hit one, the others to the stack, nearest on top
//!       leaf  → triangle blocks
//!       next  → pop; skip what begins beyond the best hit
//! ```
//!
//! After Wald, Benthin, Boulos, *Getting Rid of Packets* (2008), and Embree's single-ray kernels. Near and far planes
//! are chosen by the signs of the direction, once per ray, as rows of the node.
//!
//! A box is entered when `max(enter, tmin) <= min(exit, best t) * SLAB_PAD`; with `<=`, as a triangle at an equal distance may win
//! by its number. The best distance is padded for boxes around parts of triangles: shear, slab and weighing add up to 15 half ulps there. The same operations as [`PreparedRay::slab`], so every instruction set visits the same nodes.
//!
//! Tried without gain (bumpy sphere of 1.3 million triangles, 8 nodes and 1.6 blocks per primary ray): prefetching the children that go to
//! the stack (-3 to -10 %), prefetching the line of the references (±2 %), leaving the children
//! unsorted when any hit will do (within the noise). What helped: huge pages (+10 to +15 %).

use super::kernels::Shells;
use super::one_ray::OneRay;
use super::stack::{STACK, Stack, pop, push};
use super::triangle4::{RayLanes, edges4};
use super::{Hit, PreparedRay, SLAB_PAD};
use crate::accel::{Bvh, ChildRef, Node8};
use crate::simd::{Isa, Vector};
use std::mem::MaybeUninit;

/// What the slab tests derive from a ray, in registers.
pub(super) struct SlabLanes<I: Isa> {
    org: [I::F8; 3],
    inv_dir: [I::F8; 3],
    tmin: I::F8,
    /// Rows of [`Node8::bounds`] with the near planes; the far ones are the other of each pair.
    near: [usize; 3],
}

impl<I: Isa> SlabLanes<I> {
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn new(ray: impl OneRay) -> Self {
        // SAFETY: the caller's promise.
        unsafe {
            Self {
                org: [I::F8::splat(ray.org(0)), I::F8::splat(ray.org(1)), I::F8::splat(ray.org(2))],
                inv_dir: [I::F8::splat(ray.inv_dir(0)), I::F8::splat(ray.inv_dir(1)), I::F8::splat(ray.inv_dir(2))],
                tmin: I::F8::splat(ray.tmin()),
                near: [0, 1, 2].map(|k| 2 * k + usize::from(ray.inv_dir(k) < 0.0)),
            }
        }
    }

    /// Which children are hit before `limit`, and where the ray enters them (not before `tmin`).
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn test(&self, node: &Node8, limit: I::F8) -> (u32, I::F8) {
        // SAFETY: the caller's promise; rows are below 6 by construction, and `^ 1` stays inside their pairs.
        unsafe {
            let distance = |axis: usize, row: usize| {
                I::F8::load(node.bounds.get_unchecked(row)).sub(self.org[axis]).mul(self.inv_dir[axis])
            };
            let [nx, ny, nz] = self.near;
            let enter = distance(0, nx).max(distance(1, ny)).max(distance(2, nz)).max(self.tmin);
            let exit = distance(0, nx ^ 1).min(distance(1, ny ^ 1)).min(distance(2, nz ^ 1));
            (enter.le(exit.mul(I::F8::splat(SLAB_PAD)).min(limit)), enter)
        }
    }
}

/// Looks for hits of `ray` in `bvh`. With `ANY` the first one found ends the search; otherwise `best` is replaced by
/// every hit that comes before it (see [`Hit::is_before`]), and nothing that cannot come before it is visited.
/// Hits are given the numbers `object` and `instance`. Returns whether there was a hit that counts.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn traverse<I: Shells, const ANY: bool>(
    bvh: &Bvh,
    ray: &PreparedRay,
    object: u32,
    instance: u32,
    best: &mut Hit,
) -> bool {
    // SAFETY: the caller's promise; a tree that is not empty has a root.
    unsafe { !bvh.is_empty() && traverse_below::<I, ANY>(bvh, ChildRef::node(0), ray, object, instance, best) }
}

/// [`traverse`], from `child` down.
///
/// # Safety
/// - The processor has the instruction set `I`; `child` is of `bvh`.
#[inline(always)]
pub(super) unsafe fn traverse_below<I: Shells, const ANY: bool>(
    bvh: &Bvh,
    child: ChildRef,
    ray: impl OneRay,
    object: u32,
    instance: u32,
    best: &mut Hit,
) -> bool {
    let (nodes, blocks) = (bvh.nodes(), bvh.blocks());
    let mut stack: Stack = [const { MaybeUninit::uninit() }; STACK];
    let mut depth = 0;
    let mut found = false;
    let mut current = child;
    // SAFETY: the caller's promise, for all vector operations. The references in a `Bvh` are to its own nodes and blocks
    // and paths have at most MAX_DEPTH nodes (its invariants, checked on construction); all nodes but
    // the first come from the stack.
    unsafe {
        let (slabs, lanes) = (SlabLanes::<I>::new(ray), RayLanes::<I>::new(ray));
        let mut limit = I::F8::splat(best.t * SLAB_PAD);
        loop {
            // Down to a leaf.
            let reached = loop {
                if current.is_leaf() {
                    break true;
                }
                let node = nodes.get_unchecked(current.index());
                let (mask, enter) = slabs.test(node, limit);
                if mask == 0 {
                    break false;
                }
                current = push::<I>(&mut stack, &mut depth, node, mask, enter);
            };
            if reached {
                let mut closer = false;
                for block in blocks.get_unchecked(current.blocks()) {
                    let Some((candidates, edges)) = edges4(&lanes, block) else { continue };
                    closer |= I::resolve::<ANY, _>(ray, block, candidates, &edges, (object, instance), best);
                    if ANY && closer {
                        return true;
                    }
                }
                if closer {
                    found = true;
                    limit = I::F8::splat(best.t * SLAB_PAD);
                }
            }
            // Back to what is left.
            let Some(next) = pop::<ANY>(&stack, &mut depth, best.t * SLAB_PAD) else { return found };
            current = next;
        }
    }
}
