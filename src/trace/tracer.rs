//! The face of the kernels: queries against the two-level structure of one frame.

use super::{Hit, Kernels, PreparedRay, Ray, Scope, traverse_scene};
use crate::accel::WorldView;
use crate::scene::Mask;

/// Directions whose largest component is outside of this range are scaled by a power of two first, so that their
/// transforms, reciprocals and products stay clear of overflow and denormals.
pub(super) const USUAL_LENGTH: std::ops::RangeInclusive<f32> = 1.0 / (1 << 20) as f32..=(1 << 20) as f32;

/// Fewer rays than this are traced one by one: a packet has to be set up.
pub(super) const WORTH_A_PACKET: usize = 4;

/// Answers ray queries against one frame's structures. Cheap to copy; shared by all threads.
#[derive(Clone, Copy)]
pub struct Tracer<'a> {
    pub(super) world: Scope<'a>,
    pub(super) kernels: Kernels,
}

impl<'a> Tracer<'a> {
    /// Answers for rays that see everything.
    pub fn new(world: &'a WorldView) -> Self {
        Self { world: Scope::new(world, Mask::ALL), kernels: Kernels::new(world.level()) }
    }

    /// The same for rays that see the instances whose mask has a bit in common with `mask`.
    #[inline]
    pub fn masked(&self, mask: Mask) -> Self {
        Self { world: Scope::new(self.world.view(), mask), ..*self }
    }

    /// What rays see.
    pub fn scope(&self) -> Scope<'a> {
        self.world
    }

    /// The structures that are traced.
    pub fn world(&self) -> &'a WorldView {
        self.world.view()
    }

    /// The closest hit of `ray` (world space). A ray with a component that is not finite, a direction of 0 or an empty
    /// interval hits nothing.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        if is_usual(ray) { self.closest(ray) } else { self.closest_rescaled(ray) }
    }

    /// Whether anything lies on `ray` within its interval: the same as [`Tracer::intersect`] finding something, but faster.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        if is_usual(ray) { self.any(ray) } else { rescale(ray).is_some_and(|(scaled, _)| self.any(&scaled)) }
    }

    /// Calls `visit` with the hits of `ray` one after the other, by distance and then by numbers, until it returns false. Each costs the search for
    /// a closest hit.
    pub fn each_hit(&self, ray: &Ray, mut visit: impl FnMut(&Hit) -> bool) {
        let rescaled = if is_usual(ray) { None } else { rescale(ray) };
        let Some(mut prepared) = PreparedRay::new(&rescaled.map_or(*ray, |(scaled, _)| scaled)) else { return };
        loop {
            let mut best = Hit::none(prepared.tmax);
            if !traverse_scene::traverse::<false>(self.world, &self.kernels, &prepared, &mut best) {
                return;
            }
            let hit = rescaled.map_or(best, |(_, length)| unscaled(best, ray, length));
            if !visit(&hit) {
                return;
            }
            // A hit has the last number only if nothing comes after it at its distance.
            prepared.tmin = best.t;
            prepared.from = Hit::order(best.instance, best.primitive).saturating_add(1);
        }
    }

    /// [`Tracer::intersect`] for many rays, [`Hit::MISS`] for none, as packets: rays that are near each other in `rays` should be near each other in space,
    /// from 64 on it pays. Callers cut large batches into pieces and trace these in parallel.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn intersect_into(&self, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        let packets = rays.len() >= WORTH_A_PACKET;
        // SAFETY: holding kernels proves that the processor can run them.
        if packets && unsafe { (self.kernels.intersect_many)(self.world, rays, hits) } {
            return;
        }
        for (ray, hit) in rays.iter().zip(hits).filter(|(ray, _)| !packets || !is_usual(ray)) {
            *hit = self.intersect(ray).unwrap_or(Hit::MISS);
        }
    }

    /// [`Tracer::intersect_into`] into memory of its own.
    pub fn intersect_many(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        let mut hits = vec![Hit::MISS; rays.len()];
        self.intersect_into(rays, &mut hits);
        hits.into_iter().map(Hit::found).collect()
    }

    /// [`Tracer::occluded`] for many rays.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn occluded_many(&self, rays: &[Ray], answers: &mut [bool]) {
        assert_eq!(rays.len(), answers.len(), "one answer per ray");
        let packets = rays.len() >= WORTH_A_PACKET;
        // SAFETY: as in `intersect_into`.
        if packets && unsafe { (self.kernels.occluded_many)(self.world, rays, answers) } {
            return;
        }
        for (ray, answer) in rays.iter().zip(answers).filter(|(ray, _)| !packets || !is_usual(ray)) {
            *answer = self.occluded(ray);
        }
    }

    #[inline]
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let prepared = PreparedRay::new(ray)?;
        let mut best = Hit::none(ray.tmax);
        traverse_scene::traverse::<false>(self.world, &self.kernels, &prepared, &mut best).then_some(best)
    }

    #[inline]
    fn any(&self, ray: &Ray) -> bool {
        PreparedRay::new(ray).is_some_and(|prepared| {
            traverse_scene::traverse::<true>(self.world, &self.kernels, &prepared, &mut Hit::none(ray.tmax))
        })
    }

    #[cold]
    fn closest_rescaled(&self, ray: &Ray) -> Option<Hit> {
        let (scaled, length) = rescale(ray)?;
        self.closest(&scaled).map(|hit| unscaled(hit, ray, length))
    }
}

/// A hit of the ray that [`rescale`] has made of `ray`, with the distance on `ray`.
fn unscaled(hit: Hit, ray: &Ray, length: f64) -> Hit {
    // For a denormal direction the distance itself may be beyond f32; a hit's distance is finite.
    let t = ((f64::from(hit.t) / length) as f32).min(f32::MAX);
    Hit { t: t.clamp(ray.tmin.max(0.0), ray.tmax), ..hit }
}

/// Whether a ray can be traced as it is.
#[inline(always)]
fn is_usual(ray: &Ray) -> bool {
    USUAL_LENGTH.contains(&ray.direction.abs().max_element())
}

/// The same ray with a direction whose largest component is in 1..2, and by what its distances were multiplied (a power of two).
/// `None` for a ray that hits nothing.
#[cold]
fn rescale(ray: &Ray) -> Option<(Ray, f64)> {
    let largest = f64::from(ray.direction.abs().max_element());
    if !(largest > 0.0 && ray.direction.is_finite() && ray.tmin.max(0.0) <= ray.tmax) {
        return None;
    }
    // Every f32 above 0 is a normal f64: its exponent bits alone are the power of two below it.
    let length = f64::from_bits(largest.to_bits() & 0x7ff0_0000_0000_0000);
    let scaled = |t: f32| (f64::from(t) * length) as f32;
    let dir = (ray.direction.as_dvec3() / length).as_vec3();
    Some((Ray { origin: ray.origin, direction: dir, tmin: scaled(ray.tmin), tmax: scaled(ray.tmax) }, length))
}
