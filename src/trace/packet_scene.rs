//! A packet of rays through the scene: the outliers, the top level, and from its leaves into objects.
//!
//! By the rules of [`super::traverse_scene`]. The boxes of the top-level tree are tested as those of objects are, with origins moved by
//! the origin error. An instance gets the rays that enter its box: they are transformed together, clipped against the
//! object's own box, split where the signs of their directions differ now, and go on as a packet.
//! In the tree of merged static objects rays find numbers of that tree, which are looked up when the packet is through it ([`Merged::locate`]): with a search among all
//! members and a copy of all hits, camera rays on 161 parts took a fifth longer than on one object, now a tenth.
//!
//! *Tried*, for diffuse bounces, which come to a part of a robot by fives, two to a vector, and to a tree by eights: packing them into fewer vectors before the
//! transform (what it spares and what packing and giving back cost are alike, 897 of 902 instructions per ray); rays that take turns through both levels, each with
//! its own transform (a third slower on the robots, and no faster on 661 trees, with 5900 instructions per ray for 5000).
//!
//! With the BSP as top level each ray goes alone: its cells cut a packet into pieces, each with an interval per ray.

use super::packet::{Found, GROUPS, LANES, Packet, Rows, groups};
use super::packet_boxes::{Slabs, enters_box};
use super::shells::Shells;
use super::traverse_packet::{Alike, Leaves, traverse_packet};
use super::{Hit, Kernels, PreparedRay, Scope, traverse_field, traverse_lazy, traverse_scene};
use crate::accel::{ChildRef, InstanceRecord, Merged, Space, Structure, TopLevel, TopLevelBvh};
use crate::simd::{Isa, Vector, bits};
use glam::Mat3;

/// Memory of one packet on its way through the scene.
pub(super) struct Scratch {
    pub world: Packet,
    local: Packet,
    /// Origins of `world` moved along and against the directions, see `traverse_scene`.
    near_org: [Rows; 3],
    far_org: [Rows; 3],
    pub found: Found,
}

impl Scratch {
    pub(super) fn new() -> Self {
        let rows = [[0.0; LANES]; GROUPS];
        Self {
            world: Packet::new(),
            local: Packet::new(),
            near_org: [rows; 3],
            far_org: [rows; 3],
            found: Found::new(),
        }
    }

    /// What ray `r` has found; with `ANY` the hit only tells that there is one.
    #[inline(always)]
    pub(super) fn answer<const ANY: bool>(&self, r: usize) -> Option<Hit> {
        let hit = self.found.hits[r];
        let is_hit = if ANY { (self.world.usable & !self.found.open) >> r & 1 == 1 } else { !hit.is_none() };
        is_hit.then_some(hit)
    }
}

/// Looks for hits of the rays in `scratch.world` and leaves them in `scratch.found`: the closest ones, or with `ANY` the rays that hit
/// nothing as `open`.
///
/// # Safety
/// - The processor has the instruction set `I`, and `kernels` are its own.
#[inline(always)]
pub(super) unsafe fn traverse<I: Shells, const ANY: bool>(world: Scope<'_>, kernels: &Kernels, scratch: &mut Scratch) {
    // SAFETY: the caller's promise.
    unsafe {
        if world.some_untransformed() || matches!(world.top_level(), TopLevel::Bsp(_)) {
            let all = scratch.world.usable;
            scratch.world.prepare_triangles::<I>(all);
        }
        match world.top_level() {
            TopLevel::Bvh(tree) => through_tree::<I, ANY>(world, tree, scratch),
            TopLevel::Bsp(_) => alone::<ANY>(world, kernels, scratch),
        }
    }
}

/// Every ray by itself.
fn alone<const ANY: bool>(world: Scope<'_>, kernels: &Kernels, scratch: &mut Scratch) {
    let Scratch { world: rays, found, .. } = scratch;
    for r in bits(rays.usable) {
        let tmax = found.t[r / LANES][r % LANES];
        let best = if ANY { &mut Hit::none(tmax) } else { &mut found.hits[r] };
        let hit = traverse_scene::traverse::<ANY>(world, kernels, &rays.ray(r, tmax), best);
        if ANY && hit {
            found.open &= !(1 << r);
        }
    }
}

