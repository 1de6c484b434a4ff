//! Triangles of model files, for measuring: OBJ, and PLY in both forms. Faces become fans; all else is left out.

use glam::Vec3;
use openrt::scene::Mesh;
use std::path::{Path, PathBuf};

/// The files of this kind at a path: itself, or those in the folder.
pub fn files(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.to_owned()];
    }
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut all: Vec<PathBuf> = entries
        .filter(|p| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj") || e.eq_ignore_ascii_case("ply")))
        .collect();
    all.sort();
    all
}

/// # Errors
/// What is wrong with the file.
pub fn read(path: &Path) -> Result<Mesh, String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let mesh = if bytes.starts_with(b"ply") { ply(&bytes)? } else { obj(&String::from_utf8_lossy(&bytes))? };
    match mesh.triangles.iter().flatten().find(|&&v| v as usize >= mesh.positions.len()) {
        Some(vertex) => Err(format!("there is no vertex {vertex}")),
        None if mesh.triangles.is_empty() => Err("it has no triangles".to_owned()),
        None => Ok(mesh),
    }
}

fn fan(mesh: &mut Mesh, face: &[u32]) {
    mesh.triangles.extend((2..face.len()).map(|k| [face[0], face[k - 1], face[k]]));
}

fn obj(text: &str) -> Result<Mesh, String> {
    let mut mesh = Mesh::default();
    for line in text.lines() {
        let mut words = line.split_ascii_whitespace();
        let wrong = || format!("{line:?} is not understood");
        match words.next() {
            Some("v") => {
                let mut next = || words.next().and_then(|w| w.parse().ok()).ok_or_else(wrong);
                mesh.positions.push(Vec3::new(next()?, next()?, next()?));
            }
            Some("f") => {
                let vertex = |word: &str| match word.split('/').next()?.parse::<i64>().ok()? {
                    0 => None,
                    back @ ..0 => u32::try_from(mesh.positions.len() as i64 + back).ok(),
                    number => u32::try_from(number - 1).ok(),
                };
                let face: Option<Vec<u32>> = words.map(vertex).collect();
                fan(&mut mesh, &face.ok_or_else(wrong)?);
            }
            _ => {}
        }
    }
    Ok(mesh)
}

/// A number of a PLY file.
#[derive(Clone, Copy, PartialEq)]
enum Number {
    Int { bytes: usize, signed: bool },
    Float { bytes: usize },
}

/// A property: its name, the type of its count if it is a list, and of its numbers.
type Property = (String, Option<Number>, Number);

fn ply(bytes: &[u8]) -> Result<Mesh, String> {
    const END: &[u8] = b"end_header\n";
    let end = bytes.windows(END.len()).position(|w| w == END).ok_or("its header has no end")?;
    let header = String::from_utf8_lossy(&bytes[..end]);
    let number = |word: &str| {
        Some(match word {
            "char" | "int8" => Number::Int { bytes: 1, signed: true },
            "uchar" | "uint8" => Number::Int { bytes: 1, signed: false },
            "short" | "int16" => Number::Int { bytes: 2, signed: true },
            "ushort" | "uint16" => Number::Int { bytes: 2, signed: false },
            "int" | "int32" => Number::Int { bytes: 4, signed: true },
            "uint" | "uint32" => Number::Int { bytes: 4, signed: false },
            "float" | "float32" => Number::Float { bytes: 4 },
            "double" | "float64" => Number::Float { bytes: 8 },
            _ => return None,
        })
    };
    let (mut is_text, mut elements) = (true, Vec::<(String, usize, Vec<Property>)>::new());
    for line in header.lines() {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let wrong = || format!("{line:?} is not understood");
        match words[..] {
            ["format", format, _] => match format {
                "ascii" | "binary_little_endian" => is_text = format == "ascii",
                _ => return Err(wrong()),
            },
            ["element", name, count] => {
                elements.push((name.to_owned(), count.parse().map_err(|_| wrong())?, Vec::new()));
            }
            ["property", "list", count, of, name] => {
                let (count, of) = number(count).zip(number(of)).ok_or_else(wrong)?;
                elements.last_mut().ok_or_else(wrong)?.2.push((name.to_owned(), Some(count), of));
            }
            ["property", of, name] => {
                let of = number(of).ok_or_else(wrong)?;
                elements.last_mut().ok_or_else(wrong)?.2.push((name.to_owned(), None, of));
            }
            _ => {}
        }
    }
    let body = &bytes[end + END.len()..];
    let text = if is_text { String::from_utf8_lossy(body) } else { "".into() };
    let (mut words, mut rest) = (text.split_ascii_whitespace(), body);
    let mut next = |of: Number| -> Option<f64> {
        if is_text {
            return words.next()?.parse().ok();
        }
        let (Number::Int { bytes, .. } | Number::Float { bytes }) = of;
        let (these, others) = rest.split_at_checked(bytes)?;
        rest = others;
        let mut raw = [0; 8];
        raw[..bytes].copy_from_slice(these);
        let (unused, word) = (64 - 8 * bytes as u32, u64::from_le_bytes(raw));
        Some(match of {
            Number::Int { signed: true, .. } => ((word << unused) as i64 >> unused) as f64,
            Number::Int { .. } => word as f64,
            Number::Float { bytes: 4 } => f64::from(f32::from_bits(word as u32)),
            Number::Float { .. } => f64::from_bits(word),
        })
    };
    let mut mesh = Mesh::default();
    let mut face = Vec::new();
    for (element, count, properties) in elements {
        for _ in 0..count {
            let mut at = Vec3::ZERO;
            for (name, list, of) in &properties {
                let length = match list {
                    Some(of) => next(*of).ok_or("it ends too early")? as usize,
                    None => 1,
                };
                face.clear();
                for _ in 0..length {
                    let value = next(*of).ok_or("it ends too early")?;
                    face.push(value as u32);
                    if let Some(axis) = ["x", "y", "z"].iter().position(|axis| axis == name) {
                        at[axis] = value as f32;
                    }
                }
                if list.is_some() && name.starts_with("vert") {
                    fan(&mut mesh, &face);
                }
            }
            if element == "vertex" {
                mesh.positions.push(at);
            }
        }
    }
    Ok(mesh)
}
