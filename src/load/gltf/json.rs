//! The JSON of glTF 2.0 as plain data: the properties that are read, all others are passed over.
//!
//! The types are our own, and not those of the crate `gltf`: its validation refuses attributes of applications and quantised meshes,
//! and without validation its accessors panic. Here an index is just a number until it is used, and names that extensions may
//! add to are text. Properties that are rarely present are boxed, so that `{}` costs little memory.

use serde::Deserialize;

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Root {
    pub asset: Asset,
    pub scene: Option<u32>,
    pub scenes: Vec<Scene>,
    pub nodes: Vec<Node>,
    pub meshes: Vec<Mesh>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub images: Vec<Image>,
    pub samplers: Vec<Sampler>,
    pub cameras: Vec<Camera>,
    pub skins: Vec<Skin>,
    pub animations: Vec<Animation>,
    pub extensions_used: Vec<String>,
    pub extensions_required: Vec<String>,
    pub extensions: RootExtensions,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Asset {
    pub version: Option<String>,
    pub min_version: Option<String>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub lights: Lights,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Lights {
    pub lights: Vec<Light>,
}

#[derive(Deserialize)]
#[serde(default)]
pub struct Light {
    pub name: Option<Box<str>>,
    #[serde(rename = "type")]
    pub kind: String,
    pub color: [f32; 3],
    pub intensity: f32,
    pub spot: Spot,
}

impl Default for Light {
    fn default() -> Self {
        Self { name: None, kind: String::new(), color: [1.0; 3], intensity: 1.0, spot: Spot::default() }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Spot {
    pub inner_cone_angle: f32,
    pub outer_cone_angle: f32,
}

impl Default for Spot {
    fn default() -> Self {
        Self { inner_cone_angle: 0.0, outer_cone_angle: std::f32::consts::FRAC_PI_4 }
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Scene {
    pub nodes: Vec<u32>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Node {
    pub name: Option<Box<str>>,
    pub children: Vec<u32>,
    pub mesh: Option<u32>,
    pub skin: Option<u32>,
    pub camera: Option<u32>,
    pub matrix: Option<Box<[f32; 16]>>,
    pub translation: Option<Box<[f32; 3]>>,
    pub rotation: Option<Box<[f32; 4]>>,
    pub scale: Option<Box<[f32; 3]>>,
    pub weights: Option<Box<[f32]>>,
    pub extensions: Option<Box<NodeExtensions>>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub light: Option<NodeLight>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
}

#[derive(Deserialize)]
pub struct NodeLight {
    pub light: u32,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Instancing {
    pub attributes: InstanceAttributes,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "UPPERCASE", default)]
pub struct InstanceAttributes {
    pub translation: Option<u32>,
    pub rotation: Option<u32>,
    pub scale: Option<u32>,
}

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

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Material {
    pub name: Option<Box<str>>,
    pub pbr_metallic_roughness: PbrMetallicRoughness,
    pub normal_texture: Option<Box<TextureInfo>>,
    pub occlusion_texture: Option<Box<TextureInfo>>,
    pub emissive_texture: Option<Box<TextureInfo>>,
    pub emissive_factor: [f32; 3],
    pub alpha_mode: Option<Box<str>>,
    pub alpha_cutoff: f32,
    pub extensions: Option<Box<MaterialExtensions>>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: None,
            pbr_metallic_roughness: PbrMetallicRoughness::default(),
            normal_texture: None,
            occlusion_texture: None,
            emissive_texture: None,
            emissive_factor: [0.0; 3],
            alpha_mode: None,
            alpha_cutoff: 0.5,
            extensions: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct PbrMetallicRoughness {
    pub base_color_factor: [f32; 4],
    pub base_color_texture: Option<Box<TextureInfo>>,
    pub metallic_factor: f32,
    pub roughness_factor: f32,
    pub metallic_roughness_texture: Option<Box<TextureInfo>>,
}

impl Default for PbrMetallicRoughness {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct TextureInfo {
    pub index: u32,
    pub tex_coord: u32,
    /// Of normal textures.
    pub scale: f32,
    /// Of occlusion textures.
    pub strength: f32,
    pub extensions: Option<Box<TextureInfoExtensions>>,
}

impl Default for TextureInfo {
    fn default() -> Self {
        Self { index: u32::MAX, tex_coord: 0, scale: 1.0, strength: 1.0, extensions: None }
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub transform: Option<TextureTransform>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "camelCase", default)]
pub struct TextureTransform {
    pub offset: [f32; 2],
    /// Radians.
    pub rotation: f32,
    pub scale: [f32; 2],
    pub tex_coord: Option<u32>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct MaterialExtensions {
    #[serde(rename = "KHR_materials_unlit")]
    pub unlit: Option<Empty>,
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior")]
    pub ior: Option<Ior>,
    #[serde(rename = "KHR_materials_transmission")]
    pub transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_volume")]
    pub volume: Option<Volume>,
    #[serde(rename = "KHR_materials_specular")]
    pub specular: Option<Specular>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub specular_glossiness: Option<SpecularGlossiness>,
}

#[derive(Deserialize)]
pub struct Empty {}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct EmissiveStrength {
    pub emissive_strength: f32,
}

impl Default for EmissiveStrength {
    fn default() -> Self {
        Self { emissive_strength: 1.0 }
    }
}

#[derive(Deserialize)]
#[serde(default)]
pub struct Ior {
    pub ior: f32,
}

impl Default for Ior {
    fn default() -> Self {
        Self { ior: 1.5 }
    }
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Transmission {
    pub transmission_factor: f32,
    pub transmission_texture: Option<Empty>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Volume {
    pub thickness_factor: f32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Specular {
    pub specular_factor: f32,
    pub specular_color_factor: [f32; 3],
    pub specular_texture: Option<Empty>,
    pub specular_color_texture: Option<Empty>,
}

impl Default for Specular {
    fn default() -> Self {
        Self {
            specular_factor: 1.0,
            specular_color_factor: [1.0; 3],
            specular_texture: None,
            specular_color_texture: None,
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct SpecularGlossiness {
    pub diffuse_factor: [f32; 4],
    pub diffuse_texture: Option<Box<TextureInfo>>,
    pub specular_factor: [f32; 3],
    pub glossiness_factor: f32,
    pub specular_glossiness_texture: Option<Empty>,
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Texture {
    pub name: Option<Box<str>>,
    pub sampler: Option<u32>,
    pub source: Option<u32>,
    pub extensions: Option<Box<TextureExtensions>>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    pub webp: Option<TextureImage>,
}

#[derive(Deserialize)]
pub struct TextureImage {
    pub source: u32,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Image {
    pub name: Option<Box<str>>,
    pub uri: Option<Box<str>>,
    pub buffer_view: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Sampler {
    pub mag_filter: Option<u32>,
    pub min_filter: Option<u32>,
    pub wrap_s: u32,
    pub wrap_t: u32,
}

impl Default for Sampler {
    fn default() -> Self {
        const REPEAT: u32 = 10497;
        Self { mag_filter: None, min_filter: None, wrap_s: REPEAT, wrap_t: REPEAT }
    }
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Camera {
    pub name: Option<Box<str>>,
    #[serde(rename = "type")]
    pub kind: String,
    pub perspective: Option<Perspective>,
    pub orthographic: Option<Orthographic>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Perspective {
    pub yfov: f32,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Orthographic {
    pub ymag: f32,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub struct Skin {
    pub joints: Vec<u32>,
    pub inverse_bind_matrices: Option<u32>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub struct Animation {
    pub name: Option<Box<str>>,
    pub channels: Vec<Channel>,
    pub samplers: Vec<AnimationSampler>,
}

#[derive(Deserialize)]
pub struct Channel {
    pub sampler: u32,
    pub target: ChannelTarget,
}

#[derive(Deserialize)]
pub struct ChannelTarget {
    pub node: Option<u32>,
    pub path: Box<str>,
}

#[derive(Deserialize)]
pub struct AnimationSampler {
    pub input: u32,
    pub output: u32,
    pub interpolation: Option<Box<str>>,
}
