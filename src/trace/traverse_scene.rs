//! One ray through all instances: the outliers, then the top level. The top-level tree has a kernel of its own,
//! [`super::traverse_top_bvh`], by the rules below; here is the BSP, and from its leaves into objects (Wald03 §4.4).
//!
//! In a leaf each instance is met at most once per ray (a small hashed mailbox on the stack; Havran 2001): the ray is tested
//! against the instance's world box, transformed without re-normalising, clipped against the object's own box (Wald03 §6), and traverses
//! the object's structure.
//!
//! # Why no instance that could win is left out
//!
//! Let the hit that wins, over all instances in turn, be at `t`. Its point lies in its instance's world box as seen from
//! an origin moved by at most `e`, the origin error of `accel/instance`. [`SceneRay`] takes near planes from an origin
//! moved forward by `e` and far planes from one moved back, so computed distances obey `near <= t P` and `t <= far P` with
//! `P = 1 + 4u` for the three roundings of a slab distance. As in `traverse_bsp`, a plane of the tree is before, beyond, or within the box, and
//! a box that only touches a plane lies on its side. So by induction `enter <= t P` and `t <= exit P` in at least one cell
//! that references the instance, and every comparison here allows a factor of [`SLAB_PAD`] > `P²`:
//!
//! * the near child is entered if `enter <= far distance * SLAB_PAD`, the far child if `near distance <= exit * SLAB_PAD`;
//! * a cell or an instance is left out only if `enter > best * SLAB_PAD`, where `best >= t` is the best hit so far.
//!
//! Within the object all comparisons are exact (the hit is clamped to the triangle's box in object space, and the transformed ray is
//! the same bits wherever it comes from), and hits at equal `t` are compared by number. So the winner is always found, and found to be the same.

use super::{Hit, Kernels, PreparedRay, Ray, SLAB_PAD, Scope, traverse_field};
use crate::accel::{Aabb, InstanceRecord, Space, Structure, TOP_MAX_DEPTH, TopLevel, TopLevelBsp, TopNode};
use glam::{Affine3A, Vec3};

/// Instances are remembered by the low bits of their index.
const MAILBOX: usize = 16;

/// A cell to come back to.
#[derive(Clone, Copy)]
struct Pending {
    node: u32,
    enter: f32,
    exit: f32,
}

/// What the slab tests of the top level need, with the origin moved both ways.
pub(super) struct SceneRay {
    pub near_org: Vec3,
    pub far_org: Vec3,
    pub inv_dir: Vec3,
    pub tmin: f32,
}

impl SceneRay {
    #[inline(always)]
    pub fn new(world: Scope<'_>, ray: &PreparedRay) -> Self {
        let m = world.origin_error();
        let o = ray.org.abs();
        let error = (m.x_axis * o.x + m.y_axis * o.y) + m.z_axis * o.z;
        let forward = Vec3::select(ray.inv_dir.cmplt(Vec3::ZERO), -error, error);
        Self { near_org: ray.org + forward, far_org: ray.org - forward, inv_dir: ray.inv_dir, tmin: ray.tmin }
    }

    /// Where the ray may enter and leave a box; not before `tmin`.
    #[inline(always)]
    fn slab(&self, aabb: &Aabb) -> (f32, f32) {
        let down = self.inv_dir.cmplt(Vec3::ZERO);
        let near = (Vec3::select(down, aabb.hi, aabb.lo) - self.near_org) * self.inv_dir;
        let far = (Vec3::select(down, aabb.lo, aabb.hi) - self.far_org) * self.inv_dir;
        (near.max_element().max(self.tmin), far.min_element())
    }
}

/// The ray of world space in object space: always these operations in this order, so that all ways to an instance give the same bits.
#[inline(always)]
pub(super) fn transform(object_from_world: &Affine3A, ray: &PreparedRay) -> Ray {
    let m = &object_from_world.matrix3;
    let linear = |v: Vec3| (m.x_axis * v.x + m.y_axis * v.y) + m.z_axis * v.z;
    Ray {
        origin: (linear(ray.org) + object_from_world.translation).into(),
        direction: linear(ray.dir).into(),
        tmin: ray.tmin,
        tmax: ray.tmax,
    }
}

/// Looks for hits of `ray` in the whole scene. With `ANY` the first one ends the search and `best` stays; else `best` is
/// replaced by the hit that wins, if there is one. Returns whether there is a hit.
pub(super) fn traverse<const ANY: bool>(
    world: Scope<'_>,
    kernels: &Kernels,
    ray: &PreparedRay,
    best: &mut Hit,
) -> bool {
    let mut found = false;
    for &index in world.outliers() {
        if visit::<ANY>(world, kernels, &world.instances()[index as usize], ray, best) {
            if ANY {
                return true;
            }
            found = true;
        }
    }
    found
        | match world.top_level() {
            TopLevel::Bvh(tree) => kernels.scene::<ANY>(world, tree, ray, best),
            TopLevel::Bsp(tree) => traverse_bsp_of_instances::<ANY>(world, tree, kernels, ray, best),
        }
}

