//! Instances, lights, camera and surroundings of the frame being assembled.

use super::guard::guard;
use super::types::*;
use crate::api::Mask;
use glam::DVec3;

/// Places an object in the frame being assembled, with the current matrix. Instances hold for one frame: all
/// are gone when it has started.
///
/// Errors: RT_INVALID_VALUE when there is no such object; RT_INVALID_OPERATION between rtBegin() and rtEnd(),
/// between rtNewObject() and rtEndObject(), and when the last row of the current matrix is not 0 0 0 1;
/// RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtInstantiateObject(object: RTuint) {
    guard(|cx| cx.instantiate_object(object))
}

/// Which rays see the instances placed from now on, as 32 bits: those whose own mask has a bit in common with it and with the object's RT_MASK (see
/// rtObjectParameteri()). All bits are set at first. It stays from frame to frame.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtInstanceMask(mask: RTbitfield) {
    guard(|cx| cx.instance_mask(Mask(mask)))
}

/// Lets a shader of a light class shine in the frame being assembled and those after it, until a later frame
/// names lights of its own. 0 takes all lights away.
///
/// Errors: RT_INVALID_VALUE when there is no such shader; RT_INVALID_OPERATION when it is not a light, is used
/// in this frame already, or between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtUseLight(shader: RTuint) {
    guard(|cx| cx.use_light(shader))
}

/// Looks through a shader of a camera class from the frame being assembled on. 0 goes back to the camera of
/// rtPerspective() and rtLookAt().
///
/// Errors: RT_INVALID_VALUE when there is no such shader; RT_INVALID_OPERATION when it is not a camera, or
/// between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtUseCamera(shader: RTuint) {
    guard(|cx| cx.use_camera(shader))
}

/// Surrounds the scene with a shader of an environment class, from the frame being assembled on. 0 goes back to
/// the clear colour.
///
/// Errors: RT_INVALID_VALUE when there is no such shader; RT_INVALID_OPERATION when it is not an environment,
/// or between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtUseEnvironmentShader(shader: RTuint) {
    guard(|cx| cx.use_environment_shader(shader))
}

/// Renders with a shader of a rendering class from the frame being assembled on. 0 goes back to whitted.
///
/// Errors: RT_INVALID_VALUE when there is no such shader; RT_INVALID_OPERATION when it is not a rendering
/// object, or between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtUseRenderingObject(shader: RTuint) {
    guard(|cx| cx.use_rendering_object(shader))
}

/// Sets up a perspective camera: fovY degrees from the bottom to the top of the picture, aspect its width
/// divided by its height. near and far are checked as in OpenGL, but nothing is cut off at them. The camera
/// replaces the projection set before; the matrix stack has no part in it.
///
/// Errors: RT_INVALID_VALUE unless 0 < fovY < 180, aspect > 0 and 0 < near < far; RT_INVALID_OPERATION between
/// rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtPerspective(fovY: RTdouble, aspect: RTdouble, zNear: RTdouble, zFar: RTdouble) {
    guard(|cx| cx.perspective(fovY, aspect, zNear, zFar))
}

/// Sets up a perspective camera by its window on the near plane. See rtPerspective().
///
/// Errors: RT_INVALID_VALUE for an empty window, planes that are not 0 < zNear < zFar, or numbers that are not
/// finite; RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtFrustum(
    left: RTdouble,
    right: RTdouble,
    bottom: RTdouble,
    top: RTdouble,
    zNear: RTdouble,
    zFar: RTdouble,
) {
    guard(|cx| cx.frustum(left, right, bottom, top, zNear, zFar))
}

/// Sets up an orthographic camera by its window in world units. Rays begin in the plane of the eye. See
/// rtPerspective().
///
/// Errors: RT_INVALID_VALUE for an empty window, zNear equal to zFar, or numbers that are not finite;
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtOrtho(
    left: RTdouble,
    right: RTdouble,
    bottom: RTdouble,
    top: RTdouble,
    zNear: RTdouble,
    zFar: RTdouble,
) {
    guard(|cx| cx.ortho(left, right, bottom, top, zNear, zFar))
}

/// Places the camera at eye, looking at center, with up upwards in the picture. Without it the camera is at the
/// origin and looks along -z. The matrix stack has no part in it.
///
/// Errors: RT_INVALID_VALUE when eye is at center, up points along the view, or a number is not finite;
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)]
pub extern "C" fn rtLookAt(
    eyeX: RTdouble,
    eyeY: RTdouble,
    eyeZ: RTdouble,
    centerX: RTdouble,
    centerY: RTdouble,
    centerZ: RTdouble,
    upX: RTdouble,
    upY: RTdouble,
    upZ: RTdouble,
) {
    let (eye, center) = (DVec3::new(eyeX, eyeY, eyeZ), DVec3::new(centerX, centerY, centerZ));
    guard(|cx| cx.look_at(eye, center, DVec3::new(upX, upY, upZ)))
}

/// Sets the colour that rays see which leave the scene, when there is no environment shader: linear red, green,
/// blue, and opacity. Not clamped.
///
/// Errors: RT_INVALID_VALUE when a number is not finite, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtClearColor(red: RTfloat, green: RTfloat, blue: RTfloat, alpha: RTfloat) {
    guard(|cx| cx.clear_color([red, green, blue, alpha]))
}
