//! Wavefront OBJ with MTL materials, through `tobj`.
//!
//! `tobj` reports what is wrong but not where; the line is found by loading shorter and shorter prefixes of the file.
//! MTL is mapped as the format's illumination models say: `Ka Kd Ks Ns` are Whitted's terms, models 3 and above mirror with
//! `Ks`, `d` below 1 lets light through, and is refracted (`Ni`) in models 5 to 7 and 9.

use crate::load::LoadError;
use crate::load::build::{Baked, Builder, Corner};
use crate::load::input::files::{self, Tree};
use crate::load::model::{Material, SceneFile, TextureData, TextureSource};
use glam::{DAffine3, Vec2, Vec3};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

const OPTIONS: tobj::LoadOptions =
    tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };

pub fn load(path: &Path) -> Result<SceneFile, LoadError> {
    let bytes = files::read(path, files::MAX_FILE_BYTES)?;
    let tree = Tree::of(path)?;
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let mut scene = SceneFile::new("OBJ", path.to_path_buf());
    // Material libraries: first problem of each, as warnings; a mesh without its materials is still a mesh.
    let warnings = RefCell::new(Vec::new());
    let read_library = |name: &Path| {
        let name_text = name.to_string_lossy();
        let found = tree.find(&name_text, &folder).map_err(|why| format!("material library `{name_text}` {why}"));
        let text = found.and_then(|file| {
            files::read(&file, files::MAX_FILE_BYTES).map_err(|e| e.to_string()).map(|bytes| (file, bytes))
        });
        match text {
            Ok((file, bytes)) => tobj::load_mtl_buf(&mut &bytes[..]).inspect_err(|e| {
                let line = first_bad_line(&bytes, |prefix| tobj::load_mtl_buf(&mut &prefix[..]).is_err());
                warnings.borrow_mut().push(LoadError::new(&file, line, e.to_string()).to_string());
            }),
            Err(text) => {
                let line = line_containing(&bytes, "mtllib");
                warnings.borrow_mut().push(LoadError::new(path, line, text).to_string());
                Err(tobj::LoadError::OpenFileFailed)
            }
        }
    };
    let (models, materials) = tobj::load_obj_buf(&mut &bytes[..], &OPTIONS, read_library).map_err(|e| {
        let parse = |prefix: &[u8]| {
            tobj::load_obj_buf(&mut &prefix[..], &OPTIONS, |_| Ok((Vec::new(), HashMap::default()))).is_err()
        };
        LoadError::new(path, first_bad_line(&bytes, parse), e.to_string())
    })?;
    scene.warnings = warnings.into_inner();
    scene.counts.files = 1;
    let mut textures = HashMap::new();
    for material in &materials.unwrap_or_default() {
        let texture = material.diffuse_texture.as_ref().and_then(|name| {
            *textures.entry(name.clone()).or_insert_with(|| find_texture(&mut scene, &tree, &folder, path, name))
        });
        scene.materials.push(translate(material, texture));
    }
    let mut builder = Builder::default();
    for model in &models {
        add_mesh(&mut builder, &mut scene, &model.mesh);
    }
    scene.objects = builder.finish(|_| path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy().into_owned()));
    Ok(scene)
}

fn find_texture(scene: &mut SceneFile, tree: &Tree, folder: &Path, path: &Path, name: &str) -> Option<u32> {
    match tree.find_texture(name, folder) {
        Ok(file) => {
            scene.textures.push(TextureSource {
                name: name.to_string(),
                data: TextureData::File(file),
                first_row_at_zero: false,
                clamp_s: false,
                clamp_t: false,
            });
            Some(scene.textures.len() as u32 - 1)
        }
        Err(why) => {
            scene.warnings.push(LoadError::new(path, None, format!("texture `{name}` {why}")).to_string());
            None
        }
    }
}

fn translate(m: &tobj::Material, texture: Option<u32>) -> Material {
    let color = |c: Option<[f32; 3]>| c.map(Vec3::from_array).filter(|c| c.is_finite()).unwrap_or(Vec3::ZERO);
    let finite = |v: Option<f32>, default: f32| v.filter(|v| v.is_finite()).unwrap_or(default);
    let model = m.illumination_model.unwrap_or(2);
    // Model 1 has no highlight. A missing Kd is white in practice: exporters leave it out next to a texture.
    let specular = if model >= 2 { color(m.specular) } else { Vec3::ZERO };
    let opacity = finite(m.dissolve, 1.0).clamp(0.0, 1.0);
    let refracts = matches!(model, 5..=7 | 9);
    Material {
        name: m.name.clone(),
        emission: color(m.emissive),
        // Exporters write Ka 1 1 1 without meaning it; a tenth of it lights shadows without washing out the picture.
        ambient: color(m.ambient) * 0.1 * color(m.diffuse.or(Some([1.0; 3]))),
        diffuse: color(m.diffuse.or(Some([1.0; 3]))) * opacity,
        specular,
        shininess: finite(m.shininess, 1.0).max(0.0),
        reflection: if matches!(model, 3..=9) { specular } else { Vec3::ZERO },
        transmission: 1.0 - opacity,
        ior: if refracts { finite(m.optical_density, 1.0).clamp(0.1, 10.0) } else { 1.0 },
        texture,
        alpha_cutoff: None,
    }
}

fn add_mesh(builder: &mut Builder, scene: &mut SceneFile, mesh: &tobj::Mesh) {
    let vec3 = |list: &[f32], i: usize| list.get(3 * i..3 * i + 3).map(Vec3::from_slice);
    let corners: Vec<Corner> = (0..mesh.positions.len() / 3)
        .map(|i| Corner {
            position: Vec3::from_slice(&mesh.positions[3 * i..3 * i + 3]),
            normal: vec3(&mesh.normals, i).filter(|n| *n != Vec3::ZERO),
            tex_coord: mesh.texcoords.get(2 * i..2 * i + 2).map_or(Vec2::ZERO, Vec2::from_slice),
        })
        .collect();
    let (faces, _) = mesh.indices.as_chunks::<3>();
    let triangles: Vec<[u32; 3]> =
        faces.iter().copied().filter(|t| t.iter().all(|&i| (i as usize) < corners.len())).collect();
    // materials[0] is the default; the file's follow.
    let material = mesh.material_id.map_or(0, |m| m as u32 + 1);
    let material = if (material as usize) < scene.materials.len() { material } else { 0 };
    scene.counts.meshes += 1;
    scene.counts.mesh_triangles += triangles.len() as u64;
    builder.add(0, &Baked::new(DAffine3::IDENTITY), &corners, &triangles, material);
}

/// The line at which a parser starts to fail: the shortest failing prefix of whole lines, found by bisection.
fn first_bad_line(bytes: &[u8], fails: impl Fn(&[u8]) -> bool) -> Option<u32> {
    let ends: Vec<usize> = bytes
        .split_inclusive(|&b| b == b'\n')
        .scan(0, |end, line| {
            *end += line.len();
            Some(*end)
        })
        .collect();
    let (mut low, mut high) = (0, ends.len());
    while low < high {
        let middle = (low + high) / 2;
        if fails(&bytes[..ends[middle]]) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    (low < ends.len()).then_some(low as u32 + 1)
}

fn line_containing(bytes: &[u8], word: &str) -> Option<u32> {
    bytes.split(|&b| b == b'\n').position(|line| line.starts_with(word.as_bytes())).map(|i| i as u32 + 1)
}
