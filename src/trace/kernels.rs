//! The kernels of an instruction set, chosen once per context.
//!
//! Calls go through function pointers to the [shells](super::shells), per object and ray or per batch, never per node.

use super::packet_query::RayPacket;
use super::packet_scene::Scratch;
use super::shells::kernels_of;
use super::{Hit, PreparedRay, Ray, Scope};
use crate::accel::{Bsp, Bvh, Grid, LazyBvh, TopLevelBvh};
use crate::simd::Level;

type Intersect = unsafe fn(&Bvh, &PreparedRay, u32, u32, &mut Hit) -> bool;
type Occluded = unsafe fn(&Bvh, &PreparedRay) -> bool;
type Lazy = unsafe fn(&LazyBvh, &PreparedRay, u32, u32, &mut Hit) -> bool;
type Other<S> = unsafe fn(&S, &PreparedRay, (u32, u32), &mut Hit) -> bool;
type Scene = unsafe fn(Scope<'_>, &TopLevelBvh, &PreparedRay, &mut Hit) -> bool;
type IntersectMany = unsafe fn(Scope<'_>, &[Ray], &mut [Hit]) -> bool;
type OccludedMany = unsafe fn(Scope<'_>, &[Ray], &mut [bool]) -> bool;
type PacketQuery = unsafe fn(Scope<'_>, &RayPacket, u64, &mut Scratch) -> u64;

/// The kernels of one level. Holding one proves that the processor can run them.
#[derive(Clone, Copy, Debug)]
pub struct Kernels {
    pub(super) level: Level,
    pub(super) intersect: Intersect,
    pub(super) occluded: Occluded,
    pub(super) lazy_intersect: Lazy,
    pub(super) lazy_occluded: Lazy,
    pub(super) bsp_intersect: Other<Bsp>,
    pub(super) bsp_occluded: Other<Bsp>,
    pub(super) grid_intersect: Other<Grid>,
    pub(super) grid_occluded: Other<Grid>,
    pub(super) scene_intersect: Scene,
    pub(super) scene_occluded: Scene,
    pub(super) intersect_many: IntersectMany,
    pub(super) occluded_many: OccludedMany,
    pub(super) intersect_packet: PacketQuery,
    pub(super) occluded_packet: PacketQuery,
}

impl Kernels {
    /// The kernels of `level`, or of the strongest level that the processor has if that is weaker.
    pub fn new(level: Level) -> Kernels {
        *kernels_of(level)
    }

    /// The level they were compiled for.
    pub fn level(&self) -> Level {
        self.level
    }

    /// The closest hit of `ray` in `bvh`, both in the same space. Replaces `best` if the hit comes before it, by distance and then
    /// by numbers ([`Hit::is_before`]); begin with [`Hit::none`]. Hits are given the numbers `object` and `instance`.
    /// Returns whether `best` was replaced.
    #[inline]
    pub fn intersect(&self, bvh: &Bvh, ray: &PreparedRay, object: u32, instance: u32, best: &mut Hit) -> bool {
        // SAFETY: `new` picks only levels that the processor has.
        unsafe { (self.intersect)(bvh, ray, object, instance, best) }
    }

    /// Whether `ray` hits anything in `bvh` within its interval.
    #[inline]
    pub fn occluded(&self, bvh: &Bvh, ray: &PreparedRay) -> bool {
        // SAFETY: `new` picks only levels that the processor has.
        unsafe { (self.occluded)(bvh, ray) }
    }

    /// [`Kernels::intersect`], or with `ANY` [`Kernels::occluded`], in a tree that is brought up to date on the way.
    #[inline]
    pub(super) fn lazy<const ANY: bool>(
        &self,
        lazy: &LazyBvh,
        ray: &PreparedRay,
        object: u32,
        instance: u32,
        best: &mut Hit,
    ) -> bool {
        let kernel = if ANY { self.lazy_occluded } else { self.lazy_intersect };
        // SAFETY: `new` picks only levels that the processor has.
        unsafe { kernel(lazy, ray, object, instance, best) }
    }

    /// [`Kernels::intersect`], or with `ANY` [`Kernels::occluded`], in a BSP, which is built if nobody needed it before.
    #[inline]
    pub(super) fn bsp<const ANY: bool>(
        &self,
        bsp: &Bsp,
        ray: &PreparedRay,
        numbers: (u32, u32),
        best: &mut Hit,
    ) -> bool {
        let kernel = if ANY { self.bsp_occluded } else { self.bsp_intersect };
        // SAFETY: `new` picks only levels that the processor has.
        unsafe { kernel(bsp, ray, numbers, best) }
    }

    /// The same in a grid.
    #[inline]
    pub(super) fn grid<const ANY: bool>(
        &self,
        grid: &Grid,
        ray: &PreparedRay,
        numbers: (u32, u32),
        best: &mut Hit,
    ) -> bool {
        let kernel = if ANY { self.grid_occluded } else { self.grid_intersect };
        // SAFETY: `new` picks only levels that the processor has.
        unsafe { kernel(grid, ray, numbers, best) }
    }

    /// The ray through the top-level tree and the objects below it: both levels in one shell. With `ANY` the first hit
    /// ends the search and `best` stays; else as [`Kernels::intersect`]. `tree` is that of `world`.
    #[inline]
    pub(super) fn scene<const ANY: bool>(
        &self,
        world: Scope<'_>,
        tree: &TopLevelBvh,
        ray: &PreparedRay,
        best: &mut Hit,
    ) -> bool {
        let kernel = if ANY { self.scene_occluded } else { self.scene_intersect };
        // SAFETY: `new` picks only levels that the processor has.
        unsafe { kernel(world, tree, ray, best) }
    }
}
