//! Materials, lights, textures and meshes as the library's shaders, textures and objects.

use crate::scene::{Deform, LightKind, Material, Object, TextureData, TextureSource};
use glam::{Vec3, Vec4};
use image::{ImageReader, Limits};
use openrt::Context;
use openrt::api::{
    Component, Error, ImageDesc, ImageFormat, Indices, Mode, Motion, Name, Primitive, TextureFormat, TextureParameter,
    VertexArray, VertexArrays, Wrap,
};
use std::collections::HashMap;
use std::io::Cursor;

/// An object as the library knows it.
pub struct Placed {
    pub name: Name,
    /// For deforming objects: the mesh vertex behind each vertex of the library's object.
    pub sources: Vec<u32>,
    pub has_normals: bool,
}

/// Makes shaders, with one class of each kind.
#[derive(Default)]
pub struct ShaderMaker {
    classes: HashMap<&'static str, Name>,
}

impl ShaderMaker {
    /// A new shader of a built-in class; it is bound afterwards.
    pub fn make(&mut self, context: &mut Context, class: &'static str) -> Result<Name, Error> {
        match self.classes.get(class) {
            Some(&name) => context.bind_shader_class(name)?,
            None => {
                let name = context.gen_new_shader_class(class)?;
                self.classes.insert(class, name);
            }
        }
        context.gen_new_shader()
    }

    pub fn floats(&self, context: &mut Context, parameter: &str, values: &[f32]) -> Result<(), Error> {
        let handle = context.parameter_handle(parameter)?;
        context.parameter_f(handle, values)
    }

    pub fn surface(&mut self, context: &mut Context, m: &Material, textures: &[Name]) -> Result<Name, Error> {
        let shader = self.make(context, "phong")?;
        let colors = [
            ("emission", m.emission),
            ("ambient", m.ambient),
            ("diffuse", m.diffuse),
            ("specular", m.specular),
            ("reflection", m.reflection),
            ("transmission", Vec3::splat(m.transmission)),
        ];
        for (parameter, color) in colors {
            self.floats(context, parameter, &color.to_array())?;
        }
        self.floats(context, "shininess", &[m.shininess])?;
        self.floats(context, "ior", &[m.ior])?;
        if let Some(cutoff) = m.alpha_cutoff {
            self.floats(context, "alpha_threshold", &[cutoff])?;
        }
        if let Some(&texture) = m.texture.and_then(|t| textures.get(t as usize)) {
            let handle = context.parameter_handle("texture")?;
            context.parameter_texture(handle, texture)?;
        }
        Ok(shader)
    }

    pub fn light(&mut self, context: &mut Context, kind: LightKind, color: Vec3) -> Result<Name, Error> {
        let class = match kind {
            LightKind::Point { .. } => "point",
            LightKind::Directional => "directional",
            LightKind::Spot { .. } => "spot",
        };
        let shader = self.make(context, class)?;
        self.floats(context, "color", &color.to_array())?;
        if matches!(kind, LightKind::Point { attenuated: true } | LightKind::Spot { .. }) {
            self.floats(context, "attenuation", &[0.0, 0.0, 1.0])?;
        }
        if let LightKind::Spot { inner, outer } = kind {
            self.floats(context, "cutoff", &[outer])?;
            self.floats(context, "penumbra", &[(outer - inner).max(0.0)])?;
        }
        Ok(shader)
    }
}

/// Largest image that is decoded, in bytes of memory.
const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// The image as RGBA, its rows in the order of rising t; bounded in size.
pub fn decode(source: &TextureSource) -> Result<image::RgbaImage, String> {
    let read;
    let bytes = match &source.data {
        TextureData::Bytes(bytes) => bytes,
        TextureData::File(path) => {
            read = std::fs::read(path).map_err(|e| e.to_string())?;
            &read
        }
    };
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(openrt::api::MAX_TEXTURE_SIZE);
    limits.max_image_height = Some(openrt::api::MAX_TEXTURE_SIZE);
    limits.max_alloc = Some(MAX_IMAGE_BYTES);
    reader.limits(limits);
    let mut image = reader.decode().map_err(|e| e.to_string())?.to_rgba8();
    if !source.first_row_at_zero {
        image::imageops::flip_vertical_in_place(&mut image);
    }
    Ok(image)
}

