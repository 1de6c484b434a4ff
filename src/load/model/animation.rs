//! Key-framed transforms of AFF: T · R · S with visibility.

use super::{PositionSpline, RotationSpline};
use glam::{DAffine3, DQuat, DVec3};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibilityKey {
    pub time: f64,
    pub visible: bool,
}

/// A transform with some of its parts key-framed; a part without keys is the identity.
#[derive(Clone, Debug, Default)]
pub struct KeyedTransform {
    pub translation: Option<PositionSpline>,
    pub rotation: Option<RotationSpline>,
    pub scale: Option<PositionSpline>,
    /// Sorted by time.
    pub visibility: Vec<VisibilityKey>,
}

impl KeyedTransform {
    /// T · R · S at `time`.
    pub fn at(&self, time: f64) -> DAffine3 {
        let translation = self.translation.as_ref().map_or(DVec3::ZERO, |s| s.at(time));
        let rotation = self.rotation.as_ref().map_or(DQuat::IDENTITY, |s| s.at(time));
        let scale = self.scale.as_ref().map_or(DVec3::ONE, |s| s.at(time));
        DAffine3::from_scale_rotation_translation(scale, rotation, translation)
    }

    /// The last key at or before `time` decides; before the first key everything is visible.
    pub fn visible(&self, time: f64) -> bool {
        let after = self.visibility.partition_point(|k| k.time <= time);
        after.checked_sub(1).is_none_or(|i| self.visibility[i].visible)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visible_until_a_key_says_otherwise() {
        let key = |time, visible| VisibilityKey { time, visible };
        let t = KeyedTransform { visibility: vec![key(1.0, false), key(2.0, true)], ..Default::default() };
        assert_eq!([0.0, 1.0, 1.9, 2.0, 9.0].map(|time| t.visible(time)), [true, false, false, true, true]);
        assert!(KeyedTransform::default().visible(0.0));
    }
}
