//! Meshes as objects, and what moves their vertices.

use crate::api::{Context, Error, Mode, Motion, Name, TriangleMesh};
use crate::load::{Deform, Deformed, Mesh, Object};
use glam::Vec3;
use std::collections::HashMap;

/// An object as the library knows it.
pub struct Placed {
    pub name: Name,
    /// For deforming objects: the mesh vertex behind each vertex of the library's object.
    sources: Vec<u32>,
    has_normals: bool,
}

/// Triangles of one material.
struct Group {
    material: u32,
    triangles: Vec<[u32; 3]>,
}

/// The triangles of a mesh by material, in the order of first use.
fn groups(mesh: &Mesh) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let mut group_of: HashMap<u32, usize> = HashMap::new();
    for (triangle, &material) in mesh.triangles.iter().zip(&mesh.materials) {
        let group = *group_of.entry(material).or_insert_with(|| {
            groups.push(Group { material, triangles: Vec::new() });
            groups.len() - 1
        });
        groups[group].triangles.push(*triangle);
    }
    groups
}

/// Compiles an object under the identity: one draw for each of its materials. `surfaces` are the shaders of the materials.
pub fn define(
    context: &mut Context,
    name: Name,
    object: &Object,
    motion: Motion,
    surfaces: &[Name],
) -> Result<Placed, Error> {
    context.new_object(name, Mode::Compile, motion)?;
    let drawn = draw(context, object, surfaces);
    // What was begun is ended also when a part of it was refused.
    context.bind_shader(0)?;
    context.end_object()?;
    match drawn {
        Ok(sources) => Ok(Placed { name, sources, has_normals: !object.mesh.normals.is_empty() }),
        Err(error) => {
            context.delete_objects(name, 1)?;
            Err(error)
        }
    }
}

/// Draws the mesh; the answer is the mesh vertex behind each vertex drawn, for objects that deform.
fn draw(context: &mut Context, object: &Object, surfaces: &[Name]) -> Result<Vec<u32>, Error> {
    let mesh = &object.mesh;
    let surface = |material: u32| surfaces.get(material as usize).copied().unwrap_or(0);
    let deforms = !matches!(object.deform, Deform::Rigid);
    let alike = || mesh.materials.windows(2).all(|w| w[0] == w[1]);
    if object.material.is_some() || alike() {
        let material = object.material.or(mesh.materials.first().copied()).unwrap_or(0);
        context.bind_shader(surface(material))?;
        context.draw_mesh(&TriangleMesh {
            positions: &mesh.positions,
            normals: &mesh.normals,
            tex_coords: &mesh.tex_coords,
            colors: &mesh.colors,
            triangles: &mesh.triangles,
        })?;
        return Ok(if deforms { (0..mesh.positions.len() as u32).collect() } else { Vec::new() });
    }
    let mut sources: Vec<u32> = Vec::new();
    // Number of each vertex in the group that used it last, and that group.
    let mut seen = vec![(u32::MAX, 0_u32); mesh.positions.len()];
    for (number, mut group) in groups(mesh).into_iter().enumerate() {
        // The group's own vertices, numbered in the order of first use.
        let first = sources.len();
        for vertex in group.triangles.as_flattened_mut() {
            let (user, slot) = &mut seen[*vertex as usize];
            if *user != number as u32 {
                (*user, *slot) = (number as u32, (sources.len() - first) as u32);
                sources.push(*vertex);
            }
            *vertex = *slot;
        }
        context.bind_shader(surface(group.material))?;
        let own = &sources[first..];
        context.draw_mesh(&TriangleMesh {
            positions: &picked(&mesh.positions, own),
            normals: &picked(&mesh.normals, own),
            tex_coords: &picked(&mesh.tex_coords, own),
            colors: &picked(&mesh.colors, own),
            triangles: &group.triangles,
        })?;
    }
    Ok(if deforms { sources } else { Vec::new() })
}

/// The values of the vertices `sources`; none when there are none.
fn picked<T: Copy>(values: &[T], sources: &[u32]) -> Vec<T> {
    if values.is_empty() { Vec::new() } else { sources.iter().map(|&v| values[v as usize]).collect() }
}

/// Moves the vertices of a deforming object.
pub fn update(context: &mut Context, placed: &Placed, deformed: &Deformed) -> Result<(), Error> {
    let pick = |values: &[Vec3]| picked(values, &placed.sources);
    context.update_vertices(placed.name, 0, pick(&deformed.positions))?;
    if placed.has_normals && !deformed.normals.is_empty() {
        context.update_normals(placed.name, 0, pick(&deformed.normals))?;
    }
    Ok(())
}
