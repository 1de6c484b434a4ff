//! Material libraries. `Ka Kd Ks Ns` are Whitted's terms, illumination models 3 and above mirror with `Ks`, `d` below 1 lets light
//! through, and is refracted (`Ni`) in models 4, 6, 7 and 9.

use super::map::{self, Map};
use crate::load::input::lexer::show;
use crate::load::input::lines::{Lines, decoded, float, keyword, without_comment, words};
use crate::load::model::Material;
use crate::load::report::Report;
use glam::{Mat3, Vec3};

/// Exponent of highlights whose file has none.
const DEFAULT_SHININESS: f32 = 30.0;

/// A material of a library.
pub struct Entry {
    /// All that stands behind `newmtl`; it may end in a comment.
    pub name: Vec<u8>,
    pub material: Material,
    pub texture: Option<Map>,
}

/// What a library says about one material.
#[derive(Default)]
struct Raw {
    name: Vec<u8>,
    ambient: Option<Vec3>,
    diffuse: Option<Vec3>,
    specular: Option<Vec3>,
    emission: Option<Vec3>,
    filter: Option<Vec3>,
    shininess: Option<f32>,
    dissolve: Option<f32>,
    ior: Option<f32>,
    model: Option<f32>,
    texture: Option<Map>,
    /// Images that can only be told apart from `texture` when all of the material is known: statement, line and image.
    others: Vec<(&'static str, Map)>,
}

/// Statements that name an image other than that of the diffuse colour.
const MAPS: [&str; 16] = [
    "map_Ka", "map_Ks", "map_Ke", "map_Ns", "map_d", "map_Tr", "map_bump", "bump", "disp", "decal", "refl", "norm",
    "map_Pr", "map_Pm", "map_Ps", "map_aat",
];

/// Numbers of materials that are not used, and the value at which they change nothing.
const NUMBERS: [(&str, f32); 7] =
    [("sharpness", 60.0), ("Pr", f32::NAN), ("Pm", 0.0), ("Ps", 0.0), ("Pc", 0.0), ("Pcr", f32::NAN), ("aniso", 0.0)];

/// Reads a library.
pub fn read(text: &[u8], report: &mut Report) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut raw: Option<Raw> = None;
    for (number, line) in Lines::new(text) {
        let (word, rest) = keyword(&line);
        if word.eq_ignore_ascii_case(b"newmtl") {
            entries.extend(raw.take().map(|r| r.finish(report)));
            raw = Some(Raw { name: rest.to_vec(), ..Raw::default() });
        } else if let Some(raw) = &mut raw {
            raw.statement(word, rest, number, report);
        } else {
            report.once(Some(number), "statements before the first `newmtl` are left out");
        }
    }
    entries.extend(raw.map(|r| r.finish(report)));
    entries
}

impl Raw {
    fn statement(&mut self, word: &[u8], rest: &[u8], line: u32, report: &mut Report) {
        let values = without_comment(rest);
        // Keywords are told apart without regard to case: programs write `map_kd` and `KD`.
        let lower = word.to_ascii_lowercase();
        let slot = match &lower[..] {
            b"ka" => &mut self.ambient,
            b"kd" => &mut self.diffuse,
            b"ks" => &mut self.specular,
            b"ke" => &mut self.emission,
            b"tf" => &mut self.filter,
            _ => return self.other_statement(word, &lower, rest, line, report),
        };
        match color(values, line, report) {
            Ok(Some(color)) => *slot = Some(color),
            Ok(None) => {}
            Err(()) => report.broken(line, format!("this is not a colour: `{} {}`", show(word), show(values))),
        }
    }

    fn other_statement(&mut self, word: &[u8], lower: &[u8], rest: &[u8], line: u32, report: &mut Report) {
        let values = without_comment(rest);
        let mut numbers = words(values);
        let mut number = || numbers.next().and_then(float);
        let slot = match lower {
            b"ns" => &mut self.shininess,
            b"ni" => &mut self.ior,
            b"illum" => &mut self.model,
            b"d" | b"tr" => {
                let halo = values.starts_with(b"-halo");
                let value = float(if halo { values[5..].trim_ascii() } else { values });
                if halo {
                    report.once(Some(line), "`d -halo` is taken as `d`: it is the same from all sides");
                }
                match value {
                    // `d` counts where both are given.
                    Some(t) if lower == b"tr" => self.dissolve = self.dissolve.or(Some(1.0 - t)),
                    Some(d) => self.dissolve = Some(d),
                    None => report.broken(line, format!("this is not an opacity: `{}`", show(values))),
                }
                return;
            }
            b"map_kd" => {
                self.texture = map::read("map_Kd", rest, line, report, false);
                return;
            }
            _ => {
                if let Some(name) = MAPS.iter().find(|m| m.as_bytes().eq_ignore_ascii_case(lower)) {
                    if let Some(map) = map::read(name, rest, line, report, true) {
                        self.others.push((name, map));
                    }
                } else if let Some((name, neutral)) =
                    NUMBERS.iter().find(|n| n.0.as_bytes().eq_ignore_ascii_case(lower))
                {
                    if number() != Some(*neutral) {
                        report.once(Some(line), &format!("`{name}` is left out"));
                    }
                } else {
                    report.once(Some(line), &format!("unknown statement `{}` is left out", show(word)));
                }
                return;
            }
        };
        match number() {
            Some(value) => *slot = Some(value),
            None => report.broken(line, format!("a number is expected: `{} {}`", show(word), show(values))),
        }
    }

