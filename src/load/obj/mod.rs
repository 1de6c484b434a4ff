//! Wavefront OBJ with MTL materials (Alias|Wavefront, "Advanced Visualizer Manual", appendices B1 and B2), as programs write them.
//!
//! Two passes over the lines: `tables` reads vertices and the names of material libraries, `faces` makes triangles of
//! faces, which may therefore stand before their vertices, and materials before their library. `mtl` reads a library,
//! `map` the options of its textures. Where programs and the manual differ:
//!
//! - a line that is not understood is left out with a warning; a broken vertex keeps its number, and faces that use it are left
//!   out;
//! - `v x y z r g b` colours a vertex; vertices without colours are white beside those that have some;
//! - faces without normals are flat, or smooth within their smoothing group (`s`);
//! - all faces become one object: `o` and `g` are names, which nothing refers to.

mod faces;
mod map;
mod mtl;
mod tables;

use crate::api::Wrap;
use crate::load::LoadError;
use crate::load::input::files::{self, Tree};
use crate::load::input::lines;
use crate::load::model::{Deform, Object, SceneFile, TextureData, TextureSource};
use crate::load::report::Report;
use map::Map;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use tables::Tables;

/// Most different lines `mtllib` of a file, and most bytes of one: every word is looked for in several places.
const MOST_LIBRARIES: usize = 1000;
const MOST_NAMES: usize = 4096;

/// Where other files are looked for.
struct Place {
    tree: Tree,
    folder: PathBuf,
}

/// A material as faces refer to it.
#[derive(Clone, Copy, Debug, Default)]
struct Surface {
    /// Index into `SceneFile::materials`.
    material: u32,
    /// Scale and offset of texture coordinates; index into `Surfaces::transforms`.
    transform: u32,
}

/// Materials by name.
struct Surfaces {
    by_name: HashMap<Vec<u8>, Surface>,
    /// Scale and offset of texture coordinates, each kind once; the first changes nothing.
    transforms: Vec<map::Transform>,
}

impl Surfaces {
    /// The material called `name`, which may have a comment behind it.
    fn find(&self, name: &[u8]) -> Option<Surface> {
        self.by_name.get(name).or_else(|| self.by_name.get(lines::without_comment(name))).copied()
    }
}

pub fn load(path: &Path) -> Result<SceneFile, LoadError> {
    let bytes = files::read(path, files::MAX_FILE_BYTES)?;
    let text = lines::text(path, &bytes)?;
    let place = Place { tree: Tree::of(path)?, folder: path.parent().map_or_else(PathBuf::new, Path::to_path_buf) };
    let mut scene = SceneFile::new("OBJ", path.to_path_buf());
    scene.counts.files = 1;
    let mut report = Report::new(path);
    let tables = Tables::read(text, &mut report);
    if !tables.understood {
        let what = if text.trim_ascii().is_empty() { "the file is empty" } else { "no line of the file is OBJ" };
        return Err(LoadError::new(path, None, what));
    }
    let surfaces = libraries(&place, &tables, &mut report, &mut scene);
    let mesh = faces::read(text, &tables, &surfaces, &mut report);
    scene.counts.meshes = 1;
    scene.counts.mesh_triangles = mesh.triangles.len() as u64;
    if mesh.triangles.is_empty() {
        report.once(None, "the file has no faces; points and lines are not drawn");
    } else {
        let name = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy().into_owned());
        scene.objects.push(Object::new(name, 0, mesh, Deform::Rigid));
    }
    // Those of the scene itself come first.
    let of_libraries = std::mem::replace(&mut scene.warnings, report.into_warnings());
    scene.warnings.extend(of_libraries);
    Ok(scene)
}

