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
//! by its number. The best distance is padded for boxes around parts of triangles: shear, slab and weighing add up to 15 half ulps there. The same operations as [`PreparedRay::slab`]
//! (but for two signs, which cancel out), so every instruction set visits the same nodes.
//!
//! Tried without gain (bumpy sphere of 1.3 million triangles, 8 nodes and 1.6 blocks per primary ray): prefetching the children that go to
//! the stack (-3 to -10 %), prefetching the line of the references (±2 %), leaving the children
//! unsorted when any hit will do (within the noise). What helped: huge pages (+10 to +15 %).

use super::ground::{Blocks, Plain};
use super::one_ray::OneRay;
use super::shells::Shells;
use super::stack::{STACK, Stack, pop, push};
use super::triangle4::{RayLanes, edges4};
use super::{Hit, PreparedRay, SLAB_PAD};
use crate::accel::{Bvh, ChildRef, Node8, WIDTH};
use crate::simd::{Isa, Vector};
use std::mem::MaybeUninit;

/// Bytes from one row of [`Node8::bounds`] to the next: one bit, that tells the rows of a pair apart.
const ROW: usize = size_of::<[f32; WIDTH]>();
const _: () = assert!(ROW.is_power_of_two());

/// What the slab tests derive from a ray, in registers.
pub(super) struct SlabLanes<I: Isa> {
    org: [I::F8; 3],
    /// Of opposite sign: planes are subtracted from the origin, as the operand that comes from memory is the one that is subtracted.
    neg_inv_dir: [I::F8; 3],
    tmin: I::F8,
    /// Where in [`Node8::bounds`] the rows of near planes and of far planes begin, in bytes: made before the loop, as addresses need no shift then.
    near: [usize; 3],
    far: [usize; 3],
}

impl<I: Isa> SlabLanes<I> {
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn new(ray: impl OneRay) -> Self {
        let near = [0, 1, 2].map(|k| ROW * (2 * k + usize::from(ray.is_down(k))));
        let inv = [ray.inv_dir(0), ray.inv_dir(1), ray.inv_dir(2)];
        // SAFETY: the caller's promise.
        unsafe {
            Self {
                org: [I::F8::splat(ray.org(0)), I::F8::splat(ray.org(1)), I::F8::splat(ray.org(2))],
                neg_inv_dir: [I::F8::splat(-inv[0]), I::F8::splat(-inv[1]), I::F8::splat(-inv[2])],
                tmin: I::F8::splat(ray.tmin()),
                near,
                far: near.map(|row| row ^ ROW),
            }
        }
    }

    /// Which children are hit before `limit`, and where the ray enters them (not before `tmin`).
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn test(&self, node: &Node8, limit: I::F8) -> (u32, I::F8) {
        let rows = (&raw const node.bounds).cast::<u8>();
        // SAFETY: the caller's promise; near and far are multiples of a row, below six of them (see `new`).
        unsafe {
            let distance = |axis: usize, row: usize| {
                let planes = &*rows.add(row).cast::<[f32; WIDTH]>();
                self.org[axis].sub(I::F8::load(planes)).mul(self.neg_inv_dir[axis])
            };
            let ([nx, ny, nz], [fx, fy, fz]) = (self.near, self.far);
            let enter = distance(0, nx).max(distance(1, ny)).max(distance(2, nz)).max(self.tmin);
            let exit = distance(0, fx).min(distance(1, fy)).min(distance(2, fz));
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
    // SAFETY: the caller's promise; a `Bvh` is a tree (its invariants, checked on construction).
    unsafe {
        let lanes = (SlabLanes::<I>::new(ray), RayLanes::<I>::new(ray));
        let tree = Plain::new(bvh);
        descend::<I, ANY, _, _>(&tree, child, &lanes, ray, (object, instance), best)
    }
}

/// What [`descend`] goes down: where nodes and blocks are, and where leaves lead that are not of blocks.
pub(super) trait Tree: Blocks {
    /// Where to go at a leaf that has been reached: to its blocks, on to another node, or back, if all below it has been looked at.
    ///
    /// # Safety
    /// - That of [`descend`]; it is a leaf of the tree.
    #[inline(always)]
    unsafe fn lead(&self, _leaf: ChildRef, _best: &mut Hit) -> Lead {
        Lead::Blocks
    }
}

/// See [`Tree::lead`].
pub(super) enum Lead {
    Blocks,
    On(ChildRef),
    /// With whether there was a hit that counts.
    Back(bool),
}

impl Tree for Plain<'_> {}

/// The loop, in `tree`, from `child` down.
///
/// # Safety
/// - The processor has the instruction set `I`; `lanes` are those of `ray`.
/// - `child` is of the tree; no path of it has more than `MAX_DEPTH` nodes.
#[inline(always)]
pub(super) unsafe fn descend<I: Shells, const ANY: bool, R: OneRay, T: Tree>(
    tree: &T,
    child: ChildRef,
    (slabs, lanes): &(SlabLanes<I>, RayLanes<I>),
    ray: R,
    numbers: (u32, u32),
    best: &mut Hit,
) -> bool {
    let mut stack: Stack = [const { MaybeUninit::uninit() }; STACK];
    let mut depth = 0;
    let mut found = false;
    let mut current = child;
    // SAFETY: the caller's promise, for all vector operations and references; all nodes but the first come from the stack.
    unsafe {
        let mut limit = I::F8::splat(best.t * SLAB_PAD);
        loop {
            // Down to a leaf.
            let reached = loop {
                if current.is_leaf() {
                    break true;
                }
                let node = tree.node(current.index());
                let (mask, enter) = slabs.test(node, limit);
                if mask == 0 {
                    break false;
                }
                current = push::<I>(&mut stack, &mut depth, node, mask, enter);
            };
            if reached {
                let mut closer = false;
                match tree.lead(current, best) {
                    Lead::Blocks => {
                        for block in tree.blocks(current) {
                            let Some((candidates, edges)) = edges4(lanes, &block) else { continue };
                            closer |= I::resolve::<ANY, _>(ray, &block, candidates, &edges, numbers, best);
                            if ANY && closer {
                                return true;
                            }
                        }
                    }
                    Lead::On(next) => {
                        current = next;
                        continue;
                    }
                    Lead::Back(hit) => {
                        if ANY && hit {
                            return true;
                        }
                        closer = hit;
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
