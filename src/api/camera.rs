//! The camera of the helper calls: `perspective`, `frustum`, `ortho` and `look_at`.
//!
//! They set up a hidden shader of the built-in class `pinhole` or `orthographic`. Unlike in OpenGL they do not multiply onto a matrix: each replaces
//! its half of the camera (projection or placement), in any order, and the matrix stack has no part in it. Near and far planes are checked as in
//! OpenGL, but nothing is clipped: a ray starts at the eye, or for `ortho` in the plane of the eye.

use super::context::Context;
use super::error::{Error, Result};
use super::names::FIRST_RESERVED;
use crate::scene::{Command, Name, ParamValue, ShaderClass};
use glam::{DVec3, Vec3};
use std::sync::Arc;

const PINHOLE: Name = FIRST_RESERVED;
const ORTHOGRAPHIC: Name = FIRST_RESERVED + 1;

#[derive(Clone, Copy, PartialEq)]
enum Projection {
    /// 60° across the viewport's height.
    Default,
    /// Left, right, bottom, top at distance 1.
    Pinhole([f32; 4]),
    /// Left, right, bottom, top.
    Orthographic([f32; 4]),
}

#[derive(Clone, Copy, PartialEq)]
pub(super) struct HelperCamera {
    projection: Projection,
    eye: Vec3,
    center: Vec3,
    up: Vec3,
    /// A helper call was made; otherwise the frame's camera is 0, the default one.
    used: bool,
    /// Not yet sent to the back-end.
    changed: bool,
    defined: bool,
}

impl Default for HelperCamera {
    fn default() -> Self {
        Self {
            projection: Projection::Default,
            eye: Vec3::ZERO,
            center: Vec3::NEG_Z,
            up: Vec3::Y,
            used: false,
            changed: false,
            defined: false,
        }
    }
}

impl Context {
    /// A pinhole camera with `fov_y` degrees between the bottom and the top of the picture, and `aspect` times that window's
    /// height as its width. The helper camera becomes the frame's camera.
    ///
    /// # Errors
    /// `InvalidValue` unless 0 < `fov_y` < 180, `aspect` > 0 and 0 < `near` < `far`, all finite.
    pub fn perspective(&mut self, fov_y: f64, aspect: f64, near: f64, far: f64) -> Result<()> {
        self.outside_begin()?;
        let top = (fov_y.to_radians() * 0.5).tan();
        let valid = fov_y > 0.0 && fov_y < 180.0 && aspect > 0.0 && aspect.is_finite();
        if !valid || !planes_are_valid(near, far) {
            return Err(Error::invalid_value(format_args!(
                "a perspective needs 0 < fov < 180, aspect > 0 and 0 < near < far; given were fov {fov_y}, aspect {aspect}, near {near}, far {far}"
            )));
        }
        self.project(Projection::Pinhole, [-top * aspect, top * aspect, -top, top])
    }

    /// A pinhole camera whose window is given on the near plane, as in OpenGL.
    ///
    /// # Errors
    /// `InvalidValue` for an empty window, planes not 0 < `near` < `far`, or numbers that are not finite.
    pub fn frustum(&mut self, left: f64, right: f64, bottom: f64, top: f64, near: f64, far: f64) -> Result<()> {
        self.outside_begin()?;
        if !planes_are_valid(near, far) {
            return Err(Error::invalid_value(format_args!(
                "a frustum needs 0 < near < far; given were near {near}, far {far}"
            )));
        }
        self.project(Projection::Pinhole, [left, right, bottom, top].map(|v| v / near))
    }

    /// An orthographic camera with a window in world units.
    ///
    /// # Errors
    /// `InvalidValue` for an empty window, `near` = `far`, or numbers that are not finite.
    pub fn ortho(&mut self, left: f64, right: f64, bottom: f64, top: f64, near: f64, far: f64) -> Result<()> {
        self.outside_begin()?;
        if !(near.is_finite() && far.is_finite() && near != far) {
            return Err(Error::invalid_value(format_args!(
                "an orthographic projection needs near and far to differ; given were near {near}, far {far}"
            )));
        }
        self.project(Projection::Orthographic, [left, right, bottom, top])
    }

