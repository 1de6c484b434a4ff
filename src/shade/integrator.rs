//! Rendering objects: which rays a pixel sends. The algorithms themselves are in [`super::whitted`], [`super::path`]
//! and [`super::ambient_occlusion`].

use crate::scene::{Program, Shader};
use crate::shade::values::Values;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// `whitted`, and with neither depth nor shadows `raycast`.
    Whitted {
        max_depth: u32,
        shadows: bool,
    },
    AmbientOcclusion {
        samples: u32,
        distance: f32,
    },
    Path {
        max_depth: u32,
        roulette_depth: u32,
    },
}

/// Bounces are recursive in `whitted`, so the caller's depth is cut here.
const MAX_RECURSION: u32 = 64;
/// Paths are loops; this only keeps a pixel from taking for ever between perfect mirrors.
const MAX_PATH: u32 = 1 << 16;
const MAX_SAMPLES: u32 = 1 << 16;

impl Integrator {
    /// Camera rays and lights, and nothing else.
    pub const RAYCAST: Self = Self::Whitted { max_depth: 0, shadows: false };

    /// The integrator that `shader` names; Whitted's if it names none of ours.
    pub fn new(shader: Option<&Shader>, frame_depth: u32) -> Self {
        let default = Self::Whitted { max_depth: frame_depth.min(MAX_RECURSION), shadows: true };
        let Some(shader) = shader.filter(|s| matches!(s.class.program, Program::BuiltIn)) else { return default };
        let values = Values(shader);
        match &*shader.class.name {
            "whitted" => {
                let own = u32::try_from(values.int("max_depth")).unwrap_or(frame_depth);
                Self::Whitted { max_depth: own.min(MAX_RECURSION), shadows: values.int("shadows") != 0 }
            }
            "raycast" => Self::RAYCAST,
            "ambient_occlusion" => {
                let distance = values.float("distance");
                Self::AmbientOcclusion {
                    samples: values.count("samples", MAX_SAMPLES),
                    distance: if distance > 0.0 { distance } else { f32::INFINITY },
                }
            }
            "path" => Self::Path {
                max_depth: values.int("max_depth").max(0).unsigned_abs().min(MAX_PATH),
                roulette_depth: values.int("roulette_depth").max(0).unsigned_abs(),
            },
            _ => default,
        }
    }

    /// Number of bounces after the primary ray that a surface shader may ask for.
    pub fn max_depth(&self) -> u32 {
        match *self {
            Self::Whitted { max_depth, .. } => max_depth,
            Self::AmbientOcclusion { .. } => 0,
            Self::Path { max_depth, .. } => max_depth.min(MAX_RECURSION),
        }
    }
}
