//! The scenes of the design's tables, generated: deterministic, seeded, and a function of the frame number where they move.
//!
//! They have the structure and size of the scenes in the papers and in `design.md` §6, not their data. Static measurements
//! take frame 0.

pub mod forest;
mod large;
pub mod moving;
mod robots;
pub mod spheres;

use crate::rays::View;
use glam::{Affine3A, Vec3};
use openrt::scene::Motion;

/// Frames of an animation; frame 0 is the first.
pub const FRAMES: u32 = 20;

/// A mesh, whose vertices may move.
pub struct Part {
    pub triangles: Vec<[u32; 3]>,
    /// Positions at a frame, always as many.
    pub positions: Box<dyn Fn(u32) -> Vec<Vec3> + Send + Sync>,
    pub motion: Motion,
}

impl Part {
    /// A mesh that keeps its shape.
    pub fn rigid(mesh: openrt::scene::Mesh, motion: Motion) -> Part {
        let positions = mesh.positions;
        Part { triangles: mesh.triangles, positions: Box::new(move |_| positions.clone()), motion }
    }
}

/// Where a part stands.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    pub part: usize,
    pub transform: Affine3A,
}

/// A scene, its camera and its lamp.
pub struct BenchScene {
    pub name: &'static str,
    pub title: &'static str,
    pub parts: Vec<Part>,
    /// Placements at a frame, always as many. Scenes without instances place every part once, where it is.
    pub place: Box<dyn Fn(u32) -> Vec<Placement> + Send + Sync>,
    /// Whether a peer had better use instances as well, instead of one structure over all parts.
    pub instanced: bool,
    pub view: View,
    pub light: Vec3,
    /// Of pictures; quick runs take the first alone.
    pub sizes: Vec<[u32; 2]>,
}

impl BenchScene {
    /// Triangles of all parts.
    pub fn triangles(&self) -> usize {
        self.parts.iter().map(|p| p.triangles.len()).sum()
    }

    /// Triangles of all instances.
    pub fn triangles_shown(&self, frame: u32) -> usize {
        (self.place)(frame).iter().map(|p| self.parts[p.part].triangles.len()).sum()
    }
}

/// Every part once, untransformed.
pub fn in_place(count: usize) -> Box<dyn Fn(u32) -> Vec<Placement> + Send + Sync> {
    Box::new(move |_| (0..count).map(|part| Placement { part, transform: Affine3A::IDENTITY }).collect())
}

pub type Make = fn() -> BenchScene;

/// Those of `dynamic` alone.
pub const LARGE: [(&str, Make); 2] = [("CROWD", large::crowd), ("SCULPT", large::sculpt)];

/// Names and generators.
pub const ALL: [(&str, Make); 7] = [
    ("S1", spheres::bumpy_sphere),
    ("S2", robots::robots),
    ("S3", forest::forest),
    ("S4", moving::soup),
    ("S5", spheres::blobs),
    ("S6", moving::cloth),
    ("S7", spheres::small_spheres),
];
