//! Textures.

use super::arrays::component;
use super::constants::*;
use super::guard::guard;
use super::pointer::{OutArray, array_at, slice, slice_mut, text, value};
use super::refusal::{not_negative, unknown};
use super::types::*;
use crate::api::{
    Context, Error, Filter, ImageDesc, ImageFormat, MAX_TEXTURE_SIZE, Result, TextureFormat, TextureParameter, Wrap,
};
use glam::Affine2;
use std::ffi::{c_char, c_void};

fn image_format(format: RTenum) -> Result<ImageFormat> {
    Ok(match format {
        RT_RGB => ImageFormat::Rgb,
        RT_RGBA => ImageFormat::Rgba,
        RT_BGR => ImageFormat::Bgr,
        RT_BGRA => ImageFormat::Bgra,
        RT_LUMINANCE => ImageFormat::Luminance,
        RT_LUMINANCE_ALPHA => ImageFormat::LuminanceAlpha,
        RT_ALPHA => ImageFormat::Alpha,
        RT_RED => ImageFormat::Red,
        _ => return Err(unknown("format", format, "a pixel format")),
    })
}

fn wrap(value: RTenum) -> Result<Wrap> {
    Ok(match value {
        RT_REPEAT => Wrap::Repeat,
        RT_CLAMP_TO_EDGE => Wrap::ClampToEdge,
        RT_MIRRORED_REPEAT => Wrap::MirroredRepeat,
        _ => return Err(unknown("param", value, "a wrap mode")),
    })
}

fn filter(value: RTenum) -> Result<Filter> {
    Ok(match value {
        RT_NEAREST => Filter::Nearest,
        RT_LINEAR => Filter::Linear,
        RT_LINEAR_MIPMAP_LINEAR => Filter::LinearMipmapLinear,
        _ => return Err(unknown("param", value, "a texture filter")),
    })
}

fn number_of_wrap(wrap: Wrap) -> RTenum {
    match wrap {
        Wrap::Repeat => RT_REPEAT,
        Wrap::ClampToEdge => RT_CLAMP_TO_EDGE,
        Wrap::MirroredRepeat => RT_MIRRORED_REPEAT,
    }
}

fn number_of_filter(filter: Filter) -> RTenum {
    match filter {
        Filter::Nearest => RT_NEAREST,
        Filter::Linear => RT_LINEAR,
        Filter::LinearMipmapLinear => RT_LINEAR_MIPMAP_LINEAR,
    }
}

fn target_2d(target: RTenum) -> Result<()> {
    if target == RT_TEXTURE_2D { Ok(()) } else { Err(unknown("target", target, "RT_TEXTURE_2D")) }
}

/// Stores n new texture names at textures.
///
/// Errors: RT_INVALID_VALUE when n is negative or textures is NULL, RT_OUT_OF_MEMORY when no names are left,
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGenTextures(n: RTsizei, textures: *mut RTuint) {
    guard(|cx| {
        // SAFETY: `textures` is NULL or a place for n names, says the manual.
        let textures = unsafe { slice_mut("textures", textures, n)? };
        cx.is_texture(0)?;
        if n == 0 {
            return Ok(());
        }
        let first = cx.gen_textures(n)?;
        for (texture, name) in textures.iter_mut().zip(first..) {
            *texture = name;
        }
        Ok(())
    })
}

/// Deletes the n textures named at textures. 0 and names that are not in use are passed over. Shaders that
/// refer to one see white from the next frame on.
///
/// Errors: RT_INVALID_VALUE when n is negative or textures is NULL, RT_INVALID_OPERATION between rtBegin() and
/// rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtDeleteTextures(n: RTsizei, textures: *const RTuint) {
    // SAFETY: `textures` is NULL or points to n names, says the manual; they are read before we return.
    let textures = unsafe { slice("textures", textures, n) };
    guard(|cx| cx.delete_textures(textures?))
}

/// RT_TRUE when texture names a texture: one that was bound or loaded, and not deleted.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtIsTexture(texture: RTuint) -> RTboolean {
    guard(|cx| cx.is_texture(texture).map(RTboolean::from))
}

/// Makes a texture the one that rtTexImage2D() and rtTexParameteri() change. target is RT_TEXTURE_2D. A name
/// that is not in use becomes a texture; 0 binds none. Shaders are given textures by rtParameterTexture(), not
/// by binding.
///
/// Errors: RT_INVALID_ENUM for another target, RT_INVALID_VALUE for one of the 256 largest names,
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtBindTexture(target: RTenum, texture: RTuint) {
    guard(|cx| {
        target_2d(target)?;
        cx.bind_texture(texture)
    })
}

