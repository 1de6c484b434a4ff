//! Lights: where they shine from, and how much.
//!
//! Radiance here is in units in which a light of colour 1 gives a white diffuse surface the value 1 (see
//! [`crate::shade::class`]): irradiance divided by π.

use crate::scene::{LightSample, LightShader, SurfacePoint};
use crate::shade::block::Block;
use crate::shade::placed::Placed;
use crate::shade::sampler::{Rng, disc, hammersley};
use crate::shade::values::Values;
use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

pub struct Light {
    pub(super) shape: Shape,
    pub(super) color: Vec3,
    /// Divides by `x + y·d + z·d²`.
    pub(super) attenuation: Vec3,
    /// Points of the light that a shading point asks for.
    pub samples: u32,
}

pub(super) enum Shape {
    Point {
        position: Vec3,
    },
    /// Unit direction towards the light.
    Directional {
        towards: Vec3,
    },
    Spot {
        position: Vec3,
        axis: Vec3,
        cos_outer: f32,
        cos_inner: f32,
        exponent: f32,
    },
    Rectangle {
        corner: Vec3,
        u: Vec3,
        v: Vec3,
        normal: Vec3,
    },
    Disc {
        center: Vec3,
        u: Vec3,
        v: Vec3,
        normal: Vec3,
    },
    Sphere {
        center: Vec3,
        radius: f32,
    },
    User {
        program: Arc<dyn LightShader>,
        block: Block,
        /// World from light and light from world, unless they are the same.
        place: Option<[Affine3A; 2]>,
    },
}

/// Most samples of an area light; more would only be slower.
const MAX_SAMPLES: u32 = 4096;

impl Light {
    /// The built-in light `class` at `place`; None if there is none of that name.
    pub fn built_in(class: &str, values: Values, place: &Affine3A) -> Option<Self> {
        let position = values.vec3("position");
        let mut samples = 1;
        let shape = match class {
            "point" => Shape::Point { position },
            "directional" => Shape::Directional { towards: (-values.vec3("direction")).normalize_or(Vec3::Z) },
            "spot" => {
                let outer = values.float("cutoff").clamp(0.0, 180.0);
                let inner = (outer - values.float("penumbra")).clamp(0.0, outer);
                Shape::Spot {
                    position,
                    axis: values.vec3("direction").normalize_or(Vec3::NEG_Z),
                    cos_outer: outer.to_radians().cos(),
                    cos_inner: inner.to_radians().cos(),
                    exponent: values.float("exponent"),
                }
            }
            "area" => {
                samples = values.count("samples", MAX_SAMPLES);
                area(values, position)
            }
            _ => return None,
        };
        let attenuation = if class == "directional" { Vec3::X } else { values.vec3("attenuation") };
        let shape = if *place == Affine3A::IDENTITY { shape } else { shape.placed(place) };
        Some(Self { shape, color: values.vec3("color"), attenuation, samples })
    }

    pub fn user(program: Arc<dyn LightShader>, block: Block, place: &Affine3A) -> Self {
        let back = place.inverse();
        let place = (*place != Affine3A::IDENTITY && back.is_finite()).then_some([*place, back]);
        Self { shape: Shape::User { program, block, place }, color: Vec3::ONE, attenuation: Vec3::X, samples: 1 }
    }

    /// Points of the light that a shading point after `depth` bounces asks for.
    pub fn points(&self, depth: u32) -> u32 {
        (self.samples >> (2 * depth).min(31)).max(1)
    }

    /// By how much a shading point shifts the light's pattern of points. It differs from pixel to pixel, which turns the bands
    /// of a fixed pattern into fine grain.
    #[inline]
    pub fn shift(&self, rng: &mut Rng) -> Vec2 {
        if self.samples > 1 { rng.next_vec2() } else { Vec2::ZERO }
    }

