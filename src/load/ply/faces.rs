//! The elements `face` and `tristrips`, as triangles.

use super::header::Element;
use super::values::Values;
use super::vertices::{Vertices, channel, full};
use crate::load::LoadError;
use crate::load::build::polygon;
use crate::load::model::Mesh;
use crate::load::report::Report;
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// What makes a vertex of the mesh where faces have attributes of their own: the file's vertex, bits of the
/// texture coordinate, and the colour.
type Key = (u32, [u32; 2], u32);

/// A face being read.
#[derive(Default)]
struct Face {
    /// −1 restarts a strip.
    indices: Vec<i64>,
    tex_coords: Vec<f32>,
    texture: u32,
    color: [f32; 4],
}

/// Makes the mesh.
pub struct Faces<'a> {
    vertices: Vertices,
    report: &'a mut Report,
    mesh: Mesh,
    known: HashMap<Key, u32>,
    /// Corners of the faces that use a vertex without a place.
    points: Vec<Vec3>,
    /// Faces have texture coordinates or colours of their own, so vertices are made for them.
    own_corners: bool,
    /// Faces have colours.
    face_colors: bool,
    /// Number of textures that the file names.
    textures: usize,
}

/// What a property of a face means.
#[derive(Clone, Copy, PartialEq)]
enum Slot {
    Indices,
    TexCoords,
    Texture,
    Color(usize, f32),
    Unused,
}

impl<'a> Faces<'a> {
    pub fn new(vertices: Vertices, textures: usize, report: &'a mut Report) -> Self {
        Self {
            vertices,
            report,
            mesh: Mesh::default(),
            known: HashMap::new(),
            points: Vec::new(),
            own_corners: false,
            face_colors: false,
            textures,
        }
    }

    /// Reads an element of faces or strips; names of properties that mean nothing here are added to `unused`.
    pub fn read(&mut self, element: &Element, values: &mut Values, unused: &mut Vec<String>) -> Result<(), LoadError> {
        let strips = element.name == "tristrips";
        // Colours of the vertices say more than those of the faces.
        let colors = self.vertices.colors.is_empty() && ["red", "green", "blue"].iter().all(|n| element.has(n));
        let slot = |p: &super::header::Property| match (p.name.as_str(), p.list) {
            ("vertex_indices" | "vertex_index", Some(_)) => Slot::Indices,
            ("texcoord", Some(_)) if self.textures > 0 && !strips => Slot::TexCoords,
            ("texnumber" | "tex_number", None) if self.textures > 0 => Slot::Texture,
            (name, None) if colors => channel(name).map_or(Slot::Unused, |c| Slot::Color(c, full(p.kind))),
            _ => Slot::Unused,
        };
        let slots: Vec<Slot> = element.properties.iter().map(slot).collect();
        let left_out = element.properties.iter().zip(&slots).filter(|(_, s)| **s == Slot::Unused);
        unused.extend(left_out.map(|(p, _)| format!("{} of faces", p.name)));
        if !slots.contains(&Slot::Indices) {
            return Err(values.error(format!("the elements `{}` have no vertex_indices", element.name)));
        }
        let has_tex_coords = slots.contains(&Slot::TexCoords);
        self.begin_own_corners(colors || has_tex_coords, has_tex_coords, colors);
        let mut face = Face::default();
        for _ in 0..element.count {
            face.indices.clear();
            face.tex_coords.clear();
            face.texture = 0;
            face.color = [1.0; 4];
            for (property, slot) in element.properties.iter().zip(&slots) {
                match (*slot, property.list) {
                    (Slot::Indices, Some(count)) => {
                        for _ in 0..values.length(count, property.kind, "a face")? {
                            let index = values.next(property.kind, "the number of a vertex")?;
                            face.indices.push(if index.fract() == 0.0 { index as i64 } else { i64::MAX });
                        }
                    }
                    (Slot::TexCoords, Some(count)) => {
                        for _ in 0..values.length(count, property.kind, "a list of texture coordinates")? {
                            face.tex_coords.push(values.next(property.kind, "a texture coordinate")? as f32);
                        }
                    }
                    (Slot::Texture, None) => face.texture = values.next(property.kind, "a texture number")? as u32,
                    (Slot::Color(i, full), None) => {
                        face.color[i] = values.next(property.kind, "a colour")? as f32 / full;
                    }
                    _ => values.skip(property.kind, property.list)?,
                }
            }
            if strips { self.strip(&face, values)? } else { self.polygon(&face, values)? }
        }
        Ok(())
    }

    /// From the first face with attributes of its own on, the mesh's vertices are not the file's.
    fn begin_own_corners(&mut self, wanted: bool, tex_coords: bool, colors: bool) {
        if !wanted || self.own_corners {
            return;
        }
        self.own_corners = true;
        self.face_colors = colors;
        if tex_coords {
            self.vertices.tex_coords = vec![Vec2::ZERO; self.vertices.positions.len()];
        }
        if colors {
            self.vertices.colors = vec![Vec4::ONE; self.vertices.positions.len()];
        }
        // Triangles of strips before count as corners without attributes.
        let triangles = std::mem::take(&mut self.mesh.triangles);
        for triangle in triangles {
            let corners = triangle.map(|v| self.corner(v, None, None));
            self.mesh.triangles.push(corners);
        }
    }

