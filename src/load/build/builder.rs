//! Collects triangles per node and materials without repeats, and turns both into objects.

use super::curved::{Curved, CurvedObjects};
use crate::load::model::{Deform, KeyedTriangle, Material, Mesh, Object, TriangleKey};
use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use std::collections::HashMap;

/// A static transform for points and normals.
#[derive(Clone, Copy, Debug)]
pub struct Baked {
    matrix: DAffine3,
    /// Transposed inverse of the linear part, up to a positive factor.
    normal: DMat3,
    /// The transform mirrors: triangles must be turned over to keep their outside.
    mirrors: bool,
}

impl Baked {
    pub fn new(matrix: DAffine3) -> Self {
        let m = matrix.matrix3;
        // Rows of the adjugate: the inverse times the determinant, and defined for singular matrices too.
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let mirrors = m.determinant() < 0.0;
        Self { matrix, normal: if mirrors { -cofactors } else { cofactors }, mirrors }
    }

    pub fn matrix(&self) -> DAffine3 {
        self.matrix
    }

    pub fn point(&self, p: Vec3) -> Vec3 {
        self.matrix.transform_point3(p.as_dvec3()).as_vec3()
    }

    /// Unit normal, or zero when it has no direction.
    pub fn normal(&self, n: Vec3) -> Vec3 {
        let n: DVec3 = self.normal * n.as_dvec3();
        // Scale first: BART scales toy parts by 10⁻³ and the cofactors by the square of that.
        let largest = n.abs().max_element();
        if largest > 0.0 && largest.is_finite() { (n / largest).normalize().as_vec3() } else { Vec3::ZERO }
    }

    pub fn ordered<T: Copy>(&self, [a, b, c]: [T; 3]) -> [T; 3] {
        if self.mirrors { [a, c, b] } else { [a, b, c] }
    }
}

/// A corner before it is transformed.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    pub position: Vec3,
    /// `None`: the triangle's own normal.
    pub normal: Option<Vec3>,
    pub tex_coord: Vec2,
}

/// Geometry of one node in the making.
#[derive(Default)]
struct Part {
    mesh: Mesh,
    keyed: Vec<KeyedTriangle>,
    keyed_materials: Vec<u32>,
}

#[derive(Default)]
pub struct Builder {
    /// One for each node that has geometry, in the order of first use.
    parts: Vec<(u32, Part)>,
    part_of_node: HashMap<u32, usize>,
    curved: CurvedObjects,
}

impl Builder {
    fn part(&mut self, node: u32) -> &mut Part {
        let next = self.parts.len();
        let index = *self.part_of_node.entry(node).or_insert(next);
        if index == next {
            self.parts.push((node, Part::default()));
        }
        &mut self.parts[index].1
    }

    /// Adds triangles given by indices into `corners`. Corners with a normal are shared; flat triangles get corners of
    /// their own, because their normals differ.
    pub fn add(&mut self, node: u32, baked: &Baked, corners: &[Corner], triangles: &[[u32; 3]], material: u32) {
        let mesh = &mut self.part(node).mesh;
        let mut shared: HashMap<u32, u32> = HashMap::new();
        for &triangle in triangles {
            let triangle = baked.ordered(triangle);
            let points = triangle.map(|i| baked.point(corners[i as usize].position));
            let flat = (points[1] - points[0]).as_dvec3().cross((points[2] - points[0]).as_dvec3());
            let flat = flat.normalize_or_zero().as_vec3();
            let indices: [u32; 3] = std::array::from_fn(|k| {
                let corner = &corners[triangle[k] as usize];
                let mut push = |normal: Vec3| {
                    mesh.positions.push(points[k]);
                    mesh.normals.push(normal);
                    mesh.tex_coords.push(corner.tex_coord);
                    mesh.positions.len() as u32 - 1
                };
                match corner.normal {
                    None => push(flat),
                    Some(n) => *shared.entry(triangle[k]).or_insert_with(|| {
                        let normal = baked.normal(n);
                        push(if normal == Vec3::ZERO { flat } else { normal })
                    }),
                }
            });
            mesh.triangles.push(indices);
            mesh.materials.push(material);
        }
    }

    pub fn add_keyed(&mut self, node: u32, baked: &Baked, mut keys: Vec<TriangleKey>, material: u32) {
        for key in &mut keys {
            key.positions = baked.ordered(key.positions.map(|p| baked.point(p)));
            key.normals = baked.ordered(key.normals.map(|n| baked.normal(n)));
        }
        let part = self.part(node);
        part.keyed.push(KeyedTriangle { keys });
        part.keyed_materials.push(material);
    }

