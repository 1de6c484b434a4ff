//! Immediate mode: begin, end, vertices and their attributes.
//!
//! Outside an object definition the triangles are drawn too, as OpenGL programmers expect: they form one unstructured object that
//! lives for the frame being assembled, instanced once without a transform, last in the frame.

use super::assembler::{Assembler, Primitive};
use super::context::Context;
use super::error::{Error, Result};
use super::mesh_builder::{Capture, Vertex};
use crate::scene::{ParamScope, ParamType, ParamValue};
use glam::{Vec2, Vec3, Vec4};

/// The attributes that the next vertex gets.
#[derive(Clone, Copy)]
pub(super) struct Current {
    /// As given; None until the first normal since the context, or the definition of the object, began.
    pub normal: Option<Vec3>,
    /// s, t, r, q as given.
    pub tex_coord: Vec4,
    pub color: Vec4,
    /// `normal` under the matrix at begin; 0 for none.
    placed_normal: Vec3,
    /// What is stored of `tex_coord`: s/q, t/q.
    stored_tex_coord: Vec2,
    /// All of them are the default, which takes no memory.
    is_plain: bool,
}

impl Default for Current {
    fn default() -> Self {
        let (normal, tex_coord, color) = (None, Vec4::W, Vec4::ONE);
        Self { normal, tex_coord, color, placed_normal: Vec3::ZERO, stored_tex_coord: Vec2::ZERO, is_plain: true }
    }
}

impl Current {
    pub fn placed_normal(&self) -> Vec3 {
        self.placed_normal
    }

    /// The texture coordinate that is stored: s/q, t/q.
    pub fn stored_tex_coord(&self) -> Vec2 {
        self.stored_tex_coord
    }

    fn set_tex_coord(&mut self, t: Vec4) {
        self.tex_coord = t;
        self.stored_tex_coord = if t.w == 1.0 { Vec2::new(t.x, t.y) } else { Vec2::new(t.x, t.y) / t.w };
        self.look();
    }

    fn look(&mut self) {
        self.is_plain =
            self.placed_normal == Vec3::ZERO && self.stored_tex_coord == Vec2::ZERO && self.color == Vec4::ONE;
    }
}

impl Context {
    /// Opens a primitive.
    ///
    /// # Errors
    /// `InvalidOperation` when one is open.
    pub fn begin(&mut self, primitive: Primitive) -> Result<()> {
        self.outside_begin()?;
        self.open_captures()?;
        self.place_normal();
        self.assembler = Some(Assembler::new(primitive));
        Ok(())
    }

    /// Closes the primitive; vertices that complete no triangle are dropped.
    ///
    /// # Errors
    /// `InvalidOperation` when none is open.
    pub fn end(&mut self) -> Result<()> {
        self.usable()?;
        if self.assembler.take().is_none() {
            return Err(Error::invalid_operation("no primitive is open"));
        }
        Ok(())
    }

    /// A vertex of the open primitive: transformed by the current matrix, divided by its w, with the current attributes.
    /// Triangles with a coordinate that is not finite keep their number, and no ray hits them.
    ///
    /// # Errors
    /// `InvalidOperation` outside begin and end, `OutOfMemory`.
    #[inline]
    pub fn vertex(&mut self, position: Vec4) -> Result<()> {
        let Some(assembler) = &mut self.assembler else { return Err(self.no_primitive()) };
        let position = self.matrices.point(position);
        if self.current.is_plain && self.builder.plain_vertex(assembler, position, self.shaders.bound()) {
            return Ok(());
        }
        self.vertex_with_attributes(position)
    }

    #[inline(never)]
    fn vertex_with_attributes(&mut self, position: Vec3) -> Result<()> {
        let Some(assembler) = &mut self.assembler else { return Err(self.no_primitive()) };
        let vertex = Vertex {
            position,
            normal: self.current.placed_normal,
            tex_coord: self.current.stored_tex_coord,
            color: self.current.color,
        };
        self.builder.vertex(assembler, &vertex, self.shaders.bound(), &self.captures)
    }

    #[cold]
    fn no_primitive(&self) -> Error {
        let outside = || Error::invalid_operation("no primitive is open: a vertex belongs between begin and end");
        self.usable().err().unwrap_or_else(outside)
    }

    /// [`Context::vertex`] with w = 1.
    ///
    /// # Errors
    /// As [`Context::vertex`].
    #[inline]
    pub fn vertex3(&mut self, x: f32, y: f32, z: f32) -> Result<()> {
        self.vertex(Vec4::new(x, y, z, 1.0))
    }

    /// Sets the normal of the vertices that follow; any length. It is transformed by the inverse transpose of the matrix that is
    /// current at the vertex.
    ///
    /// # Errors
    /// None but after a defect.
    #[inline]
    pub fn normal(&mut self, normal: Vec3) -> Result<()> {
        self.usable()?;
        self.current.normal = Some(normal);
        self.place_normal();
        Ok(())
    }

    /// Sets the texture coordinate s, t, r, q of the vertices that follow; s/q and t/q are used.
    ///
    /// # Errors
    /// None but after a defect.
    #[inline]
    pub fn tex_coord(&mut self, tex_coord: Vec4) -> Result<()> {
        self.usable()?;
        self.current.set_tex_coord(tex_coord);
        Ok(())
    }

    /// Sets the linear RGBA colour of the vertices that follow; it multiplies the colour of their shader.
    ///
    /// # Errors
    /// None but after a defect.
    #[inline]
    pub fn color(&mut self, color: Vec4) -> Result<()> {
        self.usable()?;
        self.current.color = color;
        self.current.look();
        Ok(())
    }

    /// Brings the transformed normal in line with the current normal and matrix.
    pub(super) fn place_normal(&mut self) {
        let placed = self.current.normal.map(|n| self.matrices.normal(n).normalize_or_zero());
        self.current.placed_normal = placed.unwrap_or(Vec3::ZERO);
        self.current.look();
    }

    /// Looks up which parameters of the bound shader are captured per vertex or triangle, and prepares their streams.
    pub(super) fn open_captures(&mut self) -> Result<()> {
        self.captures.clear();
        let shader = self.shaders.bound();
        if let Some(state) = self.shaders.get(shader) {
            for (i, (def, value)) in state.class.params.iter().zip(&state.values).enumerate() {
                if def.scope != ParamScope::Shader
                    && let (ParamType::Float(width), &ParamValue::Float(value)) = (def.ty, value)
                {
                    self.captures.try_reserve(1)?;
                    self.captures.push(Capture::new(i as u32, def.scope, u32::from(width), value));
                }
            }
        }
        self.builder.open(shader, &mut self.captures)
    }
}
