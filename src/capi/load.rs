//! Scene files.

use super::constants::*;
use super::guard::guard_session;
use super::pointer::{OutArray, text};
use super::types::*;
use crate::api::{Context, Error, Result, State};
use std::ffi::c_char;

/// Parts of a scene.
#[derive(Clone, Copy)]
#[cfg_attr(not(feature = "load"), allow(dead_code, reason = "without the readers no scene has parts"))]
pub(super) struct Parts {
    pub instances: bool,
    pub lights: bool,
    pub camera: bool,
    pub background: bool,
}

/// Questions with one number for an answer.
pub(super) enum Integers {
    FirstObject,
    Objects,
    Triangles,
    Lights,
    Cameras,
    Frames,
    Warnings,
    Srgb,
}

/// Questions with several numbers.
pub(super) enum Doubles {
    Times,
    Bounds,
}

/// Questions with a text.
pub(super) enum Text {
    Warning,
    ObjectName,
    Format,
}

fn parts_of(bits: RTbitfield) -> Result<Parts> {
    if bits & !RT_SCENE_ALL_BITS != 0 {
        return Err(Error::invalid_value(format!("0x{bits:X} has bits that name no part of a scene")));
    }
    let has = |bit| bits & bit != 0;
    Ok(Parts {
        instances: has(RT_SCENE_INSTANCES_BIT),
        lights: has(RT_SCENE_LIGHTS_BIT),
        camera: has(RT_SCENE_CAMERA_BIT),
        background: has(RT_SCENE_BACKGROUND_BIT),
    })
}

/// Fails between begin and end, and in the definition of an object.
fn outside_object(cx: &Context) -> Result<()> {
    if cx.get(State::CurrentObject)?.as_slice() != [0.0] {
        return Err(Error::invalid_operation("not allowed between rtNewObject and rtEndObject"));
    }
    Ok(())
}

/// Reads a scene file, defines its objects, shaders and textures in the current context, and puts the parts of
/// it that the bits name into the frame being assembled, as rtInstantiateLoadedScene() does, for the first moment
/// of its animation. Returns the name of the loaded scene; 0 on failure, and then nothing is defined.
///
/// The format is told by the file's extension: .aff or .nff (BART and SPD), .obj with its .mtl, .ply, .gltf or .glb.
/// file is UTF-8. Files that the scene names are read from its own folder and those below, textures also
/// from folders beside it called textures or TextureFiles. What the file has and the library leaves out is told
/// by rtGetLoadedSceneString(), one text for each kind of thing; a file that cannot be understood is an error,
/// whose text begins with file and line.
///
/// Objects, shaders and textures are ordinary ones: they may be instantiated, changed and deleted like any others.
/// The current matrix, what is bound, and the current colour, normal and texture coordinate stay as they are.
/// Colours of glTF files are meant for frame buffers with RT_FRAMEBUFFER_SRGB.
///
///   scene = rtLoadScene("museum.aff", RT_NONE);
///   rtGetLoadedScenedv(scene, RT_SCENE_TIMES, times);   (the first and the last)
///   for (i = 0; i < 100; i++) {
///       rtInstantiateLoadedScene(scene, first + (last - first) * i / 99, RT_SCENE_ALL_BITS);
///       rtRender();
///   }
///
/// Errors: RT_IO_ERROR when the file, or one that it cannot be without, cannot be read or is damaged;
/// RT_INVALID_VALUE when file is NULL or other bits are set; RT_INVALID_OPERATION when the library was built
/// without the readers (see RT_SCENE_READERS), between rtBegin() and rtEnd(), or between rtNewObject() and
/// rtEndObject(); RT_STACK_OVERFLOW when the matrix stack is full; RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtLoadScene(file: *const c_char, parts: RTbitfield) -> RTuint {
    // SAFETY: `file` is NULL or a string, says the manual; it is read before we return.
    let file = unsafe { text("file", file) };
    guard_session(|session| {
        outside_object(&session.context)?;
        let (file, parts) = (file?, parts_of(parts)?);
        session.scenes.load(&mut session.context, file, parts)
    })
}

/// Puts parts of a loaded scene into the frame being assembled, as they are at a time of its animation, in
/// seconds on the file's own clock (RT_SCENE_TIMES); beyond its ends the animation rests, as far as the file does
/// not say otherwise. parts is a combination of:
///
/// RT_SCENE_INSTANCES_BIT: instances of the objects that are visible then, under the current matrix. Vertices of
/// deforming objects have one state in a frame, that of the last call.
/// RT_SCENE_LIGHTS_BIT: the lights that are on, as by rtUseLight().
/// RT_SCENE_CAMERA_BIT: the file's first camera, or one that shows everything, as by rtPerspective() or rtOrtho()
/// and rtLookAt(). Its picture has the shape of the viewport, so rtViewport() comes before.
/// RT_SCENE_BACKGROUND_BIT: what rays see that leave the scene, as by rtClearColor() and rtUseEnvironmentShader().
///
/// May be called while the frame before renders.
///
/// Errors: RT_INVALID_VALUE when there is no such loaded scene, time is not finite, or other bits are set;
/// RT_INVALID_OPERATION between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject();
/// RT_STACK_OVERFLOW when the matrix stack is full; RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtInstantiateLoadedScene(scene: RTuint, time: RTdouble, parts: RTbitfield) {
    guard_session(|session| {
        outside_object(&session.context)?;
        let parts = parts_of(parts)?;
        if !time.is_finite() {
            return Err(Error::invalid_value(format!("the time {time} is not finite")));
        }
        session.scenes.get(scene)?.instantiate(&mut session.context, time, parts)
    })
}

