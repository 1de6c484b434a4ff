//! The tree of placements and its state at one time.

use super::{KeyedTransform, TrsChannels};
use glam::DAffine3;

/// How a node stands relative to its parent.
#[derive(Clone, Debug)]
pub enum Local {
    Fixed(DAffine3),
    /// AFF: the fixed transforms above the named one, then its key frames (none when the name has no keys).
    Keyed {
        before: DAffine3,
        keys: Option<Box<KeyedTransform>>,
    },
    /// glTF.
    Channels(Box<TrsChannels>),
}

#[derive(Clone, Debug)]
pub struct Node {
    pub name: String,
    /// Smaller than the node's own index; `None` for the root.
    pub parent: Option<u32>,
    pub local: Local,
}

impl Node {
    pub fn root() -> Self {
        Self { name: "world".into(), parent: None, local: Local::Fixed(DAffine3::IDENTITY) }
    }

    /// Whether the node can move relative to its parent.
    pub fn moves(&self) -> bool {
        match &self.local {
            Local::Fixed(_) => false,
            Local::Keyed { keys, .. } => keys.is_some(),
            Local::Channels(c) => c.translation.is_some() || c.rotation.is_some() || c.scale.is_some(),
        }
    }
}

/// Where a node is at one time.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    pub world: DAffine3,
    /// False when the node or one above it is switched off.
    pub visible: bool,
}

/// Poses of all nodes; parents come before their children, so one pass suffices.
pub(super) fn pose(nodes: &[Node], time: f64) -> Vec<Pose> {
    let mut poses: Vec<Pose> = Vec::with_capacity(nodes.len());
    for node in nodes {
        let parent = node
            .parent
            .and_then(|p| poses.get(p as usize).copied())
            .unwrap_or(Pose { world: DAffine3::IDENTITY, visible: true });
        let (local, visible) = match &node.local {
            Local::Fixed(m) => (*m, true),
            Local::Keyed { before, keys: Some(keys) } => (*before * keys.at(time), keys.visible(time)),
            Local::Keyed { before, keys: None } => (*before, true),
            Local::Channels(channels) => (channels.at(time), true),
        };
        poses.push(Pose { world: parent.world * local, visible: parent.visible && visible });
    }
    poses
}
