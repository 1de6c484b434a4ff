//! Contact sheets of public models: each is right, or a warning says what is missing, or there is a clear error.
//!
//! Looked for are the models of Debian's package `assimp-testmodels`, the crate `bvh` in cargo's registry, the Python packages `trimesh` and
//! `panda3d`, and the folders in `OPENRT_MODELS` (separated as in `PATH`). What is not there is skipped aloud. With `OPENRT_PICTURES` set
//! the sheets are written to that folder, to be looked at.

#[path = "common/skip.rs"]
mod skip;

use openrt::Context;
use openrt::api::{Capability, Config, PixelFormat, PixelKind};
use openrt::load::{LoadedScene, Parts, SceneFile, read};
use skip::skipped;
use std::path::{Path, PathBuf};

const FORMATS: [&str; 6] = ["obj", "ply", "nff", "aff", "gltf", "glb"];
/// Of one picture, and how many stand side by side.
const SIZE: [usize; 2] = [160, 120];
const COLUMNS: usize = 8;

/// Files below `folder` that may be scenes.
fn models(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut pending) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
            if path.is_dir() {
                pending.push(path);
            } else if extension.is_some_and(|e| FORMATS.contains(&e.as_str())) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Folders of the collections that are here, by name.
fn collections() -> Vec<(String, PathBuf)> {
    let mut found = Vec::new();
    let mut add = |name: &str, places: Vec<PathBuf>| {
        let here: Vec<PathBuf> = places.into_iter().filter(|p| p.is_dir()).collect();
        if here.is_empty() {
            skipped(format_args!("no models of {name}"));
        }
        found.extend(here.into_iter().map(|p| (name.to_owned(), p)));
    };
    add("assimp-testmodels", vec!["/usr/share/assimp/models".into()]);
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".cargo"))).unwrap_or_default();
    let below = |folder: PathBuf| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
    let crates = below(home.join("registry/src")).flat_map(below);
    add("bvh", crates.filter(|p| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("bvh-"))).collect());
    for package in ["trimesh", "panda3d"] {
        add(package, python_package(package).into_iter().collect());
    }
    for folder in std::env::var_os("OPENRT_MODELS").iter().flat_map(|f| std::env::split_paths(f).collect::<Vec<_>>()) {
        add(&folder.file_name().unwrap_or_default().to_string_lossy(), vec![folder.clone()]);
    }
    found
}

/// Folder of an installed Python package.
fn python_package(name: &str) -> Option<PathBuf> {
    let script = "import importlib.util, sys; s = importlib.util.find_spec(sys.argv[1]); print(s.submodule_search_locations[0] if s else '')";
    let output = std::process::Command::new("python3").args(["-c", script, name]).output().ok()?;
    let folder = String::from_utf8(output.stdout).ok()?;
    (!folder.trim().is_empty()).then(|| folder.trim().into())
}

/// The picture of a scene as RGB, row 0 at the top.
fn picture(file: SceneFile) -> Result<Vec<u8>, String> {
    let mut cx = Context::with_config(Config::with_threads(1)).map_err(|e| e.to_string())?;
    let render = |cx: &mut Context, file: SceneFile| {
        cx.set_frame_size(SIZE[0] as u32, SIZE[1] as u32)?;
        cx.enable(Capability::OriginTopLeft)?;
        if file.srgb {
            cx.enable(Capability::FramebufferSrgb)?;
        }
        let time = file.animation.map_or(0.0, |a| a.start);
        let mut scene = LoadedScene::define(cx, file)?;
        scene.instantiate(cx, time, Parts::ALL)?;
        cx.render()?;
        let mut pixels = vec![0; SIZE[0] * SIZE[1] * 3];
        cx.read_pixels(0, 0, SIZE[0] as u32, SIZE[1] as u32, PixelKind::Color(PixelFormat::Rgb8), 0, &mut pixels)?;
        Ok::<_, openrt::api::Error>(pixels)
    };
    render(&mut cx, file).map_err(|e| e.to_string())
}

#[test]
fn models_are_right_or_told() {
    let sheets = std::env::var_os("OPENRT_PICTURES").map(PathBuf::from);
    for (name, folder) in collections() {
        let models = models(&folder);
        let mut sheet =
            image::RgbImage::new((SIZE[0] * COLUMNS) as u32, (SIZE[1] * models.len().div_ceil(COLUMNS).max(1)) as u32);
        for (i, path) in models.iter().enumerate() {
            let shown = path.strip_prefix(&folder).unwrap_or(path).display();
            match read(path) {
                Ok(file) => {
                    let drawn = file.objects.iter().any(|o| !o.mesh.triangles.is_empty());
                    assert!(
                        drawn || !file.warnings.is_empty(),
                        "{}: nothing is drawn, and nothing is said",
                        path.display()
                    );
                    println!("{name} {i}: {shown}, {} warnings", file.warnings.len());
                    file.warnings.iter().for_each(|w| println!("    {w}"));
                    let pixels = picture(file).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                    let part = image::RgbImage::from_raw(SIZE[0] as u32, SIZE[1] as u32, pixels)
                        .expect("as many bytes as pixels");
                    image::imageops::replace(
                        &mut sheet,
                        &part,
                        ((i % COLUMNS) * SIZE[0]) as i64,
                        ((i / COLUMNS) * SIZE[1]) as i64,
                    );
                }
                Err(error) => {
                    assert!(!error.message.is_empty(), "{}", path.display());
                    println!("{name} {i}: {shown}\n    error: {}", error.message);
                }
            }
        }
        if let Some(sheets) = &sheets {
            let file = sheets.join(format!("models_{name}.png"));
            std::fs::create_dir_all(sheets)
                .and_then(|()| sheet.save(&file).map_err(std::io::Error::other))
                .expect("a sheet is written");
            println!("{} models in {}", models.len(), file.display());
        }
    }
}
