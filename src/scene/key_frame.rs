//! Key frames: where the vertices of an object will be at some time, as far as is known before.

use glam::Vec3;

/// Vertices at one time. They are not drawn; trees are built for them (see `accel/key_trees`).
#[derive(Clone, Debug)]
pub struct KeyFrame {
    pub time: f32,
    /// As many as the object has.
    pub positions: Vec<Vec3>,
    /// The epoch at which it was given; no two are alike.
    pub version: u64,
}

/// Puts `key` into `keys`, which are in ascending order of time; one of the same time is replaced.
pub(super) fn insert(keys: &mut Vec<KeyFrame>, key: KeyFrame) {
    let at = keys.partition_point(|k| k.time < key.time);
    match keys.get_mut(at) {
        Some(same) if same.time == key.time => *same = key,
        _ => keys.insert(at, key),
    }
}

/// The key frame nearest to `time`, of two equally near the earlier one.
pub(super) fn nearest(keys: &[KeyFrame], time: f32) -> Option<&KeyFrame> {
    let at = keys.partition_point(|k| k.time < time);
    let (before, after) = (at.checked_sub(1).and_then(|i| keys.get(i)), keys.get(at));
    match (before, after) {
        (Some(before), Some(after)) if after.time - time < time - before.time => Some(after),
        (before, after) => before.or(after),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_key_frame_is_the_active_one() {
        let mut keys = Vec::new();
        assert!(nearest(&keys, 1.0).is_none());
        for (version, time) in [2.0, 0.0, 1.0, 2.0].into_iter().enumerate() {
            insert(&mut keys, KeyFrame { time, positions: Vec::new(), version: version as u64 });
        }
        assert_eq!(keys.iter().map(|k| (k.time, k.version)).collect::<Vec<_>>(), [(0.0, 1), (1.0, 2), (2.0, 3)]);
        for (time, version) in [(-5.0, 1), (0.4, 1), (0.5, 1), (0.6, 2), (1.0, 2), (1.51, 3), (9.0, 3)] {
            assert_eq!(nearest(&keys, time).map(|k| k.version), Some(version), "at {time}");
        }
    }
}
