//! Indexed triangles with per-vertex attributes, as the begin/end assembler leaves them.

use super::Name;
use crate::memory::{OutOfMemory, copied, vec_of};
use glam::{Vec2, Vec3, Vec4};

/// Triangles with a coordinate beyond this (or not a number) are dropped: areas and differences of their boxes would overflow. Embree draws the line
/// at the same place.
pub const MAX_COORDINATE: f32 = 1.844e18;

/// Triangles of one object, in object space.
///
/// Invariants: every index is below `positions.len()`; an attribute vector is empty (absent) or has one entry per
/// vertex; `shader_of_triangle` has one entry per triangle. Positions may be NaN or infinite: triangles with such
/// a corner exist (they keep their number) but no ray ever hits them.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Unit length not required; interpolated, then normalised.
    pub normals: Vec<Vec3>,
    pub tex_coords: Vec<Vec2>,
    /// Linear RGBA that multiplies the shader's base colour.
    pub colors: Vec<Vec4>,
    /// Shader bound when the triangle was completed; 0 is the default surface.
    pub shader_of_triangle: Vec<Name>,
    /// Values of per-vertex and per-triangle shader parameters.
    pub params: Vec<ParamStream>,
}

/// One per-vertex or per-triangle shader parameter of a mesh.
#[derive(Clone, Debug)]
pub struct ParamStream {
    /// Shader whose parameter this is; triangles of other shaders ignore the stream.
    pub shader: Name,
    /// Index into the parameters of the shader's class.
    pub param: u32,
    /// Floats per entry, 1 to 4.
    pub width: u32,
    /// `width` floats per vertex ([`super::ParamScope::Vertex`]) or per triangle ([`super::ParamScope::Triangle`]).
    pub data: Vec<f32>,
}

impl Mesh {
    /// A copy.
    ///
    /// # Errors
    /// No memory.
    pub fn try_clone(&self) -> Result<Self, OutOfMemory> {
        let mut params = vec_of(self.params.len())?;
        for stream in &self.params {
            params.push(ParamStream { data: copied(&stream.data)?, ..*stream });
        }
        Ok(Self {
            positions: copied(&self.positions)?,
            triangles: copied(&self.triangles)?,
            normals: copied(&self.normals)?,
            tex_coords: copied(&self.tex_coords)?,
            colors: copied(&self.colors)?,
            shader_of_triangle: copied(&self.shader_of_triangle)?,
            params,
        })
    }

    /// Corners of triangle `prim` in object space.
    #[inline]
    pub fn corners(&self, prim: u32) -> [Vec3; 3] {
        let [a, b, c] = self.triangles[prim as usize];
        [self.positions[a as usize], self.positions[b as usize], self.positions[c as usize]]
    }
}
