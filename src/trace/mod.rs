//! Rays through structures: the kernels that decide what a ray hits.
//!
//! All kernels answer the same question with the same bits, on every instruction set and through every structure:
//! the hit with the smallest `t`, and among equal `t` the one with the lowest (instance, object, primitive).
//! Many rays at once go as packets of up to 64 ([`Tracer::intersect_into`], [`Tracer::intersect_packet`]), with the same bits.
//! How that is kept: [`ray`] (slab distances), [`triangle`] (edge functions, clamped `t`).

pub mod closest_point;
pub mod ray;
mod scope;
pub mod triangle;

mod bsp_turns;
mod gathered;
mod ground;
mod hit;
mod kernels;
mod one_ray;
mod packet;
mod packet_batch;
mod packet_boxes;
mod packet_object;
mod packet_query;
mod packet_scene;
mod packet_triangles;
mod shells;
mod stack;
mod tracer;
mod traverse_bsp;
mod traverse_bvh;
mod traverse_field;
mod traverse_grid;
mod traverse_grid_far;
mod traverse_lazy;
mod traverse_packet;
mod traverse_scene;
mod traverse_top_bvh;
mod triangle4;
mod turns;

pub use closest_point::ClosestPoint;
pub use hit::Hit;
pub use kernels::Kernels;
pub use packet_query::{PacketMemory, RayPacket};
pub use ray::{PreparedRay, Ray, SLAB_PAD};
pub use scope::Scope;
pub use tracer::Tracer;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod turns_tests;