    /// Places the helper camera at `eye`, looking at `center`, with `up` upwards in the picture.
    ///
    /// # Errors
    /// `InvalidValue` when `eye` is `center`, `up` points along the view, or a number is not finite.
    pub fn look_at(&mut self, eye: DVec3, center: DVec3, up: DVec3) -> Result<()> {
        self.outside_begin()?;
        let (given_eye, given_center, given_up) = (eye, center, up);
        // The direction, not the far end, is what must survive the rounding to f32.
        let forward = (center - eye).normalize_or_zero();
        let (eye, up) = (eye.as_vec3(), up.normalize_or_zero().as_vec3());
        let center = eye + forward.as_vec3() * eye.length().max(1.0);
        let side = (center - eye).normalize_or_zero().cross(up);
        if !(eye.is_finite() && center.is_finite() && side.length() > 1e-6) {
            return Err(Error::invalid_value(format_args!(
                "eye and center must be apart and up not along the view; given were eye {given_eye}, center {given_center}, up {given_up}"
            )));
        }
        self.select_helper_camera(HelperCamera { eye, center, up, ..self.camera });
        Ok(())
    }

    fn project(&mut self, kind: fn([f32; 4]) -> Projection, window: [f64; 4]) -> Result<()> {
        let [left, right, bottom, top] = window.map(|v| v as f32);
        let finite = left.is_finite() && right.is_finite() && bottom.is_finite() && top.is_finite();
        if !finite || left == right || bottom == top {
            return Err(Error::invalid_value(format_args!(
                "the window is empty or not finite: left {left}, right {right}, bottom {bottom}, top {top}, at distance 1"
            )));
        }
        self.select_helper_camera(HelperCamera { projection: kind([left, right, bottom, top]), ..self.camera });
        Ok(())
    }

    fn select_helper_camera(&mut self, camera: HelperCamera) {
        let changed = !self.camera.used || self.camera != camera;
        self.camera = HelperCamera { used: true, changed: changed || self.camera.changed, ..camera };
        self.content.camera = None;
    }

    /// Camera shader of the frame to start. Sends the helper camera if it changed.
    pub(super) fn send_camera(&mut self) -> Result<Name> {
        if let Some(camera) = self.content.camera {
            return Ok(camera);
        }
        if !self.camera.used {
            return Ok(0);
        }
        let name = match self.camera.projection {
            Projection::Orthographic(_) => ORTHOGRAPHIC,
            _ => PINHOLE,
        };
        if self.camera.changed {
            self.backend.reserve(16)?;
            if !self.camera.defined {
                for (name, class) in [(PINHOLE, "pinhole"), (ORTHOGRAPHIC, "orthographic")] {
                    let class = self.shaders.built_in(class).expect("a built-in camera");
                    self.backend.send(Command::DefineClass { name, class });
                    self.backend.send(Command::DefineShader { name, class: name });
                }
                self.camera.defined = true;
            }
            let class = if name == PINHOLE { "pinhole" } else { "orthographic" };
            let class = self.shaders.built_in(class).expect("a built-in camera");
            let window = match self.camera.projection {
                Projection::Default => [0.0; 4],
                Projection::Pinhole(window) | Projection::Orthographic(window) => window,
            };
            let vec3 = |v: Vec3| [v.x, v.y, v.z, 0.0];
            let HelperCamera { eye, center, up, .. } = self.camera;
            for (param, value) in [("eye", vec3(eye)), ("center", vec3(center)), ("up", vec3(up)), ("window", window)] {
                self.send_helper_parameter(name, &class, param, value);
            }
            self.camera.changed = false;
        }
        Ok(name)
    }

    fn send_helper_parameter(&mut self, shader: Name, class: &Arc<ShaderClass>, param: &str, value: [f32; 4]) {
        let param = class.param_index(param).expect("a parameter of the built-in cameras");
        self.backend.send(Command::SetParameter { shader, param, value: ParamValue::Float(value) });
    }
}

fn planes_are_valid(near: f64, far: f64) -> bool {
    near > 0.0 && near < far && far.is_finite()
}
