//! Indexed triangles from typed slices: the vertex arrays of Rust programs.

use super::context::Context;
use super::error::{Error, Result};
use super::mesh_builder::Vertex;
use glam::{Vec2, Vec3, Vec4};

/// Vertices of an indexed mesh. Attributes are empty, and then the current one counts, or have one entry per position.
#[derive(Clone, Copy, Debug, Default)]
pub struct TriangleMesh<'a> {
    pub positions: &'a [Vec3],
    /// Any length; 0 shades the surface flat there.
    pub normals: &'a [Vec3],
    pub tex_coords: &'a [Vec2],
    /// Linear RGBA.
    pub colors: &'a [Vec4],
    pub triangles: &'a [[u32; 3]],
}

impl Context {
    /// Draws a mesh with the current matrix and shader. Every position becomes a vertex of the object, used or not, in this
    /// order; [`Context::update_vertices`] counts so.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end; `InvalidValue` for an index beyond the positions, or an attribute with another
    /// number of entries; `OutOfMemory`. Nothing is drawn then.
    pub fn draw_mesh(&mut self, mesh: &TriangleMesh<'_>) -> Result<()> {
        self.outside_begin()?;
        let count = mesh.positions.len();
        let attributes =
            [("normals", mesh.normals.len()), ("tex_coords", mesh.tex_coords.len()), ("colors", mesh.colors.len())];
        if let Some((what, n)) = attributes.into_iter().find(|&(_, n)| n != 0 && n != count) {
            return Err(Error::invalid_value(format_args!("there are {count} positions and {n} {what}")));
        }
        if let Some(index) = mesh.triangles.as_flattened().iter().find(|&&index| index as usize >= count) {
            return Err(Error::invalid_value(format_args!("index {index} lies beyond the {count} positions")));
        }
        self.all_or_nothing(|context| {
            let placed = &context.matrices;
            let base = context.builder.vertex_count();
            for (i, position) in mesh.positions.iter().enumerate() {
                let vertex = Vertex {
                    position: placed.point(position.extend(1.0)),
                    normal: match mesh.normals.get(i) {
                        Some(&normal) => placed.normal(normal).normalize_or_zero(),
                        None => context.current.placed_normal(),
                    },
                    tex_coord: mesh.tex_coords.get(i).copied().unwrap_or_else(|| context.current.stored_tex_coord()),
                    color: mesh.colors.get(i).copied().unwrap_or(context.current.color),
                };
                context.builder.push_vertex(&vertex, &context.captures)?;
            }
            let shader = context.shaders.bound();
            for triangle in mesh.triangles {
                let corners = triangle.map(|index| (base + index as usize) as u32);
                context.builder.triangle(corners, shader, &context.captures)?;
            }
            Ok(())
        })
    }
}
