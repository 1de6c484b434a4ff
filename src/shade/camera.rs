//! Cameras: from a place on the picture to a ray.

use crate::scene::{CameraShader, PrimaryRay};
use crate::shade::block::Block;
use crate::shade::footprint::Cone;
use crate::shade::sampler::disc;
use crate::shade::values::Values;
use glam::{Vec2, Vec3, Vec4};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// A camera of one frame. Keeps nothing of the scene, so that picking works after the frame.
#[derive(Clone)]
pub struct Camera {
    pub(super) eye: Vec3,
    pub(super) right: Vec3,
    pub(super) up: Vec3,
    pub(super) forward: Vec3,
    /// Width over height; 0 takes the viewport's.
    pub(super) aspect: f32,
    pub(super) kind: Kind,
}

#[derive(Clone)]
pub(super) enum Kind {
    Pinhole(Window),
    Orthographic(Window),
    ThinLens { window: Window, aperture: f32, focus: f32 },
    Environment,
    User { program: Arc<dyn CameraShader>, block: Block },
}

/// The part of the plane at distance 1 that is seen.
#[derive(Clone, Copy)]
pub(super) enum Window {
    /// Half the height; the width follows from the aspect.
    HalfHeight(f32),
    /// Left, right, bottom, top.
    Rect(Vec4),
}

impl Window {
    #[inline]
    fn at(&self, screen: Vec2, aspect: f32) -> Vec2 {
        match self {
            Window::HalfHeight(h) => (2.0 * screen - Vec2::ONE) * Vec2::new(h * aspect, *h),
            Window::Rect(w) => Vec2::new(w.x + screen.x * (w.y - w.x), w.z + screen.y * (w.w - w.z)),
        }
    }

    fn height(&self) -> f32 {
        match self {
            Window::HalfHeight(h) => 2.0 * h,
            Window::Rect(w) => (w.w - w.z).abs(),
        }
    }
}

impl Default for Camera {
    /// At the origin, looking down −z, 60° high.
    fn default() -> Self {
        Self {
            eye: Vec3::ZERO,
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            aspect: 0.0,
            kind: Kind::Pinhole(half_height(60.0)),
        }
    }
}

fn half_height(fov_degrees: f32) -> Window {
    Window::HalfHeight((fov_degrees.clamp(1e-3, 179.9).to_radians() * 0.5).tan())
}

impl Camera {
    /// The built-in camera `class`; None if there is none of that name.
    pub fn built_in(class: &str, values: Values) -> Option<Self> {
        let eye = values.vec3("eye");
        let view = values.vec3("center") - eye;
        let forward = view.normalize_or(Vec3::NEG_Z);
        let right = forward.cross(values.vec3("up")).try_normalize();
        let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let rect = values.vec4("window");
        let window = |other| if rect.x != rect.y && rect.z != rect.w { Window::Rect(rect) } else { other };
        let kind = match class {
            "pinhole" => Kind::Pinhole(window(half_height(values.float("fov")))),
            "orthographic" => Kind::Orthographic(window(Window::HalfHeight(0.5 * values.float("height")))),
            "thinlens" => {
                let focus = values.float("focus");
                Kind::ThinLens {
                    window: window(half_height(values.float("fov"))),
                    aperture: values.float("aperture").max(0.0),
                    focus: if focus > 0.0 { focus } else { view.length().max(f32::MIN_POSITIVE) },
                }
            }
            "environment" => Kind::Environment,
            _ => return None,
        };
        Some(Self { eye, right, up, forward, aspect: values.float("aspect").max(0.0), kind })
    }

    pub fn user(program: Arc<dyn CameraShader>, block: Block) -> Self {
        Self { kind: Kind::User { program, block }, ..Self::default() }
    }

    /// The ray through `screen`, both coordinates in [0, 1), (0, 0) the lower left; its direction has unit length.
    /// `aspect` is the viewport's, `lens` a point of the unit square that chooses the point of the lens. None leaves
    /// the pixel clear.
    #[inline(always)]
    pub fn primary_ray(&self, screen: Vec2, aspect: f32, lens: Vec2) -> Option<PrimaryRay> {
        let aspect = if self.aspect > 0.0 { self.aspect } else { aspect };
        let world = |p: Vec3| self.right * p.x + self.up * p.y + self.forward * p.z;
        let (origin, direction) = match &self.kind {
            Kind::Pinhole(window) => (self.eye, world(window.at(screen, aspect).extend(1.0))),
            Kind::Orthographic(window) => (self.eye + world(window.at(screen, aspect).extend(0.0)), self.forward),
            Kind::ThinLens { window, aperture, focus } => {
                let focused = window.at(screen, aspect).extend(1.0) * *focus;
                let on_lens = (disc(lens) * *aperture).extend(0.0);
                (self.eye + world(on_lens), world(focused - on_lens))
            }
            Kind::Environment => {
                let (phi, theta) = ((screen.x - 0.5) * TAU, (screen.y - 0.5) * PI);
                (self.eye, world(Vec3::new(theta.cos() * phi.sin(), theta.sin(), theta.cos() * phi.cos())))
            }
            Kind::User { program, block } => {
                let ray = program.primary_ray(block.bytes(), screen, aspect)?;
                (ray.origin, ray.direction)
            }
        };
        let direction = direction.try_normalize()?;
        origin.is_finite().then_some(PrimaryRay { origin, direction })
    }

    /// Whether [`Camera::primary_ray`] looks at its `lens`.
    pub fn has_lens(&self) -> bool {
        matches!(self.kind, Kind::ThinLens { .. })
    }

    /// The cone of a pixel when the picture has `rows` rows (or the samples of a pixel count as rows).
    pub fn cone(&self, rows: f32, aspect: f32) -> Cone {
        match &self.kind {
            Kind::Pinhole(window) | Kind::ThinLens { window, .. } => {
                Cone { width: 0.0, spread: window.height() / rows }
            }
            Kind::Orthographic(window) => Cone { width: window.height() / rows, spread: 0.0 },
            Kind::Environment => Cone { width: 0.0, spread: PI / rows },
            Kind::User { .. } => {
                // Measured between two neighbouring rows in the middle of the picture.
                let ray = |dy: f32| self.primary_ray(Vec2::new(0.5, 0.5 + dy / rows), aspect, Vec2::splat(0.5));
                match (ray(-0.5), ray(0.5)) {
                    (Some(a), Some(b)) => {
                        Cone { width: a.origin.distance(b.origin), spread: a.direction.distance(b.direction) }
                    }
                    _ => Cone { width: 0.0, spread: 1.0 / rows },
                }
            }
        }
    }
}
