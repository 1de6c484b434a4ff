//! Settings and getters.

use super::arrays::{ClientArrays, number_of_component};
use super::constants::*;
use super::current::Session;
use super::frame_parameters::upsampling_number;
use super::guard::{guard, guard_session};
use super::loaded_scenes::READERS;
use super::pointer::{OutArray, answer};
use super::refusal::unknown;
use super::types::*;
use crate::api::{Capability, Result, State, StateString, TopLevelKind};
use std::ffi::c_char;

fn capability(name: RTenum) -> Result<Capability> {
    Ok(match name {
        RT_FRAMEBUFFER_SRGB => Capability::FramebufferSrgb,
        RT_ORIGIN_TOP_LEFT => Capability::OriginTopLeft,
        RT_ACCUMULATE => Capability::Accumulate,
        RT_PROGRESSIVE => Capability::Progressive,
        _ => return Err(unknown("capability", name, "a capability")),
    })
}

/// Switches a capability on: RT_FRAMEBUFFER_SRGB, RT_ORIGIN_TOP_LEFT, RT_ACCUMULATE or RT_PROGRESSIVE. All begin
/// switched off.
///
/// Errors: RT_INVALID_ENUM for something else, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtEnable(capability_: RTenum) {
    guard(|cx| {
        #[cfg(debug_assertions)]
        defect_on_demand(capability_);
        cx.enable(capability(capability_)?)
    })
}

/// Debug builds have a defect for tests of the panic boundary to find.
#[cfg(debug_assertions)]
fn defect_on_demand(capability: RTenum) {
    assert!(capability != 0x7FFF_DEAD, "the defect that tests ask for");
}

/// Switches a capability off. See rtEnable().
#[unsafe(no_mangle)]
pub extern "C" fn rtDisable(capability_: RTenum) {
    guard(|cx| cx.disable(capability(capability_)?))
}

/// RT_TRUE when a capability (see rtEnable()) or a vertex array (see rtEnableClientState()) is switched on.
///
/// Errors: RT_INVALID_ENUM for something else, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtIsEnabled(capability_: RTenum) -> RTboolean {
    guard_session(|session| {
        session.outside_begin()?;
        match session.arrays.of(capability_) {
            Some(array) => Ok(array.enabled.into()),
            None => session.context.is_enabled(capability(capability_)?).map(RTboolean::from),
        }
    })
}

/// Sets how many samples are taken in each pixel, from the next frame on; they are averaged. 1, which is the
/// default, takes the centre.
///
/// Errors: RT_INVALID_VALUE when samples is below 1 or above RT_MAX_SAMPLES, RT_INVALID_OPERATION between
/// rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtSamplesPerPixel(samples: RTint) {
    guard(|cx| cx.samples_per_pixel(samples))
}

/// Sets how often a ray may be reflected or refracted, from the next frame on. 0 is never; the default is 3.
///
/// Errors: RT_INVALID_VALUE when depth is negative or above RT_MAX_RAY_DEPTH, RT_INVALID_OPERATION between
/// rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtMaxDepth(depth: RTint) {
    guard(|cx| cx.max_depth(depth))
}

/// Sets the structure over the instances, from the next frame on: RT_AUTO, which is the default and takes the one
/// that was measured to be faster, RT_BSP (Wald, Benthin and Slusallek 2003) or RT_TOPLEVEL_BVH. All give the
/// same picture. rtGetIntegerv(RT_TOPLEVEL, ...) gives it back.
///
/// Errors: RT_INVALID_ENUM for another structure, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtTopLevel(structure: RTenum) {
    guard(|cx| {
        cx.top_level(match structure {
            RT_AUTO => TopLevelKind::Auto,
            RT_BSP => TopLevelKind::Bsp,
            RT_TOPLEVEL_BVH => TopLevelKind::Bvh,
            _ => return Err(unknown("structure", structure, "a structure over instances")),
        })
    })
}

