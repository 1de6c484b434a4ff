//! Meshes, and the numbers that they are made of.

use serde::Deserialize;

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Mesh {
    pub name: Option<Box<str>>,
    pub primitives: Vec<Primitive>,
    pub weights: Option<Box<[f32]>>,
}

#[derive(Deserialize)]
#[serde(default)]
pub struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<u32>,
    pub material: Option<u32>,
    pub mode: u32,
    pub targets: Vec<Target>,
    pub extensions: Option<Box<PrimitiveExtensions>>,
}

impl Default for Primitive {
    fn default() -> Self {
        const TRIANGLES: u32 = 4;
        Self {
            attributes: Attributes::default(),
            indices: None,
            material: None,
            mode: TRIANGLES,
            targets: Vec::new(),
            extensions: None,
        }
    }
}

/// Accessors, or what stands for them in compressed meshes. Attributes of applications (`_NAME`) are passed over.
#[derive(Deserialize, Default)]
#[serde(rename_all = "UPPERCASE", default)]
pub struct Attributes {
    pub position: Option<u32>,
    pub normal: Option<u32>,
    pub texcoord_0: Option<u32>,
    pub texcoord_1: Option<u32>,
    pub texcoord_2: Option<u32>,
    pub texcoord_3: Option<u32>,
    pub color_0: Option<u32>,
    pub joints_0: Option<u32>,
    pub joints_1: Option<u32>,
    pub weights_0: Option<u32>,
    pub weights_1: Option<u32>,
}

impl Attributes {
    pub fn tex_coord(&self, set: u32) -> Option<u32> {
        match set {
            0 => self.texcoord_0,
            1 => self.texcoord_1,
            2 => self.texcoord_2,
            3 => self.texcoord_3,
            _ => None,
        }
    }
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "UPPERCASE", default)]
pub struct Target {
    pub position: Option<u32>,
    pub normal: Option<u32>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Draco>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Draco {
    pub buffer_view: u32,
    pub attributes: Attributes,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Accessor {
    pub buffer_view: Option<u32>,
    pub byte_offset: u64,
    pub component_type: u32,
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub kind: Kind,
    pub sparse: Option<Box<Sparse>>,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq, Eq, Debug)]
#[serde(rename_all = "UPPERCASE")]
pub enum Kind {
    #[default]
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Sparse {
    pub count: u64,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: u32,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: u32,
    #[serde(default)]
    pub byte_offset: u64,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct BufferView {
    pub buffer: u32,
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
    pub extensions: Option<Box<ViewExtensions>>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub meshopt: Option<Meshopt>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Meshopt {
    pub buffer: u32,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: u64,
    pub count: u64,
    pub mode: String,
    #[serde(default)]
    pub filter: Option<String>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Buffer {
    pub uri: Option<Box<str>>,
    pub byte_length: u64,
}
