//! Cameras and lights, which may hang on a node or have key frames of their own.

use super::{KeyedTransform, Pose};
use crate::api::{Context, Error};
use glam::{DAffine3, DVec3, Vec3};

/// Eye point and orientation in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    pub from: DVec3,
    /// Viewing direction; any length but 0.
    pub forward: DVec3,
    pub up: DVec3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Vertical field of view in degrees.
    Perspective { fov_y: f64 },
    /// Field of view in degrees along the shorter side of the picture: what an overview shows is whole at any shape.
    Overview { fov: f64 },
    /// Half the height of the picture in world units.
    Orthographic { half_height: f64 },
}

impl Projection {
    /// Gives the camera of `context` this projection, for a picture that is `aspect` times as wide as high.
    ///
    /// # Errors
    /// As [`Context::perspective`] and [`Context::ortho`].
    pub fn apply(self, context: &mut Context, aspect: f64) -> Result<(), Error> {
        // Nothing is clipped: the planes only have to be valid.
        let (near, far) = (0.1, 1e3);
        match self {
            Projection::Perspective { fov_y } => context.perspective(fov_y, aspect, near, far),
            Projection::Overview { fov } => context.perspective(overview_fov_y(fov, aspect), aspect, near, far),
            Projection::Orthographic { half_height: h } => context.ortho(-h * aspect, h * aspect, -h, h, near, far),
        }
    }
}

/// Vertical field of view of a picture whose shorter side has `fov`, both in degrees.
fn overview_fov_y(fov: f64, aspect: f64) -> f64 {
    if aspect >= 1.0 { fov } else { 2.0 * ((fov.to_radians() * 0.5).tan() / aspect).atan().to_degrees() }
}

#[derive(Clone, Debug)]
pub struct Camera {
    pub name: String,
    /// At rest, relative to `node`.
    pub rest: View,
    pub node: Option<u32>,
    /// AFF's animation called `camera`. Its translation, if keyed, replaces the eye point; its rotation, if keyed,
    /// turns a camera that looks down −z with +y up. What is not keyed stays as in `rest`.
    pub keys: Option<Box<KeyedTransform>>,
    pub projection: Projection,
    /// Width and height that the file asks for.
    pub resolution: Option<(u32, u32)>,
}

impl Camera {
    pub fn view(&self, time: f64, poses: &[Pose]) -> View {
        let mut view = self.rest;
        if let Some(pose) = self.node.and_then(|n| poses.get(n as usize)) {
            view.from = pose.world.transform_point3(view.from);
            view.forward = pose.world.transform_vector3(view.forward);
            view.up = pose.world.transform_vector3(view.up);
        }
        if let Some(keys) = &self.keys {
            if let Some(translation) = &keys.translation {
                view.from = translation.at(time);
            }
            if let Some(rotation) = &keys.rotation {
                let rotation = rotation.at(time);
                view.forward = rotation * DVec3::NEG_Z;
                view.up = rotation * DVec3::Y;
            }
        }
        view
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// The same brightness at any distance (NFF), or falling with its square (glTF).
    Point {
        attenuated: bool,
    },
    Directional,
    /// Half angles of the full and of the outermost cone in degrees; falls with the square of the distance.
    Spot {
        inner: f32,
        outer: f32,
    },
}

#[derive(Clone, Debug)]
pub struct Light {
    pub name: String,
    pub kind: LightKind,
    /// Linear RGB, intensity included.
    pub color: Vec3,
    /// Relative to `node`, or to the key frames.
    pub position: DVec3,
    /// Direction of travel.
    pub direction: DVec3,
    pub node: Option<u32>,
    /// AFF `la`: the key frames of that name.
    pub keys: Option<Box<KeyedTransform>>,
}

impl Light {
    /// Position and direction of travel in world space; `None` while the light is switched off.
    pub fn placed(&self, time: f64, poses: &[Pose]) -> Option<(Vec3, Vec3)> {
        let mut world = DAffine3::IDENTITY;
        if let Some(pose) = self.node.and_then(|n| poses.get(n as usize)) {
            if !pose.visible {
                return None;
            }
            world = pose.world;
        }
        if let Some(keys) = &self.keys {
            if !keys.visible(time) {
                return None;
            }
            world *= keys.at(time);
        }
        let direction = world.transform_vector3(self.direction);
        Some((world.transform_point3(self.position).as_vec3(), direction.as_vec3()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_overview_keeps_its_field_of_view_along_the_shorter_side() {
        assert_eq!(overview_fov_y(45.0, 2.0), 45.0);
        assert_eq!(overview_fov_y(45.0, 1.0), 45.0);
        let fov_y = overview_fov_y(45.0, 0.25);
        let half_width = (fov_y.to_radians() * 0.5).tan() * 0.25;
        assert!((half_width - 22.5_f64.to_radians().tan()).abs() < 1e-12);
        assert!(overview_fov_y(45.0, 1e-5) < 180.0);
    }
}
