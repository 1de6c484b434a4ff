//! The geometry statements of NFF and AFF: `s c p pp tt ttp tpa m`.

use super::Aff;
use crate::load::LoadError;
use crate::load::build::polygon::{fan, triangulate};
use crate::load::build::{Corner, Curved};
use crate::load::input::lexer::Lexer;
use crate::load::model::TriangleKey;
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// Reads the rest of a geometry statement; false when `word` is none.
pub(super) fn statement(aff: &mut Aff, word: &[u8], lexer: &mut Lexer) -> Result<bool, LoadError> {
    match word {
        b"s" => sphere(aff, lexer)?,
        b"c" => cone(aff, lexer)?,
        b"p" => polygon(aff, lexer, false)?,
        b"pp" => polygon(aff, lexer, true)?,
        b"tt" => textured_triangle(aff, lexer, false)?,
        b"ttp" => textured_triangle(aff, lexer, true)?,
        b"tpa" => animated_triangle(aff, lexer)?,
        b"m" => mesh(aff, lexer)?,
        _ => return Ok(false),
    }
    Ok(true)
}

fn vec3(lexer: &mut Lexer, what: &str) -> Result<Vec3, LoadError> {
    Ok(Vec3::from_array(lexer.floats(what)?))
}

fn add(aff: &mut Aff, corners: &[Corner], triangles: &[[u32; 3]], material: u32) {
    aff.builder.add(aff.node, &aff.inside, corners, triangles, material);
}

fn add_curved(aff: &mut Aff, curved: &Curved) {
    aff.builder.add_curved(aff.node, &aff.inside, curved, aff.fill_index);
}

fn sphere(aff: &mut Aff, lexer: &mut Lexer) -> Result<(), LoadError> {
    let center = vec3(lexer, "the centre of a sphere")?;
    let radius = lexer.float("the radius of a sphere")?;
    aff.scene.counts.spheres += 1;
    // A sphere of radius 0 is in many files, and is nothing.
    if radius != 0.0 {
        add_curved(aff, &Curved::sphere(center, radius));
    }
    Ok(())
}

fn cone(aff: &mut Aff, lexer: &mut Lexer) -> Result<(), LoadError> {
    let base = vec3(lexer, "the base of a cone")?;
    let base_radius = lexer.float("the base radius of a cone")?;
    let apex = vec3(lexer, "the apex of a cone")?;
    let apex_radius = lexer.float("the apex radius of a cone")?;
    let Some(cone) = Curved::cone(base, base_radius, apex, apex_radius) else {
        return Err(lexer.error("base and apex of the cone coincide, or both radii are 0"));
    };
    aff.scene.counts.cones += 1;
    add_curved(aff, &cone);
    Ok(())
}

fn polygon(aff: &mut Aff, lexer: &mut Lexer, with_normals: bool) -> Result<(), LoadError> {
    let count = lexer.count("the number of corners", u32::MAX)? as usize;
    if count < 3 {
        return Err(lexer.error(format!("a polygon needs at least 3 corners, found {count}")));
    }
    let mut corners = Vec::with_capacity(count.min(lexer.words_left()));
    for _ in 0..count {
        let position = vec3(lexer, "a corner of a polygon")?;
        let normal = if with_normals { Some(vec3(lexer, "a normal of a polygon")?) } else { None };
        corners.push(Corner { position, normal, tex_coord: Vec2::ZERO });
    }
    let positions: Vec<Vec3> = corners.iter().map(|c| c.position).collect();
    let triangles = triangulate(&positions).unwrap_or_else(|| {
        aff.warn(lexer, "a concave polygon is too large to be cut; it is drawn as a fan");
        fan(count as u32)
    });
    aff.scene.counts.polygons += 1;
    aff.scene.counts.polygon_triangles += triangles.len() as u64;
    add(aff, &corners, &triangles, aff.fill_index);
    Ok(())
}

fn textured_triangle(aff: &mut Aff, lexer: &mut Lexer, with_normals: bool) -> Result<(), LoadError> {
    let texture = lexer.name("the name of a texture")?;
    let material = aff.textured_fill(texture, lexer);
    let mut corners = [Corner { position: Vec3::ZERO, normal: None, tex_coord: Vec2::ZERO }; 3];
    for corner in &mut corners {
        corner.position = vec3(lexer, "a corner of a triangle")?;
        if with_normals {
            corner.normal = Some(vec3(lexer, "a normal of a triangle")?);
        }
        corner.tex_coord = Vec2::from_array(lexer.floats("texture coordinates")?);
    }
    aff.scene.counts.textured_triangles += 1;
    add(aff, &corners, &[[0, 1, 2]], material);
    Ok(())
}

