//! Triangles of one object and the ways in which they change with time.

use super::{Local, Node, Pose};
use glam::{Affine3, DAffine3, Mat4, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Indexed triangles. An attribute is empty or has one entry per position.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub tex_coords: Vec<Vec2>,
    pub colors: Vec<Vec4>,
    /// Every index is below `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
    /// One index into `SceneFile::materials` per triangle.
    pub materials: Vec<u32>,
}

/// State of a key-framed triangle at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleKey {
    pub time: f64,
    pub positions: [Vec3; 3],
    pub normals: [Vec3; 3],
}

/// A triangle of AFF `tpa`: linear between its keys, clamped outside. Not empty, ascending times.
#[derive(Clone, Debug)]
pub struct KeyedTriangle {
    pub keys: Vec<TriangleKey>,
}

impl KeyedTriangle {
    /// Corners and unit normals at `time`.
    pub fn at(&self, time: f64) -> ([Vec3; 3], [Vec3; 3]) {
        let next = self.keys.partition_point(|k| k.time <= time);
        let a = &self.keys[next.saturating_sub(1)];
        let b = &self.keys[next.min(self.keys.len() - 1)];
        let length = b.time - a.time;
        let u = if length > 0.0 { ((time - a.time) / length) as f32 } else { 0.0 };
        let mix = |a: [Vec3; 3], b: [Vec3; 3]| [0, 1, 2].map(|i| a[i].lerp(b[i], u));
        let positions = mix(a.positions, b.positions);
        // Opposite normals cancel half-way; the triangle's own normal is then the only sensible one.
        let flat = (positions[1] - positions[0]).cross(positions[2] - positions[0]).normalize_or(Vec3::Y);
        (positions, mix(a.normals, b.normals).map(|n| n.normalize_or(flat)))
    }
}

/// Displacements of one morph target; empty or one per vertex.
#[derive(Clone, Debug, Default)]
pub struct MorphTarget {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
}

/// Linear blend skinning.
#[derive(Clone, Debug)]
pub struct Skin {
    pub joints: Vec<u32>,
    pub inverse_bind: Vec<Mat4>,
    /// Per vertex: four indices into `joints`, all valid.
    pub indices: Vec<[u16; 4]>,
    pub weights: Vec<Vec4>,
}

#[derive(Clone, Debug, Default)]
pub enum Deform {
    #[default]
    Rigid,
    /// One entry per triangle; triangle i uses vertices 3i, 3i + 1 and 3i + 2.
    Triangles(Vec<KeyedTriangle>),
    /// Morph targets with their rest weights, then a skin.
    Blend { targets: Vec<MorphTarget>, weights: Vec<f32>, skin: Option<Skin> },
}

/// Geometry that hangs on one node.
#[derive(Clone, Debug)]
pub struct Object {
    pub name: String,
    pub node: u32,
    /// Shared by objects that differ in their material only.
    pub mesh: Arc<Mesh>,
    /// Material of all triangles, in place of the mesh's own.
    pub material: Option<u32>,
    pub deform: Deform,
    /// Where it stands relative to the node; empty for once, at the node itself.
    pub copies: Vec<Affine3>,
}

/// Vertices of a deformed object, in object space.
#[derive(Clone, Debug)]
pub struct Deformed {
    pub positions: Vec<Vec3>,
    /// Empty when the object has no normals.
    pub normals: Vec<Vec3>,
}

impl Object {
    /// An object that stands once, at its node.
    pub fn new(name: String, node: u32, mesh: Mesh, deform: Deform) -> Self {
        Self { name, node, mesh: Arc::new(mesh), material: None, deform, copies: Vec::new() }
    }

    /// How often the object stands in the scene.
    pub fn count(&self) -> usize {
        self.copies.len().max(1)
    }

