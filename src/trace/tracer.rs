//! The face of the kernels: queries against the two-level structure of one frame.

use super::{Hit, PreparedRay, Ray, triangle};
use crate::accel::TwoLevel;

/// Answers ray queries against one frame's structures. Cheap to copy; shared by all threads.
#[derive(Clone, Copy)]
pub struct Tracer<'a> {
    world: &'a TwoLevel,
}

impl<'a> Tracer<'a> {
    pub fn new(world: &'a TwoLevel) -> Self {
        Self { world }
    }

    /// The structures that are traced.
    pub fn world(&self) -> &'a TwoLevel {
        self.world
    }

    /// The closest hit of `ray` (world space).
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        for inst in &self.world.instances {
            let local = Ray {
                org: inst.object_from_world.transform_point3(ray.org),
                dir: inst.object_from_world.transform_vector3(ray.dir),
                ..*ray
            };
            let Some(prepared) = PreparedRay::new(&local) else { continue };
            let object = &self.world.objects[inst.slot as usize];
            for (prim, corners) in object.corners.iter().enumerate() {
                if let Some(h) = triangle::intersect(&prepared, *corners) {
                    let hit =
                        Hit { t: h.t, u: h.u, v: h.v, prim: prim as u32, object: inst.object, instance: inst.instance };
                    if best.is_none_or(|b| hit.is_before(&b)) {
                        best = Some(hit);
                    }
                }
            }
        }
        best
    }

    /// Whether anything lies on `ray` within its interval.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.intersect(ray).is_some()
    }
}
