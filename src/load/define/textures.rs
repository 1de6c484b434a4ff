//! Images of a scene as textures.

use crate::api::{
    Component, Context, Error, Filter, ImageDesc, ImageFormat, MAX_TEXTURE_SIZE, Name, TextureFormat, TextureParameter,
};
use crate::load::input::files;
use crate::load::{TextureData, TextureSource};
use crate::quiet;
use image::{ImageReader, Limits};
use std::io::Cursor;

/// Largest image that is decoded, in bytes of memory.
const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// The image as RGBA, its rows in the order of rising t; bounded in size.
pub fn decode(source: &TextureSource) -> Result<image::RgbaImage, String> {
    quiet::caught(|| decode_image(source)).unwrap_or_else(|panic| Err(format!("the reader {panic}")))
}

fn decode_image(source: &TextureSource) -> Result<image::RgbaImage, String> {
    let read;
    let bytes: &[u8] = match &source.data {
        TextureData::Bytes(bytes) => bytes,
        TextureData::File(path) => {
            read = files::read(path, files::MAX_FILE_BYTES).map_err(|e| e.message)?;
            &read
        }
    };
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_TEXTURE_SIZE);
    limits.max_image_height = Some(MAX_TEXTURE_SIZE);
    limits.max_alloc = Some(MAX_IMAGE_BYTES);
    reader.limits(limits);
    let mut image = reader.decode().map_err(|e| e.to_string())?.to_rgba8();
    if !source.first_row_at_zero {
        image::imageops::flip_vertical_in_place(&mut image);
    }
    Ok(image)
}

/// A new texture object.
pub fn texture(context: &mut Context, source: &TextureSource, image: &image::RgbaImage) -> Result<Name, Error> {
    let name = context.gen_textures(1)?;
    context.bind_texture(name)?;
    let format = if source.srgb { TextureFormat::Srgb } else { TextureFormat::Linear };
    context.tex_parameter(TextureParameter::Format(format))?;
    context.tex_parameter(TextureParameter::WrapS(source.wrap[0]))?;
    context.tex_parameter(TextureParameter::WrapT(source.wrap[1]))?;
    if source.filter == Filter::Nearest {
        context.tex_parameter(TextureParameter::MagFilter(Filter::Nearest))?;
    }
    context.tex_parameter(TextureParameter::MinFilter(source.filter))?;
    context.tex_parameter(TextureParameter::Transform(source.transform))?;
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
