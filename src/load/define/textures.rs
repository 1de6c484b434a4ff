//! Images of a scene as textures.

use crate::api::{
    Component, Context, Error, ImageDesc, ImageFormat, MAX_TEXTURE_SIZE, Name, TextureFormat, TextureParameter, Wrap,
};
use crate::load::input::files;
use crate::load::{TextureData, TextureSource, quiet};
use image::{ImageReader, Limits};
use std::io::Cursor;

/// Largest image that is decoded, in bytes of memory.
const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// The image as RGBA, its rows in the order of rising t; bounded in size.
pub fn decode(source: &TextureSource) -> Result<image::RgbaImage, String> {
    quiet::caught(|| decode_image(source)).unwrap_or_else(Err)
}

fn decode_image(source: &TextureSource) -> Result<image::RgbaImage, String> {
    let read;
    let bytes = match &source.data {
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