    /// Adds a curved surface: one more place of an object that all surfaces of its kind and material share.
    pub fn add_curved(&mut self, node: u32, baked: &Baked, curved: &Curved, material: u32) {
        self.curved.add(node, baked.matrix() * curved.placement, curved.kind, material);
    }

    /// Number of triangles so far, key-framed ones included; a curved surface counts as one.
    pub fn len(&self) -> usize {
        self.parts.iter().map(|(_, p)| p.mesh.triangles.len() + p.keyed.len()).sum::<usize>() + self.curved.len()
    }

    /// One rigid object per node, one of key-framed triangles where there are any, and one for each kind and material of
    /// curved surfaces at a node.
    pub fn finish(self, name_of_node: impl Fn(u32) -> String) -> Vec<Object> {
        let mut objects = Vec::new();
        for (node, part) in self.parts {
            let name = name_of_node(node);
            if !part.mesh.triangles.is_empty() {
                objects.push(Object::new(name.clone(), node, part.mesh, Deform::Rigid));
            }
            if !part.keyed.is_empty() {
                let mut mesh = Mesh { materials: part.keyed_materials, ..Mesh::default() };
                for triangle in &part.keyed {
                    let first = mesh.positions.len() as u32;
                    let (positions, normals) = triangle.at(f64::NEG_INFINITY);
                    mesh.positions.extend(positions);
                    mesh.normals.extend(normals);
                    mesh.triangles.push([first, first + 1, first + 2]);
                }
                let deform = Deform::Triangles(part.keyed);
                objects.push(Object::new(format!("{name}, key-framed"), node, mesh, deform));
            }
        }
        objects.extend(self.curved.finish(name_of_node));
        objects
    }
}

/// Materials without repeats; the index of the first equal one is used.
pub struct MaterialTable {
    pub materials: Vec<Material>,
    by_bits: HashMap<Vec<u32>, u32>,
}

impl MaterialTable {
    pub fn new(first: Material) -> Self {
        let mut table = Self { materials: Vec::new(), by_bits: HashMap::new() };
        table.index(&first);
        table
    }

    pub fn index(&mut self, material: &Material) -> u32 {
        let m = material;
        let mut bits = Vec::with_capacity(20);
        for v in [m.emission, m.ambient, m.diffuse, m.specular, m.reflection] {
            bits.extend(v.to_array().map(f32::to_bits));
        }
        bits.extend([m.shininess, m.transmission, m.ior].map(f32::to_bits));
        bits.push(m.texture.map_or(0, |t| t + 1));
        bits.push(m.alpha_cutoff.map_or(u32::MAX, f32::to_bits));
        let next = self.materials.len() as u32;
        let index = *self.by_bits.entry(bits).or_insert(next);
        if index == next {
            self.materials.push(material.clone());
        }
        index
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrored_parts_keep_their_outside() {
        let mut builder = Builder::default();
        let baked = Baked::new(DAffine3::from_scale(DVec3::new(-1.0, 2.0, 1e-3)));
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Z].map(|position| Corner {
            position,
            normal: Some(Vec3::NEG_Y),
            tex_coord: Vec2::ZERO,
        });
        builder.add(0, &baked, &corners, &[[0, 1, 2]], 0);
        let objects = builder.finish(|_| "part".into());
        let mesh = &objects[0].mesh;
        let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
        assert_eq!((b - a).cross(c - a).normalize(), Vec3::NEG_Y);
        assert_eq!(mesh.normals[0], Vec3::NEG_Y);
    }

    #[test]
    fn normals_follow_the_inverse_transpose() {
        let baked = Baked::new(DAffine3::from_scale(DVec3::new(1.0, 10.0, 1.0)));
        let n = baked.normal(Vec3::new(1.0, 1.0, 0.0).normalize());
        assert!((n - Vec3::new(10.0, 1.0, 0.0).normalize()).length() < 1e-6);
        assert_eq!(Baked::new(DAffine3::from_scale(DVec3::ZERO)).normal(Vec3::X), Vec3::ZERO);
    }

    #[test]
    fn equal_materials_are_one() {
        let mut table = MaterialTable::new(Material::default());
        let red = Material { diffuse: Vec3::X, ..Material::default() };
        assert_eq!((table.index(&Material::default()), table.index(&red), table.index(&red)), (0, 1, 1));
    }
}