/// Gives the bound texture an image, read from pixels before the call returns: height rows of width pixels
/// without gaps, the lowest row first. NULL gives transparent black.
///
/// target is RT_TEXTURE_2D, border 0. Level 0 replaces the whole image, and the smaller levels are averaged
/// from it; another level replaces only itself. internalFormat is 1 to 4, RT_RGB, RT_RGBA, RT_LUMINANCE,
/// RT_LUMINANCE_ALPHA, RT_ALPHA, RT_RED, RT_RGB8 or RT_RGBA8, or RT_SRGB8 or RT_SRGB8_ALPHA8, which also set
/// RT_TEXTURE_COLOR_SPACE to RT_SRGB; channels are always kept with 8 bits. format is RT_RGB, RT_RGBA, RT_BGR,
/// RT_BGRA, RT_LUMINANCE, RT_LUMINANCE_ALPHA, RT_ALPHA or RT_RED; type any data type from RT_BYTE to RT_DOUBLE.
///
/// Errors: RT_INVALID_ENUM for another target, format or type; RT_INVALID_VALUE for another internalFormat or
/// border, a negative number, or a side above RT_MAX_TEXTURE_SIZE; RT_INVALID_OPERATION when no texture is
/// bound, the size does not fit that of level 0, or between rtBegin() and rtEnd(); RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexImage2D(
    target: RTenum,
    level: RTint,
    internalFormat: RTint,
    width: RTsizei,
    height: RTsizei,
    border: RTint,
    format: RTenum,
    type_: RTenum,
    pixels: *const c_void,
) {
    guard(|cx| {
        cx.is_texture(0)?;
        target_2d(target)?;
        let (format, component) = (image_format(format)?, component(type_)?);
        let srgb = match internalFormat as RTenum {
            RT_SRGB8 | RT_SRGB8_ALPHA8 => true,
            1..=4 | RT_RGB8 | RT_RGBA8 => false,
            other if image_format(other).is_ok() => false,
            other => {
                let message = format_args!("internalFormat is 0x{other:04X}, which is not an internal format");
                return Err(Error::invalid_value(message));
            }
        };
        let level = not_negative("level", level)?;
        let (width, height) = (not_negative("width", width)?, not_negative("height", height)?);
        // Asked before the size is computed and the pixels are touched.
        if border != 0 || width > MAX_TEXTURE_SIZE || height > MAX_TEXTURE_SIZE {
            return Err(Error::invalid_value(format_args!(
                "{width} x {height} texels with a border of {border}; there are at most {MAX_TEXTURE_SIZE} on a side, and no border"
            )));
        }
        let image = ImageDesc { width, height, format, component, row_stride: 0 };
        let bytes = image.byte_size().expect("sides are limited");
        let data = if pixels.is_null() {
            None
        } else {
            // SAFETY: not NULL, so that many readable bytes, says the manual; read before we return. Sides are limited, so is the size.
            Some(unsafe { std::slice::from_raw_parts(pixels.cast::<u8>(), bytes) })
        };
        cx.tex_image_2d(level, &image, data)?;
        if srgb { cx.tex_parameter(TextureParameter::Format(TextureFormat::Srgb)) } else { Ok(()) }
    })
}

fn tex_parameter(cx: &mut Context, target: RTenum, pname: RTenum, value: RTenum) -> Result<()> {
    target_2d(target)?;
    cx.tex_parameter(match pname {
        RT_TEXTURE_WRAP_S => TextureParameter::WrapS(wrap(value)?),
        RT_TEXTURE_WRAP_T => TextureParameter::WrapT(wrap(value)?),
        RT_TEXTURE_MIN_FILTER => TextureParameter::MinFilter(filter(value)?),
        RT_TEXTURE_MAG_FILTER => match filter(value)? {
            Filter::LinearMipmapLinear => return Err(unknown("param", value, "a magnification filter")),
            filter => TextureParameter::MagFilter(filter),
        },
        RT_TEXTURE_COLOR_SPACE => TextureParameter::Format(match value {
            RT_LINEAR_COLOR => TextureFormat::Linear,
            RT_SRGB => TextureFormat::Srgb,
            _ => return Err(unknown("param", value, "a colour space of textures")),
        }),
        _ => return Err(unknown("pname", pname, "a texture parameter that can be set")),
    })
}

/// Sets a parameter of the bound texture: RT_TEXTURE_WRAP_S and RT_TEXTURE_WRAP_T to RT_REPEAT,
/// RT_CLAMP_TO_EDGE or RT_MIRRORED_REPEAT; RT_TEXTURE_MIN_FILTER to RT_NEAREST, RT_LINEAR or
/// RT_LINEAR_MIPMAP_LINEAR; RT_TEXTURE_MAG_FILTER to RT_NEAREST or RT_LINEAR; RT_TEXTURE_COLOR_SPACE to
/// RT_LINEAR_COLOR or RT_SRGB.
///
/// Errors: RT_INVALID_ENUM for another target, parameter or value; RT_INVALID_OPERATION when no texture is
/// bound, or between rtBegin() and rtEnd(); RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtTexParameteri(target: RTenum, pname: RTenum, param: RTint) {
    guard(|cx| {
        cx.is_texture(0)?;
        tex_parameter(cx, target, pname, param as RTenum)
    })
}

