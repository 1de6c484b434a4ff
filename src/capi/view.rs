//! Instances, lights, camera and surroundings of the frame being assembled.

use super::guard::guard;
use super::pointer::strided;
use super::types::*;
use crate::api::Mask;
use glam::{DVec3, Mat4};

/// Places an object in the frame being assembled, with the current matrix. Instances hold for one frame: all
/// are gone when it has started.
///
/// Between rtNewObject() and rtEndObject() it makes the object part of the one that is being defined, with the
/// current matrix, as glCallList() does between glNewList() and glEndList(). Objects may have triangles and parts,
/// and parts may have parts, as deep as memory allows. Parts are named, not copied: one that is defined anew shows
/// from the next frame on wherever it is a part, one that is deleted shows nothing until an object of its name is
/// defined. Hits and RT_OBJECT_ID name the innermost object, whose triangle was hit; their instance is the one that
/// was placed in the frame.
///
/// A matrix that flattens the object, as rtScalef(1, 1, 0) does, shows it flat; that takes memory and time for each
/// such instance, as does one that is smaller than 1e-12 of its object.
///
/// Errors: RT_INVALID_VALUE when there is no such object, or the matrix has an element above 1.844e18, the largest
/// coordinate; RT_INVALID_OPERATION between rtBegin() and rtEnd(), when the last row of the current matrix is not
/// 0 0 0 1, or when the object would become a part of itself; RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtInstantiateObject(object: RTuint) {
    guard(|cx| cx.instantiate_object(object))
}

/// Which rays see the instances placed from now on, as 32 bits: those whose own mask has a bit in common with it and with the object's RT_MASK (see
/// rtObjectParameteri()). All bits are set at first. It stays from frame to frame. A part of an object that is placed keeps the mask that it was given there,
/// and the mask of the whole counts for it, too.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtInstanceMask(mask: RTbitfield) {
    guard(|cx| cx.instance_mask(Mask(mask)))
}

/// Places an object n times: once for each of the n matrices at matrices, which is multiplied on the current matrix
/// as by rtMultMatrixf(). A matrix is 16 numbers, column by column; from one to the next it is stride bytes, or 64
/// when stride is 0. The current matrix stays. As rtInstantiateObject() many times, but all are placed or none.
///
/// Errors: as rtInstantiateObject(); RT_INVALID_VALUE also when n is negative, stride is neither 0 nor at least 64,
/// matrices is NULL, or a number is not finite.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtInstantiateObjects(object: RTuint, n: RTsizei, matrices: *const RTfloat, stride: RTsizei) {
    // SAFETY: `matrices` is NULL or points to n matrices that are `stride` bytes apart, says the manual; they are read before we return.
    let matrices = unsafe { strided::<RTfloat, 16>("matrices", matrices, n, stride) };
    guard(|cx| {
        cx.is_object(0)?;
        cx.instantiate_objects(object, matrices?.map(|matrix| Mat4::from_cols_array(&matrix)))
    })
}

/// Begins a new frame without rendering the one that was being assembled: its instances are dropped, and what was
/// drawn outside objects. Lights, camera and all else that persists from frame to frame stay. rtCommitScene() keeps
/// the instances, so a program that only asks rays places them, commits, asks, and calls this before it places them
/// anew.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject();
/// RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtClearInstances() {
    guard(|cx| cx.clear_instances())
}

/// Lets a shader of a light class shine in the frame being assembled and those after it, until a later frame
/// names lights of its own. 0 takes all lights away.
///
/// The current matrix is applied to its position and direction and to the edges of an area, as OpenGL applies it in
/// glLightfv(GL_POSITION); the parameters keep their values, so the same shader may be used several times in a
/// frame, each time with another matrix. The radius of a sphere changes with the cube root of the matrix's
/// determinant; attenuation is by distance in the world.
///
/// Errors: RT_INVALID_VALUE when there is no such shader, or the matrix has an element above 1.844e18;
/// RT_INVALID_OPERATION when the shader is not a light, is used in this frame already with this matrix, when the last
/// row of the matrix is not 0 0 0 1, when it has no inverse and the light is a function of the application's, or
/// between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtUseLight(shader: RTuint) {
    guard(|cx| cx.use_light(shader))
}

/// Sets the light that comes from everywhere, as glLightModelfv(GL_LIGHT_MODEL_AMBIENT) does: a surface reflects its
/// parameter ambient of it, and of lights of class ambient. Linear, not clamped. Before the first call it is 0.2 in
/// frames without lights of class ambient, and only surfaces reflect it whose ambient was set. The rendering object
/// path computes the light that this stands for, and leaves it out.
///
/// Errors: RT_INVALID_VALUE when a number is not finite, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtAmbientLight(red: RTfloat, green: RTfloat, blue: RTfloat) {
    guard(|cx| cx.ambient_light([red, green, blue]))
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
