//! Kitchen and robots of BART, read from `../shared/bart` by the library's reader of such files, with their textures, lights and cameras.

use crate::load::{LoadedScene, Object, Parts, Projection, SceneFile, nff};
use crate::stage::{Eye, Stage};
use openrt::api::Error;
use std::path::Path;

/// A scene of the folder, and the seconds of its frames; nothing, said aloud, where it is not.
pub fn load(scene: &str) -> Option<SceneFile> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/bart").join(scene);
    if !path.is_file() {
        println!("!!! NO {}: a generated scene takes its place", path.display());
        return None;
    }
    match nff::load(&path, 0.0) {
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
    let moves = |object: &Object| moving[object.node as usize];
    let bytes = 48.0 * file.objects.iter().filter(|o| moves(o)).count() as f64;
    Stage::new(threads, size, bytes, move |context| {
        let animation = file.animation;
        let mut scene = LoadedScene::define(context, file)?;
        Ok(Box::new(move |context: &mut openrt::Context, frame| {
            let time = animation.map_or(0.0, |a| a.time(frame));
            scene.instantiate(context, time, Parts { instances: true, lights: true, ..Parts::NONE })?;
            let camera = scene.camera();
            let view = camera.view(time, &scene.file().pose(time));
            let degrees = match camera.projection {
                Projection::Perspective { fov_y } | Projection::Overview { fov: fov_y } => fov_y,
                Projection::Orthographic { .. } => 45.0,
            };
            Ok(Eye { from: view.from, at: view.from + view.forward.normalize_or_zero(), up: view.up, degrees })
        }))
    })
}