/// Sets the parameter RT_TEXTURE_MATRIX of the bound texture: 16 numbers, column by column, that take the texture
/// coordinates s and t of surfaces (with 0 and 1 as third and fourth) to those at which the image is looked up; only s and t
/// of the result count. The identity is the default. Other parameters as for rtTexParameterf().
///
/// Errors: RT_INVALID_ENUM for another target, parameter or value; RT_INVALID_VALUE when params is NULL;
/// RT_INVALID_OPERATION when no texture is bound, or between rtBegin() and rtEnd(); RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexParameterfv(target: RTenum, pname: RTenum, params: *const RTfloat) {
    guard(|cx| {
        cx.is_texture(0)?;
        target_2d(target)?;
        if pname != RT_TEXTURE_MATRIX {
            // SAFETY: `params` is NULL or points to one number, says the manual; it is read before we return.
            let value = unsafe { value("params", params)? };
            return tex_parameter(cx, target, pname, value.round() as RTenum);
        }
        // SAFETY: `params` is NULL or points to 16 numbers, says the manual; they are read before we return.
        let m: [_; 16] = unsafe { array_at("params", params)? };
        let transform = Affine2::from_cols_array(&[m[0], m[1], m[4], m[5], m[12], m[13]]);
        cx.tex_parameter(TextureParameter::Transform(transform))
    })
}

/// See rtTexParameteri(); the value is rounded.
#[unsafe(no_mangle)]
pub extern "C" fn rtTexParameterf(target: RTenum, pname: RTenum, param: RTfloat) {
    guard(|cx| {
        cx.is_texture(0)?;
        tex_parameter(cx, target, pname, param.round() as RTenum)
    })
}

fn get_tex_parameter(cx: &Context, target: RTenum, pname: RTenum) -> Result<RTint> {
    cx.is_texture(0)?;
    target_2d(target)?;
    let info = cx.get_tex_parameters();
    let value = match pname {
        RT_TEXTURE_WIDTH => info?.width,
        RT_TEXTURE_HEIGHT => info?.height,
        RT_TEXTURE_WRAP_S => number_of_wrap(info?.wrap_s),
        RT_TEXTURE_WRAP_T => number_of_wrap(info?.wrap_t),
        RT_TEXTURE_MIN_FILTER => number_of_filter(info?.min_filter),
        RT_TEXTURE_MAG_FILTER => number_of_filter(info?.mag_filter),
        RT_TEXTURE_COLOR_SPACE => match info?.format {
            TextureFormat::Linear => RT_LINEAR_COLOR,
            TextureFormat::Srgb => RT_SRGB,
        },
        _ => return Err(unknown("pname", pname, "a texture parameter")),
    };
    Ok(value as RTint)
}

/// Stores a parameter of the bound texture at params: one of those of rtTexParameteri(), RT_TEXTURE_WIDTH or
/// RT_TEXTURE_HEIGHT.
///
/// Errors: RT_INVALID_ENUM for another target or parameter, RT_INVALID_VALUE when params is NULL,
/// RT_INVALID_OPERATION when no texture is bound, or between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetTexParameteriv(target: RTenum, pname: RTenum, params: *mut RTint) {
    // SAFETY: `params` is NULL or a place for one value, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard(|cx| params.set(&[get_tex_parameter(cx, target, pname)?]))
}

/// See rtGetTexParameteriv(). RT_TEXTURE_MATRIX is 16 numbers, column by column.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetTexParameterfv(target: RTenum, pname: RTenum, params: *mut RTfloat) {
    // SAFETY: `params` is NULL or a place for one value, or 16 of RT_TEXTURE_MATRIX, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard(|cx| {
        if pname != RT_TEXTURE_MATRIX {
            return params.set(&[get_tex_parameter(cx, target, pname)? as RTfloat]);
        }
        cx.is_texture(0)?;
        target_2d(target)?;
        let transform = cx.get_tex_parameters()?.transform;
        let ([a, b, c, d], [s, t]) = (transform.matrix2.to_cols_array(), transform.translation.to_array());
        params.set(&[a, b, 0.0, 0.0, c, d, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, s, t, 0.0, 1.0])
    })
}

/// Reads an image file (PNG, JPEG, EXR, HDR or PNM, told by its content) into a new texture, binds it and
/// returns its name; 0 on failure. Images made for screens are usually stored on the sRGB curve: set
/// RT_TEXTURE_COLOR_SPACE to RT_SRGB.
///
/// Errors: RT_IO_ERROR when the file cannot be read, RT_INVALID_VALUE when file is NULL, RT_INVALID_OPERATION
/// between rtBegin() and rtEnd(), RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtLoadTexture(file: *const c_char) -> RTuint {
    // SAFETY: `file` is NULL or a string, says the manual; it is read before we return.
    let file = unsafe { text("file", file) };
    guard(|cx| cx.load_texture(file?))
}
