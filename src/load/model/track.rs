//! Animation channels of glTF 2.0 (appendix C of its specification): step, linear and cubic key frames.

use glam::{DAffine3, DQuat, DVec3, DVec4};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    Step,
    Linear,
    /// Each key holds an in-tangent, a value and an out-tangent.
    CubicSpline,
}

/// Key frames of a vector with `width` components, clamped outside.
#[derive(Clone, Debug)]
pub struct Track {
    /// Ascending, not empty.
    pub times: Vec<f32>,
    /// `width` floats per key; three times as many for cubic splines.
    pub values: Vec<f32>,
    pub width: usize,
    pub interpolation: Interpolation,
}

impl Track {
    /// The key at or before `time` and how far it is to the next one, 0 to 1.
    fn locate(&self, time: f64) -> (usize, f64) {
        let last = self.times.len() - 1;
        let next = self.times.partition_point(|&t| f64::from(t) <= time);
        if next == 0 {
            return (0, 0.0);
        }
        if next > last {
            return (last, 0.0);
        }
        let (a, b) = (f64::from(self.times[next - 1]), f64::from(self.times[next]));
        (next - 1, (time - a) / (b - a))
    }

    /// Part `part` (0 in-tangent, 1 value, 2 out-tangent) of key `key`, component `c`.
    fn value(&self, key: usize, part: usize, c: usize) -> f64 {
        let i = if self.interpolation == Interpolation::CubicSpline { key * 3 + part } else { key };
        f64::from(self.values[i * self.width + c])
    }

    fn component(&self, time: f64, c: usize) -> f64 {
        let (key, u) = self.locate(time);
        let a = self.value(key, 1, c);
        if u <= 0.0 || self.interpolation == Interpolation::Step {
            return a;
        }
        let b = self.value(key + 1, 1, c);
        if self.interpolation == Interpolation::Linear {
            return a + (b - a) * u;
        }
        let length = f64::from(self.times[key + 1]) - f64::from(self.times[key]);
        let (leaving, arriving) = (self.value(key, 2, c) * length, self.value(key + 1, 0, c) * length);
        let (u2, u3) = (u * u, u * u * u);
        (2.0 * u3 - 3.0 * u2 + 1.0) * a
            + (u3 - 2.0 * u2 + u) * leaving
            + (3.0 * u2 - 2.0 * u3) * b
            + (u3 - u2) * arriving
    }

    pub fn vec3(&self, time: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|c| self.component(time, c)))
    }

    /// Spherical interpolation by the shorter arc for linear keys.
    pub fn quat(&self, time: f64) -> DQuat {
        let key = |k: usize| DQuat::from_array(std::array::from_fn(|c| self.value(k, 1, c)));
        let unit = |q: DQuat| DVec4::from(q).try_normalize().map_or(DQuat::IDENTITY, DQuat::from_vec4);
        let (k, u) = self.locate(time);
        if self.interpolation == Interpolation::Linear && u > 0.0 {
            return unit(key(k)).slerp(unit(key(k + 1)), u);
        }
        unit(DQuat::from_array(std::array::from_fn(|c| self.component(time, c))))
    }

    pub fn floats(&self, time: f64) -> Vec<f32> {
        (0..self.width).map(|c| self.component(time, c) as f32).collect()
    }
}

/// A node's rest placement and the channels that replace parts of it.
#[derive(Clone, Debug)]
pub struct TrsChannels {
    pub rest_translation: DVec3,
    pub rest_rotation: DQuat,
    pub rest_scale: DVec3,
    pub translation: Option<Track>,
    pub rotation: Option<Track>,
    pub scale: Option<Track>,
    /// Morph weights; drives the meshes of the node.
    pub weights: Option<Track>,
}

impl TrsChannels {
    /// The same node without its channels.
    pub fn at_rest(&self) -> Self {
        let Self { rest_translation, rest_rotation, rest_scale, .. } = *self;
        Self {
            rest_translation,
            rest_rotation,
            rest_scale,
            translation: None,
            rotation: None,
            scale: None,
            weights: None,
        }
    }

    pub fn at(&self, time: f64) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(
            self.scale.as_ref().map_or(self.rest_scale, |t| t.vec3(time)),
            self.rotation.as_ref().map_or(self.rest_rotation, |t| t.quat(time)),
            self.translation.as_ref().map_or(self.rest_translation, |t| t.vec3(time)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_and_clamps() {
        let mut t =
            Track { times: vec![1.0, 2.0], values: vec![0.0, 10.0], width: 1, interpolation: Interpolation::Linear };
        assert_eq!([0.0, 1.0, 1.5, 2.0, 3.0].map(|s| t.floats(s)[0]), [0.0, 0.0, 5.0, 10.0, 10.0]);
        t.interpolation = Interpolation::Step;
        assert_eq!(t.floats(1.9)[0], 0.0);
        t.interpolation = Interpolation::CubicSpline;
        t.values = vec![0.0, 0.0, 0.0, 0.0, 10.0, 0.0];
        assert_eq!([1.0, 1.5, 2.0].map(|s| t.floats(s)[0]), [0.0, 5.0, 10.0]);
        assert!(t.floats(1.25)[0] < 2.5, "flat tangents ease in");
    }
}