    /// Point `i` of `n` of the light as the shading point sees it; None where no light arrives on the viewer's side.
    #[inline]
    pub fn facing(&self, point: &SurfacePoint, i: u32, n: u32, shift: Vec2) -> Option<LightSample> {
        let u = if self.samples > 1 { hammersley(i, n, shift) } else { Vec2::splat(0.5) };
        let sample = self.sample(point.position, u)?;
        let visible = sample.direction.dot(point.normal) > 0.0 && sample.direction.dot(point.geometric_normal) > 0.0;
        visible.then_some(sample)
    }

    /// Light at `position` from the point of the light that `u` (in [0, 1)²) chooses; None where it does not shine.
    #[inline]
    pub fn sample(&self, position: Vec3, u: Vec2) -> Option<LightSample> {
        let (source, strength) = match &self.shape {
            Shape::Directional { towards } => {
                return Some(LightSample { direction: *towards, distance: f32::INFINITY, radiance: self.color });
            }
            Shape::User { program, block, place } => {
                return match place {
                    None => program.illuminate(block.bytes(), position).and_then(sane),
                    Some(place) => placed_sample(&**program, block, place, position),
                };
            }
            Shape::Point { position } => (*position, None),
            Shape::Spot { position, .. } => (*position, None),
            Shape::Rectangle { corner, u: edge_u, v: edge_v, normal } => {
                (*corner + *edge_u * u.x + *edge_v * u.y, Some(*normal))
            }
            Shape::Disc { center, u: axis_u, v: axis_v, normal } => {
                let p = disc(u);
                (*center + *axis_u * p.x + *axis_v * p.y, Some(*normal))
            }
            Shape::Sphere { center, radius } => return self.sample_sphere(*center, *radius, position, u),
        };
        let to_light = source - position;
        let distance = to_light.length();
        if !(distance > 0.0 && distance.is_finite()) {
            return None;
        }
        let direction = to_light / distance;
        let mut strength = match strength {
            Some(normal) => (-direction.dot(normal)).max(0.0),
            None => 1.0,
        };
        if let Shape::Spot { axis, cos_outer, cos_inner, exponent, .. } = &self.shape {
            strength = spot_strength(-direction.dot(*axis), *cos_outer, *cos_inner, *exponent);
        }
        let radiance = self.color * (strength * self.falloff(distance));
        (radiance != Vec3::ZERO).then_some(LightSample { direction, distance, radiance })
    }

    /// Samples the cone of directions in which the sphere is seen, uniformly: all samples count alike and none is
    /// wasted on the far side.
    fn sample_sphere(&self, center: Vec3, radius: f32, position: Vec3, u: Vec2) -> Option<LightSample> {
        let to_center = center - position;
        let d2 = to_center.length_squared();
        let sin2 = radius * radius / d2;
        if !(sin2 < 1.0) || !d2.is_finite() {
            return None;
        }
        let axis = to_center / d2.sqrt();
        // 1 − cos of the cone's half angle, without cancellation for small spheres.
        let cap = sin2 / (1.0 + (1.0 - sin2).sqrt());
        let one_minus_cos = cap * u.x;
        let cos = 1.0 - one_minus_cos;
        let sin = (one_minus_cos * (1.0 + cos)).max(0.0).sqrt();
        let (t, b) = axis.any_orthonormal_pair();
        let phi = TAU * u.y;
        let direction = (t * (sin * phi.cos()) + b * (sin * phi.sin()) + axis * cos).normalize_or(axis);
        // Where that direction enters the sphere.
        let along = d2.sqrt() * cos;
        let half_chord = (radius * radius - d2 * sin * sin).max(0.0).sqrt();
        let distance = along - half_chord;
        // Solid angle times radiance, relative to the small-sphere limit π·sin².
        let near = if sin2 > 0.0 { 2.0 * cap / sin2 } else { 1.0 };
        let radiance = self.color * (near * self.falloff(d2.sqrt()));
        (distance > 0.0).then_some(LightSample { direction, distance, radiance })
    }

