//! Objects: a mesh, how it moves, and what changed since when.

use super::Mesh;

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

/// How an object's acceleration structure is built and brought up to date (design §5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// Chosen from the motion flag and from what was measured.
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
    /// Uniform grid (Larsson03 §5), rebuilt when the geometry changes.
    Grid,
}

impl Strategy {
    /// Every strategy that can be forced, for tests that loop over all of them.
    pub const ALL: [Strategy; 6] =
        [Strategy::Bsp, Strategy::Sah, Strategy::FastBuild, Strategy::Refit, Strategy::Rotate, Strategy::Grid];

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
        }
    }

    /// Inverse of [`Strategy::name`].
    pub fn from_name(name: &str) -> Option<Self> {
        [Strategy::Auto].into_iter().chain(Self::ALL).find(|s| s.name() == name)
    }
}

/// A compiled object. The counters only grow; the engine remembers the values that it has seen.
#[derive(Clone, Debug, Default)]
pub struct Object {
    pub mesh: Mesh,
    pub motion: Motion,
    pub strategy: Strategy,
    /// Grows when the object is defined anew: indices, counts or shaders changed.
    pub topology_version: u64,
    /// Grows when vertices moved under an unchanged topology.
    pub vertex_version: u64,
}
