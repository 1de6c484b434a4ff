//! The shells: kernels compiled once per instruction set.
//!
//! A shell carries the `#[target_feature]`; the generic kernel inlines into it. Those that [`super::Kernels`] lists are called through function pointers, per
//! object and ray or per batch, never per node; those of [`Shells`] are called by other kernels of the same instruction set.

use super::bsp_turns::take_turns as bsp_turns;
use super::ground::Ground;
use super::kernels::Kernels;
use super::one_ray::OneRay;
use super::packet::{Found, Packet};
use super::packet_batch::trace_many;
use super::packet_object::traverse_object;
use super::packet_query::{RayPacket, trace_packet};
use super::packet_scene::Scratch;
use super::traverse_bvh::traverse;
use super::traverse_lazy::{self, View};
use super::triangle4::{Edges, resolve};
use super::turns::take_turns;
use super::{Hit, PreparedRay, Ray, Scope, traverse_bsp, traverse_grid, traverse_top_bvh};
use crate::accel::{Bsp, Bvh, ChildRef, Grid, LazyBvh, TopLevelBvh, Tri4};
use crate::simd::{Isa, Level, Scalar};

/// The shells within: parts of the kernels that are functions of their own. The loops around them keep their registers, and code that is
/// called from several places is compiled once. (Kernels called by each other's generic code cannot be plain functions: those would lack the
/// instruction set.)
pub(super) trait Shells: Isa {
    /// See [`resolve`]; `numbers` are those of the object and of the instance.
    ///
    /// # Safety
    /// - The processor has the instruction set.
    unsafe fn resolve<const ANY: bool, R: OneRay>(
        ray: R,
        block: &Tri4,
        candidates: u32,
        edges: &Edges<Self>,
        numbers: (u32, u32),
        best: &mut Hit,
    ) -> bool;

    /// One ray through one object: see [`traverse`].
    ///
    /// # Safety
    /// - The processor has the instruction set.
    unsafe fn one<const ANY: bool>(bvh: &Bvh, ray: &PreparedRay, numbers: (u32, u32), best: &mut Hit) -> bool;

    /// One ray through one object's BSP: see [`traverse_bsp::traverse`].
    ///
    /// # Safety
    /// - The processor has the instruction set.
    unsafe fn bsp<const ANY: bool>(bsp: &Bsp, ray: &PreparedRay, numbers: (u32, u32), best: &mut Hit) -> bool;

    /// One ray through one object's grid: see [`traverse_grid::traverse`].
    ///
    /// # Safety
    /// - The processor has the instruction set.
    unsafe fn grid<const ANY: bool>(grid: &Grid, ray: &PreparedRay, numbers: (u32, u32), best: &mut Hit) -> bool;

    /// A packet through one object's BSP: see [`bsp_turns`].
    ///
    /// # Safety
    /// - The processor has the instruction set.
    unsafe fn bsp_packet<const ANY: bool>(
        bsp: &Bsp,
        packet: &Packet,
        mask: u64,
        numbers: (u32, u32),
        found: &mut Found,
    );

    /// A packet through one object: see [`traverse_object`].
    ///
    /// # Safety
    /// - The processor has the instruction set.
    unsafe fn packet<const ANY: bool>(bvh: &Bvh, packet: &Packet, mask: u64, numbers: (u32, u32), found: &mut Found);

    /// The rays of a packet through one object, each on its own way: see [`take_turns`].
    ///
    /// # Safety
    /// - The processor has the instruction set; `root` is a node of the tree.
    unsafe fn turns<const ANY: bool, T: Ground>(
        tree: &T,
        root: ChildRef,
        packet: &Packet,
        mask: u64,
        down: [bool; 3],
        numbers: (u32, u32),
        found: &mut Found,
    ) -> u64;

    /// One ray through a lazy tree, from a child down: see [`traverse_lazy::below`].
    ///
    /// # Safety
    /// - The processor has the instruction set; the child may be read in the view.
    unsafe fn lazy<const ANY: bool>(
        view: &View<'_>,
        child: ChildRef,
        ray: &PreparedRay,
        numbers: (u32, u32),
        best: &mut Hit,
    ) -> bool;

