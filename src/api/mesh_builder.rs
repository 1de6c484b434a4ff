//! Collects the vertices and triangles of the object that is being defined.
//!
//! Vertex `n` of the finished mesh is the `n`-th vertex that was given, whether or not a triangle uses it; that is what
//! [`super::Context::update_vertices`] counts. Attributes that were never given cost no memory: their vector stays empty
//! until the first vertex that differs from the default, and is then filled up for the vertices before it.
//!
//! Every growth reserves first and stores afterwards, so that running out of memory leaves the mesh as it was.

use super::assembler::{Assembler, Completed};
use super::error::{Error, Result};
use crate::scene::{Mesh, Name, ParamScope, ParamStream};
use glam::{Vec2, Vec3, Vec4};

/// One vertex, in object space.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    pub position: Vec3,
    /// 0 when the application gave none: the surface is shaded flat there.
    pub normal: Vec3,
    pub tex_coord: Vec2,
    pub color: Vec4,
}

/// A per-vertex or per-triangle parameter of the shader that is bound between begin and end.
#[derive(Clone, Copy, Debug)]
pub struct Capture {
    pub param: u32,
    pub scope: ParamScope,
    /// Floats per entry, 1 to 4.
    pub width: u32,
    pub value: [f32; 4],
    /// Index into the mesh's streams; set by [`MeshBuilder::open`].
    stream: usize,
}

impl Capture {
    pub fn new(param: u32, scope: ParamScope, width: u32, value: [f32; 4]) -> Self {
        Self { param, scope, width, value, stream: 0 }
    }
}

const MOST_VERTICES: usize = u32::MAX as usize;
/// Before the last vertex, which may add two.
const MOST_TRIANGLES: usize = u32::MAX as usize - 1;

#[derive(Default)]
pub struct MeshBuilder {
    mesh: Mesh,
    /// Scope of each of the mesh's streams.
    scopes: Vec<ParamScope>,
    /// How many vertices fit in that have nothing but a position, with the triangles they complete; 0 as soon as a vertex has more.
    plain_room: usize,
}

/// Lengths to return to; see [`MeshBuilder::rewind`].
pub struct Mark {
    vertices: usize,
    triangles: usize,
    normals: usize,
    tex_coords: usize,
    colors: usize,
    streams: Vec<usize>,
}

impl MeshBuilder {
    pub fn vertex_count(&self) -> usize {
        self.mesh.positions.len()
    }

    /// Prepares for a primitive whose triangles have `shader`: finds or makes the streams of `captures`.
    pub fn open(&mut self, shader: Name, captures: &mut [Capture]) -> Result<()> {
        self.plain_room = 0;
        for capture in captures {
            let known = self.mesh.params.iter().position(|s| s.shader == shader && s.param == capture.param);
            capture.stream = match known {
                Some(i) => i,
                None => {
                    self.mesh.params.try_reserve(1)?;
                    self.scopes.try_reserve(1)?;
                    self.scopes.push(capture.scope);
                    let stream = ParamStream { shader, param: capture.param, width: capture.width, data: Vec::new() };
                    self.mesh.params.push(stream);
                    self.mesh.params.len() - 1
                }
            };
            self.pad_stream(capture.stream)?;
        }
        Ok(())
    }

    /// Appends a vertex that has the default attributes, and the triangles that it completes, without memory being asked for. False, and nothing is done, where
    /// that cannot be: [`MeshBuilder::vertex`] does it then.
    #[inline]
    pub fn plain_vertex(&mut self, assembler: &mut Assembler, position: Vec3, shader: Name) -> bool {
        if self.plain_room == 0 {
            return false;
        }
        self.plain_room -= 1;
        let index = self.mesh.positions.len() as u32;
        self.mesh.positions.push(position);
        self.complete(assembler.push(index), shader, &[]);
        true
    }

    /// Appends a vertex and the triangles that it completes.
    pub fn vertex(
        &mut self,
        assembler: &mut Assembler,
        vertex: &Vertex,
        shader: Name,
        captures: &[Capture],
    ) -> Result<()> {
        if !(captures.is_empty() && self.has_room(vertex)) {
            self.make_room(vertex, captures)?;
        }
        let index = self.store_vertex(vertex, captures);
        self.complete(assembler.push(index), shader, captures);
        self.plain_room = if captures.is_empty() { self.room_for_plain() } else { 0 };
        Ok(())
    }

