//! Kitchen and robots of BART, read from `../shared/bart` by the reader of the program `openrt`, with their textures, lights and cameras.

use crate::loaders::aff;
use crate::scene::{Deform, LightKind, Projection, SceneFile};
use crate::stage::{Eye, Stage};
use crate::upload::{Placed, ShaderMaker, decode, define, texture};
use glam::{DMat4, Vec3};
use openrt::api::{Error, ErrorCode, Motion, Name};
use std::path::Path;

/// A scene of the folder, and the seconds of its frames; nothing, said aloud, where it is not.
pub fn load(scene: &str) -> Option<SceneFile> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/bart").join(scene);
    if !path.is_file() {
        println!("!!! NO {}: a generated scene takes its place", path.display());
        return None;
    }
    match aff::load(&path, 0.0) {
        Ok(file) => Some(file),
        Err(error) => {
            println!("!!! {error}: a generated scene takes its place");
            None
        }
    }
}

/// The scene in a context with so many threads. A frame sends 48 bytes for each object that moves.
pub fn stage(threads: usize, size: [u32; 3], file: SceneFile) -> Result<Stage, Error> {
    let moving = file.moving_nodes();
    let moves = |object: &crate::scene::Object| moving[object.node as usize];
    let bytes = 48.0 * file.objects.iter().filter(|o| moves(o)).count() as f64;
    let motions: Vec<Motion> =
        file.objects.iter().map(|o| if moves(o) { Motion::Affine } else { Motion::Static }).collect();
    Stage::new(threads, size, bytes, move |context| {
        let mut shaders = ShaderMaker::default();
        let mut textures: Vec<Name> = Vec::new();
        for source in &file.textures {
            let image = decode(source).map_err(|text| Error::new(ErrorCode::InvalidValue, text))?;
            textures.push(texture(context, source, &image, file.srgb)?);
        }
        let mut surfaces = Vec::new();
        for material in &file.materials {
            surfaces.push(shaders.surface(context, material, &textures)?);
        }
        let mut lights = Vec::new();
        for light in &file.lights {
            lights.push(shaders.light(context, light.kind, light.color)?);
        }
        let mut placed: Vec<Placed> = Vec::new();
        for (object, motion) in file.objects.iter().zip(&motions) {
            placed.push(define(context, object, *motion, &surfaces)?);
        }
        let animation = file.animation;
        Ok(Box::new(move |context: &mut openrt::Context, frame| {
            let time = animation.map_or(0.0, |a| a.time(frame));
            let poses = file.pose(time);
            for (object, placed) in file.objects.iter().zip(&placed) {
                if !poses[object.node as usize].visible {
                    continue;
                }
                if !matches!(object.deform, Deform::Rigid)
                    && let Some(deformed) = object.deformed(time, &poses, &file.nodes)
                {
                    let positions: Vec<Vec3> = placed.sources.iter().map(|&v| deformed.positions[v as usize]).collect();
                    context.update_vertices(placed.name, 0, positions)?;
                }
                context.load_matrix(DMat4::from(object.world_from_object(&poses)))?;
                context.instantiate_object(placed.name)?;
            }
            context.load_identity()?;
            for (light, &shader) in file.lights.iter().zip(&lights) {
                let Some((position, _)) = light.placed(time, &poses) else { continue };
                context.bind_shader(shader)?;
                if light.kind != LightKind::Directional {
                    let handle = context.parameter_handle("position")?;
                    context.parameter_f(handle, &position.to_array())?;
                }
                context.use_light(shader)?;
            }
            let camera = file.cameras.first().cloned().unwrap_or_else(|| file.overview());
            let view = camera.view(time, &poses);
            let degrees = match camera.projection {
                Projection::Perspective { fov_y } => fov_y,
                Projection::Orthographic { .. } => 45.0,
            };
            Ok(Eye { from: view.from, at: view.from + view.forward.normalize_or_zero(), up: view.up, degrees })
        }))
    })
}
