//! The JSON of glTF 2.0 as plain data: the properties that are read, all others are passed over.
//!
//! The types are our own, and not those of the crate `gltf`: its validation refuses attributes of applications and quantised meshes,
//! and without validation its accessors panic. Here an index is just a number until it is used, and names that extensions may
//! add to are text. Properties that are rarely present are boxed, so that `{}` costs little memory.

mod material;
mod mesh;

pub use material::*;
pub use mesh::*;

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