    /// Whether a vertex without captures, and the triangles that it completes, fit in without any reserve.
    #[inline]
    fn has_room(&self, vertex: &Vertex) -> bool {
        fn fits<T>(values: &Vec<T>, more: usize) -> bool {
            values.capacity() - values.len() >= more
        }
        fn takes<T>(values: &Vec<T>, differs: bool) -> bool {
            if values.is_empty() { !differs } else { fits(values, 1) }
        }
        let mesh = &self.mesh;
        fits(&mesh.positions, 1)
            && fits(&mesh.triangles, 2)
            && fits(&mesh.shader_of_triangle, 2)
            && takes(&mesh.normals, vertex.normal != Vec3::ZERO)
            && takes(&mesh.tex_coords, vertex.tex_coord != Vec2::ZERO)
            && takes(&mesh.colors, vertex.color != Vec4::ONE)
            && mesh.positions.len() < MOST_VERTICES
            && mesh.triangles.len() < MOST_TRIANGLES
    }

    #[cold]
    #[inline(never)]
    fn make_room(&mut self, vertex: &Vertex, captures: &[Capture]) -> Result<()> {
        self.reserve_triangles(captures)?;
        self.reserve_vertex(vertex, captures)
    }

    #[inline]
    fn room_for_plain(&self) -> usize {
        fn room<T>(values: &Vec<T>, most: usize) -> usize {
            values.capacity().min(most).saturating_sub(values.len())
        }
        let mesh = &self.mesh;
        if !(mesh.normals.is_empty() && mesh.tex_coords.is_empty() && mesh.colors.is_empty()) {
            return 0;
        }
        // A vertex completes two triangles at most.
        let triangles = room(&mesh.triangles, MOST_TRIANGLES).min(room(&mesh.shader_of_triangle, MOST_TRIANGLES));
        room(&mesh.positions, MOST_VERTICES).min(triangles / 2)
    }

    /// Feeds the assembler a vertex that is already in the mesh.
    pub fn reuse_vertex(
        &mut self,
        assembler: &mut Assembler,
        index: u32,
        shader: Name,
        captures: &[Capture],
    ) -> Result<()> {
        self.reserve_triangles(captures)?;
        self.complete(assembler.push(index), shader, captures);
        Ok(())
    }

    /// Appends a triangle between vertices of the mesh.
    pub fn triangle(&mut self, corners: [u32; 3], shader: Name, captures: &[Capture]) -> Result<()> {
        self.reserve_triangles(captures)?;
        self.push_triangle(corners, shader, captures);
        Ok(())
    }

    /// Appends a vertex and returns its number.
    pub fn push_vertex(&mut self, vertex: &Vertex, captures: &[Capture]) -> Result<u32> {
        self.reserve_vertex(vertex, captures)?;
        Ok(self.store_vertex(vertex, captures))
    }

    fn reserve_vertex(&mut self, vertex: &Vertex, captures: &[Capture]) -> Result<()> {
        let mesh = &mut self.mesh;
        let index = mesh.positions.len();
        if index >= MOST_VERTICES {
            return Err(Error::new(super::ErrorCode::OutOfMemory, "an object holds at most 2^32 - 1 vertices"));
        }
        mesh.positions.try_reserve(1)?;
        reserve_attribute(&mut mesh.normals, index, vertex.normal != Vec3::ZERO)?;
        reserve_attribute(&mut mesh.tex_coords, index, vertex.tex_coord != Vec2::ZERO)?;
        reserve_attribute(&mut mesh.colors, index, vertex.color != Vec4::ONE)?;
        for capture in captures.iter().filter(|c| c.scope == ParamScope::Vertex) {
            mesh.params[capture.stream].data.try_reserve(capture.width as usize)?;
        }
        Ok(())
    }

    /// Appends a vertex for which there is room, and returns its number.
    #[inline]
    fn store_vertex(&mut self, vertex: &Vertex, captures: &[Capture]) -> u32 {
        let mesh = &mut self.mesh;
        let index = mesh.positions.len();
        mesh.positions.push(vertex.position);
        push_attribute(&mut mesh.normals, index, vertex.normal, Vec3::ZERO);
        push_attribute(&mut mesh.tex_coords, index, vertex.tex_coord, Vec2::ZERO);
        push_attribute(&mut mesh.colors, index, vertex.color, Vec4::ONE);
        for capture in captures.iter().filter(|c| c.scope == ParamScope::Vertex) {
            mesh.params[capture.stream].data.extend_from_slice(&capture.value[..capture.width as usize]);
        }
        index as u32
    }