    fn finish(self, report: &mut Report) -> Entry {
        let opaque = |c: Option<Vec3>| c.is_none_or(|c| c == Vec3::ONE || c == Vec3::ZERO);
        let model = self.model.unwrap_or(2.0) as i32;
        let refracts = matches!(model, 4 | 6 | 7 | 9);
        let mut opacity = self.dissolve.unwrap_or(1.0).clamp(0.0, 1.0);
        // Glass of models 6 and 7 may say what it lets through by its filter alone.
        if let (6 | 7, 1.0, Some(filter)) = (model, opacity, self.filter) {
            opacity = 1.0 - (filter.element_sum() / 3.0).clamp(0.0, 1.0);
        } else if !opaque(self.filter) && opacity < 1.0 {
            report.once(None, "the colour of what shines through (`Tf`) is left out");
        }
        for (statement, map) in self.others {
            // Many programs name the same image for both.
            let same = self.texture.as_ref().is_some_and(|t| t.file == map.file);
            if !(same && statement == "map_Ka") {
                report.once(Some(map.line), &format!("`{statement}` is left out"));
            }
        }
        // A missing Kd is white in practice: exporters leave it out next to a texture, or write black there.
        let diffuse = match self.diffuse {
            Some(Vec3::ZERO) | None if self.texture.is_some() => Vec3::ONE,
            None => Vec3::ONE,
            Some(color) => color,
        };
        let specular = self.specular.unwrap_or(Vec3::ZERO);
        let shininess = self.shininess.unwrap_or(DEFAULT_SHININESS);
        // Model 1 has no highlight; an exponent of 0 would be one that is everywhere, which no program shows.
        let highlight = model >= 2 && shininess > 0.0;
        let material = Material {
            name: decoded(&self.name),
            emission: self.emission.unwrap_or(Vec3::ZERO),
            // Exporters write Ka 1 1 1 without meaning it; a tenth of it lights shadows without washing out the picture.
            ambient: self.ambient.unwrap_or(Vec3::ZERO) * 0.1 * diffuse,
            diffuse: diffuse * opacity,
            specular: if highlight { specular } else { Vec3::ZERO },
            shininess: shininess.max(0.0),
            reflection: if matches!(model, 3..=9) { specular } else { Vec3::ZERO },
            transmission: 1.0 - opacity,
            ior: if refracts { self.ior.unwrap_or(1.0).clamp(0.1, 10.0) } else { 1.0 },
            ..Material::default()
        };
        Entry { name: self.name, material, texture: self.texture }
    }
}

/// `r [g [b]]`, where what is missing is as the first, or `xyz x [y [z]]`. `None`, told, for a spectrum in another file.
fn color(values: &[u8], line: u32, report: &mut Report) -> Result<Option<Vec3>, ()> {
    let (first, rest) = keyword(values);
    if first.eq_ignore_ascii_case(b"spectral") {
        report.once(Some(line), "colours given as spectra are left out");
        return Ok(None);
    }
    let is_xyz = first.eq_ignore_ascii_case(b"xyz");
    let mut numbers = [None; 3];
    for (number, word) in numbers.iter_mut().zip(words(if is_xyz { rest } else { values })) {
        *number = Some(float(word).ok_or(())?);
    }
    let x = numbers[0].ok_or(())?;
    let color = Vec3::new(x, numbers[1].unwrap_or(x), numbers[2].unwrap_or(x));
    Ok(Some(if is_xyz { linear_srgb(color) } else { color }))
}

/// CIE XYZ as linear RGB with the primaries and the white of sRGB (IEC 61966-2-1).
fn linear_srgb(xyz: Vec3) -> Vec3 {
    let rgb_from_xyz = Mat3::from_cols(
        Vec3::new(3.240_97, -0.969_244, 0.055_630),
        Vec3::new(-1.537_383, 1.875_968, -0.203_977),
        Vec3::new(-0.498_611, 0.041_555, 1.056_972),
    );
    (rgb_from_xyz * xyz).max(Vec3::ZERO)
}