fn state(pname: RTenum) -> Result<State> {
    Ok(match pname {
        RT_MATRIX => State::CurrentMatrix,
        RT_MATRIX_STACK_DEPTH => State::MatrixDepth,
        RT_MAX_MATRIX_STACK_DEPTH => State::MaxMatrixDepth,
        RT_CURRENT_COLOR => State::CurrentColor,
        RT_CURRENT_NORMAL => State::CurrentNormal,
        RT_CURRENT_TEXTURE_COORDS => State::CurrentTexCoord,
        RT_CURRENT_OBJECT => State::CurrentObject,
        RT_SHADER_CLASS_BINDING => State::BoundShaderClass,
        RT_SHADER_BINDING => State::BoundShader,
        RT_TEXTURE_BINDING_2D => State::BoundTexture,
        RT_CAMERA => State::Camera,
        RT_ENVIRONMENT => State::Environment,
        RT_CURRENT_RENDERING_OBJECT => State::RenderingObject,
        RT_LIGHT_COUNT => State::LightCount,
        RT_INSTANCE_COUNT => State::InstanceCount,
        RT_COLOR_CLEAR_VALUE => State::ClearColor,
        RT_AMBIENT_LIGHT => State::AmbientLight,
        RT_VIEWPORT => State::Viewport,
        RT_FRAME_SIZE => State::FrameSize,
        RT_MAX_FRAME_SIZE => State::MaxFrameSize,
        RT_MAX_TEXTURE_SIZE => State::MaxTextureSize,
        RT_SAMPLES_PER_PIXEL => State::SamplesPerPixel,
        RT_MAX_SAMPLES => State::MaxSamples,
        RT_RAY_DEPTH => State::MaxDepth,
        RT_MAX_RAY_DEPTH => State::MaxMaxDepth,
        RT_THREADS => State::Threads,
        RT_RENDERING => State::Rendering,
        RT_FRAME_NUMBER => State::FrameNumber,
        RT_SUBSAMPLING => State::Subsampling,
        RT_FRAMELESS => State::Frameless,
        RT_TIME_BUDGET => State::TimeBudget,
        RT_JPEG_QUALITY => State::JpegQuality,
        other => match capability(other) {
            Ok(capability) => State::Capability(capability),
            Err(_) => return Err(unknown("pname", pname, "a state that can be asked for")),
        },
    })
}

/// What a vertex array looks like, if `pname` asks for that.
fn array_state(arrays: &ClientArrays, pname: RTenum) -> Option<RTint> {
    let ClientArrays { vertex, normal, color, tex_coord } = arrays;
    let kind = |array: &super::arrays::ClientArray| number_of_component(array.component) as RTint;
    Some(match pname {
        RT_VERTEX_ARRAY => vertex.enabled.into(),
        RT_VERTEX_ARRAY_SIZE => vertex.size,
        RT_VERTEX_ARRAY_TYPE => kind(vertex),
        RT_VERTEX_ARRAY_STRIDE => vertex.stride,
        RT_NORMAL_ARRAY => normal.enabled.into(),
        RT_NORMAL_ARRAY_TYPE => kind(normal),
        RT_NORMAL_ARRAY_STRIDE => normal.stride,
        RT_COLOR_ARRAY => color.enabled.into(),
        RT_COLOR_ARRAY_SIZE => color.size,
        RT_COLOR_ARRAY_TYPE => kind(color),
        RT_COLOR_ARRAY_STRIDE => color.stride,
        RT_TEXTURE_COORD_ARRAY => tex_coord.enabled.into(),
        RT_TEXTURE_COORD_ARRAY_SIZE => tex_coord.size,
        RT_TEXTURE_COORD_ARRAY_TYPE => kind(tex_coord),
        RT_TEXTURE_COORD_ARRAY_STRIDE => tex_coord.stride,
        _ => return None,
    })
}

/// Stores the numbers behind `pname` as `T`.
fn get<T: Copy + Default>(
    session: &mut Session,
    pname: RTenum,
    params: &OutArray<T>,
    convert: impl Fn(f64) -> T,
) -> Result<()> {
    session.outside_begin()?;
    if let Some(value) = array_state(&session.arrays, pname) {
        return params.set(&[convert(value.into())]);
    }
    match pname {
        RT_LIGHTS => {
            let lights = session.context.get_lights()?;
            let mut out = Vec::new();
            out.try_reserve_exact(lights.len())?;
            out.extend(lights.iter().map(|light| convert(light.shader.into())));
            params.set(&out)
        }
        RT_TOPLEVEL => params.set(&[convert(f64::from(match session.context.get_top_level()? {
            TopLevelKind::Auto => RT_AUTO,
            TopLevelKind::Bsp => RT_BSP,
            TopLevelKind::Bvh => RT_TOPLEVEL_BVH,
        }))]),
        RT_SCENE_READERS => params.set(&[convert(f64::from(u8::from(READERS)))]),
        RT_UPSAMPLING => params.set(&[convert(f64::from(upsampling_number(session.context.get_upsampling()?)))]),
        // The mode of the definition that is open, as rtNewObject() was given it.
        RT_CURRENT_OBJECT_MODE => {
            let open = session.context.get(State::CurrentObject)?.as_slice()[0] != 0.0;
            let mode = session.context.get(State::CurrentObjectMode)?.as_slice()[0];
            params.set(&[convert(if open { f64::from(RT_COMPILE) + mode } else { 0.0 })])
        }
        _ => {
            let value = session.context.get(state(pname)?)?;
            let mut out = [T::default(); 16];
            let numbers = value.as_slice();
            out.iter_mut().zip(numbers).for_each(|(to, &from)| *to = convert(from));
            params.set(&out[..numbers.len()])
        }
    }
}