    /// Number in the mesh of the file's vertex `vertex`, with attributes of a face.
    fn corner(&mut self, vertex: u32, tex_coord: Option<Vec2>, color: Option<Vec4>) -> u32 {
        if !self.own_corners {
            return vertex;
        }
        let v = vertex as usize;
        let of_vertex = self.vertices.tex_coords.get(v).copied().unwrap_or_default();
        let tex_coord = tex_coord.filter(|t| t.is_finite()).unwrap_or(of_vertex);
        let color = color.or(self.vertices.colors.get(v).copied()).filter(|c| c.is_finite()).unwrap_or(Vec4::ONE);
        let bytes = u32::from_le_bytes(color.to_array().map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8));
        let (mesh, vertices) = (&mut self.mesh, &self.vertices);
        *self.known.entry((vertex, tex_coord.to_array().map(f32::to_bits), bytes)).or_insert_with(|| {
            mesh.positions.push(vertices.positions[v]);
            if let Some(&normal) = vertices.normals.get(v) {
                mesh.normals.push(normal);
            }
            if !vertices.tex_coords.is_empty() {
                mesh.tex_coords.push(tex_coord);
            }
            if !vertices.colors.is_empty() {
                mesh.colors.push(color);
            }
            mesh.positions.len() as u32 - 1
        })
    }

    fn polygon(&mut self, face: &Face, values: &Values) -> Result<(), LoadError> {
        self.points.clear();
        for &index in &face.indices {
            match usize::try_from(index).ok().and_then(|i| self.vertices.positions.get(i)) {
                Some(&p) => self.points.push(p),
                None => return Err(self.no_vertex(index, values)),
            }
        }
        if self.points.len() < 3 {
            self.report.once(values.line(), "a face with fewer than 3 corners is left out");
            return Ok(());
        }
        if !self.points.iter().all(|p| p.is_finite()) {
            self.report.once(values.line(), "a face with a corner that is not finite is left out");
            return Ok(());
        }
        let n = self.points.len();
        let triangles = match n {
            3 => vec![[0, 1, 2]],
            _ => polygon::triangulate(&self.points).unwrap_or_else(|| {
                self.report.once(values.line(), "a concave polygon is too large to be cut; it is drawn as a fan");
                polygon::fan(n as u32)
            }),
        };
        let pairs = face.tex_coords.as_chunks::<2>().0;
        if !face.tex_coords.is_empty() && pairs.len() < n {
            let text = "a face has fewer texture coordinates than corners; the others are those of the vertices";
            self.report.once(values.line(), text);
        }
        let color = self.face_colors.then_some(Vec4::from_array(face.color));
        for triangle in triangles {
            let corners = triangle.map(|i| {
                let tex_coord = pairs.get(i as usize).map(|&p| Vec2::from_array(p));
                self.corner(face.indices[i as usize] as u32, tex_coord, color)
            });
            self.push(corners, face.texture);
        }
        Ok(())
    }

    /// Every three neighbours make a triangle, whose side alternates; −1 begins anew.
    fn strip(&mut self, face: &Face, values: &Values) -> Result<(), LoadError> {
        for strip in face.indices.split(|&i| i == -1) {
            for (k, corners) in strip.windows(3).enumerate() {
                let mut triangle = [0; 3];
                for (vertex, &index) in triangle.iter_mut().zip(corners) {
                    match usize::try_from(index).ok().and_then(|i| self.vertices.positions.get(i)) {
                        Some(_) => *vertex = index as u32,
                        None => return Err(self.no_vertex(index, values)),
                    }
                }
                let [a, b, c] = triangle;
                let finite = |v: u32| self.vertices.positions[v as usize].is_finite();
                // Strips turn corners by triangles without area.
                if a != b && b != c && a != c && triangle.into_iter().all(finite) {
                    let turned = if k % 2 == 0 { [a, b, c] } else { [a, c, b] };
                    let corners = turned.map(|v| self.corner(v, None, None));
                    self.push(corners, face.texture);
                }
            }
        }
        Ok(())
    }

    fn push(&mut self, corners: [u32; 3], texture: u32) {
        self.mesh.triangles.push(corners);
        // materials[0] is that of meshes without textures.
        let known = (texture as usize) < self.textures;
        self.mesh.materials.push(if known { texture + 1 } else { u32::from(self.textures > 0) });
    }

    fn no_vertex(&self, index: i64, values: &Values) -> LoadError {
        let count = self.vertices.positions.len();
        let index = if index == i64::MAX { "a number with a fraction".into() } else { index.to_string() };
        values.error(format!("a face names vertex {index}, but there are {count}"))
    }

    /// The mesh.
    pub fn finish(mut self) -> Mesh {
        if !self.own_corners {
            let Vertices { positions, normals, tex_coords, colors } = self.vertices;
            self.mesh = Mesh { positions, normals, tex_coords, colors, ..self.mesh };
        }
        // Without an image they mean nothing.
        if self.textures == 0 {
            self.mesh.tex_coords = Vec::new();
        }
        self.mesh
    }
}