    /// Where it stands in the world, once or more often.
    pub fn placements(&self, poses: &[Pose]) -> impl Iterator<Item = DAffine3> + '_ {
        let world = self.world_from_object(poses);
        let once = self.copies.is_empty().then_some(world);
        once.into_iter().chain(self.copies.iter().map(move |copy| world * copy.as_daffine3()))
    }

    /// Placement of the object without its copies; a skinned mesh is placed by its joints alone.
    pub fn world_from_object(&self, poses: &[Pose]) -> DAffine3 {
        match &self.deform {
            Deform::Blend { skin: Some(_), .. } => DAffine3::IDENTITY,
            _ => poses.get(self.node as usize).map_or(DAffine3::IDENTITY, |p| p.world),
        }
    }

    /// Vertices at `time`; `None` for a rigid object.
    pub fn deformed(&self, time: f64, poses: &[Pose], nodes: &[Node]) -> Option<Deformed> {
        match &self.deform {
            Deform::Rigid => None,
            Deform::Triangles(triangles) => {
                let mut positions = Vec::with_capacity(triangles.len() * 3);
                let mut normals = Vec::with_capacity(triangles.len() * 3);
                for triangle in triangles {
                    let (p, n) = triangle.at(time);
                    positions.extend(p);
                    normals.extend(n);
                }
                Some(Deformed { positions, normals })
            }
            Deform::Blend { targets, weights, skin } => {
                let driven = match &nodes[self.node as usize].local {
                    Local::Channels(channels) => channels.weights.as_ref().map(|t| t.floats(time)),
                    _ => None,
                };
                let weights = driven.as_deref().unwrap_or(weights);
                let mut positions = self.mesh.positions.clone();
                let mut normals = self.mesh.normals.clone();
                for (target, &weight) in targets.iter().zip(weights) {
                    add_scaled(&mut positions, &target.positions, weight);
                    add_scaled(&mut normals, &target.normals, weight);
                }
                if let Some(skin) = skin {
                    skin.apply(poses, &mut positions, &mut normals);
                }
                Some(Deformed { positions, normals })
            }
        }
    }
}

fn add_scaled(values: &mut [Vec3], deltas: &[Vec3], weight: f32) {
    for (value, delta) in values.iter_mut().zip(deltas) {
        *value += *delta * weight;
    }
}

impl Skin {
    /// Moves vertices from the mesh's space to world space.
    fn apply(&self, poses: &[Pose], positions: &mut [Vec3], normals: &mut [Vec3]) {
        let joints: Vec<Mat4> = self
            .joints
            .iter()
            .zip(&self.inverse_bind)
            .map(|(&joint, inverse)| match poses.get(joint as usize) {
                Some(pose) => Mat4::from(pose.world.as_affine3()) * *inverse,
                None => Mat4::IDENTITY,
            })
            .collect();
        for (v, position) in positions.iter_mut().enumerate() {
            let (Some(indices), Some(weights)) = (self.indices.get(v), self.weights.get(v)) else { continue };
            let total: f32 = weights.element_sum();
            let mut blended = Mat4::ZERO;
            for (i, &joint) in indices.iter().enumerate() {
                let weight = if total > 0.0 { weights[i] / total } else { f32::from(i == 0) };
                if let Some(matrix) = joints.get(usize::from(joint)) {
                    blended += *matrix * weight;
                }
            }
            *position = blended.transform_point3(*position);
            if let Some(normal) = normals.get_mut(v) {
                // Joints are close to rigid: the blended matrix itself turns the normal well enough.
                *normal = blended.transform_vector3(*normal).normalize_or_zero();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keyed_triangle_is_linear_and_clamped() {
        let key = |time, x: f32, n: Vec3| TriangleKey {
            time,
            positions: [Vec3::X * x, Vec3::X * x + Vec3::X, Vec3::X * x + Vec3::Y],
            normals: [n; 3],
        };
        let t = KeyedTriangle { keys: vec![key(0.0, 0.0, Vec3::Z * 0.01), key(2.0, 4.0, Vec3::X * 0.01)] };
        assert_eq!(t.at(-1.0), t.at(0.0));
        assert_eq!(t.at(9.0).0[0], Vec3::X * 4.0);
        let (p, n) = t.at(1.0);
        assert_eq!(p[0], Vec3::X * 2.0);
        assert!((n[0] - Vec3::new(0.5, 0.0, 0.5).normalize()).length() < 1e-6, "re-normalised");
        let flipping = KeyedTriangle { keys: vec![key(0.0, 0.0, Vec3::Z), key(2.0, 0.0, Vec3::NEG_Z)] };
        assert!(flipping.at(1.0).1[0].is_normalized());
    }
}
