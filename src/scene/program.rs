//! The code of a shader class: built in, or the user's through one of the traits below.
//!
//! The traits are what a Rust user implements and what the C face wraps around function pointers and plug-ins.
//! A program receives its parameters as a byte block laid out as its class declares
//! ([`super::ParamDef::offset`]), with per-triangle and per-vertex values already filled in.

use glam::{Vec2, Vec3, Vec4};
use std::sync::Arc;

/// What runs when a shader of a class is asked.
#[derive(Clone)]
pub enum Program {
    /// A class that `shade` knows by its name.
    BuiltIn,
    Surface(Arc<dyn SurfaceShader>),
    Light(Arc<dyn LightShader>),
    Camera(Arc<dyn CameraShader>),
    Environment(Arc<dyn EnvironmentShader>),
}

/// The point that a surface shader is asked to colour. World space, except where said.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    pub position: Vec3,
    /// Unit geometric normal on the side of the incoming ray.
    pub geometric_normal: Vec3,
    /// Unit interpolated normal, turned to the side of the incoming ray.
    pub normal: Vec3,
    /// Unit direction of the incoming ray (towards the surface).
    pub incoming: Vec3,
    pub tex_coord: Vec2,
    /// Interpolated vertex colour, white when the mesh has none.
    pub color: Vec4,
    /// Barycentric weights of the second and third corner.
    pub barycentric: Vec2,
    /// Distance along the incoming ray.
    pub distance: f32,
    pub object: u32,
    pub instance: u32,
    pub primitive: u32,
    /// The ray came from the side on which the corners appear clockwise.
    pub back_facing: bool,
    /// Bounces so far; 0 for a primary ray.
    pub depth: u32,
}

/// Light arriving at a point from one light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction from the point to the light.
    pub direction: Vec3,
    /// Distance to the light; infinite for directional lights.
    pub distance: f32,
    /// Incident radiance (linear RGB) before shadowing, already divided by the sample's density.
    pub radiance: Vec3,
}

/// A camera ray in world space; the direction need not have unit length.
#[derive(Clone, Copy, Debug)]
pub struct PrimaryRay {
    pub origin: Vec3,
    pub direction: Vec3,
}

/// What a surface shader may ask of the engine while it runs.
pub trait ShadingContext {
    fn point(&self) -> &SurfacePoint;
    /// Number of lights used by the frame.
    fn light_count(&self) -> u32;
    /// Light from light `index` at the point; None when it does not shine there or does not exist.
    fn illuminate(&mut self, index: u32) -> Option<LightSample>;
    /// Whether something opaque lies between the point and `distance` along `direction`.
    fn shadowed(&mut self, direction: Vec3, distance: f32) -> bool;
    /// Radiance along a new ray from the point; black beyond the recursion limit.
    fn trace(&mut self, direction: Vec3) -> Vec3;
    /// Colour of texture `name` at `uv`, filtered as the texture asks; white when there is no such texture.
    fn texture(&self, name: super::Name, uv: Vec2) -> Vec4;
}

pub trait SurfaceShader: Send + Sync {
    /// Radiance (linear RGB) leaving the point towards the ray's origin, and opacity in w.
    fn shade(&self, params: &[u8], context: &mut dyn ShadingContext) -> Vec4;
}

pub trait LightShader: Send + Sync {
    /// Light arriving at `position`; None when it does not shine there. Point and answer are in the space of [`super::LightUse::world_from_light`].
    fn illuminate(&self, params: &[u8], position: Vec3) -> Option<LightSample>;
}

pub trait CameraShader: Send + Sync {
    /// Ray through `screen`, both coordinates in [0, 1), (0, 0) the lower left; None leaves the pixel clear.
    fn primary_ray(&self, params: &[u8], screen: Vec2, aspect: f32) -> Option<PrimaryRay>;
}

pub trait EnvironmentShader: Send + Sync {
    /// Radiance (linear RGB) arriving against unit `direction` from outside the scene.
    fn radiance(&self, params: &[u8], direction: Vec3) -> Vec3;
}