/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn through_tree<I: Shells, const ANY: bool>(world: Scope<'_>, tree: &TopLevelBvh, scratch: &mut Scratch) {
    let Scratch { world: rays, local, near_org, far_org, found } = scratch;
    let rays = &*rays;
    let mut instances = Instances::<ANY> { world, refs: tree.refs(), rays, local };
    // SAFETY: the caller's promise; a `TopLevelBvh` that is not empty is a tree (by its construction).
    unsafe {
        for &index in world.outliers() {
            instances.visit::<I>(&world.instances()[index as usize], found.open, found);
        }
        if tree.is_empty() || found.open == 0 {
            return;
        }
        if let [only] = *tree.refs() {
            instances.visit::<I>(&world.instances()[only as usize], found.open, found);
            return;
        }
        let (mut near, mut far) = (&rays.org, &rays.org);
        if *world.origin_error() != Mat3::ZERO {
            move_origins::<I>(world, rays, near_org, far_org);
            (near, far) = (near_org, far_org);
        }
        let slabs = Slabs { near_org: near, far_org: far, inv_dir: &rays.inv_dir, tmin: &rays.tmin };
        let (negative, mask) = (rays.negative, found.open);
        traverse_packet::<I, _>(tree.nodes(), ChildRef::ROOT, &slabs, &negative, mask, &mut instances, found);
    }
}

/// What `traverse_scene` does to the origin of one ray.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn move_origins<I: Isa>(world: Scope<'_>, rays: &Packet, near_org: &mut [Rows; 3], far_org: &mut [Rows; 3]) {
    let error = world.origin_error().to_cols_array_2d();
    // SAFETY: the caller's promise.
    unsafe {
        let zero = I::F8::splat(0.0);
        for g in groups(rays.usable) {
            let x = I::F8::load(&rays.org[0][g]).abs();
            let y = I::F8::load(&rays.org[1][g]).abs();
            let z = I::F8::load(&rays.org[2][g]).abs();
            for k in 0..3 {
                let [ex, ey, ez] = [I::F8::splat(error[0][k]), I::F8::splat(error[1][k]), I::F8::splat(error[2][k])];
                let error = ex.mul(x).add(ey.mul(y)).add(ez.mul(z));
                let forward = zero.select_le(I::F8::load(&rays.inv_dir[k][g]), error, zero.sub(error));
                let org = I::F8::load(&rays.org[k][g]);
                org.add(forward).store(&mut near_org[k][g]);
                org.sub(forward).store(&mut far_org[k][g]);
            }
        }
    }
}

/// The instances of the top-level tree, as seen by a packet in the world.
struct Instances<'a, const ANY: bool> {
    world: Scope<'a>,
    refs: &'a [u32],
    rays: &'a Packet,
    /// Memory for the packet in an object's space.
    local: &'a mut Packet,
}