/// Deletes a loaded scene with its objects, shaders and textures. What the frame being assembled shows of it is
/// still shown. 0 is ignored.
///
/// Errors: RT_INVALID_VALUE when there is no such loaded scene; RT_INVALID_OPERATION between rtBegin() and rtEnd(),
/// or between rtNewObject() and rtEndObject(); RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtDeleteLoadedScene(scene: RTuint) {
    guard_session(|session| {
        outside_object(&session.context)?;
        session.scenes.delete(&mut session.context, scene)
    })
}

/// RT_TRUE when scene names a loaded scene.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtIsLoadedScene(scene: RTuint) -> RTboolean {
    guard_session(|session| {
        session.outside_begin()?;
        Ok(session.scenes.get(scene).is_ok().into())
    })
}

fn integers(pname: RTenum) -> Result<Integers> {
    Ok(match pname {
        RT_SCENE_FIRST_OBJECT => Integers::FirstObject,
        RT_SCENE_OBJECT_COUNT => Integers::Objects,
        RT_SCENE_TRIANGLE_COUNT => Integers::Triangles,
        RT_SCENE_LIGHT_COUNT => Integers::Lights,
        RT_SCENE_CAMERA_COUNT => Integers::Cameras,
        RT_SCENE_FRAME_COUNT => Integers::Frames,
        RT_SCENE_WARNING_COUNT => Integers::Warnings,
        RT_SCENE_SRGB => Integers::Srgb,
        _ => return Err(Error::invalid_enum(format!("0x{pname:X} is not a number of a loaded scene"))),
    })
}

/// Stores a number of a loaded scene at params.
///
/// RT_SCENE_FIRST_OBJECT, RT_SCENE_OBJECT_COUNT: its objects have this many names in a row, from the first on.
/// RT_SCENE_TRIANGLE_COUNT: triangles of all objects, each object counted once.
/// RT_SCENE_LIGHT_COUNT, RT_SCENE_CAMERA_COUNT: as many as the file has.
/// RT_SCENE_FRAME_COUNT: frames of the animation; 0 when nothing moves.
/// RT_SCENE_WARNING_COUNT: texts about what was left out.
/// RT_SCENE_SRGB: RT_TRUE when the colours are meant for RT_FRAMEBUFFER_SRGB.
///
/// Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when there is no such loaded scene or params is NULL,
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetLoadedSceneiv(scene: RTuint, pname: RTenum, params: *mut RTint) {
    // SAFETY: `params` is NULL or a place for one value, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard_session(|session| {
        session.outside_begin()?;
        let question = integers(pname)?;
        let value = session.scenes.get(scene)?.integer(question);
        params.set(&[RTint::try_from(value).unwrap_or(RTint::MAX)])
    })
}

/// Stores numbers of a loaded scene at params.
///
/// RT_SCENE_TIMES: first and last moment of the animation, in seconds on the file's clock; 0 0 when nothing moves.
/// RT_SCENE_BOUNDS: lowest x, y, z and highest x, y, z of what is there at the first moment; 0 for an empty scene.
///
/// Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when there is no such loaded scene or params is NULL,
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetLoadedScenedv(scene: RTuint, pname: RTenum, params: *mut RTdouble) {
    // SAFETY: `params` is NULL or a place for as many values as the manual says.
    let params = unsafe { OutArray::new(params) };
    guard_session(|session| {
        session.outside_begin()?;
        let question = match pname {
            RT_SCENE_TIMES => Doubles::Times,
            RT_SCENE_BOUNDS => Doubles::Bounds,
            _ => return Err(Error::invalid_enum(format!("0x{pname:X} is not numbers of a loaded scene"))),
        };
        params.set(&session.scenes.get(scene)?.doubles(question))
    })
}

/// A text of a loaded scene, which lives until the scene is deleted.
///
/// RT_SCENE_WARNING: what was left out or is odd, index from 0 to below RT_SCENE_WARNING_COUNT; most begin with file
/// and line.
/// RT_SCENE_OBJECT_NAME: the file's name for an object, index from 0 to below RT_SCENE_OBJECT_COUNT.
/// RT_SCENE_FORMAT: "AFF", "NFF", "OBJ", "PLY" or "glTF"; index is 0.
///
/// Returns NULL on failure.
///
/// Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when there is no such loaded scene or no such text,
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtGetLoadedSceneString(scene: RTuint, pname: RTenum, index: RTuint) -> *const c_char {
    guard_session(|session| {
        session.outside_begin()?;
        let question = match pname {
            RT_SCENE_WARNING => Text::Warning,
            RT_SCENE_OBJECT_NAME => Text::ObjectName,
            RT_SCENE_FORMAT => Text::Format,
            _ => return Err(Error::invalid_enum(format!("0x{pname:X} is not a text of a loaded scene"))),
        };
        let text = session.scenes.get(scene)?.text(question, index);
        Ok(text
            .ok_or_else(|| Error::invalid_value(format!("the loaded scene has no text {index} of this kind")))?
            .as_ptr())
    })
}
