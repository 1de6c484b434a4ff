//! Vertex arrays: whole meshes in one call.
//!
//! Arrays are described as in OpenGL (components, type, stride) over plain bytes; every length is checked before the first vertex
//! is read. An indexed draw stores each referenced vertex once, in the order of the array, so that `update_vertices` can count
//! as the array does when every vertex up to the highest is used.

use super::assembler::{Assembler, Primitive};
use super::context::Context;
use super::error::{Error, Result};
use super::mesh_builder::Vertex;
use glam::{Vec2, Vec3, Vec4};

/// Type of the numbers in an array or image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Component {
    Byte,
    UnsignedByte,
    Short,
    UnsignedShort,
    Int,
    UnsignedInt,
    Float,
    Double,
}

impl Component {
    pub fn bytes(self) -> usize {
        match self {
            Component::Byte | Component::UnsignedByte => 1,
            Component::Short | Component::UnsignedShort => 2,
            Component::Int | Component::UnsignedInt | Component::Float => 4,
            Component::Double => 8,
        }
    }

    /// The number at the start of `bytes`; with `normalized`, integers are fractions of their largest value.
    #[inline]
    fn read(self, bytes: &[u8], normalized: bool) -> f64 {
        let scale = |value: f64, largest: f64| if normalized { (value / largest).max(-1.0) } else { value };
        match self {
            Component::Byte => scale(f64::from(i8::from_ne_bytes(head(bytes))), 127.0),
            Component::UnsignedByte => scale(f64::from(bytes[0]), 255.0),
            Component::Short => scale(f64::from(i16::from_ne_bytes(head(bytes))), 32767.0),
            Component::UnsignedShort => scale(f64::from(u16::from_ne_bytes(head(bytes))), 65535.0),
            Component::Int => scale(f64::from(i32::from_ne_bytes(head(bytes))), 2147483647.0),
            Component::UnsignedInt => scale(f64::from(u32::from_ne_bytes(head(bytes))), 4294967295.0),
            Component::Float => f64::from(f32::from_ne_bytes(head(bytes))),
            Component::Double => f64::from_ne_bytes(head(bytes)),
        }
    }

    /// The number at the start of `bytes` as a colour of 8 bits; NaN is 0.
    pub(super) fn read_unorm8(self, bytes: &[u8]) -> u8 {
        match self {
            Component::UnsignedByte => bytes[0],
            _ => (self.read(bytes, true) * 255.0 + 0.5) as u8,
        }
    }
}

#[inline]
fn head<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes[..N].try_into().expect("N bytes")
}

/// One attribute of all vertices.
#[derive(Clone, Copy, Debug)]
pub struct VertexArray<'a> {
    /// Numbers per vertex: 2–4 for positions, 3 for normals, 3–4 for colours, 1–4 for texture coordinates.
    pub size: u32,
    pub component: Component,
    /// Bytes from one vertex to the next; 0 when they follow each other without a gap.
    pub stride: usize,
    pub bytes: &'a [u8],
}

impl<'a> VertexArray<'a> {
    fn step(&self) -> usize {
        if self.stride == 0 { self.element_bytes() } else { self.stride }
    }

    fn element_bytes(&self) -> usize {
        self.size as usize * self.component.bytes()
    }

    /// Bytes that `vertices` vertices take; None beyond the address space.
    pub fn bytes_needed(&self, vertices: usize) -> Option<usize> {
        match vertices.checked_sub(1) {
            None => Some(0),
            Some(last) => self.step().checked_mul(last)?.checked_add(self.element_bytes()),
        }
    }

    fn check(&self, sizes: std::ops::RangeInclusive<u32>, vertices: usize, what: &str) -> Result<()> {
        if !sizes.contains(&self.size) {
            let (least, most) = (sizes.start(), sizes.end());
            return Err(Error::invalid_value(format_args!(
                "{what} have {} components; they must have {least} to {most}",
                self.size
            )));
        }
        if self.bytes_needed(vertices).is_none_or(|needed| needed > self.bytes.len()) {
            let bytes = self.bytes.len();
            return Err(Error::invalid_value(format_args!(
                "the array of {what} has {bytes} bytes, too few for {vertices} vertices"
            )));
        }
        Ok(())
    }

    /// Vertex `index`; what the array does not hold is taken from `rest`.
    #[inline]
    fn get(&self, index: usize, normalized: bool, rest: Vec4) -> Vec4 {
        let bytes = &self.bytes[index * self.step()..];
        let size = self.component.bytes();
        let mut out = rest.to_array();
        if self.component == Component::Float {
            // By far the most frequent.
            for (out, bytes) in out.iter_mut().zip(bytes.chunks_exact(4)).take(self.size as usize) {
                *out = f32::from_ne_bytes(head(bytes));
            }
            return Vec4::from_array(out);
        }
        for (i, out) in out.iter_mut().enumerate().take(self.size as usize) {
            *out = self.component.read(&bytes[i * size..], normalized) as f32;
        }
        Vec4::from_array(out)
    }
}

