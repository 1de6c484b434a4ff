//! The element `vertex`.

use super::header::{Element, Kind};
use super::values::Values;
use crate::load::LoadError;
use glam::{Vec2, Vec3, Vec4};

/// Columns of the vertices; those that the file does not have are empty.
#[derive(Debug, Default)]
pub struct Vertices {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub tex_coords: Vec<Vec2>,
    pub colors: Vec<Vec4>,
}

/// What a property means.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slot {
    Position(usize),
    Normal(usize),
    TexCoord(usize),
    /// Channel, and its value at full brightness.
    Color(usize, f32),
    Unused,
}

/// Channel of a colour property.
pub fn channel(name: &str) -> Option<usize> {
    match name {
        "red" | "diffuse_red" | "r" => Some(0),
        "green" | "diffuse_green" | "g" => Some(1),
        "blue" | "diffuse_blue" | "b" => Some(2),
        "alpha" | "diffuse_alpha" | "a" => Some(3),
        _ => None,
    }
}

/// Full brightness in colours of a type.
pub fn full(kind: Kind) -> f32 {
    match kind {
        Kind::F32 | Kind::F64 => 1.0,
        Kind::U16 => 65535.0,
        _ => 255.0,
    }
}

fn slot(name: &str, kind: Kind) -> Slot {
    match name {
        "x" | "y" | "z" => Slot::Position((name.as_bytes()[0] - b'x').into()),
        "nx" => Slot::Normal(0),
        "ny" => Slot::Normal(1),
        "nz" => Slot::Normal(2),
        "s" | "u" | "texture_u" | "texture_s" => Slot::TexCoord(0),
        "t" | "v" | "texture_v" | "texture_t" => Slot::TexCoord(1),
        _ => channel(name).map_or(Slot::Unused, |c| Slot::Color(c, full(kind))),
    }
}

impl Vertices {
    /// Reads the element; names of properties that mean nothing here are added to `unused`.
    pub fn read(element: &Element, values: &mut Values, unused: &mut Vec<String>) -> Result<Self, LoadError> {
        if !["x", "y", "z"].iter().all(|n| element.has(n)) {
            return Err(values.error("the vertices have no x, y and z"));
        }
        let slots: Vec<Slot> = element
            .properties
            .iter()
            .map(|p| if p.list.is_some() { Slot::Unused } else { slot(&p.name, p.kind) })
            .collect();
        let has = |wanted: fn(&Slot) -> bool, n: usize| slots.iter().filter(|s| wanted(s)).count() >= n;
        let has_normals = has(|s| matches!(s, Slot::Normal(_)), 3);
        let has_tex_coords = has(|s| matches!(s, Slot::TexCoord(_)), 2);
        let has_colors = has(|s| matches!(s, Slot::Color(0..3, _)), 3);
        for (property, slot) in element.properties.iter().zip(&slots) {
            let used = match slot {
                Slot::Position(_) => true,
                Slot::Normal(_) => has_normals,
                Slot::TexCoord(_) => has_tex_coords,
                Slot::Color(..) => has_colors,
                Slot::Unused => false,
            };
            if !used {
                unused.push(format!("{} of vertices", property.name));
            }
        }
        let mut vertices = Self::default();
        let size = |wanted: bool| if wanted { element.count } else { 0 };
        let no_memory = |_| values.error("there is no memory for the vertices");
        vertices.positions.try_reserve_exact(element.count).map_err(no_memory)?;
        vertices.normals.try_reserve_exact(size(has_normals)).map_err(no_memory)?;
        vertices.tex_coords.try_reserve_exact(size(has_tex_coords)).map_err(no_memory)?;
        vertices.colors.try_reserve_exact(size(has_colors)).map_err(no_memory)?;
        for _ in 0..element.count {
            let (mut position, mut normal, mut tex_coord, mut color) = (Vec3::ZERO, Vec3::ZERO, Vec2::ZERO, Vec4::ONE);
            for (property, slot) in element.properties.iter().zip(&slots) {
                if property.list.is_some() {
                    values.skip(property.kind, property.list)?;
                    continue;
                }
                let value = values.next(property.kind, "a value of a vertex")? as f32;
                match *slot {
                    Slot::Position(i) => position[i] = value,
                    Slot::Normal(i) => normal[i] = value,
                    Slot::TexCoord(i) => tex_coord[i] = value,
                    Slot::Color(i, full) => color[i] = value / full,
                    Slot::Unused => {}
                }
            }
            vertices.positions.push(position);
            if has_normals {
                // Scans have none where nothing was seen from two sides.
                vertices.normals.push(if normal.is_finite() { normal } else { Vec3::ZERO });
            }
            if has_tex_coords {
                vertices.tex_coords.push(if tex_coord.is_finite() { tex_coord } else { Vec2::ZERO });
            }
            if has_colors {
                vertices.colors.push(if color.is_finite() { color } else { Vec4::ONE });
            }
        }
        // Floats that some programs write from 0 to 255.
        if vertices.colors.iter().any(|c| c.truncate().max_element() > 1.0) {
            vertices.colors.iter_mut().for_each(|c| *c /= 255.0);
        }
        Ok(vertices)
    }
}
