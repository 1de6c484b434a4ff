//! Objects: a mesh, how it moves, and what changed since when.

use super::{Instance, KeyFrame, Mask, Mesh, Moves, key_frame};
use std::sync::Arc;

/// How the application means to move an object (Wald03 §3). A promise that only costs speed when broken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Motion {
    /// Neither geometry nor instance matrix changes.
    Static,
    /// Only the instance matrix changes.
    #[default]
    Affine,
    /// Vertices move independently, every frame.
    Unstructured,
}

/// How an object's acceleration structure is built and brought up to date.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// Chosen from the motion flag, from what was measured, and from whether rays met the object.
    #[default]
    Auto,
    /// Object BSP (kd-tree), Wald03 §4.2–4.3.
    Bsp,
    /// Binned SAH BVH, rebuilt when the geometry changes.
    Sah,
    /// Morton-code BVH, rebuilt when the geometry changes.
    FastBuild,
    /// Binned SAH BVH once, then bottom-up refit (Larsson03 §2) until the topology changes.
    Refit,
    /// Refit with rotations (Kopta12), and a new tree when that does not keep up.
    Rotate,
    /// Grid of grids (Larsson03 §5), rebuilt when the geometry changes.
    Grid,
    /// Binned SAH BVH once; after that only what rays reach is brought up to date, when they reach it (Larsson03 §3).
    Lazy,
    /// Visibility field (Khanna04): subfields of tiles for many directions, drawn when rays ask for them.
    VisibilityField,
}

impl Strategy {
    /// Every strategy that can be forced, for tests that loop over all of them.
    pub const ALL: [Strategy; 8] = [
        Strategy::Bsp,
        Strategy::Sah,
        Strategy::FastBuild,
        Strategy::Refit,
        Strategy::Rotate,
        Strategy::Grid,
        Strategy::Lazy,
        Strategy::VisibilityField,
    ];

    /// Lower-case name, as accepted by the environment variable `OPENRT_ACCEL`.
    pub fn name(self) -> &'static str {
        match self {
            Strategy::Auto => "auto",
            Strategy::Bsp => "bsp",
            Strategy::Sah => "sah",
            Strategy::FastBuild => "fast_build",
            Strategy::Refit => "refit",
            Strategy::Rotate => "rotate",
            Strategy::Grid => "grid",
            Strategy::Lazy => "lazy",
            Strategy::VisibilityField => "visibility_field",
        }
    }

    /// Inverse of [`Strategy::name`].
    pub fn from_name(name: &str) -> Option<Self> {
        [Strategy::Auto].into_iter().chain(Self::ALL).find(|s| s.name() == name)
    }
}

/// How [`Strategy::Lazy`] cuts a tree into what is updated at once; never changes a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LazyShape {
    /// Subtrees of at most so many triangles hang below the part that is updated first. 0: those at half the tree's height, as in the
    /// paper.
    pub cut: u32,
    /// Levels of such a subtree that are updated together when a ray reaches them. 0: the whole subtree.
    pub levels: u32,
}

impl Default for LazyShape {
    fn default() -> Self {
        Self { cut: 2048, levels: 0 }
    }
}

/// A compiled object. The counters only grow; the engine remembers the values that it has seen.
#[derive(Clone, Debug, Default)]
pub struct Object {
    /// Structures that are updated while rays are traced keep a weak reference: a change of the mesh then moves it instead of copying it, and
    /// cuts them off from it.
    pub mesh: Arc<Mesh>,
    /// Objects that are part of this one, placed in its space.
    pub children: Vec<Instance>,
    pub motion: Motion,
    pub strategy: Strategy,
    pub lazy: LazyShape,
    /// Rays see its instances that are in this mask and in the instance's.
    pub mask: Mask,
    /// A static object built by binned SAH may have its triangles cut, for a better tree that takes longer to build.
    pub spatial_splits: bool,
    /// Grows when the object is defined anew: indices, counts or shaders changed.
    pub topology_version: u64,
    /// Grows when vertices moved under an unchanged topology.
    pub vertex_version: u64,
    /// Which ones, by the `vertex_version` of their time.
    pub moves: Moves,
    /// In ascending order of time.
    pub keys: Vec<KeyFrame>,
    /// Grows when `keys` change.
    pub keys_version: u64,
    /// Chooses among `keys`.
    pub time: f32,
}

impl Object {
    /// The key frame nearest to the object's time.
    pub fn active_key(&self) -> Option<&KeyFrame> {
        key_frame::nearest(&self.keys, self.time)
    }
}
