//! Second pass: faces as triangles.

use super::tables::Tables;
use super::{Surface, Surfaces};
use crate::load::build::polygon;
use crate::load::input::lexer::show;
use crate::load::input::lines::{Lines, keyword, without_comment, words};
use crate::load::model::Mesh;
use crate::load::report::Report;
use glam::{DVec3, Vec2, Vec3};
use std::collections::{BTreeMap, HashMap};

/// No normal or texture coordinate.
const NONE: u32 = u32::MAX;

/// Numbers of position, texture coordinate and normal of a corner, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Corner {
    position: u32,
    tex_coord: u32,
    normal: u32,
}

/// What makes a vertex of the mesh: a corner, in a smoothing group when it has no normal, with texture coordinates of a transform.
type Key = (Corner, u32, u32);

/// Reads the faces.
pub fn read(text: &[u8], tables: &Tables, surfaces: &Surfaces, report: &mut Report) -> Mesh {
    let mut faces = Faces {
        tables,
        surfaces,
        mesh: Mesh::default(),
        vertices: HashMap::new(),
        smooth: HashMap::new(),
        seen: [0; 3],
        surface: Surface::default(),
        group: 0,
        missing: BTreeMap::new(),
        corners: Vec::new(),
    };
    for (number, line) in Lines::new(text) {
        let (word, rest) = keyword(&line);
        match word {
            b"v" => faces.seen[0] += 1,
            b"vt" => faces.seen[1] += 1,
            b"vn" => faces.seen[2] += 1,
            b"f" | b"fo" => faces.face(rest, number, report),
            b"s" => faces.group = group(without_comment(rest)),
            b"usemtl" => faces.use_material(rest, number),
            _ => {}
        }
    }
    tell_missing(&faces.missing, report);
    faces.finish()
}

/// Most names of materials that are told.
const MOST_NAMES: usize = 20;

/// A file whose library is lost misses all its materials: that is one warning.
fn tell_missing(missing: &BTreeMap<String, u32>, report: &mut Report) {
    let names: Vec<String> = missing.keys().take(MOST_NAMES).map(|name| format!("`{name}`")).collect();
    let line = missing.values().min().copied();
    match names.len() {
        0 => {}
        1 => report.once(line, &format!("material {} is not defined", names[0])),
        n => {
            let further = missing.len() - n;
            let more = if further > 0 { format!(" and {further} more") } else { String::new() };
            report.once(line, &format!("materials {}{more} are not defined", names.join(", ")));
        }
    }
}

/// Number of a smoothing group; 0 is none.
fn group(word: &[u8]) -> u32 {
    match word {
        b"off" | b"" => 0,
        b"on" => 1,
        _ => std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()).unwrap_or(0),
    }
}

struct Faces<'a> {
    tables: &'a Tables,
    surfaces: &'a Surfaces,
    mesh: Mesh,
    vertices: HashMap<Key, u32>,
    /// Sum of the normals of the faces around a position in a smoothing group, longer for larger faces.
    smooth: HashMap<(u32, u32), Vec3>,
    /// Positions, texture coordinates and normals so far; negative numbers count back from there.
    seen: [usize; 3],
    surface: Surface,
    group: u32,
    /// Materials that no library defines, with the line that names them first.
    missing: BTreeMap<String, u32>,
    /// Of the face being read.
    corners: Vec<Corner>,
}

