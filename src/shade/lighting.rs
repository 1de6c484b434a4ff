//! Phong's model at the points of a packet, eight at a time: what `surface` and `whitted` have for one.
//!
//! The same operations in the same order, so that a sample has the same bits alone. Only powers of highlights go one by one: they come from the
//! system's library.

use crate::shade::light::Light;
use crate::shade::light_packet::{Arriving, LightPoint};
use crate::shade::materials::Materials;
use crate::shade::points::Points;
use crate::shade::rows::{GROUPS, Rows, Rows3, SLOTS, ZEROS, lanes_of, row3, row3_mut};
use crate::shade::shade_scene::ShadeScene;
use crate::shade::worker::SHADOW_END;
use crate::simd::{Isa, LANES, Level, Proof, Wide3, WideKernel, bits, run_wide};
use crate::trace::RayPacket;
use glam::{Vec2, Vec3, Vec4};

/// What is lit, and by what sums.
pub(super) struct Lighting<'a, 's> {
    pub scene: &'s ShadeScene<'a>,
    pub level: Level,
    pub rays: &'s RayPacket,
    pub points: &'s Points,
    pub materials: &'s Materials,
}

/// Reflected light on its way, and the shadow rays that ask whether it arrives.
pub(super) struct Shadows {
    pub rays: RayPacket,
    pub reflected: Rows3,
}

impl Shadows {
    pub fn new() -> Self {
        Self { rays: RayPacket::new(), reflected: [ZEROS; 3] }
    }
}

impl Lighting<'_, '_> {
    /// Adds to `sum` what one point of a light sends to the samples, nothing being in the way.
    pub fn add(&self, light: &Light, which: LightPoint, shifts: &[Vec2; SLOTS], sum: &mut Rows3) {
        let from = Source { light, which, shifts };
        run_wide(self.level, Illuminate { lighting: self, from, shadows: None, sum: Some(sum) });
    }

    /// Leaves in `shadows` what one point of a light sends to the samples if nothing is in the way. Returns those that get any.
    pub fn ask(&self, light: &Light, which: LightPoint, shifts: &[Vec2; SLOTS], shadows: &mut Shadows) -> u64 {
        let from = Source { light, which, shifts };
        run_wide(self.level, Illuminate { lighting: self, from, shadows: Some(shadows), sum: None })
    }

    /// Makes `sum` what the lamp at the eye sends to the samples.
    pub fn headlight(&self, sum: &mut Rows3) {
        run_wide(self.level, Headlight { lighting: self, sum });
    }

    /// Adds to `sum` what arrives of `shadows`.
    pub fn add_arriving(&self, shadows: &Shadows, arriving: u64, sum: &mut Rows3) {
        run_wide(self.level, Add { reflected: &shadows.reflected, arriving, sum });
    }

    /// Colours of all samples: `sky` where nothing is lit.
    pub fn finish(&self, sum: &Rows3, sky: Vec4, mask: u64, color: &mut [Rows; 4]) {
        run_wide(self.level, Finish { lighting: self, sum, sky, mask, color });
    }

    /// Light of `radiance` from `direction`, reflected to the viewer by row `g`.
    #[inline(always)]
    fn reflected<I: Isa>(
        &self,
        isa: Proof<I>,
        g: usize,
        lanes: u32,
        normal: Wide3<I>,
        direction: Wide3<I>,
        radiance: Wide3<I>,
    ) -> Wide3<I> {
        let materials = self.materials;
        let rows = &materials.held[g].rows;
        let diffuse = isa.load3([&rows[0], &rows[1], &rows[2]]);
        let base = isa.load3(row3(&materials.base, g));
        let mut color = diffuse * base * direction.dot(normal).max(isa.splat(0.0));
        let shiny = lanes_of(materials.highlights, g) & lanes;
        if shiny != 0 {
            let incoming = isa.load3(row3(&self.rays.dir, g));
            let mirrored = incoming - normal * (isa.splat(2.0) * incoming.dot(normal));
            let mut cosines = [0.0; LANES];
            direction.dot(mirrored).store(&mut cosines);
            let mut highlight = [[0.0; LANES]; 3];
            for l in bits(u64::from(shiny)).map(|l| l % LANES) {
                let phong = materials.phong(self.scene, LANES * g + l);
                let v = phong.specular * cosines[l].max(0.0).powf(phong.shininess);
                (highlight[0][l], highlight[1][l], highlight[2][l]) = v.into();
            }
            let [x, y, z] = &highlight;
            color = (color + isa.load3([x, y, z])).select(color, shiny);
        }
        color * radiance
    }
}

/// One point of a light.
#[derive(Clone, Copy)]
struct Source<'a> {
    light: &'a Light,
    which: LightPoint,
    shifts: &'a [Vec2; SLOTS],
}

struct Illuminate<'k, 'a, 's> {
    lighting: &'k Lighting<'a, 's>,
    from: Source<'k>,
    shadows: Option<&'k mut Shadows>,
    sum: Option<&'k mut Rows3>,
}