    /// A packet through a lazy tree, from a node down: see [`traverse_lazy::packet_below`].
    ///
    /// # Safety
    /// - The processor has the instruction set; the node may be read in the view.
    unsafe fn lazy_packet<const ANY: bool>(
        view: &View<'_>,
        root: ChildRef,
        packet: &Packet,
        mask: u64,
        numbers: (u32, u32),
        found: &mut Found,
    );
}

/// Writes the shells of one instruction set as a module.
macro_rules! shells {
    ($name:ident, $isa:ty $(, $feature:literal)*) => {
        mod $name {
            use super::*;

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            pub(super) unsafe fn intersect(
                bvh: &Bvh,
                ray: &PreparedRay,
                object: u32,
                instance: u32,
                best: &mut Hit,
            ) -> bool {
                // SAFETY: the caller's promise.
                unsafe { traverse::<$isa, false>(bvh, ray, object, instance, best) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            pub(super) unsafe fn occluded(bvh: &Bvh, ray: &PreparedRay) -> bool {
                // SAFETY: the caller's promise.
                unsafe { traverse::<$isa, true>(bvh, ray, 0, 0, &mut Hit::none(ray.tmax)) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            pub(super) unsafe fn scene_intersect(
                world: Scope<'_>,
                tree: &TopLevelBvh,
                ray: &PreparedRay,
                best: &mut Hit,
            ) -> bool {
                // SAFETY: the caller's promise.
                unsafe { traverse_top_bvh::traverse::<$isa, false>(world, tree, ray, best) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            unsafe fn intersect_many(world: Scope<'_>, rays: &[Ray], hits: &mut [Hit]) -> bool {
                // SAFETY: the caller's promise.
                unsafe { trace_many::<$isa, false>(world, &KERNELS, rays, |i, hit| hits[i] = hit.unwrap_or(Hit::MISS)) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            pub(super) unsafe fn scene_occluded(
                world: Scope<'_>,
                tree: &TopLevelBvh,
                ray: &PreparedRay,
                best: &mut Hit,
            ) -> bool {
                // SAFETY: the caller's promise.
                unsafe { traverse_top_bvh::traverse::<$isa, true>(world, tree, ray, best) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            unsafe fn occluded_many(world: Scope<'_>, rays: &[Ray], answers: &mut [bool]) -> bool {
                // SAFETY: the caller's promise.
                unsafe { trace_many::<$isa, true>(world, &KERNELS, rays, |i, hit| answers[i] = hit.is_some()) }
            }

            /// # Safety
            /// - The processor has the features named; the child may be read in the view.
            $(#[target_feature(enable = $feature)])*
            unsafe fn lazy_shell<const ANY: bool>(
                view: &View<'_>,
                child: ChildRef,
                ray: &PreparedRay,
                numbers: (u32, u32),
                best: &mut Hit,
            ) -> bool {
                // SAFETY: the caller's promise.
                unsafe { traverse_lazy::below::<$isa, ANY>(view, child, ray, numbers, best) }
            }

            /// # Safety
            /// - The processor has the features named; the node may be read in the view.
            $(#[target_feature(enable = $feature)])*
            unsafe fn lazy_packet_shell<const ANY: bool>(
                view: &View<'_>,
                root: ChildRef,
                packet: &Packet,
                mask: u64,
                numbers: (u32, u32),
                found: &mut Found,
            ) {
                // SAFETY: the caller's promise.
                unsafe { traverse_lazy::packet_below::<$isa, ANY>(view, root, packet, mask, numbers, found) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            unsafe fn lazy<const ANY: bool>(
                lazy: &LazyBvh,
                ray: &PreparedRay,
                object: u32,
                instance: u32,
                best: &mut Hit,
            ) -> bool {
                // SAFETY: the caller's promise.
                unsafe { traverse_lazy::traverse::<$isa, ANY>(lazy, ray, (object, instance), best) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            unsafe fn bsp_shell<const ANY: bool>(
                bsp: &Bsp,
                ray: &PreparedRay,
                numbers: (u32, u32),
                best: &mut Hit,
            ) -> bool {
                // SAFETY: the caller's promise.
                unsafe { traverse_bsp::traverse::<$isa, ANY>(bsp, ray, numbers, best) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            unsafe fn grid_shell<const ANY: bool>(
                grid: &Grid,
                ray: &PreparedRay,
                numbers: (u32, u32),
                best: &mut Hit,
            ) -> bool {
                // SAFETY: the caller's promise.
                unsafe { traverse_grid::traverse::<$isa, ANY>(grid, ray, numbers, best) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            #[inline(never)]
            unsafe fn bsp_packet_shell<const ANY: bool>(
                bsp: &Bsp,
                packet: &Packet,
                mask: u64,
                numbers: (u32, u32),
                found: &mut Found,
            ) {
                // SAFETY: the caller's promise.
                unsafe { bsp_turns::<$isa, ANY>(bsp, packet, mask, numbers, found) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            unsafe fn intersect_packet(world: Scope<'_>, rays: &RayPacket, mask: u64, scratch: &mut Scratch) -> u64 {
                // SAFETY: the caller's promise.
                unsafe { trace_packet::<$isa, false>(world, &KERNELS, rays, mask, scratch) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            unsafe fn occluded_packet(world: Scope<'_>, rays: &RayPacket, mask: u64, scratch: &mut Scratch) -> u64 {
                // SAFETY: the caller's promise.
                unsafe { trace_packet::<$isa, true>(world, &KERNELS, rays, mask, scratch) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            #[inline(never)]
            unsafe fn resolve_shell<const ANY: bool, R: OneRay>(
                ray: R,
                block: &Tri4,
                candidates: u32,
                edges: &Edges<$isa>,
                (object, instance): (u32, u32),
                best: &mut Hit,
            ) -> bool {
                // SAFETY: the caller's promise.
                unsafe { resolve::<$isa, ANY, R>(ray, block, candidates, edges, object, instance, best) }
            }

            /// # Safety
            /// - The processor has the features named.
            $(#[target_feature(enable = $feature)])*
            #[inline(never)]
            unsafe fn object_shell<const ANY: bool>(
                bvh: &Bvh,
                packet: &Packet,
                mask: u64,
                (object, instance): (u32, u32),
                found: &mut Found,
            ) {
                // SAFETY: the caller's promise.
                unsafe { traverse_object::<$isa, ANY>(bvh, packet, mask, object, instance, found) }
            }

            /// # Safety
            /// - The processor has the features named; `root` is a node of the tree.
            $(#[target_feature(enable = $feature)])*
            #[inline(never)]
            unsafe fn turns_shell<const ANY: bool, T: Ground>(
                tree: &T,
                root: ChildRef,
                packet: &Packet,
                mask: u64,
                down: [bool; 3],
                numbers: (u32, u32),
                found: &mut Found,
            ) -> u64 {
                // SAFETY: the caller's promise.
                unsafe { take_turns::<$isa, ANY, T>(tree, root, packet, mask, down, numbers, found) }
            }

            impl Shells for $isa {
                #[inline(always)]
                unsafe fn resolve<const ANY: bool, R: OneRay>(
                    ray: R,
                    block: &Tri4,
                    candidates: u32,
                    edges: &Edges<$isa>,
                    numbers: (u32, u32),
                    best: &mut Hit,
                ) -> bool {
                    // SAFETY: the caller's promise.
                    unsafe { resolve_shell::<ANY, R>(ray, block, candidates, edges, numbers, best) }
                }

                #[inline(always)]
                unsafe fn one<const ANY: bool>(
                    bvh: &Bvh,
                    ray: &PreparedRay,
                    (object, instance): (u32, u32),
                    best: &mut Hit,
                ) -> bool {
                    // SAFETY: the caller's promise.
                    unsafe { if ANY { occluded(bvh, ray) } else { intersect(bvh, ray, object, instance, best) } }
                }

                #[inline(always)]
                unsafe fn bsp<const ANY: bool>(
                    bsp: &Bsp,
                    ray: &PreparedRay,
                    numbers: (u32, u32),
                    best: &mut Hit,
                ) -> bool {
                    // SAFETY: the caller's promise.
                    unsafe { bsp_shell::<ANY>(bsp, ray, numbers, best) }
                }

                #[inline(always)]
                unsafe fn grid<const ANY: bool>(
                    grid: &Grid,
                    ray: &PreparedRay,
                    numbers: (u32, u32),
                    best: &mut Hit,
                ) -> bool {
                    // SAFETY: the caller's promise.
                    unsafe { grid_shell::<ANY>(grid, ray, numbers, best) }
                }

                #[inline(always)]
                unsafe fn bsp_packet<const ANY: bool>(
                    bsp: &Bsp,
                    packet: &Packet,
                    mask: u64,
                    numbers: (u32, u32),
                    found: &mut Found,
                ) {
                    // SAFETY: the caller's promise.
                    unsafe { bsp_packet_shell::<ANY>(bsp, packet, mask, numbers, found) }
                }

                #[inline(always)]
                unsafe fn packet<const ANY: bool>(
                    bvh: &Bvh,
                    packet: &Packet,
                    mask: u64,
                    numbers: (u32, u32),
                    found: &mut Found,
                ) {
                    // SAFETY: the caller's promise.
                    unsafe { object_shell::<ANY>(bvh, packet, mask, numbers, found) }
                }

                #[inline(always)]
                unsafe fn turns<const ANY: bool, T: Ground>(
                    tree: &T,
                    root: ChildRef,
                    packet: &Packet,
                    mask: u64,
                    down: [bool; 3],
                    numbers: (u32, u32),
                    found: &mut Found,
                ) -> u64 {
                    // SAFETY: the caller's promise.
                    unsafe { turns_shell::<ANY, T>(tree, root, packet, mask, down, numbers, found) }
                }

                #[inline(always)]
                unsafe fn lazy<const ANY: bool>(
                    view: &View<'_>,
                    child: ChildRef,
                    ray: &PreparedRay,
                    numbers: (u32, u32),
                    best: &mut Hit,
                ) -> bool {
                    // SAFETY: the caller's promise.
                    unsafe { lazy_shell::<ANY>(view, child, ray, numbers, best) }
                }

                #[inline(always)]
                unsafe fn lazy_packet<const ANY: bool>(
                    view: &View<'_>,
                    root: ChildRef,
                    packet: &Packet,
                    mask: u64,
                    numbers: (u32, u32),
                    found: &mut Found,
                ) {
                    // SAFETY: the caller's promise.
                    unsafe { lazy_packet_shell::<ANY>(view, root, packet, mask, numbers, found) }
                }
            }

            pub(super) static KERNELS: Kernels = Kernels {
                level: super::level_of!($name),
                intersect,
                occluded,
                lazy_intersect: lazy::<false>,
                lazy_occluded: lazy::<true>,
                bsp_intersect: bsp_shell::<false>,
                bsp_occluded: bsp_shell::<true>,
                grid_intersect: grid_shell::<false>,
                grid_occluded: grid_shell::<true>,
                scene_intersect,
                scene_occluded,
                intersect_many,
                occluded_many,
                intersect_packet,
                occluded_packet,
            };
        }
    };
}

macro_rules! level_of {
    (scalar) => {
        Level::Scalar
    };
    (sse41) => {
        Level::Sse41
    };
    (avx2) => {
        Level::Avx2
    };
    (avx512) => {
        Level::Avx512
    };
}
use level_of;

shells!(scalar, Scalar);
#[cfg(all(target_arch = "x86_64", not(openrt_few_levels)))]
shells!(sse41, crate::simd::Sse41, "sse4.1");
#[cfg(target_arch = "x86_64")]
shells!(avx2, crate::simd::Avx2, "avx2", "bmi1", "bmi2", "lzcnt", "popcnt");
#[cfg(all(target_arch = "x86_64", not(openrt_few_levels)))]
shells!(avx512, crate::simd::Avx512, "avx512f", "avx512vl", "avx2", "bmi1", "bmi2", "lzcnt", "popcnt");

/// The kernels of `level`, or of the strongest level that the processor has if that is weaker.
pub(super) fn kernels_of(level: Level) -> &'static Kernels {
    match level.min(Level::strongest()) {
        Level::Scalar => &scalar::KERNELS,
        #[cfg(all(target_arch = "x86_64", not(openrt_few_levels)))]
        Level::Sse41 => &sse41::KERNELS,
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => &avx2::KERNELS,
        #[cfg(all(target_arch = "x86_64", not(openrt_few_levels)))]
        Level::Avx512 => &avx512::KERNELS,
        #[cfg(any(not(target_arch = "x86_64"), openrt_few_levels))]
        _ => &scalar::KERNELS,
    }
}
