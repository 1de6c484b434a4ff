//! Cameras, and the lights of KHR_lights_punctual.

use super::file::document::Document;
use super::json;
use crate::load::LoadError;
use crate::load::model::{Camera, Light, LightKind, Projection, SceneFile, View};
use glam::{DVec3, Vec3};

/// Adds the camera of node `number`, whose index in the scene is `index`.
pub fn add_camera(
    document: &Document,
    scene: &mut SceneFile,
    node: &json::Node,
    number: u32,
    index: u32,
) -> Result<(), LoadError> {
    let Some(camera) = node.camera else { return Ok(()) };
    let camera = document.get(&document.root.cameras, "cameras", camera, || format!("nodes[{number}]"))?;
    let projection = match (&camera.perspective, &camera.orthographic) {
        (Some(p), _) if camera.kind != "orthographic" => {
            let degrees = f64::from(p.yfov).to_degrees();
            Projection::Perspective { fov_y: if degrees > 0.0 && degrees < 180.0 { degrees } else { 45.0 } }
        }
        (_, Some(o)) => {
            let half_height = f64::from(o.ymag).abs();
            Projection::Orthographic { half_height: if half_height > 0.0 { half_height } else { 1.0 } }
        }
        _ => {
            document.left_out(format!("nodes[{number}]"), "a camera without a projection is left out");
            return Ok(());
        }
    };
    scene.cameras.push(Camera {
        name: camera.name.as_deref().or(node.name.as_deref()).unwrap_or("camera").to_string(),
        rest: View { from: DVec3::ZERO, forward: DVec3::NEG_Z, up: DVec3::Y },
        node: Some(index),
        keys: None,
        projection,
        resolution: None,
    });
    Ok(())
}

/// Adds the light of node `number`, whose index in the scene is `index`.
pub fn add_light(
    document: &Document,
    scene: &mut SceneFile,
    node: &json::Node,
    number: u32,
    index: u32,
) -> Result<(), LoadError> {
    let Some(light) = node.extensions.as_ref().and_then(|e| e.light.as_ref()) else { return Ok(()) };
    let lights = &document.root.extensions.lights.lights;
    let light = document.get(lights, "lights", light.light, || format!("nodes[{number}]"))?;
    let kind = match light.kind.as_str() {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point { attenuated: true },
        "spot" => {
            let spot = &light.spot;
            LightKind::Spot { inner: spot.inner_cone_angle.to_degrees(), outer: spot.outer_cone_angle.to_degrees() }
        }
        other => {
            document.left_out(format!("nodes[{number}]"), format!("lights of type `{other}` are left out"));
            return Ok(());
        }
    };
    scene.lights.push(Light {
        name: light.name.as_deref().or(node.name.as_deref()).unwrap_or("light").to_string(),
        kind,
        // Candela or lux; the library counts in what a white surface reflects, which is a π-th.
        color: Vec3::from_array(light.color) * light.intensity / std::f32::consts::PI,
        position: DVec3::ZERO,
        direction: DVec3::NEG_Z,
        node: Some(index),
        keys: None,
    });
    Ok(())
}
