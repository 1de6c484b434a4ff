//! Stanford PLY (ASCII and binary), through `ply-rs-bw`.
//!
//! Vertices with `x y z`, and `nx ny nz`, `s t` (or `u v`, `texture_u texture_v`) and `red green blue [alpha]` where there are
//! any; faces as `vertex_indices` or `vertex_index`, polygons of any size, and `tristrips` of Stanford's
//! scans. Colours of bytes are read as shares of 255.

use crate::load::input::files::{self, line_of};
use crate::load::model::{Deform, Mesh, Object, SceneFile};
use crate::load::{LoadError, build::shapes};
use glam::{Vec2, Vec3, Vec4};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::path::Path;

struct Vertex {
    position: Vec3,
    normal: Vec3,
    tex_coord: Vec2,
    color: Vec4,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: Vec3::ZERO, normal: Vec3::ZERO, tex_coord: Vec2::ZERO, color: Vec4::ONE }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(value) = property.to_f32_lossy() else { return PropertyAccessResult::Ignored };
        let unit = match property {
            Property::UChar(_) => value / 255.0,
            Property::UShort(_) => value / 65535.0,
            _ => value,
        };
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "nx" => self.normal.x = value,
            "ny" => self.normal.y = value,
            "nz" => self.normal.z = value,
            "s" | "u" | "texture_u" => self.tex_coord.x = value,
            "t" | "v" | "texture_v" => self.tex_coord.y = value,
            "red" | "diffuse_red" => self.color.x = unit,
            "green" | "diffuse_green" => self.color.y = unit,
            "blue" | "diffuse_blue" => self.color.z = unit,
            "alpha" => self.color.w = unit,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// A list of vertex numbers; −1 restarts a strip.
#[derive(Default)]
struct Face {
    indices: Vec<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.indices = match property {
            Property::ListChar(v) => v.into_iter().map(i64::from).collect(),
            Property::ListUChar(v) => v.into_iter().map(i64::from).collect(),
            Property::ListShort(v) => v.into_iter().map(i64::from).collect(),
            Property::ListUShort(v) => v.into_iter().map(i64::from).collect(),
            Property::ListInt(v) => v.into_iter().map(i64::from).collect(),
            Property::ListUInt(v) => v.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::Ignored,
        };
        PropertyAccessResult::Set
    }
}

/// Elements that are read past.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

pub fn load(path: &Path) -> Result<SceneFile, LoadError> {
    let bytes = files::read(path, files::MAX_FILE_BYTES)?;
    let fault = |e: ply_rs_bw::parser::ParseError| {
        // The first line of the message; the rest repeats the offending line.
        let text = e.to_string();
        let text = text.lines().next().unwrap_or("unreadable").to_string();
        let text = text
            .split_once(": ")
            .filter(|(head, _)| head.starts_with("Line "))
            .map_or(text.clone(), |(_, t)| t.to_string());
        LoadError::new(path, e.line().map(|l| l as u32), text)
    };
    let mut reader = Reader::new(&bytes[..]);
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(fault)?;
    let mut vertices: Vec<Vertex> = Vec::new();
    let mut faces: Vec<Face> = Vec::new();
    let mut strips = false;
    let (mut has_normals, mut has_tex_coords, mut has_colors) = (false, false, false);
    for element in header.elements.values() {
        // Each element takes at least one byte or one line end; a count beyond the file is a lie.
        if element.count > bytes.len() {
            let line = line_of(&bytes, 0);
            let text =
                format!("{} elements `{}` cannot be in a file of {} bytes", element.count, element.name, bytes.len());
            return Err(LoadError::new(path, Some(line), text));
        }
        match element.name.as_str() {
            "vertex" => {
                let has = |name: &str| element.properties.contains_key(name);
                if !(has("x") && has("y") && has("z")) {
                    return Err(LoadError::new(path, None, "the vertices have no x, y and z"));
                }
                has_normals = has("nx") && has("ny") && has("nz");
                has_tex_coords = has("s") || has("u") || has("texture_u");
                has_colors = has("red") || has("diffuse_red");
                vertices = Parser::new().read_payload_for_element(&mut reader, element, &header).map_err(fault)?;
            }
            "face" | "tristrips" => {
                strips = element.name == "tristrips";
                faces = Parser::new().read_payload_for_element(&mut reader, element, &header).map_err(fault)?;
            }
            _ => {
                Parser::<Skipped>::new().read_payload_for_element(&mut reader, element, &header).map_err(fault)?;
            }
        }
    }
    let mut mesh = Mesh {
        positions: vertices.iter().map(|v| v.position).collect(),
        normals: if has_normals { vertices.iter().map(|v| v.normal).collect() } else { Vec::new() },
        tex_coords: if has_tex_coords { vertices.iter().map(|v| v.tex_coord).collect() } else { Vec::new() },
        colors: if has_colors { vertices.iter().map(|v| v.color).collect() } else { Vec::new() },
        ..Mesh::default()
    };
    for (number, face) in faces.iter().enumerate() {
        let triangles = if strips { strip(&face.indices) } else { polygon(&face.indices, &mesh.positions) };
        let triangles = triangles.ok_or_else(|| {
            let text = format!("face {number} names a vertex that does not exist (there are {})", mesh.positions.len());
            LoadError::new(path, None, text)
        })?;
        for t in triangles {
            if t.iter().any(|&i| i as usize >= mesh.positions.len()) {
                let text =
                    format!("face {number} names a vertex that does not exist (there are {})", mesh.positions.len());
                return Err(LoadError::new(path, None, text));
            }
            mesh.triangles.push(t);
        }
    }
    mesh.materials = vec![0; mesh.triangles.len()];
    let mut scene = SceneFile::new("PLY", path.to_path_buf());
    scene.counts.files = 1;
    scene.counts.meshes = 1;
    scene.counts.mesh_triangles = mesh.triangles.len() as u64;
    if mesh.triangles.is_empty() {
        scene.warnings.push(format!("{}: the file has no faces; points are not drawn", path.display()));
    } else {
        let name = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy().into_owned());
        scene.objects.push(Object { name, node: 0, mesh, deform: Deform::Rigid });
    }
    Ok(scene)
}

fn polygon(indices: &[i64], positions: &[Vec3]) -> Option<Vec<[u32; 3]>> {
    let indices: Vec<u32> = indices.iter().map(|&i| u32::try_from(i)).collect::<Result<_, _>>().ok()?;
    if let [a, b, c] = indices[..] {
        return Some(vec![[a, b, c]]);
    }
    let corners: Option<Vec<Vec3>> = indices.iter().map(|&i| positions.get(i as usize).copied()).collect();
    let triangles = shapes::triangulate(&corners?);
    Some(triangles.into_iter().map(|t| t.map(|k| indices[k as usize])).collect())
}

/// Triangles of strips that are separated by −1; every second triangle is turned over.
fn strip(indices: &[i64]) -> Option<Vec<[u32; 3]>> {
    let mut triangles = Vec::new();
    for part in indices.split(|&i| i == -1) {
        let part: Vec<u32> = part.iter().map(|&i| u32::try_from(i)).collect::<Result<_, _>>().ok()?;
        for (k, w) in part.windows(3).enumerate() {
            triangles.push(if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
        }
    }
    Some(triangles)
}