    fn reserve_triangles(&mut self, captures: &[Capture]) -> Result<()> {
        self.mesh.triangles.try_reserve(2)?;
        self.mesh.shader_of_triangle.try_reserve(2)?;
        for capture in captures.iter().filter(|c| c.scope == ParamScope::Triangle) {
            self.mesh.params[capture.stream].data.try_reserve(2 * capture.width as usize)?;
        }
        if self.mesh.triangles.len() >= MOST_TRIANGLES {
            return Err(Error::new(super::ErrorCode::OutOfMemory, "an object holds at most 2^32 - 1 triangles"));
        }
        Ok(())
    }

    #[inline]
    fn complete(&mut self, completed: Completed, shader: Name, captures: &[Capture]) {
        match completed {
            Completed::None => {}
            Completed::One(a) => self.push_triangle(a, shader, captures),
            Completed::Two(a, b) => {
                self.push_triangle(a, shader, captures);
                self.push_triangle(b, shader, captures);
            }
        }
    }

    #[inline]
    fn push_triangle(&mut self, corners: [u32; 3], shader: Name, captures: &[Capture]) {
        self.mesh.triangles.push(corners);
        self.mesh.shader_of_triangle.push(shader);
        for capture in captures.iter().filter(|c| c.scope == ParamScope::Triangle) {
            self.mesh.params[capture.stream].data.extend_from_slice(&capture.value[..capture.width as usize]);
        }
    }

    /// Fills a stream with zeros up to the current number of vertices or triangles; those belong to other shaders.
    fn pad_stream(&mut self, stream: usize) -> Result<()> {
        let entries = match self.scopes[stream] {
            ParamScope::Triangle => self.mesh.triangles.len(),
            _ => self.mesh.positions.len(),
        };
        let stream = &mut self.mesh.params[stream];
        let len = entries * stream.width as usize;
        stream.data.try_reserve(len - stream.data.len())?;
        stream.data.resize(len, 0.0);
        Ok(())
    }

    pub fn mark(&self) -> Result<Mark> {
        let mut streams = Vec::new();
        streams.try_reserve_exact(self.mesh.params.len())?;
        streams.extend(self.mesh.params.iter().map(|s| s.data.len()));
        Ok(Mark {
            vertices: self.mesh.positions.len(),
            triangles: self.mesh.triangles.len(),
            normals: self.mesh.normals.len(),
            tex_coords: self.mesh.tex_coords.len(),
            colors: self.mesh.colors.len(),
            streams,
        })
    }

    /// Forgets what was added since `mark`.
    pub fn rewind(&mut self, mark: &Mark) {
        self.mesh.positions.truncate(mark.vertices);
        self.mesh.triangles.truncate(mark.triangles);
        self.mesh.shader_of_triangle.truncate(mark.triangles);
        self.mesh.normals.truncate(mark.normals);
        self.mesh.tex_coords.truncate(mark.tex_coords);
        self.mesh.colors.truncate(mark.colors);
        for (i, stream) in self.mesh.params.iter_mut().enumerate() {
            stream.data.truncate(mark.streams.get(i).copied().unwrap_or(0));
        }
    }

    /// Brings every stream to full length, after which [`MeshBuilder::into_mesh`] cannot fail.
    pub fn finish(&mut self) -> Result<()> {
        (0..self.mesh.params.len()).try_for_each(|stream| self.pad_stream(stream))
    }

    /// A copy of the mesh, after [`MeshBuilder::finish`].
    pub fn try_copy(&self) -> Result<Mesh> {
        Ok(self.mesh.try_clone()?)
    }

    /// The mesh, with the invariants of [`Mesh`].
    pub fn into_mesh(self) -> Mesh {
        self.mesh
    }
}

/// A copy of `values`, or the news that there is no memory for it.
pub fn try_copy<T: Copy>(values: &[T]) -> Result<Vec<T>> {
    let mut out = Vec::new();
    out.try_reserve_exact(values.len())?;
    out.extend_from_slice(values);
    Ok(out)
}

#[inline]
fn reserve_attribute<T>(values: &mut Vec<T>, index: usize, differs: bool) -> Result<()> {
    if !values.is_empty() {
        values.try_reserve(1)?;
    } else if differs {
        values.try_reserve(index + 1)?;
    }
    Ok(())
}

/// Stores the value of vertex `index`; needs a call of [`reserve_attribute`] before.
#[inline]
fn push_attribute<T: Copy + PartialEq>(values: &mut Vec<T>, index: usize, value: T, default: T) {
    if values.is_empty() {
        if value == default {
            return;
        }
        values.resize(index, default);
    }
    values.push(value);
}

#[cfg(test)]
#[path = "mesh_builder_tests.rs"]
mod tests;