/// The arrays that a draw reads; absent ones leave the current attribute.
#[derive(Clone, Copy, Debug)]
pub struct VertexArrays<'a> {
    pub positions: VertexArray<'a>,
    pub normals: Option<VertexArray<'a>>,
    pub colors: Option<VertexArray<'a>>,
    pub tex_coords: Option<VertexArray<'a>>,
}

impl VertexArrays<'_> {
    /// Whether all arrays hold `vertices` vertices of a sensible number of components.
    fn check(&self, vertices: usize) -> Result<()> {
        self.positions.check(2..=4, vertices, "positions")?;
        let optional = [
            (&self.normals, 3..=3, "normals"),
            (&self.colors, 3..=4, "colours"),
            (&self.tex_coords, 1..=4, "texture coordinates"),
        ];
        for (array, sizes, what) in optional {
            if let Some(array) = array {
                array.check(sizes, vertices, what)?;
            }
        }
        Ok(())
    }
}

/// Indices of an indexed draw: unsigned bytes, shorts or ints without gaps.
#[derive(Clone, Copy, Debug)]
pub struct Indices<'a> {
    component: Component,
    bytes: &'a [u8],
}

impl<'a> Indices<'a> {
    /// # Errors
    /// `InvalidEnum` when `component` is not an unsigned integer.
    pub fn new(component: Component, bytes: &'a [u8]) -> Result<Self> {
        match component {
            Component::UnsignedByte | Component::UnsignedShort | Component::UnsignedInt => {
                Ok(Self { component, bytes })
            }
            _ => Err(Error::invalid_enum(format_args!(
                "indices are of type {component:?}; they must be unsigned bytes, shorts or ints"
            ))),
        }
    }

    pub fn len(&self) -> usize {
        self.bytes.len() / self.component.bytes()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn iter(&self) -> impl ExactSizeIterator<Item = u32> + use<'a> {
        let component = self.component;
        self.bytes.chunks_exact(component.bytes()).map(move |bytes| match component {
            Component::UnsignedByte => u32::from(bytes[0]),
            Component::UnsignedShort => u32::from(u16::from_ne_bytes(head(bytes))),
            _ => u32::from_ne_bytes(head(bytes)),
        })
    }

    /// All of them.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn to_vec(&self) -> Result<Vec<u32>> {
        let mut all = Vec::new();
        all.try_reserve_exact(self.len())?;
        all.extend(self.iter());
        Ok(all)
    }

    /// The highest index; tells a caller who holds only pointers how long the arrays must be.
    pub fn max(&self) -> Option<u32> {
        self.iter().max()
    }
}

impl Context {
    /// Draws vertices `first..first + count` of `arrays`, as if by `begin`, a `vertex` each, and `end`.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end; `InvalidValue` for negative numbers, a wrong number of components or
    /// an array that is too short; `OutOfMemory`. Nothing is drawn then.
    pub fn draw_arrays(
        &mut self,
        primitive: Primitive,
        arrays: &VertexArrays<'_>,
        first: i32,
        count: i32,
    ) -> Result<()> {
        self.outside_begin()?;
        let (Ok(first), Ok(count)) = (usize::try_from(first), usize::try_from(count)) else {
            return Err(Error::invalid_value(format_args!(
                "first is {first} and count {count}; neither may be negative"
            )));
        };
        if count == 0 {
            return Ok(());
        }
        arrays.check(first + count)?;
        self.all_or_nothing(|context| {
            let mut assembler = Assembler::new(primitive);
            let shader = context.shaders.bound();
            for index in first..first + count {
                let vertex = context.array_vertex(arrays, index);
                context.builder.vertex(&mut assembler, &vertex, shader, &context.captures)?;
            }
            Ok(())
        })
    }

    /// Draws the vertices that `indices` name. Each becomes one vertex of the object, however often it is named.
    ///
    /// # Errors
    /// As [`Context::draw_arrays`].
    pub fn draw_elements(
        &mut self,
        primitive: Primitive,
        arrays: &VertexArrays<'_>,
        indices: Indices<'_>,
    ) -> Result<()> {
        self.outside_begin()?;
        let Some(highest) = indices.max() else { return Ok(()) };
        arrays.check(highest as usize + 1)?;
        let used = used_vertices(&indices, highest)?;
        self.all_or_nothing(|context| {
            let base = context.builder.vertex_count();
            for &index in &used {
                let vertex = context.array_vertex(arrays, index as usize);
                context.builder.push_vertex(&vertex, &context.captures)?;
            }
            let mut assembler = Assembler::new(primitive);
            let shader = context.shaders.bound();
            let dense = used.len() == highest as usize + 1;
            for index in indices.iter() {
                let position = if dense {
                    index as usize
                } else {
                    used.binary_search(&index).expect("every index is among the used")
                };
                context.builder.reuse_vertex(&mut assembler, (base + position) as u32, shader, &context.captures)?;
            }
            Ok(())
        })
    }

