//! Objects and their instances.

use super::constants::*;
use super::guard::guard;
use super::pointer::OutArray;
use super::refusal::{not_negative, unknown};
use super::types::*;
use crate::api::{Context, Mask, Mode, Motion, ObjectParameter, Result, Strategy};

const MOTION_FLAGS: RTbitfield = RT_STATIC | RT_AFFINE | RT_UNSTRUCTURED;

fn mode_and_motion(mode: RTenum) -> Result<(Mode, Option<Motion>)> {
    let compile = match mode & !MOTION_FLAGS {
        RT_COMPILE => Mode::Compile,
        RT_COMPILE_AND_INSTANTIATE => Mode::CompileAndInstantiate,
        _ => return Err(unknown("mode", mode, "an object mode")),
    };
    let flag = mode & MOTION_FLAGS;
    Ok((compile, if flag == 0 { None } else { Some(motion(flag)?) }))
}

fn motion(flag: RTbitfield) -> Result<Motion> {
    Ok(match flag {
        RT_AFFINE => Motion::Affine,
        RT_STATIC => Motion::Static,
        RT_UNSTRUCTURED => Motion::Unstructured,
        _ => return Err(unknown("motion", flag, "one motion flag")),
    })
}

fn strategy(value: RTenum) -> Result<Strategy> {
    Ok(match value {
        RT_AUTO => Strategy::Auto,
        RT_BSP => Strategy::Bsp,
        RT_SAH => Strategy::Sah,
        RT_FAST_BUILD => Strategy::FastBuild,
        RT_REFIT => Strategy::Refit,
        RT_ROTATE => Strategy::Rotate,
        RT_GRID => Strategy::Grid,
        RT_LAZY => Strategy::Lazy,
        RT_VISIBILITY_FIELD => Strategy::VisibilityField,
        _ => return Err(unknown("param", value, "an update strategy")),
    })
}

fn truth(value: RTenum) -> Result<bool> {
    match RTboolean::try_from(value) {
        Ok(RT_TRUE) => Ok(true),
        Ok(RT_FALSE) => Ok(false),
        _ => Err(unknown("param", value, "RT_TRUE or RT_FALSE")),
    }
}

/// Returns the first of n new names in a row, for rtNewObject(); 0 on failure. Each names an empty object.
///
/// Errors: RT_INVALID_VALUE when n is not positive, RT_OUT_OF_MEMORY when there are not n names in a row left,
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtGenObjects(n: RTsizei) -> RTuint {
    guard(|cx| cx.gen_objects(n))
}

/// Begins the definition of the object called object. The name need not come from rtGenObjects(). If the object
/// exists, its geometry is replaced when the definition ends, for all its instances from the next frame on.
///
/// mode is RT_COMPILE (or RT_DEFINE), or RT_COMPILE_AND_INSTANTIATE (or RT_DEFINE_AND_INSTANTIATE) to also
/// place the object once with the matrix that is current at rtEndObject(); OR-ed with at most one of RT_STATIC,
/// RT_AFFINE and RT_UNSTRUCTURED, which say how the object will move. Without one it stays as it is: RT_AFFINE, or
/// what rtObjectParameteri() has set, before the first definition, too. Wrong promises cost time, not correctness.
///
/// The matrix current at each vertex is applied to it. Matrices, bound shaders and other state are neither
/// saved nor restored by a definition.
///
/// Errors: RT_INVALID_ENUM for another mode, RT_INVALID_VALUE for the name 0 or one of the 256 largest names,
/// RT_INVALID_OPERATION inside a definition or between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtNewObject(object: RTuint, mode: RTenum) {
    guard(|cx| {
        let (mode, motion) = mode_and_motion(mode)?;
        cx.new_object(object, mode, motion)
    })
}

/// Ends the definition of an object.
///
/// Errors: RT_INVALID_OPERATION without rtNewObject() or between rtBegin() and rtEnd(), and for
/// RT_COMPILE_AND_INSTANTIATE when the last row of the current matrix is not 0 0 0 1 (the definition then stays
/// open); RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtEndObject() {
    guard(|cx| cx.end_object())
}

/// Deletes the n objects whose names begin with first. Names that are not in use are passed over. Instances
/// already placed in the frame being assembled, and frames that are being rendered, still show deleted objects.
///
/// Errors: RT_INVALID_VALUE when n is negative, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtDeleteObjects(first: RTuint, n: RTsizei) {
    guard(|cx| cx.delete_objects(first, n))
}

/// RT_TRUE when object is the name of an object: generated or defined, and not deleted.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtIsObject(object: RTuint) -> RTboolean {
    guard(|cx| cx.is_object(object).map(RTboolean::from))
}

fn object_parameter(cx: &mut Context, object: RTuint, pname: RTenum, value: RTenum) -> Result<()> {
    let parameter = match pname {
        RT_UPDATE_STRATEGY => ObjectParameter::Strategy(strategy(value)?),
        RT_MOTION => ObjectParameter::Motion(motion(value)?),
        RT_LAZY_CUT | RT_LAZY_LEVELS => {
            let number = not_negative("param", value as RTint)?;
            let mut shape = cx.get_object_parameters(object)?.lazy_shape;
            *if pname == RT_LAZY_CUT { &mut shape.cut } else { &mut shape.levels } = number;
            ObjectParameter::LazyShape(shape)
        }
        RT_OBJECT_TIME => ObjectParameter::Time(value as RTint as f32),
        RT_SPATIAL_SPLITS => ObjectParameter::SpatialSplits(truth(value)?),
        RT_MASK => ObjectParameter::Mask(Mask(value)),
        RT_CAST_SHADOW => {
            let mask = cx.get_object_parameters(object)?.mask;
            ObjectParameter::Mask(mask.with(Mask::SHADOW, truth(value)?))
        }
        _ => return Err(unknown("pname", pname, "a parameter of objects that can be set")),
    };
    cx.object_parameter(object, parameter)
}

