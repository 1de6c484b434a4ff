//! S2: ten articulated figures of 16 parts, standing around on a floor: 161 instances of 11 meshes.

use super::{BenchScene, FRAMES, Part, Placement};
use crate::meshes::{moved, uv_sphere};
use crate::rays::View;
use glam::{Affine3A, Mat3, Quat, Vec3};
use openrt::scene::{Mesh, Motion};
use std::f32::consts::{PI, TAU};

/// A body with rounded corners that fills `half` on each side of the origin: a sphere pushed outwards. `edge` below 1 is boxier.
fn body(half: Vec3, edge: f32, rings: u32, around: u32) -> Mesh {
    moved(uv_sphere(rings, around), |p| p.map(|x| x.signum() * x.abs().powf(edge)) * half)
}

/// A limb: a body that hangs down from the origin.
fn limb(length: f32, thick: f32, around: u32) -> Mesh {
    let half = Vec3::new(thick, length * 0.5 + thick * 0.5, thick);
    moved(body(half, 0.6, 20, around), |p| p - Vec3::Y * (length * 0.5))
}

/// Numbers of the parts.
const FLOOR: usize = 0;
const PELVIS: usize = 1;
const TORSO: usize = 2;
const HEAD: usize = 3;
const PACK: usize = 4;
const UPPER_ARM: usize = 5;
const LOWER_ARM: usize = 6;
const HAND: usize = 7;
const THIGH: usize = 8;
const SHIN: usize = 9;
const FOOT: usize = 10;

fn meshes() -> Vec<Mesh> {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let floor = Mesh {
        positions: corners.iter().map(|&(x, z)| Vec3::new(x, 0.0, z) * 30.0).collect(),
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        ..Mesh::default()
    };
    vec![
        floor,
        body(Vec3::new(0.22, 0.14, 0.15), 0.5, 16, 22),
        body(Vec3::new(0.30, 0.36, 0.18), 0.5, 24, 36),
        body(Vec3::new(0.15, 0.19, 0.17), 0.8, 22, 34),
        body(Vec3::new(0.18, 0.22, 0.10), 0.3, 14, 20),
        limb(0.36, 0.08, 17),
        limb(0.34, 0.07, 17),
        body(Vec3::new(0.06, 0.10, 0.08), 0.7, 14, 18),
        limb(0.48, 0.10, 18),
        limb(0.46, 0.08, 18),
        body(Vec3::new(0.08, 0.06, 0.17), 0.5, 12, 18),
    ]
}

/// The 16 parts of the figure with this number, in a walk at phase `time`.
fn figure(number: usize, time: f32) -> Vec<Placement> {
    let phase = time * TAU + number as f32 * 0.9;
    let turn = number as f32 * 2.4;
    let at = Vec3::new((number % 5) as f32 * 1.5 - 3.0, 0.0, (number / 5) as f32 * -2.0 + (number % 2) as f32 * 0.8);
    let shift = |v: Vec3| Affine3A::from_translation(v);
    let swing = |angle: f32| Affine3A::from_quat(Quat::from_rotation_x(angle));
    let base =
        shift(at) * Affine3A::from_quat(Quat::from_rotation_y(turn)) * shift(Vec3::Y * (0.03 * (2.0 * phase).sin()));
    let pelvis = base * shift(Vec3::Y * 1.05);
    let torso = pelvis * Affine3A::from_quat(Quat::from_rotation_y(0.15 * phase.sin())) * shift(Vec3::Y * 0.46);
    let mut parts = vec![
        Placement { part: PELVIS, transform: pelvis },
        Placement { part: TORSO, transform: torso },
        Placement { part: HEAD, transform: torso * shift(Vec3::Y * 0.56) },
        Placement { part: PACK, transform: torso * shift(Vec3::new(0.0, 0.05, -0.27)) },
    ];
    for side in [-1.0f32, 1.0] {
        let arm = torso * shift(Vec3::new(side * 0.37, 0.28, 0.0)) * swing(side * 0.6 * phase.sin());
        let fore = arm * shift(Vec3::Y * -0.42) * swing(-0.5 - 0.3 * (side * phase.sin()).max(0.0));
        let leg = pelvis * shift(Vec3::new(side * 0.13, -0.10, 0.0)) * swing(-side * 0.5 * phase.sin());
        let shin = leg * shift(Vec3::Y * -0.50) * swing(0.15 + 0.4 * (side * phase.cos()).max(0.0));
        // A mirrored foot, for the sign of a determinant.
        let mirror = Affine3A::from_mat3(Mat3::from_diagonal(Vec3::new(side, 1.0, 1.0)));
        parts.extend([
            Placement { part: UPPER_ARM, transform: arm },
            Placement { part: LOWER_ARM, transform: fore },
            Placement { part: HAND, transform: fore * shift(Vec3::Y * -0.45) },
            Placement { part: THIGH, transform: leg },
            Placement { part: SHIN, transform: shin },
            Placement { part: FOOT, transform: shin * shift(Vec3::new(0.0, -0.47, 0.07)) * mirror },
        ]);
    }
    parts
}

pub fn robots() -> BenchScene {
    let place = |frame: u32| {
        let time = (frame % FRAMES) as f32 / FRAMES as f32;
        let floor = Placement { part: FLOOR, transform: Affine3A::IDENTITY };
        std::iter::once(floor).chain((0..10).flat_map(|i| figure(i, time))).collect()
    };
    BenchScene {
        name: "S2",
        title: "ten figures of instanced parts",
        parts: meshes().into_iter().map(|mesh| Part::rigid(mesh, Motion::Affine)).collect(),
        place: Box::new(place),
        instanced: true,
        view: View { eye: Vec3::new(1.0, 2.2, 5.5), at: Vec3::new(0.0, 0.8, -0.8), degrees: PI.to_degrees() / 4.0 },
        light: Vec3::new(4.0, 6.0, 5.0),
        sizes: vec![[640, 480]],
    }
}
