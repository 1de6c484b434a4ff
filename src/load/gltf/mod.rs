//! glTF 2.0 (`.gltf` and `.glb`): node tree, meshes with morph targets and skins, instances, materials, cameras, lights and
//! animations; meshes may be quantised or compressed.
//!
//! The JSON becomes plain data ([`json`]) and every index, offset and count in it is checked where it is used, so a fault is told
//! with its place in the file and nothing is allocated on the word of a count. What is optional and not read is noted
//! once by name ([`file::document::Document::left_out`]).

mod animation;
mod extensions;
mod file;
mod json;
mod material;
mod meshes;
mod nodes;
mod primitive;
mod skin;
#[cfg(test)]
mod tests;
mod texture;
mod view;

use crate::load::LoadError;
use crate::load::build::Builder;
use crate::load::input::files::Tree;
use crate::load::model::SceneFile;
use file::document::Document;
use std::path::Path;

pub fn load(path: &Path) -> Result<SceneFile, LoadError> {
    let tree = Tree::of(path)?;
    let document = Document::load(path, &tree)?;
    extensions::check(&document)?;
    let mut scene = SceneFile::new("glTF", path.to_path_buf());
    scene.counts.files = 1;
    scene.srgb = true;
    let motion = animation::read(&document)?;
    let nodes = nodes::read(&document, &motion, &mut scene)?;
    let needs = material::read(&document, &mut scene)?;
    let mut builder = Builder::default();
    meshes::read(&document, &nodes, &needs, &mut scene, &mut builder)?;
    for &(number, index) in &nodes.order {
        let node = &document.root.nodes[number as usize];
        view::add_camera(&document, &mut scene, node, number, index)?;
        view::add_light(&document, &mut scene, node, number, index)?;
    }
    let file = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy().into_owned());
    scene.objects.extend(builder.finish(|_| file.clone()));
    motion.finish(&document, &nodes, &mut scene);
    if scene.objects.is_empty() {
        document.left_out("", "the scene has no triangles");
    }
    scene.warnings.extend(document.warnings());
    Ok(scene)
}