    #[inline]
    fn falloff(&self, d: f32) -> f32 {
        let divisor = self.attenuation.x + d * (self.attenuation.y + d * self.attenuation.z);
        if divisor > 0.0 { 1.0 / divisor } else { 1.0 }
    }
}

impl Shape {
    /// The shape under a matrix.
    fn placed(self, world_from_light: &Affine3A) -> Self {
        let point = |p: Vec3| world_from_light.transform_point3(p);
        let vector = |v: Vec3| world_from_light.transform_vector3(v);
        // The lit side stays the lit side under mirrors.
        let normal = |n: Vec3| Placed::new(*world_from_light).normal(n).normalize_or(n);
        match self {
            Shape::Point { position } => Shape::Point { position: point(position) },
            Shape::Directional { towards } => Shape::Directional { towards: vector(towards).normalize_or(towards) },
            Shape::Spot { position, axis, cos_outer, cos_inner, exponent } => {
                let (position, axis) = (point(position), vector(axis).normalize_or(axis));
                Shape::Spot { position, axis, cos_outer, cos_inner, exponent }
            }
            Shape::Rectangle { corner, u, v, normal: n } => {
                Shape::Rectangle { corner: point(corner), u: vector(u), v: vector(v), normal: normal(n) }
            }
            Shape::Disc { center, u, v, normal: n } => {
                Shape::Disc { center: point(center), u: vector(u), v: vector(v), normal: normal(n) }
            }
            Shape::Sphere { center, radius } => {
                let scale = world_from_light.matrix3.determinant().abs().cbrt();
                Shape::Sphere { center: point(center), radius: radius * scale }
            }
            user @ Shape::User { .. } => user,
        }
    }
}

/// What a user's light at `place` sends to `position`: it is asked in its own space.
fn placed_sample(
    program: &dyn LightShader,
    block: &Block,
    [world_from_light, light_from_world]: &[Affine3A; 2],
    position: Vec3,
) -> Option<LightSample> {
    let local = light_from_world.transform_point3(position);
    let sample = program.illuminate(block.bytes(), local).and_then(sane)?;
    if sample.distance == f32::INFINITY {
        let direction = world_from_light.transform_vector3(sample.direction).try_normalize()?;
        return Some(LightSample { direction, ..sample });
    }
    let to_light = world_from_light.transform_point3(local + sample.direction * sample.distance) - position;
    let distance = to_light.length();
    let direction = to_light.try_normalize()?;
    Some(LightSample { direction, distance, ..sample })
}

fn area(values: Values, position: Vec3) -> Shape {
    let (u, v) = (values.vec3("edge_u"), values.vec3("edge_v"));
    let normal = u.cross(v).normalize_or(Vec3::NEG_Y);
    let radius = values.float("radius").max(0.0);
    match values.string("shape") {
        "sphere" => Shape::Sphere { center: position, radius },
        "disc" => {
            let u = u.normalize_or(Vec3::X);
            Shape::Disc { center: position, u: u * radius, v: normal.cross(u) * radius, normal }
        }
        _ => Shape::Rectangle { corner: position - 0.5 * (u + v), u, v, normal },
    }
}

/// Share of a spot's colour at the angle whose cosine is `cos` from its axis.
fn spot_strength(cos: f32, cos_outer: f32, cos_inner: f32, exponent: f32) -> f32 {
    if cos < cos_outer {
        return 0.0;
    }
    let edge = if cos >= cos_inner {
        1.0
    } else {
        let x = (cos - cos_outer) / (cos_inner - cos_outer);
        x * x * (3.0 - 2.0 * x)
    };
    if exponent > 0.0 { edge * cos.max(0.0).powf(exponent) } else { edge }
}

/// A user's sample with a usable direction, made unit length.
fn sane(sample: LightSample) -> Option<LightSample> {
    let direction = sample.direction.try_normalize()?;
    (sample.distance > 0.0 && sample.radiance.is_finite()).then_some(LightSample { direction, ..sample })
}
