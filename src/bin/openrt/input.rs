//! The scene that a command works on: a file, or the standard input.

use crate::args::{Format, SceneArgs};
use crate::output::STANDARD;
use openrt::load::{ReadOptions, SceneFile, read_with};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

/// As much of the standard input is read, as of a file.
const MAX_BYTES: u64 = 1 << 30;

/// Loads a scene and shows what was odd about it.
pub fn load(args: &SceneArgs) -> Result<SceneFile, String> {
    let options = ReadOptions { detail: args.detail };
    let mut scene = if args.scene == Path::new(STANDARD) {
        standard(args.format, &options)?
    } else {
        read_with(&args.scene, &options).map_err(|e| e.to_string())?
    };
    for warning in &scene.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some(wanted) = &args.animation {
        let index = animation_called(wanted, &scene)?;
        scene.play_clip(index);
    }
    Ok(scene)
}

/// Index of an animation by its name, else by its number.
fn animation_called(wanted: &str, scene: &SceneFile) -> Result<usize, String> {
    let names: Vec<&str> = scene.clips.iter().map(|clip| clip.name.as_str()).collect();
    let numbered = || wanted.parse().ok().filter(|&index| index < names.len());
    names.iter().position(|name| *name == wanted).or_else(numbered).ok_or_else(|| match names[..] {
        [] => format!("{}: there are no animations to choose from", scene.path.display()),
        _ => format!("there is no animation {wanted}; there are 0 to {}: {}", names.len() - 1, names.join(", ")),
    })
}

fn standard(format: Option<Format>, options: &ReadOptions) -> Result<SceneFile, String> {
    let mut bytes = Vec::new();
    let fault = |e: std::io::Error| format!("standard input: {e}");
    std::io::stdin().lock().take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(fault)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(format!("standard input: more than {MAX_BYTES} bytes"));
    }
    let format = format.or_else(|| told_by(&bytes)).ok_or("standard input: which kind of scene? say --format")?;
    Copy::new(&bytes, format)?.read(Path::new(STANDARD), options)
}

/// A file of our own, whose name tells the format. Goes away when it is dropped.
struct Copy(PathBuf);

impl Copy {
    fn new(bytes: &[u8], format: Format) -> Result<Self, String> {
        let folder = std::env::temp_dir().join(format!("openrt-{}", std::process::id()));
        fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let copy = Self(folder.join(format!("scene.{}", format.extension())));
        fs::write(&copy.0, bytes).map_err(|e| format!("{}: {e}", copy.0.display()))?;
        Ok(copy)
    }

    /// Reads the scene; what is said of it names `shown`.
    fn read(&self, shown: &Path, options: &ReadOptions) -> Result<SceneFile, String> {
        let (copy, shown_text) = (self.0.display().to_string(), shown.display().to_string());
        let renamed = |text: String| text.replace(&copy, &shown_text);
        let mut scene = read_with(&self.0, options).map_err(|e| renamed(e.to_string()))?;
        scene.path = shown.to_owned();
        for text in scene.warnings.iter_mut().chain(&mut scene.notes) {
            *text = renamed(std::mem::take(text));
        }
        Ok(scene)
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        // What stays in the folder for temporary files does no harm.
        let _ = fs::remove_file(&self.0);
        let _ = self.0.parent().map(fs::remove_dir);
    }
}

/// The format that the first bytes, or the first words of lines, give away.
fn told_by(bytes: &[u8]) -> Option<Format> {
    match bytes {
        [b'g', b'l', b'T', b'F', ..] => return Some(Format::Glb),
        [b'p', b'l', b'y', b'\n' | b'\r', ..] => return Some(Format::Ply),
        _ => {}
    }
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 16)]);
    let text = text.trim_start_matches('\u{feff}');
    if text.trim_start().starts_with('{') {
        return Some(Format::Gltf);
    }
    text.lines().find_map(|line| {
        let mut words = line.split_whitespace();
        let (word, next) = (words.next()?, words.next());
        let is_number = next.is_some_and(|w| w.parse::<f64>().is_ok());
        match word {
            "mtllib" | "usemtl" | "vn" | "vt" | "o" | "g" => Some(Format::Obj),
            "v" if is_number => Some(Format::Obj),
            "v" | "b" | "l" | "fm" | "i" | "from" => Some(Format::Nff),
            _ => None,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_by_their_content() {
        for (text, format) in [
            ("glTF\u{2}\0\0\0", Some(Format::Glb)),
            ("ply\nformat ascii 1.0\n", Some(Format::Ply)),
            ("\n {\"asset\": {}}", Some(Format::Gltf)),
            ("# a cube\nv 1 2 3\n", Some(Format::Obj)),
            ("# a cube\nmtllib cube.mtl\n", Some(Format::Obj)),
            ("v\nfrom 1 2 3\n", Some(Format::Nff)),
            ("b 0 0 0\nv from 0 0 5\n", Some(Format::Nff)),
            ("", None),
            ("a text", None),
        ] {
            assert_eq!(told_by(text.as_bytes()), format, "{text:?}");
        }
    }
}
