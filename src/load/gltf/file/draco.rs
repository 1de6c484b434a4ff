//! KHR_draco_mesh_compression: meshes compressed by Draco, decoded by the crate `draco-core`.

use super::document::Document;
use crate::load::LoadError;
use crate::load::gltf::json::{Attributes, Draco, Primitive};
use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};

/// A decoded mesh.
pub struct Compressed<'d> {
    mesh: Mesh,
    /// Identifiers of the attributes in the mesh.
    ids: &'d Attributes,
}

/// An attribute of all vertices.
pub struct Unpacked {
    values: Vec<f32>,
    width: usize,
}

impl Unpacked {
    pub fn len(&self) -> usize {
        self.values.len() / self.width
    }

    pub fn floats<const N: usize>(&self, i: usize) -> [f32; N] {
        std::array::from_fn(|c| self.values[i * self.width + c])
    }
}

impl<'d> Compressed<'d> {
    /// Decodes what `packed` names. The accessors of the primitive say how much that is.
    pub fn decode(
        document: &Document,
        primitive: &Primitive,
        packed: &'d Draco,
        place: &str,
    ) -> Result<Self, LoadError> {
        let here = || place.to_string();
        let fault = |text: String| document.error(format!("{place}: {text}"));
        let count = |index: Option<u32>| -> Result<u64, LoadError> {
            let accessors = &document.root.accessors;
            index.map_or(Ok(0), |i| Ok(document.get(accessors, "accessors", i, here)?.count))
        };
        let (vertices, corners) = (count(primitive.attributes.position)?, count(primitive.indices)?);
        document.spend(corners.max(vertices), here)?;
        let limits = DecodeLimits::default()
            .with_max_points(vertices.saturating_add(corners))
            .with_max_faces(corners / 3)
            .with_max_decoded_bytes(vertices.saturating_add(corners).saturating_mul(256));
        let (_, bytes) = document.view(packed.buffer_view, here)?;
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
        MeshDecoder::new()
            .decode(&mut buffer, &mut mesh)
            .map_err(|e| fault(format!("the Draco mesh cannot be decoded: {e}")))?;
        Ok(Self { mesh, ids: &packed.attributes })
    }

    /// The attribute that `choose` picks, of `width` components that are divided by `most`; None where the compressed mesh
    /// has none.
    pub fn attribute(
        &self,
        choose: impl Fn(&Attributes) -> Option<u32>,
        width: usize,
        most: f32,
    ) -> Result<Option<Unpacked>, String> {
        let Some(id) = choose(self.ids) else { return Ok(None) };
        let attribute = self.mesh.attribute_by_unique_id(id);
        let attribute = attribute.ok_or_else(|| format!("the Draco mesh has no attribute {id}"))?;
        if usize::from(attribute.num_components()) < width {
            return Err(format!("attribute {id} of the Draco mesh has too few components"));
        }
        let mut values = attribute.read_f32s(self.mesh.num_points(), width);
        if most != 1.0 {
            values.iter_mut().for_each(|v| *v = (*v / most).max(-1.0));
        }
        Ok(Some(Unpacked { values, width }))
    }

    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.mesh.faces().iter().map(|face| face.map(|point| point.0)).collect()
    }
}
