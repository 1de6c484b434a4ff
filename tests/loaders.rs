//! Scene files through `openrt info`: the counts of the BART scenes, and messages for bad files.

#[path = "common/skip.rs"]
mod skip;

use skip::skipped;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn info(scene: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_openrt")).arg("info").arg(scene).output().expect("the program starts")
}

/// What `info` says, line by line: (label, text).
fn facts(scene: &Path) -> Vec<(String, String)> {
    let output = info(scene);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && errors.is_empty(), "{}: {errors}", scene.display());
    let text = String::from_utf8(output.stdout).expect("output is UTF-8");
    text.lines().map(|l| (l[..20].trim().to_string(), l[20..].trim().to_string())).collect()
}

fn bart() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/bart");
    if !path.is_dir() {
        skipped("no ../shared/bart");
        return None;
    }
    Some(path)
}

fn check(scene: &str, expected: &[(&str, &str)]) {
    let Some(bart) = bart() else { return };
    let facts = facts(&bart.join(scene));
    for (label, text) in expected {
        let found = facts.iter().find(|f| f.0 == *label).map(|f| f.1.as_str());
        assert_eq!(found, Some(*text), "{scene}: {label}");
    }
}

#[test]
fn kitchen_has_the_counts_of_its_documentation() {
    check(
        "kitchen/aff/kitchen.aff",
        &[
            ("triangles", "110,561"),
            ("in meshes", "110,561 in 393 meshes"),
            ("lights", "6"),
            ("static transforms", "416"),
            ("named transforms", "5"),
            ("keys", "36 translation, 742 rotation, 4 scale"),
            ("animation", "800 frames from 0 s to 20 s"),
        ],
    );
}

#[test]
fn robots_have_the_counts_of_their_documentation() {
    check(
        "robot/aff/Robot.aff",
        &[
            ("triangles", "71,708"),
            ("in meshes", "71,708 in 1,849 meshes"),
            ("lights", "1"),
            ("textures", "44"),
            ("static transforms", "521"),
            ("named transforms", "190"),
            ("keys", "1,206 translation, 12,811 rotation"),
            ("animation", "800 frames from 0 s to 50 s"),
            ("objects", "161"),
        ],
    );
}

#[test]
fn museum_has_the_counts_of_its_documentation() {
    check(
        "museum/aff/museum5.aff",
        &[
            ("triangles", "10,284"),
            ("in meshes", "10,000 in 1 meshes"),
            ("in polygons", "274 in 133 polygons"),
            ("single, textured", "10"),
            ("animated triangles", "1,024"),
            ("curved surfaces", "0 spheres, 8 cones (drawn as 512 triangles)"),
            ("lights", "2"),
            ("keys", "11 translation, 11 rotation"),
            ("animation", "300 frames from -1 s to 5 s"),
        ],
    );
}

#[test]
fn an_incomplete_scene_says_what_is_missing() {
    let Some(bart) = bart() else { return };
    let output = info(&bart.join("museum/aff/museum7.aff"));
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("museum7.aff:33: included file `animart7.aff` does not exist"), "{text}");
}

#[test]
fn every_format_has_its_facts() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    for (scene, format, triangles) in
        [("every.aff", "AFF", "10"), ("box.obj", "OBJ", "3"), ("quad.ply", "PLY", "3"), ("moving.gltf", "glTF", "8")]
    {
        let facts = facts(&data.join(scene));
        let fact = |label: &str| facts.iter().find(|f| f.0 == label).map_or("", |f| f.1.as_str()).to_string();
        assert!(fact("format").starts_with(format), "{scene}: {}", fact("format"));
        assert_eq!(fact("triangles"), triangles, "{scene}");
    }
}

#[test]
fn an_unknown_kind_of_scene_is_named() {
    let path = std::env::temp_dir().join(format!("openrt-{}.xyz", std::process::id()));
    std::fs::write(&path, "hello").expect("the temporary folder is writable");
    let output = info(&path);
    let _ = std::fs::remove_file(&path);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("unknown kind of scene"));
}
