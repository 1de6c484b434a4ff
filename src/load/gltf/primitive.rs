//! One primitive of a mesh: its triangles with the vertices that they use.

use super::file::accessor::Accessor;
use super::file::document::Document;
use super::file::draco::{self, Unpacked};
use super::json::{Kind, Primitive};
use super::material::Needs;
use crate::load::LoadError;
use crate::load::model::{Mesh, MorphTarget};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// A primitive as read. Its vertices are those that triangles use, in the order of first use.
pub struct Part {
    pub mesh: Mesh,
    pub targets: Vec<MorphTarget>,
    /// The number in the file of each vertex.
    pub sources: Vec<u32>,
}

/// Numbers of an attribute, from an accessor or from a compressed mesh.
pub enum Numbers<'a> {
    Accessor(Accessor<'a>),
    Unpacked(Unpacked),
}

impl Numbers<'_> {
    pub fn len(&self) -> usize {
        match self {
            Numbers::Accessor(accessor) => accessor.len(),
            Numbers::Unpacked(unpacked) => unpacked.len(),
        }
    }

    pub fn floats<const N: usize>(&self, i: usize) -> [f32; N] {
        match self {
            Numbers::Accessor(accessor) => accessor.floats(i),
            Numbers::Unpacked(unpacked) => unpacked.floats(i),
        }
    }

    pub fn integers<const N: usize>(&self, i: usize) -> [u32; N] {
        match self {
            Numbers::Accessor(accessor) => accessor.integers(i),
            Numbers::Unpacked(unpacked) => unpacked.floats(i).map(|x: f32| x as u32),
        }
    }
}

/// Where the attributes of a primitive come from.
pub struct Source<'d> {
    document: &'d Document<'d>,
    primitive: &'d Primitive,
    place: String,
    draco: Option<draco::Compressed<'d>>,
}

impl<'d> Source<'d> {
    pub fn new(document: &'d Document<'d>, primitive: &'d Primitive, place: String) -> Result<Self, LoadError> {
        let draco = primitive.extensions.as_ref().and_then(|e| e.draco.as_ref());
        let draco = match draco {
            Some(packed) => Some(draco::Compressed::decode(document, primitive, packed, &place)?),
            None => None,
        };
        Ok(Self { document, primitive, place, draco })
    }

    pub fn place(&self) -> String {
        self.place.clone()
    }

    pub fn fault(&self, text: &str) -> LoadError {
        self.document.error(format!("{}: {text}", self.place))
    }

