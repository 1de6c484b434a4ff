//! One ray through the top-level tree of instances, and from its leaves into objects: both levels in one shell.
//!
//! The loop is that of [`super::traverse_bvh`], over boxes of instances. The rules are those of [`super::traverse_scene`]: near planes are
//! seen from an origin moved forward by the origin error and far planes from one moved back, so that
//! `near <= t P` and `t <= far P` for the hit that wins; a box is left out only if `near > min(far, best t) * SLAB_PAD`.
//! Every box above an instance contains the instance's own, and slab distances are monotone in the planes, so what holds for
//! the instance's box holds for all boxes above it.
//!
//! Each instance is in one leaf, so there is no mailbox.

use super::shells::Shells;
use super::stack::{STACK, Stack, pop, push};
use super::traverse_scene::{SceneRay, transform};
use super::{Hit, PreparedRay, SLAB_PAD, Scope, traverse_field, traverse_lazy};
use crate::accel::{ChildRef, InstanceRecord, Node8, Space, Structure, TopLevelBvh};
use crate::simd::{Isa, Vector};
use std::mem::MaybeUninit;

/// What the slab tests derive from a ray, in registers.
struct SlabLanes<I: Isa> {
    near_org: [I::F8; 3],
    far_org: [I::F8; 3],
    inv_dir: [I::F8; 3],
    tmin: I::F8,
    /// Rows of [`Node8::bounds`] with the near planes; the far ones are the other of each pair.
    near: [usize; 3],
}

impl<I: Isa> SlabLanes<I> {
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn new(ray: &SceneRay) -> Self {
        // SAFETY: the caller's promise.
        unsafe {
            let splat = |v: glam::Vec3| [I::F8::splat(v.x), I::F8::splat(v.y), I::F8::splat(v.z)];
            Self {
                near_org: splat(ray.near_org),
                far_org: splat(ray.far_org),
                inv_dir: splat(ray.inv_dir),
                tmin: I::F8::splat(ray.tmin),
                near: [0, 1, 2].map(|k| 2 * k + usize::from(ray.inv_dir[k] < 0.0)),
            }
        }
    }

    /// Which children may be hit before `limit` (with the padding), and where the ray enters them (not before `tmin`).
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn test(&self, node: &Node8, limit: I::F8) -> (u32, I::F8) {
        // SAFETY: the caller's promise; rows are below 6 by construction, and `^ 1` stays inside their pairs.
        unsafe {
            let row = |row: usize| I::F8::load(node.bounds.get_unchecked(row));
            let near = |axis: usize| row(self.near[axis]).sub(self.near_org[axis]).mul(self.inv_dir[axis]);
            let far = |axis: usize| row(self.near[axis] ^ 1).sub(self.far_org[axis]).mul(self.inv_dir[axis]);
            let enter = near(0).max(near(1)).max(near(2)).max(self.tmin);
            let exit = far(0).min(far(1)).min(far(2));
            (enter.le(exit.mul(I::F8::splat(SLAB_PAD)).min(limit)), enter)
        }
    }
}

/// Looks for hits of `ray` in the instances of `tree`, the top level of `world`. With `ANY` the first one ends the search and
/// `best` stays; else `best` is replaced by every hit that comes before it. Returns whether there is a hit that counts.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn traverse<I: Shells, const ANY: bool>(
    world: Scope<'_>,
    tree: &TopLevelBvh,
    ray: &PreparedRay,
    best: &mut Hit,
) -> bool {
    if tree.is_empty() {
        return false;
    }
    let (nodes, refs, records) = (tree.nodes(), tree.refs(), world.instances());
    if let [only] = *refs {
        // SAFETY: the caller's promise.
        return unsafe { visit::<I, ANY>(world, &records[only as usize], ray, best) };
    }
    let mut stack: Stack = [const { MaybeUninit::uninit() }; STACK];
    let mut depth = 0;
    let mut found = false;
    let mut current = ChildRef::node(0);
    let scene_ray = SceneRay::new(world, ray);
    // SAFETY: the caller's promise, for all vector operations. A tree's references are to its own nodes and to its own `refs`, and paths
    // have at most MAX_DEPTH nodes (by its construction); all nodes but the root come from
    // the stack.
    unsafe {
        let slabs = SlabLanes::<I>::new(&scene_ray);
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
                for &index in &refs[current.blocks()] {
                    if visit::<I, ANY>(world, &records[index as usize], ray, best) {
                        if ANY {
                            return true;
                        }
                        found = true;
                        limit = I::F8::splat(best.t * SLAB_PAD);
                    }
                }
            }
            // Back to what is left.
            let Some(next) = pop::<ANY>(&stack, &mut depth, best.t * SLAB_PAD) else { return found };
            current = next;
        }
    }
}

/// The ray in one instance, from the transform on.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn visit<I: Shells, const ANY: bool>(
    world: Scope<'_>,
    record: &InstanceRecord,
    ray: &PreparedRay,
    best: &mut Hit,
) -> bool {
    if !world.sees(record) {
        return false;
    }
    let transformed;
    let (local, bvh) = match &record.space {
        Space::Merged => {
            let Some(merged) = world.merged() else { return false };
            if ray.from == 0 {
                (ray, merged.bvh())
            } else {
                transformed = ray.in_merged(merged);
                (&transformed, merged.bvh())
            }
        }
        space => {
            let accel = &world.objects()[record.slot as usize];
            let local = match space {
                Space::Object { object_from_world } => {
                    let local = transform(object_from_world, ray);
                    let Some(local) = PreparedRay::entering(&local, &accel.bounds(), best.t) else { return false };
                    transformed = PreparedRay { from: ray.from, ..local };
                    &transformed
                }
                // The lane of the top level was the object's own box.
                _ => ray,
            };
            match accel.structure() {
                Structure::Bvh(bvh) => (local, bvh),
                Structure::Bsp(bsp) => {
                    // SAFETY: the caller's promise.
                    return unsafe { I::bsp::<ANY>(bsp, local, (record.object, record.instance), best) };
                }
                Structure::Grid(grid) => {
                    // SAFETY: the caller's promise.
                    return unsafe { I::grid::<ANY>(grid, local, (record.object, record.instance), best) };
                }
                Structure::Field(field) if ANY => return traverse_field::occluded(field, local),
                Structure::Field(field) => {
                    return traverse_field::intersect(field, local, record.object, record.instance, best);
                }
                Structure::Lazy(lazy) => {
                    let numbers = (record.object, record.instance);
                    // SAFETY: the caller's promise.
                    return unsafe { traverse_lazy::traverse::<I, ANY>(lazy, local, numbers, best) };
                }
                Structure::None => return false,
            }
        }
    };
    // In the merged tree numbers mean nothing yet, so hits as far away as the best one count.
    let is_merged = matches!(record.space, Space::Merged);
    let mut own = if is_merged { Hit::none(best.t) } else { *best };
    // SAFETY: the caller's promise.
    if !unsafe { I::one::<ANY>(bvh, local, (record.object, record.instance), &mut own) } {
        return false;
    }
    if ANY {
        return true;
    }
    match world.merged().filter(|_| is_merged) {
        Some(merged) => own.located(merged).replaces(best),
        None => {
            *best = own;
            true
        }
    }
}