fn animated_triangle(aff: &mut Aff, lexer: &mut Lexer) -> Result<(), LoadError> {
    let count = lexer.count("the number of keys", u32::MAX)? as usize;
    if count == 0 {
        return Err(lexer.error("an animated triangle needs at least one key"));
    }
    let mut keys: Vec<TriangleKey> = Vec::with_capacity(count.min(lexer.words_left()));
    for _ in 0..count {
        let time = lexer.number("the time of a key")?;
        if keys.last().is_some_and(|k| k.time > time) {
            return Err(lexer.error("the keys of an animated triangle must not go back in time"));
        }
        let mut key = TriangleKey { time, positions: [Vec3::ZERO; 3], normals: [Vec3::ZERO; 3] };
        for i in 0..3 {
            key.positions[i] = vec3(lexer, "a corner of an animated triangle")?;
            key.normals[i] = vec3(lexer, "a normal of an animated triangle")?;
        }
        keys.push(key);
    }
    aff.scene.counts.animated_triangles += 1;
    aff.builder.add_keyed(aff.node, &aff.inside, keys, aff.fill_index);
    Ok(())
}

/// The lists of a mesh: positions, and normals and texture coordinates when it has them.
#[derive(Default)]
struct Lists {
    positions: Vec<Vec3>,
    normals: Option<Vec<Vec3>>,
    tex_coords: Option<Vec<Vec2>>,
}

fn mesh(aff: &mut Aff, lexer: &mut Lexer) -> Result<(), LoadError> {
    lexer.expect("vertices")?;
    let count = lexer.count("the number of vertices", u32::MAX)? as usize;
    let mut lists = Lists { positions: Vec::with_capacity(count.min(lexer.words_left())), ..Lists::default() };
    for _ in 0..count {
        lists.positions.push(vec3(lexer, "a vertex")?);
    }
    let mut material = aff.fill_index;
    loop {
        match lexer.peek() {
            Some(b"normals") => {
                lexer.word();
                let count = lexer.count("the number of normals", u32::MAX)? as usize;
                let mut normals = Vec::with_capacity(count.min(lexer.words_left()));
                for _ in 0..count {
                    normals.push(vec3(lexer, "a normal")?);
                }
                lists.normals = Some(normals);
            }
            Some(b"texturecoords") => {
                lexer.word();
                let count = lexer.count("the number of texture coordinates", u32::MAX)? as usize;
                let texture = lexer.name("the name of a texture")?;
                material = aff.textured_fill(texture, lexer);
                let mut tex_coords = Vec::with_capacity(count.min(lexer.words_left()));
                for _ in 0..count {
                    tex_coords.push(Vec2::from_array(lexer.floats("texture coordinates")?));
                }
                lists.tex_coords = Some(tex_coords);
            }
            _ => break,
        }
    }
    lexer.expect("triangles")?;
    mesh_triangles(aff, lexer, &lists, material)
}

fn index(lexer: &mut Lexer, what: &str, length: usize) -> Result<u32, LoadError> {
    let i = lexer.count(what, u32::MAX)?;
    if i as usize >= length {
        return Err(lexer.error(format!("{what} is {i}, but the mesh has only {length}")));
    }
    Ok(i)
}

/// Per triangle: three vertices, then three normals and three texture coordinates if the mesh has them.
fn mesh_triangles(aff: &mut Aff, lexer: &mut Lexer, lists: &Lists, material: u32) -> Result<(), LoadError> {
    let count = lexer.count("the number of triangles", u32::MAX)? as usize;
    let mut corners: Vec<Corner> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(count.min(lexer.words_left()));
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    for _ in 0..count {
        // Vertex, normal and texture coordinate of the three corners; unused ones stay 0.
        let mut ids = [[0_u32; 3]; 3];
        for corner in &mut ids {
            corner[0] = index(lexer, "a vertex number", lists.positions.len())?;
        }
        if let Some(normals) = &lists.normals {
            for corner in &mut ids {
                corner[1] = index(lexer, "a normal number", normals.len())?;
            }
        }
        if let Some(tex_coords) = &lists.tex_coords {
            for corner in &mut ids {
                corner[2] = index(lexer, "a texture coordinate number", tex_coords.len())?;
            }
        }
        triangles.push(ids.map(|id| {
            *known.entry(id).or_insert_with(|| {
                corners.push(Corner {
                    position: lists.positions[id[0] as usize],
                    normal: lists.normals.as_ref().map(|n| n[id[1] as usize]),
                    tex_coord: lists.tex_coords.as_ref().map_or(Vec2::ZERO, |t| t[id[2] as usize]),
                });
                corners.len() as u32 - 1
            })
        }));
    }
    aff.scene.counts.meshes += 1;
    aff.scene.counts.mesh_triangles += triangles.len() as u64;
    add(aff, &corners, &triangles, material);
    Ok(())
}