impl WideKernel for Illuminate<'_, '_, '_> {
    type Output = u64;

    #[inline(always)]
    fn run<I: Isa>(self, isa: Proof<I>) -> u64 {
        let Self { lighting, from: Source { light, which, shifts }, mut shadows, mut sum } = self;
        let points = lighting.points;
        let zero = isa.splat(0.0);
        let mut asking = 0;
        for g in 0..GROUPS {
            let lanes = lanes_of(lighting.materials.lit, g);
            if lanes == 0 {
                continue;
            }
            let position = isa.load3(row3(&points.position, g));
            let shifts = &shifts[LANES * g..LANES * (g + 1)];
            let Arriving { direction, distance, mut radiance, lanes } =
                light.arriving(isa, position, lanes, which, shifts);
            let normal = isa.load3(row3(&points.normal, g));
            let geometric_normal = isa.load3(row3(&points.geometric_normal, g));
            let lanes = lanes & zero.lt(direction.dot(normal)) & zero.lt(direction.dot(geometric_normal));
            if lanes == 0 {
                continue;
            }
            if which.n > 1 {
                radiance = radiance / isa.splat(which.n as f32);
            }
            let reflected = lighting.reflected(isa, g, lanes, normal, direction, radiance);
            asking |= u64::from(lanes) << (LANES * g);
            if let Some(sum) = &mut sum {
                let here = reflected.select(isa.splat3(Vec3::ZERO), lanes);
                (isa.load3(row3(sum, g)) + here).store(row3_mut(sum, g));
            }
            if let Some(shadows) = &mut shadows {
                // As `Interaction::spawn`; the direction is on the side of the geometric normal.
                let origin = position + geometric_normal * isa.load(&points.clearance[g]);
                origin.store(row3_mut(&mut shadows.rays.org, g));
                direction.store(row3_mut(&mut shadows.rays.dir, g));
                (distance * isa.splat(SHADOW_END)).store(&mut shadows.rays.tmax[g]);
                reflected.store(row3_mut(&mut shadows.reflected, g));
            }
        }
        asking
    }
}

struct Headlight<'k, 'a, 's> {
    lighting: &'k Lighting<'a, 's>,
    sum: &'k mut Rows3,
}

impl WideKernel for Headlight<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: Proof<I>) {
        let Self { lighting, sum } = self;
        for g in 0..GROUPS {
            let lanes = lanes_of(lighting.materials.lit, g);
            if lanes != 0 {
                let normal = isa.load3(row3(&lighting.points.normal, g));
                let towards = -isa.load3(row3(&lighting.rays.dir, g));
                let reflected = lighting.reflected(isa, g, lanes, normal, towards, isa.splat3(Vec3::ONE));
                reflected.store(row3_mut(sum, g));
            }
        }
    }
}

struct Add<'k> {
    reflected: &'k Rows3,
    arriving: u64,
    sum: &'k mut Rows3,
}

impl WideKernel for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: Proof<I>) {
        let Self { reflected, arriving, sum } = self;
        for g in 0..GROUPS {
            let lanes = lanes_of(arriving, g);
            if lanes != 0 {
                // A sum is never -0, so 0 changes nothing. (Processors are slow to store some lanes only.)
                let here = isa.load3(row3(reflected, g)).select(isa.splat3(Vec3::ZERO), lanes);
                (isa.load3(row3(sum, g)) + here).store(row3_mut(sum, g));
            }
        }
    }
}

struct Finish<'k, 'a, 's> {
    lighting: &'k Lighting<'a, 's>,
    sum: &'k Rows3,
    sky: Vec4,
    mask: u64,
    color: &'k mut [Rows; 4],
}

impl WideKernel for Finish<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: Proof<I>) {
        let Self { lighting, sum, sky, mask, color } = self;
        let materials = lighting.materials;
        let background = isa.splat3(sky.truncate());
        let (zero, one, most) = (isa.splat(0.0), isa.splat(1.0), isa.splat(f32::MAX));
        for g in 0..GROUPS {
            if lanes_of(mask, g) == 0 {
                continue;
            }
            let (mut rgb, mut coverage) = (background, isa.splat(sky.w));
            let lanes = lanes_of(materials.lit, g);
            if lanes != 0 {
                let rows = &materials.held[g].rows;
                let ambient = isa.load3([&rows[3], &rows[4], &rows[5]]);
                let emission = isa.load3([&rows[6], &rows[7], &rows[8]]);
                let base = isa.load3(row3(&materials.base, g));
                let own = emission + ambient * base;
                // The first sum is that of the layers along the ray, of which this is the only one.
                let lit = isa.splat3(Vec3::ZERO) + (own + isa.load3(row3(sum, g)));
                // A shader may have divided by zero, see `Worker::end`.
                let finite = lit.x.abs().le(most) & lit.y.abs().le(most) & lit.z.abs().le(most);
                let (mut inside, mut opaque) = (lit, one);
                if finite != 0xff {
                    inside = lit.select(isa.splat3(Vec3::ZERO), finite);
                    opaque = one.select(zero, finite);
                }
                (rgb, coverage) = if lanes == 0xff {
                    (inside, opaque)
                } else {
                    (inside.select(rgb, lanes), opaque.select(coverage, lanes))
                };
            }
            let [red, green, blue, alpha] = &mut *color;
            rgb.store([&mut red[g], &mut green[g], &mut blue[g]]);
            coverage.store(&mut alpha[g]);
        }
    }
}
