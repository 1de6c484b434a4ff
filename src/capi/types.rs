//! The C types of `<openrt/rt.h>`: numbers named as in OpenGL, and the plain structures that cross the
//! boundary.

#![allow(non_camel_case_types)]

use std::ffi::{c_char, c_double, c_float, c_int, c_schar, c_short, c_uchar, c_uint, c_ushort, c_void};

/// One of the RT_ constants.
pub type RTenum = c_uint;
/// RT_TRUE or RT_FALSE; any value but 0 is taken as true.
pub type RTboolean = c_uchar;
/// RT_ flags, OR-ed.
pub type RTbitfield = c_uint;
/// Signed 8-bit integer.
pub type RTbyte = c_schar;
/// Signed 16-bit integer.
pub type RTshort = c_short;
/// Signed 32-bit integer.
pub type RTint = c_int;
/// A count or a size. Signed as in OpenGL; negative values are errors, never huge numbers.
pub type RTsizei = c_int;
/// Unsigned 8-bit integer.
pub type RTubyte = c_uchar;
/// Unsigned 16-bit integer.
pub type RTushort = c_ushort;
/// Unsigned 32-bit integer; also the name of an object, a shader, a shader class, a texture or a context. 0
/// names nothing.
pub type RTuint = c_uint;
/// Single precision.
pub type RTfloat = c_float;
/// Single precision, clamped to 0..1 where it is used.
pub type RTclampf = c_float;
/// Double precision. The engine computes in single precision, so doubles are rounded when they are read.
pub type RTdouble = c_double;
/// Double precision, clamped to 0..1 where it is used.
pub type RTclampd = c_double;

/// A ray asked of rtIntersectRays() or rtOccludedRays(): the points origin + t * direction with tmin <= t <=
/// tmax.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RTray {
    /// World space.
    pub origin: [RTfloat; 3],
    /// Smallest accepted distance; negative counts as 0.
    pub tmin: RTfloat,
    /// Any length but 0. Distances are measured in units of this length. A zero or non-finite direction hits
    /// nothing.
    pub direction: [RTfloat; 3],
    /// Largest accepted distance; INFINITY for no limit.
    pub tmax: RTfloat,
}

/// What a ray met.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RThit {
    /// Distance in units of the ray's direction; negative when nothing was hit. The other fields are then 0.
    pub t: RTfloat,
    /// Barycentric weight of the triangle's second corner.
    pub u: RTfloat,
    /// Barycentric weight of the triangle's third corner; the first one's is 1 - u - v.
    pub v: RTfloat,
    /// Number of the triangle in its object, in the order of definition. Polygons are cut into triangles.
    pub primitive: RTuint,
    /// Name of the object; 0 when nothing was hit.
    pub object: RTuint,
    /// Number of the instance in its frame: the first rtInstantiateObject() made instance 0.
    pub instance: RTuint,
}

/// What the last finished frame, or the last rtCommitScene(), cost. Times in seconds of wall clock.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RTframeStats {
    /// Bringing the acceleration structures up to date, the top level included.
    pub updateSeconds: RTdouble,
    /// The top level alone.
    pub topLevelSeconds: RTdouble,
    /// Tracing and shading.
    pub renderSeconds: RTdouble,
    /// From the start of the frame to its last pixel.
    pub totalSeconds: RTdouble,
    /// Rays from the camera.
    pub primaryRays: RTdouble,
    /// Rays that only ask whether something is in the way.
    pub shadowRays: RTdouble,
    /// Reflected, refracted and all other rays sent by shaders.
    pub secondaryRays: RTdouble,
    /// Instances in the frame.
    pub instances: RTdouble,
    /// Triangles, each counted once per instance.
    pub triangles: RTdouble,
    /// Nodes of acceleration structures that were computed anew before the first ray.
    pub nodesUpdated: RTdouble,
    /// Subtrees of RT_LAZY objects and of those left to the rays (see objectsByRays), subfields of RT_VISIBILITY_FIELD and objects that waited for a ray (see objectsWaiting)
    /// that rays of the frame were the first to reach and so had computed anew.
    pub subtreesTouched: RTdouble,
    /// Nodes in these subtrees, which nodesUpdated does not count.
    pub nodesTouched: RTdouble,
    /// Bytes held by acceleration structures.
    pub structureBytes: RTdouble,
    /// Share of the picture, 0 to 1, that was rendered in full; the rest has had only its rays from the camera, for
    /// want of time (see RT_TIME_BUDGET of rtFrameParameteri()).
    pub refined: RTdouble,
    /// One pixel in each block of so many on a side was sampled.
    pub subsampling: RTuint,
    /// Objects whose structure was built.
    pub objectsBuilt: RTuint,
    /// Objects whose structure was brought up to date in place.
    pub objectsRefitted: RTuint,
    /// Objects whose vertices have moved and that no ray met in the frame before: with RT_AUTO their structures wait for one.
    pub objectsWaiting: RTuint,
    /// Objects whose vertices move and whose structures RT_AUTO leaves to the rays, as RT_LAZY does: the times of earlier frames say that it pays.
    pub objectsByRays: RTuint,
    /// RT_STATIC instances whose triangles have been merged into one structure.
    pub mergedInstances: RTuint,
    /// RT_TRUE when the frame was cancelled; some pixels then show an older frame.
    pub cancelled: RTboolean,
}

/// Is told of every error: the code, a text that is valid during the call only, and the pointer given to
/// rtErrorCallback(). Called on the thread whose call went wrong, after the error was recorded, with no lock held;
/// it may call any function of this library, and is not told of errors that it makes itself. It must not leave by
/// longjmp() or by a C++ exception.
pub type RTerrorCallback = Option<unsafe extern "C" fn(error: RTenum, message: *const c_char, userData: *mut c_void)>;

/// Is told that a frame has ended, and whether it was cancelled. Called on a thread of the library on which no
/// context is current: it should only note the fact or wake somebody up, and leave rtEndRendering() to the thread
/// that owns the context. It must not destroy that context, which waits for it, nor leave by longjmp() or by a C++
/// exception.
pub type RTframeCallback = Option<unsafe extern "C" fn(cancelled: RTboolean, userData: *mut c_void)>;
