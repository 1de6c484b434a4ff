//! Lights seen from eight points at a time.
//!
//! Point and directional lights go in lanes, by the operations of [`Light::sample`]; the others are asked point by point.

use crate::shade::light::{Light, Shape};
use crate::shade::sampler::hammersley;
use crate::simd::{Isa, LANES, Proof, Wide, Wide3, bits};
use glam::{Vec2, Vec3};

/// Light that arrives at eight points.
pub(super) struct Arriving<I: Isa> {
    pub direction: Wide3<I>,
    pub distance: Wide<I>,
    pub radiance: Wide3<I>,
    /// The points at which there is any.
    pub lanes: u32,
}

/// Which point of a light is meant: the `i`-th of `n`.
#[derive(Clone, Copy)]
pub(super) struct LightPoint {
    pub i: u32,
    pub n: u32,
}

impl Light {
    /// What arrives at `lanes` of `position` from one point of the light; `shifts` as in [`Light::facing`].
    #[inline(always)]
    pub(super) fn arriving<I: Isa>(
        &self,
        isa: Proof<I>,
        position: Wide3<I>,
        lanes: u32,
        which: LightPoint,
        shifts: &[Vec2],
    ) -> Arriving<I> {
        match &self.shape {
            Shape::Directional { towards } => Arriving {
                direction: isa.splat3(*towards),
                distance: isa.splat(f32::INFINITY),
                radiance: isa.splat3(self.color),
                lanes,
            },
            Shape::Point { position: source } => {
                let to_light = isa.splat3(*source) - position;
                let distance = to_light.length();
                let (zero, one) = (isa.splat(0.0), isa.splat(1.0));
                let Wide3 { x, y, z } = isa.splat3(self.attenuation);
                let divisor = x + distance * (y + distance * z);
                // Not above 0, or no number: 1.
                let falloff = one / one.select(divisor, !zero.lt(divisor));
                let radiance = isa.splat3(self.color) * falloff;
                let lanes = lanes & zero.lt(distance) & distance.le(isa.splat(f32::MAX));
                Arriving { direction: to_light / distance, distance, radiance, lanes: lanes & !all_zero(isa, radiance) }
            }
            _ => self.arriving_one_by_one(isa, position, lanes, which, shifts),
        }
    }

    #[inline(always)]
    fn arriving_one_by_one<I: Isa>(
        &self,
        isa: Proof<I>,
        position: Wide3<I>,
        lanes: u32,
        which: LightPoint,
        shifts: &[Vec2],
    ) -> Arriving<I> {
        let [mut x, mut y, mut z] = [[0.0; LANES]; 3];
        position.store([&mut x, &mut y, &mut z]);
        let mut rows = [[0.0; LANES]; 7];
        let mut arriving = 0;
        for l in bits(u64::from(lanes)).map(|l| l % LANES) {
            let u = if self.samples > 1 { hammersley(which.i, which.n, shifts[l]) } else { Vec2::splat(0.5) };
            let Some(sample) = self.sample(Vec3::new(x[l], y[l], z[l]), u) else { continue };
            arriving |= 1 << l;
            for k in 0..3 {
                rows[k][l] = sample.direction[k];
                rows[4 + k][l] = sample.radiance[k];
            }
            rows[3][l] = sample.distance;
        }
        Arriving {
            direction: isa.load3([&rows[0], &rows[1], &rows[2]]),
            distance: isa.load(&rows[3]),
            radiance: isa.load3([&rows[4], &rows[5], &rows[6]]),
            lanes: arriving,
        }
    }
}

/// Lanes whose components are all 0.
#[inline(always)]
fn all_zero<I: Isa>(isa: Proof<I>, v: Wide3<I>) -> u32 {
    v.abs().x.le(isa.splat(0.0)) & v.abs().y.le(isa.splat(0.0)) & v.abs().z.le(isa.splat(0.0))
}