impl<const ANY: bool> Instances<'_, ANY> {
    /// The rays of `mask` in one instance.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn visit<I: Shells>(&mut self, record: &InstanceRecord, mask: u64, found: &mut Found) {
        let Self { world, rays, ref mut local, .. } = *self;
        if !world.sees(record) {
            return;
        }
        // SAFETY: the caller's promise.
        unsafe {
            let (packet, mask) = match &record.space {
                Space::Object { object_from_world } => {
                    let bounds = world.objects()[record.slot as usize].bounds();
                    local.transform::<I>(object_from_world, rays, mask);
                    let mask = enters_box::<I>(local, found, local.usable, &bounds);
                    local.prepare_triangles::<I>(mask);
                    (&**local, mask)
                }
                // The lane of the top level was the object's own box.
                Space::World => (rays, mask),
                Space::Merged => {
                    if let Some(merged) = world.merged() {
                        through_merged::<I, ANY>(merged, rays, mask, found);
                    }
                    return;
                }
            };
            match world.objects()[record.slot as usize].structure() {
                Structure::Bvh(bvh) => {
                    I::packet::<ANY>(bvh, packet, mask, (record.object, record.instance), found);
                }
                Structure::Bsp(bsp) => {
                    I::bsp_packet::<ANY>(bsp, packet, mask, (record.object, record.instance), found);
                }
                Structure::Grid(grid) => one_by_one::<ANY>(packet, mask, found, |ray, best| {
                    let numbers = (record.object, record.instance);
                    I::grid::<ANY>(grid, ray, numbers, best.unwrap_or(&mut Hit::none(ray.tmax)))
                }),
                Structure::Field(field) => one_by_one::<ANY>(packet, mask, found, |ray, best| match best {
                    Some(best) => traverse_field::intersect(field, ray, record.object, record.instance, best),
                    None => traverse_field::occluded(field, ray),
                }),
                Structure::Lazy(lazy) => {
                    traverse_lazy::traverse_many::<I, ANY>(lazy, packet, mask, (record.object, record.instance), found);
                }
                Structure::None => {}
            }
        }
    }
}

/// The rays of `mask` in the tree of merged static instances.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn through_merged<I: Shells, const ANY: bool>(merged: &Merged, rays: &Packet, mask: u64, found: &mut Found) {
    // Numbers mean nothing yet in this tree, so hits as far away as the best one count, and those found before wait aside.
    let mut aside = 0;
    if !ANY {
        for r in bits(mask) {
            aside |= u64::from(!found.hits[r].is_none()) << r;
        }
    }
    let before = (aside != 0).then_some(found.hits);
    for r in bits(aside) {
        found.hits[r] = Hit::none(found.hits[r].t);
    }
    // SAFETY: the caller's promise.
    unsafe { I::packet::<ANY>(merged.bvh(), rays, mask, (0, u32::MAX), found) };
    if ANY {
        return;
    }
    for r in bits(mask) {
        let own = &mut found.hits[r];
        if !own.is_none() {
            *own = own.located(merged);
        }
    }
    if let Some(before) = before {
        for r in bits(aside) {
            let own = std::mem::replace(&mut found.hits[r], before[r]);
            if !own.is_none() {
                own.replaces(&mut found.hits[r]);
            }
        }
    }
}

/// Every ray of `mask` by itself: `trace` looks for the closest hit if there is a place for it, else for any.
#[inline(always)]
fn one_by_one<const ANY: bool>(
    local: &Packet,
    mask: u64,
    found: &mut Found,
    trace: impl Fn(&PreparedRay, Option<&mut Hit>) -> bool,
) {
    for r in bits(mask) {
        let t = &mut found.t[r / LANES][r % LANES];
        let ray = local.ray(r, *t);
        if ANY {
            found.open &= !(u64::from(trace(&ray, None)) << r);
        } else {
            let best: &mut Hit = &mut found.hits[r];
            trace(&ray, Some(best));
            *t = best.t;
        }
    }
}

impl<I: Shells, const ANY: bool> Leaves<I> for Instances<'_, ANY> {
    /// To visit an instance costs more than what a kernel for one ray would save on the way to it.
    const FEW: u32 = 0;

    #[inline(always)]
    unsafe fn test(&mut self, leaf: ChildRef, mask: u64, _alike: Alike, found: &mut Found) -> bool {
        for &index in &self.refs[leaf.blocks()] {
            let mask = mask & found.open;
            // SAFETY: the caller's promise.
            unsafe { self.visit::<I>(&self.world.view().instances()[index as usize], mask, found) };
        }
        !ANY
    }

    #[inline(always)]
    unsafe fn alone(&mut self, _child: ChildRef, _r: usize, _down: [bool; 3], _found: &mut Found) {
        unreachable!("no ray is too few");
    }

    /// The top level is small.
    #[inline(always)]
    fn prefetch(&self, _child: ChildRef) {}
}