/// A new texture object.
pub fn texture(
    context: &mut Context,
    source: &TextureSource,
    image: &image::RgbaImage,
    srgb: bool,
) -> Result<Name, Error> {
    let name = context.gen_textures(1)?;
    context.bind_texture(name)?;
    if srgb {
        context.tex_parameter(TextureParameter::Format(TextureFormat::Srgb))?;
    }
    let wrap = |clamp| if clamp { Wrap::ClampToEdge } else { Wrap::Repeat };
    context.tex_parameter(TextureParameter::WrapS(wrap(source.clamp_s)))?;
    context.tex_parameter(TextureParameter::WrapT(wrap(source.clamp_t)))?;
    let description = ImageDesc {
        width: image.width(),
        height: image.height(),
        format: ImageFormat::Rgba,
        component: Component::UnsignedByte,
        row_stride: 0,
    };
    context.tex_image_2d(0, &description, Some(image.as_raw()))?;
    Ok(name)
}

/// One vertex attribute as the bytes of an array.
fn bytes_of<const N: usize>(values: impl Iterator<Item = [f32; N]>) -> Vec<u8> {
    values.flatten().flat_map(f32::to_ne_bytes).collect()
}

/// Compiles an object: one indexed draw for each of its materials.
pub fn define(context: &mut Context, object: &Object, motion: Motion, surfaces: &[Name]) -> Result<Placed, Error> {
    let mesh = &object.mesh;
    let mut groups: Vec<(u32, Vec<[u32; 3]>)> = Vec::new();
    let mut group_of: HashMap<u32, usize> = HashMap::new();
    for (triangle, &material) in mesh.triangles.iter().zip(&mesh.materials) {
        let group = *group_of.entry(material).or_insert_with(|| {
            groups.push((material, Vec::new()));
            groups.len() - 1
        });
        groups[group].1.push(*triangle);
    }
    let name = context.gen_objects(1)?;
    context.load_identity()?;
    context.new_object(name, Mode::Compile, motion)?;
    let mut sources: Vec<u32> = Vec::new();
    // Number of each vertex in the group that used it last, and that group.
    let mut seen = vec![(u32::MAX, 0_u32); mesh.positions.len()];
    for (group, (material, triangles)) in groups.iter().enumerate() {
        context.bind_shader(surfaces.get(*material as usize).copied().unwrap_or(0))?;
        // The group's own vertices, numbered in the order of first use.
        let first = sources.len();
        let mut indices: Vec<u8> = Vec::new();
        for &vertex in triangles.as_flattened() {
            let (user, slot) = &mut seen[vertex as usize];
            if *user != group as u32 {
                (*user, *slot) = (group as u32, (sources.len() - first) as u32);
                sources.push(vertex);
            }
            indices.extend(slot.to_ne_bytes());
        }
        draw(context, object, &sources[first..], &indices)?;
    }
    context.bind_shader(0)?;
    context.end_object()?;
    let sources = if matches!(object.deform, Deform::Rigid) { Vec::new() } else { sources };
    Ok(Placed { name, sources, has_normals: !mesh.normals.is_empty() })
}

fn draw(context: &mut Context, object: &Object, vertices: &[u32], indices: &[u8]) -> Result<(), Error> {
    let mesh = &object.mesh;
    let each = || vertices.iter().map(|&v| v as usize);
    let positions = bytes_of(each().map(|v| mesh.positions[v].to_array()));
    let normals =
        if mesh.normals.is_empty() { Vec::new() } else { bytes_of(each().map(|v| mesh.normals[v].to_array())) };
    let tex_coords =
        if mesh.tex_coords.is_empty() { Vec::new() } else { bytes_of(each().map(|v| mesh.tex_coords[v].to_array())) };
    let colors = if mesh.colors.is_empty() { Vec::new() } else { bytes_of(each().map(|v| mesh.colors[v].to_array())) };
    fn array(bytes: &[u8], size: u32) -> VertexArray<'_> {
        VertexArray { size, component: Component::Float, stride: 0, bytes }
    }
    fn optional(bytes: &[u8], size: u32) -> Option<VertexArray<'_>> {
        (!bytes.is_empty()).then(|| array(bytes, size))
    }
    let arrays = VertexArrays {
        positions: array(&positions, 3),
        normals: optional(&normals, 3),
        colors: optional(&colors, 4),
        tex_coords: optional(&tex_coords, 2),
    };
    if mesh.colors.is_empty() {
        context.color(Vec4::ONE)?;
    }
    let indices = Indices::new(Component::UnsignedInt, indices)?;
    context.draw_elements(Primitive::Triangles, &arrays, indices)
}
