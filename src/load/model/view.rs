//! Cameras and lights, which may hang on a node or have key frames of their own.

use super::{KeyedTransform, Pose};
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
    /// Half the height of the picture in world units.
    Orthographic { half_height: f64 },
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
