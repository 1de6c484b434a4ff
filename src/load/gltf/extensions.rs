//! Extensions by name: which are read, and what is said about the others.

use super::file::document::Document;
use crate::load::LoadError;

/// Extensions that are read, in whole or as far as warnings say otherwise.
const READ: [&str; 16] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
    // Descriptions for people, which change nothing that is seen.
    "KHR_xmp_json_ld",
];

/// Refuses a file that requires what is not read, and notes what else is not.
pub fn check(document: &Document) -> Result<(), LoadError> {
    let unknown = |name: &&String| !READ.contains(&name.as_str());
    let required: Vec<&str> = document.root.extensions_required.iter().filter(unknown).map(String::as_str).collect();
    if !required.is_empty() {
        let (s, verb) = if required.len() == 1 { ("", "is") } else { ("s", "are") };
        let text = format!("the file requires extension{s} {}, which {verb} not read", required.join(", "));
        return Err(document.error(text));
    }
    for name in document.root.extensions_used.iter().filter(unknown) {
        document.left_out("", format!("extension {name} is ignored"));
    }
    Ok(())
}
