//! `openrt info`: what is in a scene, counted with included files expanded.

use crate::args::InfoArgs;
use crate::input;
use openrt::load::{Camera, Counts, Deform, Projection, SceneFile, TextureData};
use serde_json::{Value, json};
use std::io::{self, Write};

pub fn run(args: &InfoArgs, out: &mut impl Write) -> Result<(), String> {
    let scene = input::load(&args.scene)?;
    let printed =
        if args.json { writeln!(out, "{}", object(&scene, args.long)) } else { print(&scene, args.long, out) };
    match printed {
        // `openrt info … | head` is no error.
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result.map_err(|e| e.to_string()),
    }
}

/// 1234567 → 1,234,567
fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

fn print(scene: &SceneFile, long: bool, out: &mut impl Write) -> io::Result<()> {
    let c = &scene.counts;
    let mut line = |label: &str, text: String| writeln!(out, "{label:<20} {text}");
    line("scene", scene.path.display().to_string())?;
    line("format", format!("{}, {} files", scene.format, grouped(c.files)))?;
    line("triangles", grouped(c.triangles()))?;
    line("  in meshes", format!("{} in {} meshes", grouped(c.mesh_triangles), grouped(c.meshes)))?;
    if c.polygons > 0 {
        line("  in polygons", format!("{} in {} polygons", grouped(c.polygon_triangles), grouped(c.polygons)))?;
    }
    if c.textured_triangles > 0 {
        line("  single, textured", grouped(c.textured_triangles))?;
    }
    if c.animated_triangles > 0 {
        line("animated triangles", grouped(c.animated_triangles))?;
    }
    if c.spheres + c.cones > 0 {
        let made = grouped(c.tessellated_triangles);
        line(
            "curved surfaces",
            format!("{} spheres, {} cones (drawn as {made} triangles)", grouped(c.spheres), grouped(c.cones)),
        )?;
    }
    line("lights", scene.lights.len().to_string())?;
    line("materials", scene.materials.len().to_string())?;
    line("textures", scene.textures.len().to_string())?;
    line("static transforms", grouped(c.static_transforms))?;
    line("named transforms", grouped(scene.named_transforms.len() as u64))?;
    let keys = [
        ("translation", c.translation_keys),
        ("rotation", c.rotation_keys),
        ("scale", c.scale_keys),
        ("visibility", c.visibility_keys),
    ];
    let keys: Vec<_> = keys.iter().filter(|k| k.1 > 0).map(|k| format!("{} {}", grouped(k.1), k.0)).collect();
    if !keys.is_empty() {
        line("keys", keys.join(", "))?;
    }
    line("objects", scene.objects.len().to_string())?;
    if let Some(a) = scene.animation {
        line("animation", format!("{} frames from {} s to {} s", a.frames, a.start, a.end))?;
    }
    if let Some(camera) = scene.cameras.first() {
        let kind = match camera.projection {
            Projection::Perspective { fov_y } => format!("{fov_y:.1}° vertically"),
            Projection::Overview { fov } => format!("{fov:.1}° along the shorter side"),
            Projection::Orthographic { half_height } => format!("orthographic, {} high", half_height * 2.0),
        };
        let moves = camera.keys.is_some() || camera.node.is_some_and(|n| scene.moving_nodes()[n as usize]);
        let size = camera.resolution.map_or(String::new(), |(w, h)| format!(", {w}x{h}"));
        line("camera", format!("{}, {kind}{size}{}", camera.name, if moves { ", moving" } else { "" }))?;
    }
    if let Some((low, high)) = scene.bounds(scene.animation.map_or(0.0, |a| a.start)) {
        line("bounds", format!("{low} to {high}"))?;
    }
    if long {
        details(scene, out)?;
    }
    Ok(())
}

/// What [`print`] says, as an object.
fn object(scene: &SceneFile, long: bool) -> Value {
    let Counts { files, meshes, polygons, spheres, cones, .. } = scene.counts;
    let c = &scene.counts;
    let mut object = json!({
        "scene": scene.path.display().to_string(),
        "format": scene.format,
        "files": files,
        "triangles": c.triangles(),
        "meshes": meshes,
        "polygons": polygons,
        "animated_triangles": c.animated_triangles,
        "spheres": spheres,
        "cones": cones,
        "lights": scene.lights.len(),
        "materials": scene.materials.len(),
        "textures": scene.textures.len(),
        "static_transforms": c.static_transforms,
        "named_transforms": scene.named_transforms.len(),
        "keys": {
            "translation": c.translation_keys,
            "rotation": c.rotation_keys,
            "scale": c.scale_keys,
            "visibility": c.visibility_keys,
        },
        "objects": scene.objects.len(),
        "animation": scene.animation.map(|a| json!({ "frames": a.frames, "start": a.start, "end": a.end })),
        "camera": scene.cameras.first().map(camera),
        "bounds": scene.bounds(scene.animation.map_or(0.0, |a| a.start)).map(|(low, high)| [low.to_array(), high.to_array()]),
        "warnings": scene.warnings,
        "notes": scene.notes,
    });
    if long {
        let names = |names: Vec<&str>| json!(names);
        object["object_names"] = names(scene.objects.iter().map(|o| &*o.name).collect());
        object["transform_names"] = names(scene.named_transforms.iter().map(|n| &**n).collect());
        object["material_names"] = names(scene.materials.iter().map(|m| &*m.name).collect());
        object["texture_names"] = names(scene.textures.iter().map(|t| &*t.name).collect());
        object["light_names"] = names(scene.lights.iter().map(|l| &*l.name).collect());
    }
    object
}

fn camera(camera: &Camera) -> Value {
    let mut object = json!({ "name": camera.name, "resolution": camera.resolution });
    match camera.projection {
        Projection::Perspective { fov_y } => object["fov_y"] = json!(fov_y),
        Projection::Overview { fov } => object["fov"] = json!(fov),
        Projection::Orthographic { half_height } => object["half_height"] = json!(half_height),
    }
    object
}

fn details(scene: &SceneFile, out: &mut impl Write) -> io::Result<()> {
    for (i, object) in scene.objects.iter().enumerate() {
        let kind = match &object.deform {
            Deform::Rigid => "rigid",
            Deform::Triangles(_) => "key-framed triangles",
            Deform::Blend { skin: Some(_), .. } => "skinned",
            Deform::Blend { .. } => "morphed",
        };
        let triangles = grouped(object.mesh.triangles.len() as u64);
        writeln!(out, "object {i}: `{}`, {triangles} triangles, {kind}", object.name)?;
    }
    for name in &scene.named_transforms {
        writeln!(out, "named transform `{name}`")?;
    }
    for texture in &scene.textures {
        let from = match &texture.data {
            TextureData::File(path) => path.display().to_string(),
            TextureData::Bytes(bytes) => format!("{} bytes", bytes.len()),
        };
        writeln!(out, "texture `{}`: {from}", texture.name)?;
    }
    for light in &scene.lights {
        writeln!(out, "light `{}`: {:?}, colour {}", light.name, light.kind, light.color)?;
    }
    for (i, m) in scene.materials.iter().enumerate() {
        writeln!(
            out,
            "material {i} {}: ambient {}, diffuse {}, specular {} ^{}, transmission {} (ior {})",
            m.name, m.ambient, m.diffuse, m.specular, m.shininess, m.transmission, m.ior
        )?;
    }
    for note in &scene.notes {
        writeln!(out, "note: {note}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn digits_in_groups() {
        assert_eq!([0, 12, 999, 1000, 110_561].map(super::grouped), ["0", "12", "999", "1,000", "110,561"]);
    }
}
