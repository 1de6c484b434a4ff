//! The first animation of a glTF file as tracks by node.

use super::buffers::Buffers;
use crate::load::LoadError;
use crate::load::model::{Animation, Interpolation, SceneFile, Track, TrsChannels};
use glam::{DQuat, DVec3};
use std::collections::HashMap;

/// Frames per second of an animation whose file gives times only.
const FRAMES_PER_SECOND: f64 = 24.0;

#[derive(Default)]
pub struct Motion {
    /// By glTF node index.
    pub channels: HashMap<usize, TrsChannels>,
}

pub fn read(gltf: &gltf::Gltf, buffers: &Buffers, scene: &mut SceneFile) -> Result<Motion, LoadError> {
    use gltf::animation::Property;
    let mut motion = Motion::default();
    let Some(animation) = gltf.animations().next() else { return Ok(motion) };
    if gltf.animations().len() > 1 {
        let text = format!("{} animations; only the first is played", gltf.animations().len());
        scene.notes.push(buffers.error(text).to_string());
    }
    let mut end = 0.0_f64;
    for channel in animation.channels() {
        let node = channel.target().node();
        let sampler = channel.sampler();
        let times = buffers.floats(&sampler.input(), 1)?;
        if times.is_empty() || !times.iter().all(|t| t.is_finite()) || times.windows(2).any(|w| w[1] <= w[0]) {
            return Err(buffers.error(format!("the times of an animation of node {} do not grow", node.index())));
        }
        let interpolation = match sampler.interpolation() {
            gltf::animation::Interpolation::Step => Interpolation::Step,
            gltf::animation::Interpolation::Linear => Interpolation::Linear,
            gltf::animation::Interpolation::CubicSpline => Interpolation::CubicSpline,
        };
        let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let property = channel.target().property();
        let component = match property {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::MorphTargetWeights => 1,
        };
        let values = buffers.floats(&sampler.output(), component)?;
        let keys = times.len();
        let width = if property == Property::MorphTargetWeights { values.len() / (keys * parts) } else { component };
        if width == 0 || values.len() != keys * parts * width || !values.iter().all(|v| v.is_finite()) {
            let text = format!("an animation of node {} has {} values for {keys} keys", node.index(), values.len());
            return Err(buffers.error(text));
        }
        end = end.max(f64::from(times[keys - 1]));
        let keys = keys as u64;
        let track = Some(Track { times, values, width, interpolation });
        let channels = motion.channels.entry(node.index()).or_insert_with(|| at_rest(&node));
        match property {
            Property::Translation => {
                channels.translation = track;
                scene.counts.translation_keys += keys;
            }
            Property::Rotation => {
                channels.rotation = track;
                scene.counts.rotation_keys += keys;
            }
            Property::Scale => {
                channels.scale = track;
                scene.counts.scale_keys += keys;
            }
            Property::MorphTargetWeights => channels.weights = track,
        }
    }
    let frames = (end * FRAMES_PER_SECOND).round().clamp(0.0, 1e6) as u32 + 1;
    scene.animation = Some(Animation { start: 0.0, end, frames });
    Ok(motion)
}

fn at_rest(node: &gltf::Node) -> TrsChannels {
    let (translation, rotation, scale) = node.transform().decomposed();
    TrsChannels {
        rest_translation: DVec3::from_array(translation.map(f64::from)),
        rest_rotation: DQuat::from_array(rotation.map(f64::from)),
        rest_scale: DVec3::from_array(scale.map(f64::from)),
        translation: None,
        rotation: None,
        scale: None,
        weights: None,
    }
}