/// Stores the value of a piece of state at params, which must have room for as many numbers as it has:
///
/// 16 for RT_MATRIX (column by column); 4 for RT_CURRENT_COLOR, RT_CURRENT_TEXTURE_COORDS, RT_COLOR_CLEAR_VALUE
/// and RT_VIEWPORT (x, y, width, height); 3 for RT_CURRENT_NORMAL and RT_AMBIENT_LIGHT; 2 for RT_FRAME_SIZE; RT_LIGHT_COUNT many for
/// RT_LIGHTS; 1 for everything else: RT_MATRIX_STACK_DEPTH, RT_MAX_MATRIX_STACK_DEPTH, RT_CURRENT_OBJECT,
/// RT_CURRENT_OBJECT_MODE, RT_SHADER_CLASS_BINDING, RT_SHADER_BINDING, RT_TEXTURE_BINDING_2D, RT_CAMERA,
/// RT_ENVIRONMENT, RT_CURRENT_RENDERING_OBJECT, RT_LIGHT_COUNT, RT_INSTANCE_COUNT, RT_MAX_FRAME_SIZE,
/// RT_MAX_TEXTURE_SIZE, RT_SAMPLES_PER_PIXEL, RT_MAX_SAMPLES, RT_RAY_DEPTH, RT_MAX_RAY_DEPTH, RT_THREADS,
/// RT_RENDERING, RT_FRAME_NUMBER, RT_TOPLEVEL, RT_JPEG_QUALITY, the parameters of rtFrameParameteri(), the capabilities of rtEnable(), and the
/// vertex arrays with their sizes, types and strides.
///
/// Numbers that are not integers are rounded.
///
/// Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when params is NULL, RT_INVALID_OPERATION
/// between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetIntegerv(pname: RTenum, params: *mut RTint) {
    // SAFETY: `params` is NULL or has room for the numbers of `pname`, says the manual.
    let params = unsafe { OutArray::new(params) };
    // Names above the largest RTint wrap, so that they are right when read as RTuint.
    let integer = |v: f64| v.round().clamp(f64::from(RTint::MIN), f64::from(RTuint::MAX)) as i64 as RTint;
    guard_session(|session| get(session, pname, &params, integer))
}

/// As rtGetIntegerv(), in single precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetFloatv(pname: RTenum, params: *mut RTfloat) {
    // SAFETY: `params` is NULL or has room for the numbers of `pname`, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard_session(|session| get(session, pname, &params, |v| v as RTfloat))
}

/// As rtGetIntegerv(), in double precision.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetDoublev(pname: RTenum, params: *mut RTdouble) {
    // SAFETY: `params` is NULL or has room for the numbers of `pname`, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard_session(|session| get(session, pname, &params, |v| v))
}

/// As rtGetIntegerv(), RT_FALSE for 0 and RT_TRUE for everything else.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetBooleanv(pname: RTenum, params: *mut RTboolean) {
    // SAFETY: `params` is NULL or has room for the numbers of `pname`, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard_session(|session| get(session, pname, &params, |v| RTboolean::from(v != 0.0)))
}

/// Returns a text about the library: RT_VENDOR, RT_VERSION (major.minor.patch), RT_RENDERER (the rendering
/// object in use), RT_SIMD_LEVEL (the instruction set in use) or RT_BACKEND (who executes frames); NULL on
/// failure. The text belongs to the library and is valid until the process ends.
///
/// Errors: RT_INVALID_ENUM for another name, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtGetString(name: RTenum) -> *const c_char {
    guard_session(|session| {
        session.outside_begin()?;
        let text = session.context.get_string(match name {
            RT_VENDOR => StateString::Vendor,
            RT_VERSION => StateString::Version,
            RT_RENDERER => StateString::Renderer,
            RT_SIMD_LEVEL => StateString::SimdLevel,
            RT_BACKEND => StateString::Backend,
            _ => return Err(unknown("name", name, "a text of the library")),
        })?;
        answer(text)
    })
}
