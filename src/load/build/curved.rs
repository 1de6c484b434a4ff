//! Spheres, cones and cylinders: triangles of one unit surface, placed as often as there are some of its kind.
//!
//! A unit sphere has 32 × 16 latitude–longitude patches (960 triangles), a unit cone 32 × 1 without end caps (64 triangles), with the exact
//! normals of the curved surface at the vertices: shading is smooth, only the silhouette shows the facets. Vertices are shared,
//! so the meshes have no cracks. Surfaces of one kind and material at one node are one object with many places of 48 bytes. Where a file
//! has so many kinds or materials that the triangles would outgrow it, all its surfaces get half or a quarter as many segments.

use crate::load::model::{Deform, Mesh, Object};
use glam::{Affine3, DAffine3, DMat3, DVec3, Vec2, Vec3};
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Edges of a full circle, from the finest to the coarsest.
const SEGMENTS: [u32; 3] = [32, 16, 8];

/// Triangles of all objects together, at most, before the next coarser circle is taken.
const MOST_TRIANGLES: usize = 1 << 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CurvedKind {
    shape: Shape,
    /// Normals and front sides point inwards. No placement does that: a mirrored sphere is a sphere.
    inside: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Shape {
    /// Of radius 1 around the origin.
    Sphere,
    /// Around the z axis, of radius 1 at z = 0 and of the radius with these bits, 0 to 1, at z = 1.
    Cone { top: u32 },
}

/// A surface: what it is and where.
#[derive(Clone, Copy, Debug)]
pub struct Curved {
    pub kind: CurvedKind,
    pub placement: DAffine3,
}

impl Curved {
    /// A sphere; a negative radius (seen from inside only) turns the normals inwards.
    pub fn sphere(center: Vec3, radius: f32) -> Self {
        let scale = DMat3::from_diagonal(DVec3::splat(radius.abs().into()));
        let placement = DAffine3::from_mat3_translation(scale, center.as_dvec3());
        Self { kind: CurvedKind { shape: Shape::Sphere, inside: radius < 0.0 }, placement }
    }

    /// A cone or cylinder around the axis from `base` to `apex`, without end caps; negative radii turn it inside out. `None`
    /// when base and apex coincide, which gives no direction, or both radii are 0.
    pub fn cone(base: Vec3, base_radius: f32, apex: Vec3, apex_radius: f32) -> Option<Self> {
        let inside = base_radius < 0.0 || apex_radius < 0.0;
        let (mut r0, mut r1) = (base_radius.abs(), apex_radius.abs());
        let (mut from, mut to) = (base.as_dvec3(), apex.as_dvec3());
        // The thicker end is the unit circle.
        if r1 > r0 {
            (r0, r1, from, to) = (r1, r0, to, from);
        }
        let axis = to - from;
        let direction = axis.try_normalize().filter(|_| r0 > 0.0)?;
        let (x, y) = direction.any_orthonormal_pair();
        let radius = f64::from(r0);
        let placement = DAffine3 { matrix3: DMat3::from_cols(x * radius, y * radius, axis), translation: from };
        Some(Self { kind: CurvedKind { shape: Shape::Cone { top: (r1 / r0).to_bits() }, inside }, placement })
    }
}

/// Places of one object.
struct Places {
    node: u32,
    kind: CurvedKind,
    material: u32,
    copies: Vec<Affine3>,
}

/// The curved surfaces of a scene.
#[derive(Default)]
pub struct CurvedObjects {
    objects: Vec<Places>,
    index: HashMap<(u32, CurvedKind, u32), usize>,
    count: usize,
}

impl CurvedObjects {
    pub fn add(&mut self, node: u32, placement: DAffine3, kind: CurvedKind, material: u32) {
        let next = self.objects.len();
        let index = *self.index.entry((node, kind, material)).or_insert(next);
        if index == next {
            self.objects.push(Places { node, kind, material, copies: Vec::new() });
        }
        self.objects[index].copies.push(placement.as_affine3());
        self.count += 1;
    }

    pub fn len(&self) -> usize {
        self.count
    }

    /// One object for each kind and material at a node.
    pub fn finish(self, name_of_node: impl Fn(u32) -> String) -> Vec<Object> {
        let triangles = |segments| self.objects.iter().map(|p| triangle_count(p.kind, segments)).sum::<usize>();
        let coarsest = SEGMENTS[SEGMENTS.len() - 1];
        let segments = SEGMENTS.into_iter().find(|&s| triangles(s) <= MOST_TRIANGLES).unwrap_or(coarsest);
        let mut meshes: HashMap<CurvedKind, Arc<Mesh>> = HashMap::new();
        let places = self.objects.into_iter();
        places
            .map(|places| {
                let mesh = meshes.entry(places.kind).or_insert_with(|| Arc::new(mesh(places.kind, segments)));
                let what = match places.kind.shape {
                    Shape::Sphere => "spheres",
                    Shape::Cone { .. } => "cones",
                };
                Object {
                    name: format!("{}, {what}", name_of_node(places.node)),
                    node: places.node,
                    mesh: mesh.clone(),
                    material: Some(places.material),
                    deform: Deform::Rigid,
                    copies: places.copies,
                }
            })
            .collect()
    }
}

fn triangle_count(kind: CurvedKind, segments: u32) -> usize {
    match kind.shape {
        Shape::Sphere => (segments * (segments - 2)) as usize,
        Shape::Cone { .. } => 2 * segments as usize,
    }
}

fn mesh(kind: CurvedKind, segments: u32) -> Mesh {
    let mut mesh = match kind.shape {
        Shape::Sphere => sphere(segments),
        Shape::Cone { top } => cone(f32::from_bits(top), segments),
    };
    if kind.inside {
        mesh.normals.iter_mut().for_each(|n| *n = -*n);
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}

/// Unit circle point number `i`; bit-equal for i and i + segments.
fn circle(i: u32, segments: u32) -> Vec2 {
    Vec2::from_angle(TAU * (i % segments) as f32 / segments as f32)
}

fn sphere(segments: u32) -> Mesh {
    let stacks = segments / 2;
    let mut points = vec![Vec3::Y];
    for stack in 1..stacks {
        let (sine, cosine) = (PI * stack as f32 / stacks as f32).sin_cos();
        for i in 0..segments {
            let c = circle(i, segments);
            points.push(Vec3::new(c.x * sine, cosine, c.y * sine));
        }
    }
    points.push(Vec3::NEG_Y);
    let south = points.len() as u32 - 1;
    let at = |stack: u32, i: u32| 1 + (stack - 1) * segments + i % segments;
    let mut triangles = Vec::new();
    for i in 0..segments {
        triangles.push([0, at(1, i + 1), at(1, i)]);
        for stack in 1..stacks - 1 {
            let (a, b, c, d) = (at(stack, i), at(stack, i + 1), at(stack + 1, i + 1), at(stack + 1, i));
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
        triangles.push([south, at(stacks - 1, i), at(stacks - 1, i + 1)]);
    }
    Mesh { normals: points.clone(), positions: points, triangles, ..Mesh::default() }
}

fn cone(top: f32, segments: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for (z, radius) in [(0.0, 1.0), (1.0, top)] {
        for i in 0..segments {
            let c = circle(i, segments);
            mesh.positions.push((c * radius).extend(z));
            // It leans towards the thinner end.
            mesh.normals.push(c.extend(1.0 - top).normalize());
        }
    }
    for i in 0..segments {
        let (a, b) = (i, (i + 1) % segments);
        let (d, c) = (a + segments, b + segments);
        mesh.triangles.push([a, b, c]);
        // The tip of a cone has no second one.
        mesh.triangles.push([a, c, d]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPHERE: CurvedKind = CurvedKind { shape: Shape::Sphere, inside: false };

    /// Corners and normals of every triangle as the placement puts them.
    fn placed(curved: &Curved) -> Vec<[(Vec3, Vec3); 3]> {
        let mesh = mesh(curved.kind, SEGMENTS[0]);
        let normal = curved.placement.matrix3.inverse().transpose();
        let vertex = |i: u32| {
            let p = curved.placement.transform_point3(mesh.positions[i as usize].as_dvec3()).as_vec3();
            (p, (normal * mesh.normals[i as usize].as_dvec3()).normalize().as_vec3())
        };
        mesh.triangles.iter().map(|t| t.map(vertex)).collect()
    }

    /// The corners run anticlockwise around their normals, apart from triangles without area.
    fn consistent(curved: &Curved) -> bool {
        let sides = placed(curved).into_iter().map(|[a, b, c]| (b.0 - a.0).cross(c.0 - a.0).dot(a.1 + b.1 + c.1));
        let sides: Vec<f32> = sides.collect();
        sides.iter().all(|&s| s > -1e-6) && sides.iter().any(|&s| s > 1e-3)
    }

    #[test]
    fn spheres_are_closed_and_face_outwards() {
        for segments in SEGMENTS {
            let mesh = sphere(segments);
            assert_eq!(mesh.triangles.len(), triangle_count(SPHERE, segments));
            // Every edge is used once in each direction.
            let edges = mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
            let mut edges: Vec<_> = edges.collect();
            edges.sort_unstable();
            assert!(edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok()));
            assert!(edges.windows(2).all(|w| w[0] != w[1]));
        }
        let center = Vec3::new(1.0, 2.0, 3.0);
        let s = Curved::sphere(center, 2.0);
        assert!(consistent(&s));
        assert!(placed(&s).iter().flatten().all(|(p, n)| (*p - center - *n * 2.0).length() < 1e-5));
        let inside = Curved::sphere(center, -2.0);
        assert!(consistent(&inside));
        assert!(placed(&inside).iter().flatten().all(|(p, n)| (*p - center + *n * 2.0).length() < 1e-5));
    }

    #[test]
    fn cones_face_outwards_and_lean() {
        for axis in [Vec3::X, Vec3::NEG_Y, Vec3::new(1.0, -2.0, 0.5)] {
            for (r0, r1) in [(2.0, 1.0), (1.0, 2.0), (1.0, 1.0), (0.5, 0.0), (0.0, 0.5)] {
                let c = Curved::cone(Vec3::ONE, r0, Vec3::ONE + axis, r1).unwrap();
                assert!(consistent(&c), "{axis} {r0} {r1}");
                let along = axis.normalize();
                for (p, n) in placed(&c).iter().flatten() {
                    // On the surface, and the normal is at right angles to the line that makes it.
                    let height = (*p - Vec3::ONE).dot(along) / axis.length();
                    let out = (*p - Vec3::ONE) - along * height * axis.length();
                    assert!((out.length() - (r0 + (r1 - r0) * height)).abs() < 1e-5, "{axis} {r0} {r1}");
                    assert!((n.dot(along) * axis.length() - n.reject_from(along).length() * (r0 - r1)).abs() < 1e-5);
                }
            }
        }
        let inside = Curved::cone(Vec3::ZERO, -1.0, Vec3::Y, -1.0).unwrap();
        assert!(consistent(&inside));
        assert!(placed(&inside).iter().flatten().all(|(p, n)| p.reject_from(Vec3::Y).dot(*n) < 0.0));
        assert!(Curved::cone(Vec3::ONE, 1.0, Vec3::ONE, 2.0).is_none());
        assert!(Curved::cone(Vec3::ONE, 0.0, Vec3::X, 0.0).is_none());
    }

    #[test]
    fn many_materials_make_coarser_surfaces() {
        let objects = |materials: u32| {
            let mut all = CurvedObjects::default();
            for material in 0..materials {
                all.add(0, DAffine3::IDENTITY, SPHERE, material);
                all.add(0, DAffine3::IDENTITY, SPHERE, material);
            }
            all.finish(|_| "world".into())
        };
        let few = objects(3);
        assert_eq!((few.len(), few[0].copies.len(), few[0].mesh.triangles.len()), (3, 2, 960));
        assert!(Arc::ptr_eq(&few[0].mesh, &few[2].mesh));
        assert_eq!(objects(3000)[0].mesh.triangles.len(), 224);
        assert_eq!(objects(30_000)[0].mesh.triangles.len(), 48);
    }
}