/// Sets a parameter of an object, from the next frame on. RT_UPDATE_STRATEGY: RT_AUTO, RT_BSP, RT_SAH,
/// RT_FAST_BUILD, RT_REFIT, RT_ROTATE, RT_GRID, RT_LAZY or RT_VISIBILITY_FIELD. RT_MOTION: RT_STATIC, RT_AFFINE or
/// RT_UNSTRUCTURED. RT_LAZY_CUT: the
/// most triangles that a subtree has which RT_LAZY updates when a ray reaches it (2048 at first; 0 for subtrees at half
/// the height). RT_LAZY_LEVELS: how many levels of it are updated at once (0, all, at first). RT_OBJECT_TIME: the
/// time that chooses among key frames, see rtKeyFrame(). None of them changes the picture, but for rounding:
/// vertices of an RT_STATIC object that is placed once are transformed, for others rays are.
///
/// RT_SPATIAL_SPLITS: RT_TRUE or RT_FALSE, the default. With RT_TRUE triangles may be cut at planes where the
/// structure is built, so that long ones, or large ones among small ones, are traced faster; the build takes
/// several times as long, and up to half as much memory again. It has effect while the object is RT_STATIC and its
/// strategy is RT_AUTO or RT_SAH; for other objects it is kept and waits. It never changes the picture.
///
/// RT_MASK: which rays see the object, as 32 bits: those whose own mask has a bit in common with it and with that of the instance (see rtInstanceMask()).
/// Rays of a frame have one of RT_CAMERA_RAYS, RT_SHADOW_RAYS and RT_REFLECTION_RAYS, those of queries RT_QUERY_RAYS or what the query says; the other
/// bits are the application's. All bits are set at first. RT_CAST_SHADOW: RT_TRUE or RT_FALSE, which sets or clears RT_SHADOW_RAYS in the
/// mask: a lamp around its light shall not keep the light in.
///
/// Errors: RT_INVALID_ENUM for another parameter or value, RT_INVALID_VALUE when there is no such object or a number
/// is negative that must not be,
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtObjectParameteri(object: RTuint, pname: RTenum, param: RTint) {
    guard(|cx| object_parameter(cx, object, pname, param as RTenum))
}

/// See rtObjectParameteri(); values but RT_OBJECT_TIME are rounded. RT_INVALID_VALUE for a time that is not finite.
#[unsafe(no_mangle)]
pub extern "C" fn rtObjectParameterf(object: RTuint, pname: RTenum, param: RTfloat) {
    // A float that is not a number becomes 0, which is no value of any parameter.
    guard(|cx| match pname {
        RT_OBJECT_TIME => cx.object_parameter(object, ObjectParameter::Time(param)),
        _ => object_parameter(cx, object, pname, param.round() as RTenum),
    })
}

fn get_object_parameter(cx: &Context, object: RTuint, pname: RTenum) -> Result<RTuint> {
    let info = cx.get_object_parameters(object)?;
    Ok(match pname {
        RT_UPDATE_STRATEGY => match info.strategy {
            Strategy::Auto => RT_AUTO,
            Strategy::Bsp => RT_BSP,
            Strategy::Sah => RT_SAH,
            Strategy::FastBuild => RT_FAST_BUILD,
            Strategy::Refit => RT_REFIT,
            Strategy::Rotate => RT_ROTATE,
            Strategy::Grid => RT_GRID,
            Strategy::Lazy => RT_LAZY,
            Strategy::VisibilityField => RT_VISIBILITY_FIELD,
        },
        RT_MOTION => match info.motion {
            Motion::Static => RT_STATIC,
            Motion::Affine => RT_AFFINE,
            Motion::Unstructured => RT_UNSTRUCTURED,
        },
        RT_SPATIAL_SPLITS => RTuint::from(info.spatial_splits),
        RT_MASK => info.mask.0,
        RT_CAST_SHADOW => RTuint::from(info.mask.meets(Mask::SHADOW)),
        RT_TRIANGLE_COUNT => info.triangle_count,
        RT_VERTEX_COUNT => info.vertex_count,
        RT_LAZY_CUT => info.lazy_shape.cut,
        RT_LAZY_LEVELS => info.lazy_shape.levels,
        RT_OBJECT_TIME => info.time.round() as RTint as RTuint,
        _ => return Err(unknown("pname", pname, "a parameter of objects")),
    })
}

/// Stores a parameter of an object at params: RT_UPDATE_STRATEGY, RT_MOTION, RT_SPATIAL_SPLITS, RT_TRIANGLE_COUNT,
/// RT_VERTEX_COUNT, RT_LAZY_CUT, RT_LAZY_LEVELS, RT_MASK, RT_CAST_SHADOW or RT_OBJECT_TIME (rounded).
///
/// Errors: RT_INVALID_ENUM for another parameter, RT_INVALID_VALUE when there is no such object or params is
/// NULL, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetObjectParameteriv(object: RTuint, pname: RTenum, params: *mut RTint) {
    // SAFETY: `params` is NULL or a place for one value, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard(|cx| params.set(&[get_object_parameter(cx, object, pname)? as RTint]))
}

/// See rtGetObjectParameteriv(); RT_OBJECT_TIME is not rounded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetObjectParameterfv(object: RTuint, pname: RTenum, params: *mut RTfloat) {
    // SAFETY: `params` is NULL or a place for one value, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard(|cx| {
        let value = match pname {
            RT_OBJECT_TIME => cx.get_object_parameters(object)?.time,
            _ => get_object_parameter(cx, object, pname)? as RTfloat,
        };
        params.set(&[value])
    })
}
