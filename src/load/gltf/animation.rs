//! Animations: key frames of nodes, and which of them are played together.
//!
//! Some programs write one animation for each node, others one for each thing that a figure can do. So animations of a file are
//! gathered into clips: one that moves nothing that an earlier one of the clip moves joins it, else it begins another.

use super::file::document::Document;
use super::json;
use super::nodes::{Nodes, at_rest};
use crate::load::LoadError;
use crate::load::model::{Animation, Clip, Interpolation, SceneFile, Track};
use std::collections::{HashMap, HashSet};

/// Frames per second of an animation whose file gives times only.
const FRAMES_PER_SECOND: f64 = 24.0;

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

struct Channel {
    node: u32,
    property: Property,
    track: Track,
}

/// Channels of animations that are played together.
#[derive(Default)]
struct Group {
    name: String,
    channels: Vec<Channel>,
    used: HashSet<(u32, Property)>,
}

/// All animations of the file; nodes by their numbers there.
#[derive(Default)]
pub struct Motion {
    groups: Vec<Group>,
    /// Nodes with any channel.
    pub targets: HashSet<u32>,
    /// Nodes that are moved, not only deformed.
    pub moved: HashSet<u32>,
}

pub fn read(document: &Document) -> Result<Motion, LoadError> {
    let mut motion = Motion::default();
    for (a, animation) in document.root.animations.iter().enumerate() {
        let mut channels = Vec::new();
        for (c, channel) in animation.channels.iter().enumerate() {
            channels.extend(read_channel(document, animation, channel, || format!("animations[{a}].channels[{c}]"))?);
        }
        if channels.is_empty() {
            continue;
        }
        for channel in &channels {
            motion.targets.insert(channel.node);
            if channel.property != Property::Weights {
                motion.moved.insert(channel.node);
            }
        }
        let name = animation.name.as_deref().map_or_else(|| format!("animation {a}"), str::to_string);
        let free = |g: &Group| channels.iter().all(|c| !g.used.contains(&(c.node, c.property)));
        let group = match motion.groups.iter().position(free) {
            Some(known) => &mut motion.groups[known],
            None => {
                motion.groups.push(Group { name, ..Group::default() });
                motion.groups.last_mut().expect("one was pushed")
            }
        };
        group.used.extend(channels.iter().map(|c| (c.node, c.property)));
        group.channels.extend(channels);
    }
    Ok(motion)
}

/// One channel; `None`, and a note, for one that moves nothing of what is read.
fn read_channel(
    document: &Document,
    animation: &json::Animation,
    channel: &json::Channel,
    place: impl Fn() -> String,
) -> Result<Option<Channel>, LoadError> {
    let left_out = |what: &str| {
        document.left_out(place(), what);
        Ok(None)
    };
    let (property, width) = match &*channel.target.path {
        "translation" => (Property::Translation, 3),
        "scale" => (Property::Scale, 3),
        "rotation" => (Property::Rotation, 4),
        "weights" => (Property::Weights, 1),
        other => return left_out(&format!("animations of `{other}` are left out")),
    };
    // The specification lets extensions say what moves.
    let Some(node) = channel.target.node else { return Ok(None) };
    document.get(&document.root.nodes, "nodes", node, &place)?;
    let sampler = document.get(&animation.samplers, "samplers", channel.sampler, &place)?;
    let interpolation = match sampler.interpolation.as_deref().unwrap_or("LINEAR") {
        "LINEAR" => Interpolation::Linear,
        "STEP" => Interpolation::Step,
        "CUBICSPLINE" => Interpolation::CubicSpline,
        other => return left_out(&format!("animations with interpolation `{other}` are left out")),
    };
    let times = document.accessor_of::<1>(sampler.input, &place)?;
    let values = document.accessor(sampler.output, &place)?;
    // The outputs of weights are one number each, but for files that are strict about nothing.
    let scalars = match property {
        Property::Weights => document.accessor_of::<1>(sampler.output, &place)?.len(),
        Property::Rotation => document.accessor_of::<4>(sampler.output, &place)?.len().saturating_mul(4),
        _ => document.accessor_of::<3>(sampler.output, &place)?.len().saturating_mul(3),
    };
    let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let keys = times.len();
    let rows = keys.saturating_mul(parts);
    let width = if property == Property::Weights { scalars.checked_div(rows).unwrap_or(0) } else { width };
    if keys == 0 || width == 0 || scalars != rows.saturating_mul(width) {
        return left_out("an animation whose values do not fit its keys is left out");
    }
    document.spend((keys + scalars) as u64 / 4, &place)?;
    let times: Vec<f32> = (0..keys).map(|k| times.floats::<1>(k)[0]).collect();
    let values: Vec<f32> = match property {
        Property::Weights => (0..scalars).map(|k| values.floats::<1>(k)[0]).collect(),
        Property::Rotation => (0..rows).flat_map(|k| values.floats::<4>(k)).collect(),
        _ => (0..rows).flat_map(|k| values.floats::<3>(k)).collect(),
    };
    let finite = times.iter().chain(&values).all(|t| t.is_finite());
    if !finite || times.windows(2).any(|w| w[1] < w[0]) {
        return left_out("an animation whose times go back, or whose values are not finite, is left out");
    }
    Ok(Some(Channel { node, property, track: Track { times, values, width, interpolation } }))
}

impl Motion {
    /// Turns the groups into the clips of the scene, and plays the first.
    pub fn finish(self, document: &Document, nodes: &Nodes, scene: &mut SceneFile) {
        for group in self.groups {
            let mut clip = Clip { name: group.name, animation: still(), channels: Vec::new() };
            let mut of_node: HashMap<u32, usize> = HashMap::new();
            let mut end = 0.0_f64;
            for Channel { node: number, property, track } in group.channels {
                end = end.max(f64::from(track.times.last().copied().unwrap_or(0.0)));
                let keys = track.times.len() as u64;
                match property {
                    Property::Translation => scene.counts.translation_keys += keys,
                    Property::Rotation => scene.counts.rotation_keys += keys,
                    Property::Scale => scene.counts.scale_keys += keys,
                    Property::Weights => {}
                }
                // Nodes that the scene does not show move unseen.
                let Some(&node) = nodes.index_of.get(&number) else { continue };
                let next = clip.channels.len();
                let at = *of_node.entry(node).or_insert(next);
                if at == next {
                    clip.channels.push((node, at_rest(&document.root.nodes[number as usize])));
                }
                let channels = &mut clip.channels[at].1;
                match property {
                    Property::Translation => channels.translation = Some(track),
                    Property::Rotation => channels.rotation = Some(track),
                    Property::Scale => channels.scale = Some(track),
                    Property::Weights => channels.weights = Some(track),
                }
            }
            clip.animation.end = end;
            clip.animation.frames = (end * FRAMES_PER_SECOND).round().clamp(0.0, 1e6) as u32 + 1;
            scene.clips.push(clip);
        }
        if !scene.clips.is_empty() {
            scene.play_clip(0);
        }
        if scene.clips.len() > 1 {
            let names: Vec<&str> = scene.clips.iter().map(|c| c.name.as_str()).collect();
            let text = format!("the animations {} move the same things; the first is played", names.join(", "));
            scene.notes.push(document.error(text).to_string());
        }
    }
}

fn still() -> Animation {
    Animation { start: 0.0, end: 0.0, frames: 1 }
}