    /// The attribute that `choose` picks, of `N` components.
    pub fn numbers<const N: usize>(
        &self,
        choose: impl Fn(&super::json::Attributes) -> Option<u32>,
    ) -> Result<Option<Numbers<'d>>, LoadError> {
        let Some(index) = choose(&self.primitive.attributes) else { return Ok(None) };
        if let Some(draco) = &self.draco {
            let most = self.document.accessor_range(index, || self.place())?;
            if let Some(unpacked) = draco.attribute(&choose, N, most).map_err(|why| self.fault(&why))? {
                return Ok(Some(Numbers::Unpacked(unpacked)));
            }
        }
        Ok(Some(Numbers::Accessor(self.document.accessor_of::<N>(index, || self.place())?)))
    }

    /// As [`Source::numbers`], of unsigned integers.
    pub fn integers<const N: usize>(
        &self,
        choose: impl Fn(&super::json::Attributes) -> Option<u32>,
    ) -> Result<Option<Numbers<'d>>, LoadError> {
        if let (None, Some(index)) = (&self.draco, choose(&self.primitive.attributes)) {
            self.document.integers_of::<N>(index, || self.place())?;
        }
        self.numbers::<N>(choose)
    }

    /// Vertices of the triangles, before they are gathered; `None`, and a note, for points and lines.
    fn corners(&self, vertices: usize) -> Result<Option<Vec<[u32; 3]>>, LoadError> {
        const MODES: [&str; 4] = ["points", "lines", "line loops", "line strips"];
        let mode = self.primitive.mode;
        if let Some(kind) = MODES.get(mode as usize) {
            self.document.left_out(&self.place, format!("{kind} are not drawn"));
            return Ok(None);
        }
        if let Some(draco) = &self.draco {
            return Ok(Some(draco.triangles()));
        }
        let indices = match self.primitive.indices {
            Some(indices) => Some(self.document.integers_of::<1>(indices, || self.place())?),
            None => None,
        };
        let count = indices.as_ref().map_or(vertices, Accessor::len);
        let triangles = match mode {
            4 => count / 3,
            5 | 6 => count.saturating_sub(2),
            _ => return Err(self.fault(&format!("there is no mode {mode}"))),
        };
        self.document.spend(triangles as u64 * 3, || self.place())?;
        let index = |i: usize| match &indices {
            Some(indices) => indices.integers::<1>(i)[0],
            None => i as u32,
        };
        let triangle = |k: usize| match mode {
            4 => [3 * k, 3 * k + 1, 3 * k + 2],
            5 if k.is_multiple_of(2) => [k, k + 1, k + 2],
            5 => [k, k + 2, k + 1],
            _ => [k + 1, k + 2, 0],
        };
        Ok(Some((0..triangles).map(|k| triangle(k).map(index)).collect()))
    }

    fn checked<'n>(
        &self,
        numbers: Option<Numbers<'n>>,
        vertices: usize,
        what: &str,
    ) -> Result<Option<Numbers<'n>>, LoadError> {
        match &numbers {
            Some(n) if n.len() < vertices => Err(self.fault(&format!("{} {what} for {vertices} vertices", n.len()))),
            _ => Ok(numbers),
        }
    }

    /// Reads the primitive; `None`, and a note, where it has no triangles.
    pub fn read(&self, material: u32, needs: Needs) -> Result<Option<Part>, LoadError> {
        let Some(positions) = self.numbers::<3>(|a| a.position)? else {
            self.document.left_out(&self.place, "primitives without positions are not drawn");
            return Ok(None);
        };
        let vertices = positions.len();
        let Some(mut triangles) = self.corners(vertices)? else { return Ok(None) };
        let Some(sources) = gather(&mut triangles, vertices) else {
            return Err(self.fault(&format!("a triangle uses a vertex beyond the {vertices} of the primitive")));
        };
        let each = || sources.iter().map(|&v| v as usize);
        let normals = self.checked(self.numbers::<3>(|a| a.normal)?, vertices, "normals")?;
        let tex_coords = self.numbers::<2>(|a| a.tex_coord(needs.tex_coord))?;
        let tex_coords = self.checked(tex_coords, vertices, "texture coordinates")?;
        let mesh = Mesh {
            positions: each().map(|v| Vec3::from_array(positions.floats(v))).collect(),
            normals: normals.map_or(Vec::new(), |n| each().map(|v| Vec3::from_array(n.floats(v))).collect()),
            tex_coords: tex_coords.map_or(Vec::new(), |t| each().map(|v| Vec2::from_array(t.floats(v))).collect()),
            colors: self.colors(&sources, vertices)?,
            materials: vec![material; triangles.len()],
            triangles,
        };
        if mesh.positions.iter().any(|p| !p.is_finite()) {
            self.document.left_out(&self.place, "vertices that are not finite have triangles that nobody sees");
        }
        let targets = self.targets(&sources, vertices)?;
        Ok(Some(Part { mesh, targets, sources }))
    }

    fn colors(&self, sources: &[u32], vertices: usize) -> Result<Vec<Vec4>, LoadError> {
        let Some(index) = self.primitive.attributes.color_0 else { return Ok(Vec::new()) };
        let each = sources.iter().map(|&v| v as usize);
        let choose = |a: &super::json::Attributes| a.color_0;
        if self.document.accessor(index, || self.place())?.kind == Kind::Vec3 {
            let colors = self.checked(self.numbers::<3>(choose)?, vertices, "colours")?;
            return Ok(colors.map_or(Vec::new(), |c| each.map(|v| Vec3::from_array(c.floats(v)).extend(1.0)).collect()));
        }
        let colors = self.checked(self.numbers::<4>(choose)?, vertices, "colours")?;
        Ok(colors.map_or(Vec::new(), |c| each.map(|v| Vec4::from_array(c.floats(v))).collect()))
    }

    fn targets(&self, sources: &[u32], vertices: usize) -> Result<Vec<MorphTarget>, LoadError> {
        let read = |index: Option<u32>| -> Result<Vec<Vec3>, LoadError> {
            let Some(index) = index else { return Ok(Vec::new()) };
            self.document.spend(sources.len() as u64 / 2, || self.place())?;
            let numbers = Numbers::Accessor(self.document.accessor_of::<3>(index, || self.place())?);
            let numbers = self.checked(Some(numbers), vertices, "displacements")?;
            Ok(numbers
                .map_or(Vec::new(), |n| sources.iter().map(|&v| Vec3::from_array(n.floats(v as usize))).collect()))
        };
        let mut targets = Vec::new();
        for target in &self.primitive.targets {
            targets.push(MorphTarget { positions: read(target.position)?, normals: read(target.normal)? });
        }
        Ok(targets)
    }
}

/// Numbers vertices anew in the order of first use; the answer is the old number of each. None where a triangle uses
/// a vertex beyond `vertices`.
fn gather(triangles: &mut [[u32; 3]], vertices: usize) -> Option<Vec<u32>> {
    let corners = triangles.as_flattened_mut();
    if corners.iter().any(|&v| v as usize >= vertices) {
        return None;
    }
    let mut sources = Vec::new();
    // A table of all vertices, unless the triangles use few of many.
    if vertices / 8 <= corners.len() {
        let mut slots = vec![u32::MAX; vertices];
        for corner in corners {
            let slot = &mut slots[*corner as usize];
            if *slot == u32::MAX {
                *slot = sources.len() as u32;
                sources.push(*corner);
            }
            *corner = *slot;
        }
    } else {
        let mut slots: HashMap<u32, u32> = HashMap::new();
        for corner in corners {
            let next = sources.len() as u32;
            let slot = *slots.entry(*corner).or_insert(next);
            if slot == next {
                sources.push(*corner);
            }
            *corner = slot;
        }
    }
    Some(sources)
}

#[cfg(test)]
mod tests {
    use super::gather;

    #[test]
    fn vertices_are_those_in_use() {
        for vertices in [10, 1_000_000] {
            let mut triangles = [[7, 3, 9], [3, 7, 5]];
            assert_eq!(gather(&mut triangles, vertices).unwrap(), [7, 3, 9, 5]);
            assert_eq!(triangles, [[0, 1, 2], [1, 0, 3]]);
        }
        assert!(gather(&mut [[0, 1, 10]], 10).is_none());
    }
}