/// Reads the material libraries; a mesh without its materials is still a mesh.
fn libraries(place: &Place, tables: &Tables, report: &mut Report, scene: &mut SceneFile) -> Surfaces {
    let mut surfaces = Surfaces { by_name: HashMap::new(), transforms: vec![map::Transform::default()] };
    let mut textures = HashMap::new();
    let mut read = Vec::new();
    let mut lines_seen = HashSet::new();
    for (line, names) in &tables.libraries {
        if !lines_seen.insert(names) {
            continue;
        }
        if lines_seen.len() > MOST_LIBRARIES || names.len() > MOST_NAMES {
            report.once(Some(*line), "there are more names of material libraries than are looked for");
            continue;
        }
        for found in library_files(place, names) {
            let file = match found {
                Ok(file) if read.contains(&file) => continue,
                Ok(file) => file,
                Err(text) => {
                    report.once(Some(*line), &text);
                    continue;
                }
            };
            read.push(file.clone());
            let bytes = match files::read(&file, files::MAX_FILE_BYTES) {
                Ok(bytes) => bytes,
                Err(error) => {
                    report.once(Some(*line), &error.to_string());
                    continue;
                }
            };
            scene.counts.files += 1;
            let mut own = Report::new(&file);
            match lines::text(&file, &bytes) {
                Ok(text) => {
                    for entry in mtl::read(text, &mut own) {
                        let mut material = entry.material;
                        let mut transform = 0;
                        if let Some(map) = &entry.texture {
                            material.texture = texture(place, map, &mut own, scene, &mut textures);
                            transform =
                                surfaces.transforms.iter().position(|t| *t == map.transform).unwrap_or_else(|| {
                                    surfaces.transforms.push(map.transform);
                                    surfaces.transforms.len() - 1
                                }) as u32;
                        }
                        let surface = Surface { material: scene.materials.len() as u32, transform };
                        scene.materials.push(material);
                        let short = lines::without_comment(&entry.name).to_vec();
                        surfaces.by_name.entry(short).or_insert(surface);
                        surfaces.by_name.insert(entry.name, surface);
                    }
                }
                Err(error) => own.once(None, &error.message),
            }
            scene.warnings.extend(own.into_warnings());
        }
    }
    surfaces
}

/// The files that a line `mtllib` names: in quotes, one name with blanks in it, or several names between blanks; `\ ` is a blank
/// in a name. What exists decides.
fn library_files(place: &Place, names: &[u8]) -> Vec<Result<PathBuf, String>> {
    let find = |name: &[u8]| {
        let name = lines::decoded(name).replace("\\ ", " ");
        place.tree.find(&name, &place.folder).map_err(|why| format!("material library `{name}` {why}"))
    };
    let short = lines::without_comment(names);
    if names.contains(&b'"') {
        let quoted = names.split(|&b| b == b'"').map(<[u8]>::trim_ascii).filter(|n| !n.is_empty() && n[0] != b'#');
        return quoted.map(find).collect();
    }
    for whole in [names, short] {
        if let Ok(file) = find(whole) {
            return vec![Ok(file)];
        }
    }
    let mut found = Vec::new();
    let mut rest = short;
    while !rest.is_empty() {
        // The longest run of words that is a file; else one word, and what is wrong with it.
        let ends = (1..=rest.len()).rev().filter(|&e| e == rest.len() || (rest[e] == b' ' && rest[e - 1] != b'\\'));
        let ends: Vec<usize> = ends.collect();
        let hit = ends.iter().take(16).find_map(|&e| Some((e, find(&rest[..e]).ok()?)));
        let end = match hit {
            Some((end, file)) => {
                found.push(Ok(file));
                end
            }
            None => {
                let end = ends.last().copied().unwrap_or(rest.len());
                found.push(find(&rest[..end]));
                end
            }
        };
        rest = rest[end..].trim_ascii();
    }
    found
}

/// Index of the texture of `map`, which is read once for each way of repeating it.
fn texture(
    place: &Place,
    map: &Map,
    report: &mut Report,
    scene: &mut SceneFile,
    known: &mut HashMap<(String, bool), Option<u32>>,
) -> Option<u32> {
    *known.entry((map.file.clone(), map.clamp)).or_insert_with(|| {
        match place.tree.find_texture(&map.file, &place.folder) {
            Ok(file) => {
                scene.textures.push(TextureSource {
                    name: map.file.clone(),
                    data: TextureData::File(file),
                    first_row_at_zero: false,
                    wrap: [if map.clamp { Wrap::ClampToEdge } else { Wrap::Repeat }; 2],
                    filter: Default::default(),
                    srgb: false,
                    transform: glam::Affine2::IDENTITY,
                });
                Some(scene.textures.len() as u32 - 1)
            }
            Err(why) => {
                report.once(Some(map.line), &format!("texture `{}` {why}", map.file));
                None
            }
        }
    })
}