impl Faces<'_> {
    fn use_material(&mut self, name: &[u8], line: u32) {
        self.surface = match self.surfaces.find(name) {
            Some(surface) => surface,
            None => {
                if !name.is_empty() {
                    self.missing.entry(show(name)).or_insert(line);
                }
                Surface::default()
            }
        };
    }

    fn face(&mut self, rest: &[u8], line: u32, report: &mut Report) {
        self.corners.clear();
        for word in words(without_comment(rest)) {
            match self.corner(word) {
                Ok(corner) => self.corners.push(corner),
                Err(why) => return report.broken(line, format!("face with corner `{}`, {why}", show(word))),
            }
        }
        // A polygon that is closed by its first corner.
        if self.corners.len() > 3 && self.corners.first() == self.corners.last() {
            self.corners.pop();
        }
        if self.corners.len() < 3 {
            return report.broken(line, format!("a face needs 3 corners, this one has {}", self.corners.len()));
        }
        let points: Vec<Vec3> = self.corners.iter().map(|c| self.tables.positions[c.position as usize]).collect();
        if !points.iter().all(|p| p.is_finite()) {
            return report.broken(line, "this face uses a vertex whose line is not understood");
        }
        let triangles = match points.len() {
            3 => vec![[0, 1, 2]],
            n => polygon::triangulate(&points).unwrap_or_else(|| {
                report.once(Some(line), "a concave polygon is too large to be cut; it is drawn as a fan");
                polygon::fan(n as u32)
            }),
        };
        if self.mesh.positions.len() + self.corners.len() >= u32::MAX as usize {
            return report.once(Some(line), "there are more corners than 32 bits can number; the others are left out");
        }
        if self.group != 0 {
            let normal = polygon::newell(&points).as_vec3();
            for corner in self.corners.iter().filter(|c| c.normal == NONE) {
                *self.smooth.entry((corner.position, self.group)).or_default() += normal;
            }
        }
        let vertices: Vec<u32> = (0..self.corners.len()).map(|i| self.vertex(self.corners[i])).collect();
        for triangle in triangles {
            self.mesh.triangles.push(triangle.map(|i| vertices[i as usize]));
            self.mesh.materials.push(self.surface.material);
        }
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`, counted from 1, or backwards from −1.
    fn corner(&self, word: &[u8]) -> Result<Corner, String> {
        if word.iter().filter(|&&b| b == b'/').count() > 2 {
            return Err("which has more than three numbers".into());
        }
        let mut numbers = [NONE; 3];
        let totals = [self.tables.positions.len(), self.tables.tex_coords.len(), self.tables.normals.len()];
        for (part, text) in word.split(|&b| b == b'/').enumerate() {
            if text.is_empty() && part > 0 {
                continue;
            }
            let value: i64 =
                std::str::from_utf8(text).ok().and_then(|t| t.parse().ok()).ok_or("which is not a number")?;
            let index = if value < 0 { self.seen[part] as i64 + value } else { value - 1 };
            if index < 0 || index >= totals[part] as i64 {
                let what = ["vertices", "texture coordinates", "normals"][part];
                return Err(format!("but there are {} {what}", totals[part]));
            }
            numbers[part] = index as u32;
        }
        Ok(Corner { position: numbers[0], tex_coord: numbers[1], normal: numbers[2] })
    }

    /// Number of the mesh's vertex for a corner.
    fn vertex(&mut self, corner: Corner) -> u32 {
        let group = if corner.normal == NONE { self.group } else { 0 };
        let transform = if corner.tex_coord == NONE { 0 } else { self.surface.transform };
        let (mesh, tables) = (&mut self.mesh, self.tables);
        *self.vertices.entry((corner, group, transform)).or_insert_with(|| {
            mesh.positions.push(tables.positions[corner.position as usize]);
            if !tables.normals.is_empty() {
                mesh.normals.push(if corner.normal == NONE {
                    Vec3::ZERO
                } else {
                    tables.normals[corner.normal as usize]
                });
            }
            if !tables.tex_coords.is_empty() {
                let t =
                    if corner.tex_coord == NONE { Vec2::ZERO } else { tables.tex_coords[corner.tex_coord as usize] };
                mesh.tex_coords.push(self.surfaces.transforms[transform as usize].apply(t));
            }
            if let Some(color) = tables.colors.get(corner.position as usize) {
                mesh.colors.push(color.extend(1.0));
            }
            mesh.positions.len() as u32 - 1
        })
    }

    fn finish(mut self) -> Mesh {
        if !self.smooth.is_empty() {
            // No normal at all is a normal of length 0: flat.
            self.mesh.normals.resize(self.mesh.positions.len(), Vec3::ZERO);
            for (&(corner, group, _), &vertex) in &self.vertices {
                if let Some(sum) = self.smooth.get(&(corner.position, group)).filter(|_| corner.normal == NONE) {
                    self.mesh.normals[vertex as usize] =
                        sum.as_dvec3().try_normalize().map_or(Vec3::ZERO, DVec3::as_vec3);
                }
            }
        }
        self.mesh
    }
}