fn traverse_bsp_of_instances<const ANY: bool>(
    world: Scope<'_>,
    tree: &TopLevelBsp,
    kernels: &Kernels,
    ray: &PreparedRay,
    best: &mut Hit,
) -> bool {
    let mut found = false;
    let nodes = tree.nodes();
    if nodes.is_empty() {
        return false;
    }
    let scene_ray = SceneRay::new(world, ray);
    let (mut enter, mut exit) = scene_ray.slab(&tree.bounds());
    exit = exit.min(best.t);
    // Written so that NaN fails.
    if !(enter <= exit * SLAB_PAD) {
        return found;
    }

    let mut mailbox = [u32::MAX; MAILBOX];
    let mut stack = [Pending { node: 0, enter: 0.0, exit: 0.0 }; TOP_MAX_DEPTH];
    let mut depth = 0;
    let mut current = 0u32;
    loop {
        match nodes[current as usize] {
            TopNode::Inner { axis, plane, lower } => {
                let axis = axis as usize;
                let inv = scene_ray.inv_dir[axis];
                let s_near = (plane - scene_ray.near_org[axis]) * inv;
                let s_far = (plane - scene_ray.far_org[axis]) * inv;
                let flip = u32::from(inv < 0.0);
                let (near, far) = (lower + flip, lower + 1 - flip);
                if enter > s_far * SLAB_PAD {
                    current = far;
                    enter = enter.max(s_near);
                } else if s_near > exit * SLAB_PAD {
                    current = near;
                } else {
                    stack[depth] = Pending { node: far, enter: enter.max(s_near), exit };
                    depth += 1;
                    current = near;
                    exit = exit.min(s_far);
                }
                continue;
            }
            TopNode::Leaf { first, count } => {
                // In no particular order: visiting the nearest box first was tried and spares 1 visit in 50.
                for &index in &tree.refs()[first as usize..][..count as usize] {
                    let letter = &mut mailbox[index as usize % MAILBOX];
                    if *letter == index {
                        continue;
                    }
                    *letter = index;
                    let (near, far) = scene_ray.slab(&world.boxes()[index as usize]);
                    if near <= far.min(best.t) * SLAB_PAD
                        && visit::<ANY>(world, kernels, &world.instances()[index as usize], ray, best)
                    {
                        if ANY {
                            return true;
                        }
                        found = true;
                    }
                }
            }
        }
        loop {
            if depth == 0 {
                return found;
            }
            depth -= 1;
            let next = stack[depth];
            if next.enter <= best.t * SLAB_PAD {
                (current, enter, exit) = (next.node, next.enter, next.exit);
                break;
            }
        }
    }
}

/// The ray in one instance, from the transform on.
#[inline]
fn visit<const ANY: bool>(
    world: Scope<'_>,
    kernels: &Kernels,
    record: &InstanceRecord,
    ray: &PreparedRay,
    best: &mut Hit,
) -> bool {
    if !world.sees(record) {
        return false;
    }
    let accel = || &*world.objects()[record.slot as usize];
    let transformed;
    let local = match &record.space {
        Space::Object { object_from_world } => {
            let local = transform(object_from_world, ray);
            let Some(local) = PreparedRay::entering(&local, &accel().bounds(), best.t) else { return false };
            transformed = PreparedRay { from: ray.from, ..local };
            &transformed
        }
        Space::World => ray,
        Space::Merged => return visit_merged::<ANY>(world, kernels, ray, best),
    };
    match (accel().structure(), ANY) {
        (Structure::Bvh(bvh), false) => kernels.intersect(bvh, local, record.object, record.instance, best),
        (Structure::Bvh(bvh), true) => kernels.occluded(bvh, local),
        (Structure::Bsp(bsp), _) => kernels.bsp::<ANY>(bsp, local, (record.object, record.instance), best),
        (Structure::Grid(grid), _) => kernels.grid::<ANY>(grid, local, (record.object, record.instance), best),
        (Structure::Field(field), false) => {
            traverse_field::intersect(field, local, record.object, record.instance, best)
        }
        (Structure::Field(field), true) => traverse_field::occluded(field, local),
        (Structure::Lazy(lazy), _) => kernels.lazy::<ANY>(lazy, local, record.object, record.instance, best),
        (Structure::None, _) => false,
    }
}

/// The ray in the tree of merged static instances.
fn visit_merged<const ANY: bool>(world: Scope<'_>, kernels: &Kernels, ray: &PreparedRay, best: &mut Hit) -> bool {
    let Some(merged) = world.merged() else { return false };
    if ANY {
        return kernels.occluded(merged.bvh(), ray);
    }
    // Numbers mean nothing yet, so hits as far away as the best one count.
    let mut own = Hit::none(best.t);
    kernels.intersect(merged.bvh(), &ray.in_merged(merged), 0, u32::MAX, &mut own) && own.located(merged).replaces(best)
}