    /// Runs `draw`; on failure the mesh is what it was before.
    pub(super) fn all_or_nothing(&mut self, draw: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.open_captures()?;
        self.place_normal();
        let mark = self.builder.mark()?;
        draw(self).inspect_err(|_| self.builder.rewind(&mark))
    }

    fn array_vertex(&self, arrays: &VertexArrays<'_>, index: usize) -> Vertex {
        let placed = &self.matrices;
        Vertex {
            position: placed.point(arrays.positions.get(index, false, Vec4::W)),
            normal: match &arrays.normals {
                Some(array) => placed.normal(array.get(index, true, Vec4::ZERO).truncate()).normalize_or_zero(),
                None => self.current.placed_normal(),
            },
            tex_coord: match &arrays.tex_coords {
                Some(array) => {
                    let t = array.get(index, false, Vec4::W);
                    Vec2::new(t.x, t.y) / t.w
                }
                None => self.current.stored_tex_coord(),
            },
            color: arrays.colors.map_or(self.current.color, |array| array.get(index, true, Vec4::ONE)),
        }
    }
}

/// The different indices, ascending.
fn used_vertices(indices: &Indices<'_>, highest: u32) -> Result<Vec<u32>> {
    let range = highest as usize + 1;
    let mut used = Vec::new();
    if range / 8 <= indices.len() {
        // Dense enough for a table of flags.
        let mut flags: Vec<bool> = Vec::new();
        flags.try_reserve_exact(range)?;
        flags.resize(range, false);
        indices.iter().for_each(|index| flags[index as usize] = true);
        used.try_reserve_exact(flags.iter().filter(|&&f| f).count())?;
        used.extend((0..=highest).filter(|&index| flags[index as usize]));
    } else {
        used.try_reserve_exact(indices.len())?;
        used.extend(indices.iter());
        used.sort_unstable();
        used.dedup();
    }
    Ok(used)
}

/// Positions for [`Context::update_vertices`] (or normals) from an array.
///
/// # Errors
/// `InvalidValue` for a wrong number of components or an array that is too short; `OutOfMemory`.
pub fn decode_vectors(array: &VertexArray<'_>, count: usize) -> Result<Vec<Vec3>> {
    array.check(2..=4, count, "vertices")?;
    let mut out = Vec::new();
    out.try_reserve_exact(count)?;
    out.extend((0..count).map(|index| {
        let v = array.get(index, false, Vec4::W);
        if v.w == 1.0 { v.truncate() } else { v.truncate() / v.w }
    }));
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_read_and_normalised() {
        let one = |component, bytes: &[u8], normalized| {
            VertexArray { size: 1, component, stride: 0, bytes }.get(0, normalized, Vec4::ZERO).x
        };
        assert_eq!(one(Component::UnsignedByte, &[255], true), 1.0);
        assert_eq!(one(Component::Byte, &[0x80], true), -1.0);
        assert_eq!(one(Component::Byte, &[0x80], false), -128.0);
        assert_eq!(one(Component::Short, &(-5i16).to_ne_bytes(), false), -5.0);
        assert_eq!(one(Component::UnsignedInt, &u32::MAX.to_ne_bytes(), true), 1.0);
        assert_eq!(one(Component::Double, &0.25f64.to_ne_bytes(), true), 0.25);
    }

    #[test]
    fn lengths_are_exact_and_cannot_overflow() {
        let bytes = [0u8; 20];
        let array = |stride| VertexArray { size: 3, component: Component::Float, stride, bytes: &bytes };
        assert_eq!(array(8).bytes_needed(2), Some(20));
        assert!(array(8).check(3..=3, 2, "x").is_ok());
        assert!(array(9).check(3..=3, 2, "x").is_err());
        assert!(array(usize::MAX).check(3..=3, 3, "x").is_err());
        assert!(array(8).check(2..=2, 1, "x").is_err());
    }

    #[test]
    fn used_vertices_dense_and_sparse_agree() {
        let values = [7u32, 3, 3, 9, 7, 0];
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
        let indices = Indices::new(Component::UnsignedInt, &bytes).unwrap();
        assert_eq!(used_vertices(&indices, 9).unwrap(), [0, 3, 7, 9]);
        assert_eq!(used_vertices(&indices, 4_000_000).unwrap(), [0, 3, 7, 9]);
        assert!(Indices::new(Component::Float, &bytes).is_err());
    }
}
