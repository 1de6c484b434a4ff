//! Stanford PLY (Turk 1994), text and binary of both byte orders, with what MeshLab, VCGlib and scanners add.
//!
//! `header` says what follows, `values` reads it, `vertices` and `faces` make a mesh. Understood are vertices with `x y z`, `nx ny nz`, `s t` (or
//! `u v`, `texture_u texture_v`) and `red green blue [alpha]`; faces as `vertex_indices` or `vertex_index`, polygons of any
//! size, `red green blue` of faces where the vertices have none, texture coordinates of corners (`texcoord`), several
//! images (`comment TextureFile`, `texnumber`), and the `tristrips` of Stanford's scans. Colours of bytes are shares of 255.
//!
//! No count is believed before the bytes that it needs have been seen to be there.

mod faces;
mod header;
mod values;
mod vertices;

use crate::load::LoadError;
use crate::load::input::files::{self, Tree};
use crate::load::model::{Deform, Material, Object, SceneFile, TextureData, TextureSource};
use crate::load::report::Report;
use faces::Faces;
use glam::Vec3;
use header::{Element, Header};
use std::path::{Path, PathBuf};
use values::Values;
use vertices::Vertices;

pub fn load(path: &Path) -> Result<SceneFile, LoadError> {
    let bytes = files::read(path, files::MAX_FILE_BYTES)?;
    let header = header::read(path, &bytes)?;
    let mut report = Report::new(path);
    for (line, word) in &header.unknown {
        report.once(Some(*line), &format!("unknown word `{word}` in the header is left out"));
    }
    let meant = ["vertex", "face", "tristrips"];
    let others = header.elements.iter().filter(|e| !meant.contains(&e.name.as_str()));
    let mut unused: Vec<String> = others.map(|e| format!("elements `{}`", e.name)).collect();
    let mut values = Values::new(path, &bytes, &header);
    let (vertices, mut next) = read_vertices(path, &header, &mut values, &mut unused)?;
    if header.elements[..next].iter().any(|e| e.name != "vertex" && meant.contains(&e.name.as_str())) {
        // Faces came before their vertices: once more from the beginning.
        (values, next) = (Values::new(path, &bytes, &header), 0);
    }
    let without_coordinates = vertices.tex_coords.is_empty() && !header.elements.iter().any(|e| e.has("texcoord"));
    let mut scene = SceneFile::new("PLY", path.to_path_buf());
    scene.counts.files = 1;
    textures(path, &header, &mut report, &mut scene)?;
    if without_coordinates && !header.textures.is_empty() {
        report.once(Some(header.textures[0].0), "a texture is named, but there are no texture coordinates");
    }
    let count = vertices.positions.len();
    let mut faces = Faces::new(vertices, header.textures.len(), &mut report);
    for element in &header.elements[next..] {
        check_count(element, &header, &values)?;
        match element.name.as_str() {
            "face" | "tristrips" => faces.read(element, &mut values, &mut unused)?,
            _ => read_past(element, &mut values)?,
        }
    }
    let mesh = faces.finish();
    if values.any_left() {
        report.once(values.line(), "what follows the last element is left out");
    }
    if !unused.is_empty() {
        report.once(None, &format!("left out: {}", unused.join(", ")));
    }
    scene.counts.meshes = 1;
    scene.counts.mesh_triangles = mesh.triangles.len() as u64;
    if mesh.triangles.is_empty() {
        report.once(None, &format!("the file has no faces; its {count} points are not drawn"));
    } else {
        let name = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy().into_owned());
        scene.objects.push(Object::new(name, 0, mesh, Deform::Rigid));
    }
    scene.warnings = report.into_warnings();
    Ok(scene)
}

/// Refuses a count that the rest of the file cannot hold.
fn check_count(element: &Element, header: &Header, values: &Values) -> Result<(), LoadError> {
    let needed = element.least_bytes(header.encoding).checked_mul(element.count);
    // The last value of text needs no blank behind it.
    if needed.is_none_or(|needed| needed > values.bytes_left() + 1) {
        let text = format!(
            "{} elements `{}` cannot be in the {} bytes that are left",
            element.count,
            element.name,
            values.bytes_left()
        );
        return Err(values.error(text));
    }
    Ok(())
}

fn read_past(element: &Element, values: &mut Values) -> Result<(), LoadError> {
    // Elements without properties take no bytes, however many there are.
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            values.skip(property.kind, property.list)?;
        }
    }
    Ok(())
}

/// Reads up to the vertices and them; the answer's number is that of the element behind them.
fn read_vertices(
    path: &Path,
    header: &Header,
    values: &mut Values,
    unused: &mut Vec<String>,
) -> Result<(Vertices, usize), LoadError> {
    for (i, element) in header.elements.iter().enumerate() {
        check_count(element, header, values)?;
        if element.name == "vertex" {
            return Ok((Vertices::read(element, values, unused)?, i + 1));
        }
        read_past(element, values)?;
    }
    Err(LoadError::new(path, Some(header.line), "the file has no element `vertex`"))
}

/// The images as materials, one each.
fn textures(path: &Path, header: &Header, report: &mut Report, scene: &mut SceneFile) -> Result<(), LoadError> {
    let tree = Tree::of(path)?;
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    for (line, name) in &header.textures {
        let texture = match tree.find_texture(name, &folder) {
            Ok(file) => {
                scene.textures.push(TextureSource {
                    name: name.clone(),
                    data: TextureData::File(file),
                    first_row_at_zero: false,
                    wrap: Default::default(),
                    filter: Default::default(),
                    srgb: false,
                    transform: glam::Affine2::IDENTITY,
                });
                Some(scene.textures.len() as u32 - 1)
            }
            Err(why) => {
                report.once(Some(*line), &format!("texture `{name}` {why}"));
                None
            }
        };
        scene.materials.push(Material { name: name.clone(), diffuse: Vec3::ONE, texture, ..Material::default() });
    }
    Ok(())
}
