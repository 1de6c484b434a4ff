/* openrt: an OpenGL-like API over a CPU ray tracing engine for scenes that move.
 *
 * Generated from src/capi by tests/header.rs; not to be edited.
 * SPDX-License-Identifier: MIT OR Apache-2.0 */
#ifndef OPENRT_RT_H
#define OPENRT_RT_H

#define OPENRT_VERSION_MAJOR 0
#define OPENRT_VERSION_MINOR 1
#define OPENRT_VERSION_PATCH 0

/* Before every function. */
#ifndef RTAPI
#if defined(_WIN32) && !defined(OPENRT_STATIC)
#define RTAPI __declspec(dllimport)
#else
#define RTAPI
#endif
#endif

/* Rules for all calls
 *
 * A call that is in error changes nothing; rtGetError() returns the first error since it was last asked. No argument can
 * crash the program, except a pointer to memory that is not there or is shorter than the manual says.
 *
 * Coordinates are right-handed, matrices are stored column by column, angles are in degrees. The first row of a picture is
 * the lowest. Colours are linear unless said otherwise.
 *
 * A context is used by one thread at a time: the one on which it is current. Rendering is parallel inside the library. After
 * fork() the child may go on using the context of the forking thread; a frame that was being rendered is the parent's, and
 * rtEndRendering() in the child is RT_INVALID_OPERATION. The library does not change the floating-point environment of the
 * caller, and flushing of denormals there does not change pictures. */

/** A snapshot of a scene; see rtAcquireScene(). */
typedef struct RTsceneView RTsceneView;

/**
 * What the rts functions work on: the point being shaded and the frame around it. Valid while the shader
 * function runs, and only on its thread.
 */
typedef struct RTshadingContext RTshadingContext;

/**
 * Unsigned 32-bit integer; also the name of an object, a shader, a shader class, a texture or a context. 0
 * names nothing.
 */
typedef unsigned int RTuint;

/** A count or a size. Signed as in OpenGL; negative values are errors, never huge numbers. */
typedef int RTsizei;

/** One of the RT_ constants. */
typedef unsigned int RTenum;

/**
 * Is told of every error: the code, a text that is valid during the call only, and the pointer given to
 * rtErrorCallback(). Called on the thread whose call went wrong, after the error was recorded, with no lock held;
 * it may call any function of this library, and is not told of errors that it makes itself. It must not leave by
 * longjmp() or by a C++ exception.
 */
typedef void (*RTerrorCallback)(RTenum error, const char *message, void *userData);

/** RT_TRUE or RT_FALSE; any value but 0 is taken as true. */
typedef unsigned char RTboolean;

/** Signed 32-bit integer. */
typedef int RTint;

/** Single precision. */
typedef float RTfloat;

/** Double precision. The engine computes in single precision, so doubles are rounded when they are read. */
typedef double RTdouble;

/** Signed 16-bit integer. */
typedef short RTshort;

/** Signed 8-bit integer. */
typedef signed char RTbyte;

/** Unsigned 8-bit integer. */
typedef unsigned char RTubyte;

/** Unsigned 16-bit integer. */
typedef unsigned short RTushort;

/** RT_ flags, OR-ed. */
typedef unsigned int RTbitfield;

/** One parameter of a shader class. */
typedef struct RTshaderParam {
    /** For rtParameterHandle(). */
    const char *name;
    /**
     * RT_INT, RT_INT_VEC2 to RT_INT_VEC4, RT_FLOAT, RT_FLOAT_VEC2 to RT_FLOAT_VEC4, RT_FLOAT_MAT4, RT_TEXTURE
     * (an RTuint in the block), RT_STRING (a const char * in the block) or RT_RAW.
     */
    RTenum type;
    /** RT_PER_SHADER, RT_PER_TRIANGLE or RT_PER_VERTEX; the latter two for floats of surface shaders only. */
    RTenum scope;
    /** Where the value lies in the parameter block: offsetof() of the member of your structure. */
    RTuint offset;
    /** Bytes of a RT_RAW parameter; not used for others. */
    RTuint size;
    /**
     * The default: as many bytes as the type has, or the text of a RT_STRING. NULL for zeros, or an empty
     * text. Textures have none.
     */
    const void *defaultValue;
} RTshaderParam;

/**
 * Colours a point: stores at result linear red, green and blue that leave it towards the ray's origin, and its
 * opacity (1 hides what is behind). params is the parameter block of the shader at this point, userData that
 * of the class. context is valid during the call only. Called from several threads at once; must not leave by
 * longjmp() or by a C++ exception, nor call rt functions (the rts functions are for it).
 */
typedef void (*RTshadeFunction)(struct RTshadingContext *context, const void *params, void *userData,
    RTfloat *result);

/** Light that arrives at a point. */
typedef struct RTlightSample {
    /** Unit direction from the point to the light. */
    RTfloat direction[3];
    /** Distance to the light; INFINITY for directional light. */
    RTfloat distance;
    /** Linear red, green and blue, before anything stands in the way. */
    RTfloat radiance[3];
} RTlightSample;

/**
 * Stores at sample the light that arrives at the point position (three floats) and returns RT_TRUE; or returns
 * RT_FALSE where the light does not shine. Point and answer are in the space of the light: that of the world, moved by
 * the matrix that rtUseLight() was called with. Rules as for RTshadeFunction.
 */
typedef RTboolean (*RTilluminateFunction)(const void *params, void *userData, const RTfloat *position,
    struct RTlightSample *sample);

/**
 * A ray asked of rtIntersectRays() or rtOccludedRays(): the points origin + t * direction with tmin <= t <=
 * tmax.
 */
typedef struct RTray {
    /** World space. */
    RTfloat origin[3];
    /** Smallest accepted distance; negative counts as 0. */
    RTfloat tmin;
    /**
     * Any length but 0. Distances are measured in units of this length. A zero or non-finite direction hits
     * nothing.
     */
    RTfloat direction[3];
    /** Largest accepted distance; INFINITY for no limit. */
    RTfloat tmax;
} RTray;

/**
 * Stores at ray the ray through (x, y), both from 0 to 1 with (0, 0) the lower left of the picture, and
 * returns RT_TRUE; or returns RT_FALSE to show the clear colour there. aspect is the width of the picture
 * divided by its height. Only origin and direction of the ray are used. Rules as for RTshadeFunction.
 */
typedef RTboolean (*RTprimaryRayFunction)(const void *params, void *userData, RTfloat x, RTfloat y,
    RTfloat aspect, struct RTray *ray);

/**
 * Stores at radiance linear red, green and blue that arrive against the unit direction (three floats) from
 * outside the scene. Rules as for RTshadeFunction.
 */
typedef void (*RTradianceFunction)(const void *params, void *userData, const RTfloat *direction,
    RTfloat *radiance);

/**
 * A shader class: what rtRegisterShaderClass() takes, and what shader libraries return. Of the four functions,
 * the one for the kind is needed and the others are NULL.
 */
typedef struct RTshaderClass {
    /** RT_SHADER_CLASS_VERSION. */
    RTuint version;
    /** RT_SURFACE_SHADER, RT_LIGHT_SHADER, RT_CAMERA_SHADER or RT_ENVIRONMENT_SHADER. */
    RTenum kind;
    /** For messages. */
    const char *name;
    /** Bytes of the parameter block, sizeof your structure. Blocks are given aligned to 16 bytes. */
    RTuint blockSize;
    /** Number of params. */
    RTuint paramCount;
    /** The parameters; NULL if there are none. */
    const struct RTshaderParam *params;
    /** For RT_SURFACE_SHADER. */
    RTshadeFunction shade;
    /** For RT_LIGHT_SHADER. */
    RTilluminateFunction illuminate;
    /** For RT_CAMERA_SHADER. */
    RTprimaryRayFunction primaryRay;
    /** For RT_ENVIRONMENT_SHADER. */
    RTradianceFunction radiance;
    /** Handed to the functions, otherwise not touched. */
    void *userData;
} RTshaderClass;

/** The point that a surface shader colours. World space, except where said. */
typedef struct RTsurfacePoint {
    /** Where the ray met the surface. */
    RTfloat position[3];
    /** Unit interpolated normal, turned to the side from which the ray came. */
    RTfloat normal[3];
    /** Unit normal of the triangle, turned to the side from which the ray came. */
    RTfloat geometricNormal[3];
    /** Unit direction of the ray, towards the surface. */
    RTfloat incoming[3];
    /** Interpolated texture coordinate. */
    RTfloat texCoord[2];
    /** Interpolated vertex colour; white for objects without. */
    RTfloat color[4];
    /** Barycentric weights of the second and third corner. */
    RTfloat barycentric[2];
    /** Distance that the ray has come. */
    RTfloat distance;
    /** Name of the object. */
    RTuint object;
    /** Number of the instance in its frame. */
    RTuint instance;
    /** Number of the triangle in its object. */
    RTuint primitive;
    /** Bounces so far; 0 for a ray from the camera. */
    RTuint depth;
    /** RT_TRUE when the ray came from the side on which the corners appear clockwise. */
    RTboolean backFacing;
} RTsurfacePoint;

/**
 * Is told that a frame has ended, and whether it was cancelled. Called on a thread of the library on which no
 * context is current: it should only note the fact or wake somebody up, and leave rtEndRendering() to the thread
 * that owns the context. It must not destroy that context, which waits for it, nor leave by longjmp() or by a C++
 * exception.
 */
typedef void (*RTframeCallback)(RTboolean cancelled, void *userData);

/** What the last finished frame, or the last rtCommitScene(), cost. Times in seconds of wall clock. */
typedef struct RTframeStats {
    /** Bringing the acceleration structures up to date, the top level included. */
    RTdouble updateSeconds;
    /** The top level alone. */
    RTdouble topLevelSeconds;
    /** Tracing and shading. */
    RTdouble renderSeconds;
    /** From the start of the frame to its last pixel. */
    RTdouble totalSeconds;
    /** Rays from the camera. */
    RTdouble primaryRays;
    /** Rays that only ask whether something is in the way. */
    RTdouble shadowRays;
    /** Reflected, refracted and all other rays sent by shaders. */
    RTdouble secondaryRays;
    /** Instances in the frame. */
    RTdouble instances;
    /** Triangles, each counted once per instance. */
    RTdouble triangles;
    /** Nodes of acceleration structures that were computed anew before the first ray. */
    RTdouble nodesUpdated;
    /**
     * Subtrees of RT_LAZY objects and of those left to the rays (see objectsByRays), subfields of RT_VISIBILITY_FIELD and objects that waited for a ray (see objectsWaiting)
     * that rays of the frame were the first to reach and so had computed anew.
     */
    RTdouble subtreesTouched;
    /** Nodes in these subtrees, which nodesUpdated does not count. */
    RTdouble nodesTouched;
    /** Bytes held by acceleration structures. */
    RTdouble structureBytes;
    /**
     * Share of the picture, 0 to 1, that was rendered in full; the rest has had only its rays from the camera, for
     * want of time (see RT_TIME_BUDGET of rtFrameParameteri()).
     */
    RTdouble refined;
    /** One pixel in each block of so many on a side was sampled. */
    RTuint subsampling;
    /** Objects whose structure was built. */
    RTuint objectsBuilt;
    /** Objects whose structure was brought up to date in place. */
    RTuint objectsRefitted;
    /**
     * Objects whose vertices have moved and that no ray met in the frame before: with RT_AUTO their structures wait for one.
     */
    RTuint objectsWaiting;
    /**
     * Objects whose vertices move and whose structures RT_AUTO leaves to the rays, as RT_LAZY does: the times of earlier frames say that it pays.
     */
    RTuint objectsByRays;
    /** RT_STATIC instances whose triangles have been merged into one structure. */
    RTuint mergedInstances;
    /** RT_TRUE when the frame was cancelled; some pixels then show an older frame. */
    RTboolean cancelled;
} RTframeStats;

/** What a ray met. */
typedef struct RThit {
    /** Distance in units of the ray's direction; negative when nothing was hit. The other fields are then 0. */
    RTfloat t;
    /** Barycentric weight of the triangle's second corner. */
    RTfloat u;
    /** Barycentric weight of the triangle's third corner; the first one's is 1 - u - v. */
    RTfloat v;
    /** Number of the triangle in its object, in the order of definition. Polygons are cut into triangles. */
    RTuint primitive;
    /** Name of the object; 0 when nothing was hit. */
    RTuint object;
    /** Number of the instance in its frame: the first rtInstantiateObject() made instance 0. */
    RTuint instance;
} RThit;

/**
 * A snapshot of a scene, made by rtAcquireScene(). Functions that take one take NULL for the scene of the current context, as it was last
 * rendered or committed.
 */
typedef struct RTsceneView *RTscene;

/**
 * Decides whether a hit counts: RT_TRUE, or RT_FALSE to let the ray go on behind it. Called on the thread that asks, with the pointer of
 * the question. It must not leave by longjmp() or by a C++ exception, nor call functions that need the context that is asked.
 */
typedef RTboolean (*RTfilter)(void *userData, const struct RTray *ray, const struct RThit *hit);

/** How a question is meant. With all members 0 it is that of rtSceneIntersect(). */
typedef struct RTquery {
    /** 0 or RT_COHERENT. */
    RTbitfield flags;
    /** The rays meet instances that have a bit in common with this, see RT_MASK; 0 stands for RT_QUERY_RAYS. */
    RTuint mask;
    /** NULL, or a mask for each ray in the place of mask; here 0 meets nothing. */
    const RTuint *masks;
    /** NULL, or what decides which hits count. Rays are then traced one by one. */
    RTfilter filter;
    /** Handed to filter. */
    void *userData;
} RTquery;

/** What lies at a hit, in world space. */
typedef struct RTsurface {
    /** The point itself. */
    RTfloat position[3];
    /**
     * Unit length; to the side from which the triangle's corners run counter-clockwise, or to that of its vertices' normals if it has some.
     */
    RTfloat geometricNormal[3];
    /** Unit length: interpolated from the vertices' normals, else the geometric one. */
    RTfloat normal[3];
    /** Interpolated from the vertices; 0 without. */
    RTfloat texCoord[2];
    /** Linear RGBA, interpolated from the vertices; 1 without. */
    RTfloat color[4];
    /** The shader that was bound at the triangle; 0 is the default surface. */
    RTuint shader;
    /** RT_TRUE when the ray came from the side to which the geometric normal points. */
    RTboolean frontFacing;
} RTsurface;

/** The nearest point of a scene or an object. */
typedef struct RTclosestPoint {
    /** The point itself. */
    RTfloat position[3];
    /** How far away it is; negative when there is none. The other fields are then 0. */
    RTfloat distance;
    /** Barycentric weight of the triangle's second corner. */
    RTfloat u;
    /** Barycentric weight of the triangle's third corner. */
    RTfloat v;
    /** Number of the triangle in its object. */
    RTuint primitive;
    /** Name of the object. */
    RTuint object;
    /** Number of the instance in its frame; 0 for a question about one object. */
    RTuint instance;
} RTclosestPoint;

/** Single precision, clamped to 0..1 where it is used. */
typedef float RTclampf;

/** Double precision, clamped to 0..1 where it is used. */
typedef double RTclampd;

/**
 * The type of the function that a shader library exports under the name openrtQueryShaderClass. It returns the
 * class called name, valid until the process ends, or NULL if the library has no such class.
 */
typedef const struct RTshaderClass *(*RTqueryShaderClass)(const char *name);

/** False. */
#define RT_FALSE 0
/** True. */
#define RT_TRUE 1
/** No object, flag or setting. */
#define RT_NONE 0
/** Error: nothing went wrong since the last rtGetError(). */
#define RT_NO_ERROR 0
/** Error: an RTenum argument is none of the accepted values. */
#define RT_INVALID_ENUM 0x0500
/** Error: a number is out of range or not a number, a pointer is NULL, or a name does not exist. */
#define RT_INVALID_VALUE 0x0501
/**
 * Error: the call is not allowed in this state, for example between rtBegin() and rtEnd(), or without a
 * context.
 */
#define RT_INVALID_OPERATION 0x0502
/** Error: rtPushMatrix() on a full stack. */
#define RT_STACK_OVERFLOW 0x0503
/** Error: rtPopMatrix() on the last matrix. */
#define RT_STACK_UNDERFLOW 0x0504
/** Error: not enough memory; the state is as before the call. */
#define RT_OUT_OF_MEMORY 0x0505
/** Error: a file or a plug-in could not be read, written or understood. rtGetErrorString() says why. */
#define RT_IO_ERROR 0x0510
/** Error: a defect of the library itself. The context answers every call with this error until it is destroyed. */
#define RT_INTERNAL_ERROR 0x0511
/** Primitive: every three vertices are a triangle. */
#define RT_TRIANGLES 0x0004
/** Primitive: every vertex after the second makes a triangle with the two before it. */
#define RT_TRIANGLE_STRIP 0x0005
/** Primitive: every vertex after the second makes a triangle with the one before it and the first. */
#define RT_TRIANGLE_FAN 0x0006
/** Primitive: every four vertices are a quadrilateral. */
#define RT_QUADS 0x0007
/** Primitive: every two vertices after the first two make a quadrilateral with the two before them. */
#define RT_QUAD_STRIP 0x0008
/** Primitive: all vertices are one convex polygon. */
#define RT_POLYGON 0x0009
/** Object mode: define the object. */
#define RT_COMPILE 0x1300
/** Object mode: define the object, and instantiate it once at rtEndObject(). */
#define RT_COMPILE_AND_INSTANTIATE 0x1301
/** Object mode: another word for RT_COMPILE. */
#define RT_DEFINE 0x1300
/** Object mode: another word for RT_COMPILE_AND_INSTANTIATE. */
#define RT_DEFINE_AND_INSTANTIATE 0x1301
/** Motion flag of an object mode: neither the geometry nor its instances will move. */
#define RT_STATIC 0x10000
/** Motion flag of an object mode: only the matrices of the instances will change. The default. */
#define RT_AFFINE 0x20000
/**
 * Motion flag of an object mode: vertices will move independently, by rtUpdateVertices() or by defining the
 * object anew.
 */
#define RT_UNSTRUCTURED 0x40000
/** Object parameter: how the acceleration structure is built and updated; one of the strategies that follow. */
#define RT_UPDATE_STRATEGY 0x6000
/** Object parameter, read only: the motion flag. */
#define RT_MOTION 0x6001
/** Object parameter, read only: the number of triangles. */
#define RT_TRIANGLE_COUNT 0x6002
/** Object parameter, read only: the number of vertices, as counted by rtUpdateVertices(). */
#define RT_VERTEX_COUNT 0x6003
/**
 * Parameter of objects: how many triangles the subtrees have at most that RT_LAZY updates when a ray reaches them.
 * 0: subtrees at half the height.
 */
#define RT_LAZY_CUT 0x6004
/** Parameter of objects: how many levels of such a subtree RT_LAZY updates at once; 0: all. */
#define RT_LAZY_LEVELS 0x6005
/** Parameter of objects: a time, which chooses among key frames. See rtKeyFrame(). */
#define RT_OBJECT_TIME 0x6006
/** Object parameter, RT_TRUE or RT_FALSE: whether triangles of an RT_STATIC object may be cut for a better tree. */
#define RT_SPATIAL_SPLITS 0x6008
/** Object parameter: which rays see the object, 32 bits. */
#define RT_MASK 0x6009
/** Object parameter: whether shadow rays see the object. */
#define RT_CAST_SHADOW 0x600A
/** Update strategy: chosen from the motion flag and from what was measured. The default. */
#define RT_AUTO 0x6010
/** Update strategy: object BSP tree (Wald, Benthin and Slusallek 2003). */
#define RT_BSP 0x6011
/**
 * Update strategy: bounding volume hierarchy by the surface area heuristic, built anew when the geometry
 * changes.
 */
#define RT_SAH 0x6012
/**
 * Update strategy: bounding volume hierarchy by Morton codes, quick to build, built anew when the geometry
 * changes.
 */
#define RT_FAST_BUILD 0x6013
/**
 * Update strategy: built once, then boxes are fitted anew when vertices move (Larsson and Akenine-Moeller
 * 2003).
 */
#define RT_REFIT 0x6014
/**
 * Update strategy: as RT_REFIT, but boxes that drift apart change places (Kopta and others 2012), and the
 * structure is built anew when that is not enough.
 */
#define RT_ROTATE 0x6017
/**
 * Update strategy: grid of grids, made anew when the geometry changes (Larsson and Akenine-Moeller 2003), for triangles
 * of like size that move without any order.
 */
#define RT_GRID 0x6018
/**
 * Update strategy: visibility field (Khanna, Mortensen, Yu and Slater 2004), tiles that list triangles, for many
 * directions, drawn when rays ask for them; triangles that move are kept apart. Takes much memory.
 */
#define RT_VISIBILITY_FIELD 0x6019
/**
 * Update strategy: built once, then only what rays reach is brought up to date, when they reach it (Larsson and
 * Akenine-Moeller 2003).
 */
#define RT_LAZY 0x6016
/** Top level: 8-wide bounding volume hierarchy over the instances, see rtTopLevel(). */
#define RT_TOPLEVEL_BVH 0x6015
/** Data type: RTbyte. */
#define RT_BYTE 0x1400
/** Data type: RTubyte. */
#define RT_UNSIGNED_BYTE 0x1401
/** Data type: RTshort. */
#define RT_SHORT 0x1402
/** Data type: RTushort. */
#define RT_UNSIGNED_SHORT 0x1403
/** Data type: RTint. */
#define RT_INT 0x1404
/** Data type: RTuint. */
#define RT_UNSIGNED_INT 0x1405
/** Data type: RTfloat. */
#define RT_FLOAT 0x1406
/** Data type: RTdouble. */
#define RT_DOUBLE 0x140A
/** Data type of shader parameters: two RTfloat. */
#define RT_FLOAT_VEC2 0x8B50
/** Data type of shader parameters: three RTfloat. */
#define RT_FLOAT_VEC3 0x8B51
/** Data type of shader parameters: four RTfloat. */
#define RT_FLOAT_VEC4 0x8B52
/** Data type of shader parameters: two RTint. */
#define RT_INT_VEC2 0x8B53
/** Data type of shader parameters: three RTint. */
#define RT_INT_VEC3 0x8B54
/** Data type of shader parameters: four RTint. */
#define RT_INT_VEC4 0x8B55
/** Data type of shader parameters: sixteen RTfloat, a column-major matrix. */
#define RT_FLOAT_MAT4 0x8B5C
/** Data type of shader parameters: the name of a texture, an RTuint. */
#define RT_TEXTURE 0x1702
/** Data type of shader parameters: a text. */
#define RT_STRING 0x6020
/** Data type of shader parameters: any number of bytes. */
#define RT_RAW 0x6021
/** Vertex array: positions. */
#define RT_VERTEX_ARRAY 0x8074
/** Vertex array: normals. */
#define RT_NORMAL_ARRAY 0x8075
/** Vertex array: colours. */
#define RT_COLOR_ARRAY 0x8076
/** Vertex array: texture coordinates. */
#define RT_TEXTURE_COORD_ARRAY 0x8078
/** Value of RTshaderClass.version that this header describes. */
#define RT_SHADER_CLASS_VERSION 1
/** Shader kind: colours points of surfaces. */
#define RT_SURFACE_SHADER 0x6030
/** Shader kind: sends light to points. */
#define RT_LIGHT_SHADER 0x6031
/** Shader kind: makes the rays through the pixels. */
#define RT_CAMERA_SHADER 0x6032
/** Shader kind: colours rays that leave the scene. */
#define RT_ENVIRONMENT_SHADER 0x6033
/** Shader kind: the algorithm that turns rays into pixels. */
#define RT_RENDERING_OBJECT 0x6034
/**
 * Scope of a shader parameter: one value per shader; the value at the start of a frame holds for the whole
 * frame.
 */
#define RT_PER_SHADER 0x6038
/** Scope of a shader parameter: captured when a triangle is completed. */
#define RT_PER_TRIANGLE 0x6039
/** Scope of a shader parameter: captured at each rtVertex, and interpolated. */
#define RT_PER_VERTEX 0x603A
/** Shader class property: its kind. */
#define RT_SHADER_KIND 0x6080
/** Shader class property: number of parameters. */
#define RT_PARAMETER_COUNT 0x6081
/** Shader parameter property: its data type. */
#define RT_PARAMETER_TYPE 0x6082
/** Shader parameter property: its scope. */
#define RT_PARAMETER_SCOPE 0x6083
/** Shader parameter property: its size in bytes. */
#define RT_PARAMETER_SIZE 0x6084
/** Texture target, the only one. */
#define RT_TEXTURE_2D 0x0DE1
/** Texture parameter: filter when a texel covers many pixels: RT_NEAREST or RT_LINEAR. */
#define RT_TEXTURE_MAG_FILTER 0x2800
/** Texture parameter: filter when a pixel covers many texels: RT_NEAREST, RT_LINEAR or RT_LINEAR_MIPMAP_LINEAR. */
#define RT_TEXTURE_MIN_FILTER 0x2801
/** Texture parameter: what happens outside 0..1 along s: RT_REPEAT, RT_CLAMP_TO_EDGE or RT_MIRRORED_REPEAT. */
#define RT_TEXTURE_WRAP_S 0x2802
/** Texture parameter: the same along t. */
#define RT_TEXTURE_WRAP_T 0x2803
/** Texture parameter, read only: width of level 0. */
#define RT_TEXTURE_WIDTH 0x1000
/** Texture parameter, read only: height of level 0. */
#define RT_TEXTURE_HEIGHT 0x1001
/** Texture parameter: RT_LINEAR_COLOR or RT_SRGB. */
#define RT_TEXTURE_COLOR_SPACE 0x6040
/** Texture parameter, for rtTexParameterfv(): where the image lies on surfaces. */
#define RT_TEXTURE_MATRIX 0x0BA8
/** Texture colour space: stored values are used as they are. */
#define RT_LINEAR_COLOR 0x6041
/** Texture colour space: stored values are on the sRGB curve. */
#define RT_SRGB 0x8C40
/** Internal texture format: three channels on the sRGB curve. */
#define RT_SRGB8 0x8C41
/** Internal texture format: three channels on the sRGB curve and opacity. */
#define RT_SRGB8_ALPHA8 0x8C43
/** Texture filter: the nearest texel. */
#define RT_NEAREST 0x2600
/** Texture filter: the four nearest texels, blended. */
#define RT_LINEAR 0x2601
/** Texture filter: bilinear on the two nearest mip-map levels, blended. The default. */
#define RT_LINEAR_MIPMAP_LINEAR 0x2703
/** Texture wrap: only the fraction counts. The default. */
#define RT_REPEAT 0x2901
/** Texture wrap: the border texel continues. */
#define RT_CLAMP_TO_EDGE 0x812F
/** Texture wrap: every second repetition is mirrored. */
#define RT_MIRRORED_REPEAT 0x8370
/** Pixel format: one channel, red. */
#define RT_RED 0x1903
/** Pixel format: one channel, opacity. */
#define RT_ALPHA 0x1906
/** Pixel format: one channel used for red, green and blue. */
#define RT_LUMINANCE 0x1909
/** Pixel format: one channel of grey and one of opacity. */
#define RT_LUMINANCE_ALPHA 0x190A
/** Pixel format: three channels. */
#define RT_RGB 0x1907
/** Pixel format: four channels. */
#define RT_RGBA 0x1908
/** Pixel format: three channels, blue first. */
#define RT_BGR 0x80E0
/** Pixel format: four channels, blue first, opacity last. */
#define RT_BGRA 0x80E1
/**
 * Pixel data of rtReadPixels(): distance from the camera along the ray, infinite where nothing was hit.
 * RT_FLOAT.
 */
#define RT_DEPTH_COMPONENT 0x1902
/** Pixel data of rtReadPixels(): unit normal in world space, three RT_FLOAT, 0 where nothing was hit. */
#define RT_NORMAL 0x6050
/** Pixel data of rtReadPixels(): name of the object, RT_UNSIGNED_INT, 0 where nothing was hit. */
#define RT_OBJECT_ID 0x6051
/** Pixel data of rtReadPixels(): number of the instance, RT_UNSIGNED_INT, 0xFFFFFFFF where nothing was hit. */
#define RT_INSTANCE_ID 0x6052
/** Frame buffer format: four bytes: red, green, blue, opacity. */
#define RT_RGBA8 0x8058
/** Frame buffer format: four bytes: blue, green, red, opacity. */
#define RT_BGRA8 0x93A1
/** Frame buffer format: three bytes: red, green, blue. */
#define RT_RGB8 0x8051
/** Frame buffer format: three RTfloat: red, green, blue; linear, not clamped. */
#define RT_RGB32F 0x8815
/** Frame buffer format: four RTfloat: red, green, blue, opacity; linear, not clamped. */
#define RT_RGBA32F 0x8814
/** Frame buffer format: 8 bits each of blue, green, red. */
#define RT_BGR8 0x60C0
/** Frame buffer format: blue, green, red as linear floats. */
#define RT_BGR32F 0x60C1
/** Frame buffer format: blue, green, red, alpha as linear floats. */
#define RT_BGRA32F 0x60C2
/** String of rtGetString(): who made the library. */
#define RT_VENDOR 0x1F00
/** String of rtGetString(): the rendering object in use. */
#define RT_RENDERER 0x1F01
/** String of rtGetString(): the version, major.minor.patch. */
#define RT_VERSION 0x1F02
/** String of rtGetString(): the instruction set in use. */
#define RT_SIMD_LEVEL 0x6060
/** String of rtGetString(): who executes the frames. */
#define RT_BACKEND 0x6061
/** Ray query flag: neighbouring rays are alike, as camera or shadow rays are; they may be traced together. */
#define RT_COHERENT 1
/** In masks: rays from the camera. */
#define RT_CAMERA_RAYS 1
/** In masks: rays from a surface to a light, and those that look for occluders nearby. */
#define RT_SHADOW_RAYS 0x0002
/** In masks: rays that are reflected, refracted or scattered. */
#define RT_REFLECTION_RAYS 0x0004
/** In masks: rays of queries that name no mask of their own. */
#define RT_QUERY_RAYS 0x0008
/**
 * Capability: 8-bit pixels are stored on the sRGB curve, as screens and image files want them, instead of
 * linear.
 */
#define RT_FRAMEBUFFER_SRGB 0x8DB9
/** Capability: row 0 of pictures is the topmost, and rtPick() counts from the top. */
#define RT_ORIGIN_TOP_LEFT 0x6070
/** Capability: frames are averaged as long as neither scene nor camera changes. */
#define RT_ACCUMULATE 0x6071
/**
 * Capability: as RT_ACCUMULATE; and if frames are sub-sampled, each next one samples blocks of half the size, as
 * long as neither scene nor camera changes.
 */
#define RT_PROGRESSIVE 0x6072
/** Frame parameter: one pixel in each block of so many on a side is sampled. */
#define RT_SUBSAMPLING 0x60B0
/** Frame parameter: how pixels that are not sampled get their colours. */
#define RT_UPSAMPLING 0x60B1
/** Up-sampling: bilinear. The default. */
#define RT_BILINEAR 0x60B2
/** Up-sampling: linear in the four triangles around the middle of each block. */
#define RT_MIDPOINT 0x60B3
/** Frame parameter: each frame renders one in so many pixels and keeps the others. */
#define RT_FRAMELESS 0x60B4
/** Frame parameter: milliseconds that a frame may take; negative without a limit. */
#define RT_TIME_BUDGET 0x60B5
/** State: the current matrix, column by column. */
#define RT_MATRIX 0x0BA6
/** State: number of matrices on the stack; at least 1. */
#define RT_MATRIX_STACK_DEPTH 0x0BA3
/** State: most matrices on the stack. */
#define RT_MAX_MATRIX_STACK_DEPTH 0x0D36
/** State: the current colour. */
#define RT_CURRENT_COLOR 0x0B00
/** State: the current normal; 0, 0, 0 when there is none. */
#define RT_CURRENT_NORMAL 0x0B02
/** State: the current texture coordinate. */
#define RT_CURRENT_TEXTURE_COORDS 0x0B03
/** State: the object that is being defined, or 0. */
#define RT_CURRENT_OBJECT 0x0B33
/** State: RT_COMPILE or RT_COMPILE_AND_INSTANTIATE while an object is being defined, else 0. */
#define RT_CURRENT_OBJECT_MODE 0x0B30
/** State: the bound shader class, or 0. */
#define RT_SHADER_CLASS_BINDING 0x60A0
/** State: the bound shader, or 0. */
#define RT_SHADER_BINDING 0x60A1
/** State: the bound texture, or 0. */
#define RT_TEXTURE_BINDING_2D 0x8069
/** State: the shader of rtUseCamera(), or 0. */
#define RT_CAMERA 0x60A2
/** State: the shader of rtUseEnvironmentShader(), or 0. */
#define RT_ENVIRONMENT 0x60A3
/** State: the shader of rtUseRenderingObject(), or 0. */
#define RT_CURRENT_RENDERING_OBJECT 0x60A4
/** State: number of lights of the frame being assembled. */
#define RT_LIGHT_COUNT 0x60A5
/** State: the lights of the frame being assembled. */
#define RT_LIGHTS 0x60A6
/** State: number of instances of the frame being assembled. */
#define RT_INSTANCE_COUNT 0x60A7
/** State: the clear colour. */
#define RT_COLOR_CLEAR_VALUE 0x0C22
/** See rtJpegQuality(). */
#define RT_JPEG_QUALITY 0x60B6
/** See rtAmbientLight(): 3 numbers. */
#define RT_AMBIENT_LIGHT 0x0B53
/** State: the viewport. */
#define RT_VIEWPORT 0x0BA2
/** State: width and height of the frame buffer; 0 before there is one. */
#define RT_FRAME_SIZE 0x60A8
/** State: largest width and height of a frame buffer. */
#define RT_MAX_FRAME_SIZE 0x60A9
/** State: largest width and height of a texture. */
#define RT_MAX_TEXTURE_SIZE 0x0D33
/** State: what rtSamplesPerPixel() set. */
#define RT_SAMPLES_PER_PIXEL 0x80A9
/** State: most samples per pixel. */
#define RT_MAX_SAMPLES 0x8D57
/** State: what rtMaxDepth() set. */
#define RT_RAY_DEPTH 0x60AA
/** State: largest value for rtMaxDepth(). */
#define RT_MAX_RAY_DEPTH 0x60AB
/** State: number of worker threads. */
#define RT_THREADS 0x60AC
/** State: RT_TRUE from rtStartRendering() to rtEndRendering(). */
#define RT_RENDERING 0x60AD
/** State: number of frames started so far. */
#define RT_FRAME_NUMBER 0x60AE
/** State: the structure over the instances, see rtTopLevel(). */
#define RT_TOPLEVEL 0x60AF
/** State: numbers per vertex in the vertex array. */
#define RT_VERTEX_ARRAY_SIZE 0x807A
/** State: data type of the vertex array. */
#define RT_VERTEX_ARRAY_TYPE 0x807B
/** State: stride of the vertex array, as given. */
#define RT_VERTEX_ARRAY_STRIDE 0x807C
/** State: data type of the normal array. */
#define RT_NORMAL_ARRAY_TYPE 0x807E
/** State: stride of the normal array, as given. */
#define RT_NORMAL_ARRAY_STRIDE 0x807F
/** State: numbers per vertex in the colour array. */
#define RT_COLOR_ARRAY_SIZE 0x8081
/** State: data type of the colour array. */
#define RT_COLOR_ARRAY_TYPE 0x8082
/** State: stride of the colour array, as given. */
#define RT_COLOR_ARRAY_STRIDE 0x8083
/** State: numbers per vertex in the texture coordinate array. */
#define RT_TEXTURE_COORD_ARRAY_SIZE 0x8088
/** State: data type of the texture coordinate array. */
#define RT_TEXTURE_COORD_ARRAY_TYPE 0x8089
/** State: stride of the texture coordinate array, as given. */
#define RT_TEXTURE_COORD_ARRAY_STRIDE 0x808A
/** Pointer of rtGetPointerv(): the vertex array. */
#define RT_VERTEX_ARRAY_POINTER 0x808E
/** Pointer of rtGetPointerv(): the normal array. */
#define RT_NORMAL_ARRAY_POINTER 0x808F
/** Pointer of rtGetPointerv(): the colour array. */
#define RT_COLOR_ARRAY_POINTER 0x8090
/** Pointer of rtGetPointerv(): the texture coordinate array. */
#define RT_TEXTURE_COORD_ARRAY_POINTER 0x8092
/** Part of a loaded scene, for rtLoadScene() and rtInstantiateLoadedScene(): instances of its objects. */
#define RT_SCENE_INSTANCES_BIT 0x100000
/** Part of a loaded scene: its lights. */
#define RT_SCENE_LIGHTS_BIT 0x200000
/** Part of a loaded scene: its camera. */
#define RT_SCENE_CAMERA_BIT 0x400000
/** Part of a loaded scene: clear colour or environment. */
#define RT_SCENE_BACKGROUND_BIT 0x800000
/** All parts of a loaded scene. */
#define RT_SCENE_ALL_BITS 0xF00000
/** State: RT_TRUE when the library was built with the readers of scene files, see rtLoadScene(). */
#define RT_SCENE_READERS 0x6100
/** Number of a loaded scene: its first object. */
#define RT_SCENE_FIRST_OBJECT 0x6101
/** Number of a loaded scene: how many objects it has. */
#define RT_SCENE_OBJECT_COUNT 0x6102
/** Number of a loaded scene: triangles of its objects. */
#define RT_SCENE_TRIANGLE_COUNT 0x6103
/** Number of a loaded scene: lights. */
#define RT_SCENE_LIGHT_COUNT 0x6104
/** Number of a loaded scene: cameras. */
#define RT_SCENE_CAMERA_COUNT 0x6105
/** Number of a loaded scene: frames of its animation. */
#define RT_SCENE_FRAME_COUNT 0x6106
/** Number of a loaded scene: texts about what was left out. */
#define RT_SCENE_WARNING_COUNT 0x6107
/** Number of a loaded scene: whether its colours are meant for RT_FRAMEBUFFER_SRGB. */
#define RT_SCENE_SRGB 0x6108
/** Numbers of a loaded scene: first and last moment of its animation. */
#define RT_SCENE_TIMES 0x6109
/** Numbers of a loaded scene: the box around it. */
#define RT_SCENE_BOUNDS 0x610A
/** Text of a loaded scene: something that was left out. */
#define RT_SCENE_WARNING 0x610B
/** Text of a loaded scene: the name of an object. */
#define RT_SCENE_OBJECT_NAME 0x610C
/** Text of a loaded scene: the format of the file. */
#define RT_SCENE_FORMAT 0x610D
/** Object of triangles that are drawn outside objects, in hits and RT_OBJECT_ID. */
#define RT_IMMEDIATE_OBJECT 0xFFFFFFFF

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/* Contexts and errors ------------------------------------------------------------------------------------------- */

/**
 * Starts the library: makes the initial context and makes it current on the calling thread. argc and argv are
 * those of main(), or NULL. They are there for back-ends that take options from the command line, which then
 * are removed from it; rendering in this process takes none.
 *
 * Variables of the environment: OPENRT_NUM_THREADS (number of worker threads, unless rtThreads() was called;
 * otherwise as many as the process may use), OPENRT_SIMD (scalar, sse, avx2 or avx512: lowers the instruction set that is used), OPENRT_ACCEL
 * (bsp, sah, fast_build, refit, rotate, grid, lazy or visibility_field: an update strategy for all objects), OPENRT_TOPLEVEL (bsp or bvh: the
 * structure over the instances), OPENRT_MERGE (now or never: when RT_STATIC instances are merged; otherwise while
 * frames are rendered). Other values are ignored.
 *
 * Errors: RT_INVALID_OPERATION when it was called before without rtExit(), or a context is current on this
 * thread; RT_IO_ERROR when the system refuses threads; RT_OUT_OF_MEMORY.
 *
 * Threads: a context belongs to the thread on which it is current. All other functions work on the context
 * that is current on the calling thread, and report RT_INVALID_OPERATION when there is none.
 */
RTAPI void rtInit(int *argc, char **argv);

/**
 * Ends what rtInit() began: destroys the initial context with everything in it, as rtDestroyContext() does.
 * rtInit() may be called again. It may be given to atexit(): a program that ends lets go of its contexts before.
 *
 * Errors: RT_INVALID_OPERATION without rtInit(), or when the initial context is current on another thread.
 */
RTAPI void rtExit(void);

/**
 * Makes a further context, with objects, shaders, textures and frames of its own, and returns its name; 0 on
 * failure. It is not made current.
 *
 * Errors: RT_IO_ERROR when the system refuses threads; RT_OUT_OF_MEMORY.
 */
RTAPI RTuint rtCreateContext(void);

/**
 * As rtCreateContext(), with as many worker threads as threads says; 0 for as many as rtThreads() has said.
 *
 * Errors: RT_INVALID_VALUE when threads is negative or above 1024, RT_IO_ERROR when the system refuses threads.
 */
RTAPI RTuint rtCreateContextThreads(RTsizei threads);

/**
 * Sets how many worker threads each context has that rtInit() and rtCreateContext() make from now on, in this
 * process; 0, as it is at first, lets OPENRT_NUM_THREADS and the system say. rtGetIntegerv(RT_THREADS, ...) tells
 * how many the current context has.
 *
 * Errors: RT_INVALID_VALUE when threads is negative or above 1024.
 */
RTAPI void rtThreads(RTsizei threads);

/**
 * Destroys a context with everything in it. A frame in flight is cancelled and waited for, so its frame buffer
 * must still exist. If the context is current on this thread, no context is current afterwards.
 *
 * Errors: RT_INVALID_VALUE when there is no such context, RT_INVALID_OPERATION when it is current on another
 * thread.
 */
RTAPI void rtDestroyContext(RTuint context);

/**
 * Makes a context current on the calling thread; 0 makes none current. The context that was current before
 * keeps its state and can be made current on any thread. A thread that ends lets go of its context.
 *
 * Errors: RT_INVALID_VALUE when there is no such context, RT_INVALID_OPERATION when it is current on another
 * thread.
 */
RTAPI void rtMakeCurrent(RTuint context);

/** Name of the context that is current on the calling thread; 0 for none. */
RTAPI RTuint rtGetCurrentContext(void);

/**
 * Returns the first error since the last call of this function and forgets it; RT_NO_ERROR when there was
 * none. A call that is in error changes nothing else. Errors of calls made while no context was current are
 * kept for the thread.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd(), returning RT_NO_ERROR.
 */
RTAPI RTenum rtGetError(void);

/**
 * A text for people. If error is what rtGetError() returned last on this thread, the text says what exactly was
 * wrong, as "rtInstantiateObject: there is no object 77"; otherwise, and after a megabyte of different texts, it
 * names the error. It never returns NULL. The text belongs to the library and is valid until the process ends.
 */
RTAPI const char *rtGetErrorString(RTenum error);

/**
 * From now on, callback is called with every error of the current context, also with those that rtGetError()
 * does not return because an earlier one was not read yet. NULL stops that. userData is handed to the callback
 * and otherwise not touched.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtErrorCallback(RTerrorCallback callback, void *userData);

/* Settings and getters ------------------------------------------------------------------------------------------ */

/**
 * Switches a capability on: RT_FRAMEBUFFER_SRGB, RT_ORIGIN_TOP_LEFT, RT_ACCUMULATE or RT_PROGRESSIVE. All begin
 * switched off.
 *
 * Errors: RT_INVALID_ENUM for something else, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtEnable(RTenum capability);

/** Switches a capability off. See rtEnable(). */
RTAPI void rtDisable(RTenum capability);

/**
 * RT_TRUE when a capability (see rtEnable()) or a vertex array (see rtEnableClientState()) is switched on.
 *
 * Errors: RT_INVALID_ENUM for something else, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTboolean rtIsEnabled(RTenum capability);

/**
 * Sets how many samples are taken in each pixel, from the next frame on; they are averaged. 1, which is the
 * default, takes the centre.
 *
 * Errors: RT_INVALID_VALUE when samples is below 1 or above RT_MAX_SAMPLES, RT_INVALID_OPERATION between
 * rtBegin() and rtEnd().
 */
RTAPI void rtSamplesPerPixel(RTint samples);

/**
 * Sets how often a ray may be reflected or refracted, from the next frame on. 0 is never; the default is 3.
 *
 * Errors: RT_INVALID_VALUE when depth is negative or above RT_MAX_RAY_DEPTH, RT_INVALID_OPERATION between
 * rtBegin() and rtEnd().
 */
RTAPI void rtMaxDepth(RTint depth);

/**
 * Sets the structure over the instances, from the next frame on: RT_AUTO, which is the default and takes the one
 * that was measured to be faster, RT_BSP (Wald, Benthin and Slusallek 2003) or RT_TOPLEVEL_BVH. All give the
 * same picture. rtGetIntegerv(RT_TOPLEVEL, ...) gives it back.
 *
 * Errors: RT_INVALID_ENUM for another structure, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtTopLevel(RTenum structure);

/**
 * Stores the value of a piece of state at params, which must have room for as many numbers as it has:
 *
 * 16 for RT_MATRIX (column by column); 4 for RT_CURRENT_COLOR, RT_CURRENT_TEXTURE_COORDS, RT_COLOR_CLEAR_VALUE
 * and RT_VIEWPORT (x, y, width, height); 3 for RT_CURRENT_NORMAL and RT_AMBIENT_LIGHT; 2 for RT_FRAME_SIZE; RT_LIGHT_COUNT many for
 * RT_LIGHTS; 1 for everything else: RT_MATRIX_STACK_DEPTH, RT_MAX_MATRIX_STACK_DEPTH, RT_CURRENT_OBJECT,
 * RT_CURRENT_OBJECT_MODE, RT_SHADER_CLASS_BINDING, RT_SHADER_BINDING, RT_TEXTURE_BINDING_2D, RT_CAMERA,
 * RT_ENVIRONMENT, RT_CURRENT_RENDERING_OBJECT, RT_LIGHT_COUNT, RT_INSTANCE_COUNT, RT_MAX_FRAME_SIZE,
 * RT_MAX_TEXTURE_SIZE, RT_SAMPLES_PER_PIXEL, RT_MAX_SAMPLES, RT_RAY_DEPTH, RT_MAX_RAY_DEPTH, RT_THREADS,
 * RT_RENDERING, RT_FRAME_NUMBER, RT_TOPLEVEL, RT_JPEG_QUALITY, the parameters of rtFrameParameteri(), the capabilities of rtEnable(), and the
 * vertex arrays with their sizes, types and strides.
 *
 * Numbers that are not integers are rounded.
 *
 * Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when params is NULL, RT_INVALID_OPERATION
 * between rtBegin() and rtEnd().
 */
RTAPI void rtGetIntegerv(RTenum pname, RTint *params);

/** As rtGetIntegerv(), in single precision. */
RTAPI void rtGetFloatv(RTenum pname, RTfloat *params);

/** As rtGetIntegerv(), in double precision. */
RTAPI void rtGetDoublev(RTenum pname, RTdouble *params);

/** As rtGetIntegerv(), RT_FALSE for 0 and RT_TRUE for everything else. */
RTAPI void rtGetBooleanv(RTenum pname, RTboolean *params);

/**
 * Returns a text about the library: RT_VENDOR, RT_VERSION (major.minor.patch), RT_RENDERER (the rendering
 * object in use), RT_SIMD_LEVEL (the instruction set in use) or RT_BACKEND (who executes frames); NULL on
 * failure. The text belongs to the library and is valid until the process ends.
 *
 * Errors: RT_INVALID_ENUM for another name, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI const char *rtGetString(RTenum name);

/* Frame techniques: how a picture is made with fewer rays ------------------------------------------------------- */

/**
 * Sets how pictures are made from fewer rays, from the next frame on. rtGetIntegerv() gives the values back.
 *
 * RT_SUBSAMPLING: only one pixel in each block of param x param is sampled; param is 1, the default, to
 * RT_MAX_FRAME_SIZE. Columns and rows 0, param, 2 * param ... of the viewport and its last ones are sampled and show what
 * they show without sub-sampling; pixels in between get colours in between, and depth, normal and names of the nearest
 * sampled one. It works with every rendering object, with rtSamplesPerPixel() and with RT_ACCUMULATE, which then
 * count for the sampled pixels. A sub-sampled frame that is cancelled leaves the whole picture as it was.
 *
 * RT_UPSAMPLING: how colours in between are found. RT_BILINEAR, the default, or RT_MIDPOINT: linear in each of the four
 * triangles that meet at the middle of a block, where the colour is the mean of the corners (Larsson and Akenine-Moller
 * 2003).
 *
 * RT_FRAMELESS: each frame renders one in param pixels, in an order that looks random and gives every pixel its turn once in
 * param frames; the others keep what older frames left there. param is 1, the default, to 1024. The first frame of a
 * size, viewport or sub-sampling renders all. Above 1, RT_ACCUMULATE and RT_PROGRESSIVE have no effect.
 *
 * RT_TIME_BUDGET: milliseconds from the start of a frame after which it shall be finished; -1, the default, and every negative
 * number: as long as it takes. All rays from the camera are sent first, and make the picture of the rendering object raycast
 * with one sample per pixel; then parts of it are rendered in full, from the middle on, until the time is up. A part of
 * 16 x 16 samples that was begun is finished. So 0 sends rays from the camera only, but for those that shaders of the
 * application ask for. refined of RTframeStats says which share was rendered in full. While frames are averaged, see rtEnable(), they
 * go on where the one before stopped.
 *
 * Errors: RT_INVALID_ENUM for another parameter or an unknown constant as its value, RT_INVALID_VALUE for a number out of
 * range, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtFrameParameteri(RTenum pname, RTint param);

/** See rtFrameParameteri(); values but RT_TIME_BUDGET are rounded. RT_INVALID_VALUE for NaN. */
RTAPI void rtFrameParameterf(RTenum pname, RTfloat param);

/* Objects and their instances ----------------------------------------------------------------------------------- */

/**
 * Returns the first of n new names in a row, for rtNewObject(); 0 on failure. Each names an empty object.
 *
 * Errors: RT_INVALID_VALUE when n is not positive, RT_OUT_OF_MEMORY when there are not n names in a row left,
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTuint rtGenObjects(RTsizei n);

/**
 * Begins the definition of the object called object. The name need not come from rtGenObjects(). If the object
 * exists, its geometry is replaced when the definition ends, for all its instances from the next frame on.
 *
 * mode is RT_COMPILE (or RT_DEFINE), or RT_COMPILE_AND_INSTANTIATE (or RT_DEFINE_AND_INSTANTIATE) to also
 * place the object once with the matrix that is current at rtEndObject(); OR-ed with at most one of RT_STATIC,
 * RT_AFFINE and RT_UNSTRUCTURED, which say how the object will move. Without one it stays as it is: RT_AFFINE, or
 * what rtObjectParameteri() has set, before the first definition, too. Wrong promises cost time, not correctness.
 *
 * The matrix current at each vertex is applied to it. Matrices, bound shaders and other state are neither
 * saved nor restored by a definition.
 *
 * Errors: RT_INVALID_ENUM for another mode, RT_INVALID_VALUE for the name 0 or one of the 256 largest names,
 * RT_INVALID_OPERATION inside a definition or between rtBegin() and rtEnd().
 */
RTAPI void rtNewObject(RTuint object, RTenum mode);

/**
 * Ends the definition of an object.
 *
 * Errors: RT_INVALID_OPERATION without rtNewObject() or between rtBegin() and rtEnd(), and for
 * RT_COMPILE_AND_INSTANTIATE when the last row of the current matrix is not 0 0 0 1 (the definition then stays
 * open); RT_OUT_OF_MEMORY.
 */
RTAPI void rtEndObject(void);

/**
 * Deletes the n objects whose names begin with first. Names that are not in use are passed over. Instances
 * already placed in the frame being assembled, and frames that are being rendered, still show deleted objects.
 *
 * Errors: RT_INVALID_VALUE when n is negative, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtDeleteObjects(RTuint first, RTsizei n);

/**
 * RT_TRUE when object is the name of an object: generated or defined, and not deleted.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTboolean rtIsObject(RTuint object);

/**
 * Sets a parameter of an object, from the next frame on. RT_UPDATE_STRATEGY: RT_AUTO, RT_BSP, RT_SAH,
 * RT_FAST_BUILD, RT_REFIT, RT_ROTATE, RT_GRID, RT_LAZY or RT_VISIBILITY_FIELD. RT_MOTION: RT_STATIC, RT_AFFINE or
 * RT_UNSTRUCTURED. RT_LAZY_CUT: the
 * most triangles that a subtree has which RT_LAZY updates when a ray reaches it (2048 at first; 0 for subtrees at half
 * the height). RT_LAZY_LEVELS: how many levels of it are updated at once (0, all, at first). RT_OBJECT_TIME: the
 * time that chooses among key frames, see rtKeyFrame(). None of them changes the picture, but for rounding:
 * vertices of an RT_STATIC object that is placed once are transformed, for others rays are.
 *
 * RT_SPATIAL_SPLITS: RT_TRUE or RT_FALSE, the default. With RT_TRUE triangles may be cut at planes where the
 * structure is built, so that long ones, or large ones among small ones, are traced faster; the build takes
 * several times as long, and up to half as much memory again. It has effect while the object is RT_STATIC and its
 * strategy is RT_AUTO or RT_SAH; for other objects it is kept and waits. It never changes the picture.
 *
 * RT_MASK: which rays see the object, as 32 bits: those whose own mask has a bit in common with it and with that of the instance (see rtInstanceMask()).
 * Rays of a frame have one of RT_CAMERA_RAYS, RT_SHADOW_RAYS and RT_REFLECTION_RAYS, those of queries RT_QUERY_RAYS or what the query says; the other
 * bits are the application's. All bits are set at first. RT_CAST_SHADOW: RT_TRUE or RT_FALSE, which sets or clears RT_SHADOW_RAYS in the
 * mask: a lamp around its light shall not keep the light in.
 *
 * Errors: RT_INVALID_ENUM for another parameter or value, RT_INVALID_VALUE when there is no such object or a number
 * is negative that must not be,
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtObjectParameteri(RTuint object, RTenum pname, RTint param);

/** See rtObjectParameteri(); values but RT_OBJECT_TIME are rounded. RT_INVALID_VALUE for a time that is not finite. */
RTAPI void rtObjectParameterf(RTuint object, RTenum pname, RTfloat param);

/**
 * Stores a parameter of an object at params: RT_UPDATE_STRATEGY, RT_MOTION, RT_SPATIAL_SPLITS, RT_TRIANGLE_COUNT,
 * RT_VERTEX_COUNT, RT_LAZY_CUT, RT_LAZY_LEVELS, RT_MASK, RT_CAST_SHADOW or RT_OBJECT_TIME (rounded).
 *
 * Errors: RT_INVALID_ENUM for another parameter, RT_INVALID_VALUE when there is no such object or params is
 * NULL, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtGetObjectParameteriv(RTuint object, RTenum pname, RTint *params);

/** See rtGetObjectParameteriv(); RT_OBJECT_TIME is not rounded. */
RTAPI void rtGetObjectParameterfv(RTuint object, RTenum pname, RTfloat *params);

/* Vertices between rtBegin and rtEnd ---------------------------------------------------------------------------- */

/**
 * Opens a primitive: RT_TRIANGLES, RT_TRIANGLE_STRIP, RT_TRIANGLE_FAN, RT_QUADS, RT_QUAD_STRIP or RT_POLYGON.
 * Its triangles belong to the object between rtNewObject() and rtEndObject(); outside of that they are drawn
 * once, in the frame being assembled. They are coloured by the shader that is bound now. Between rtBegin() and
 * rtEnd() only vertices, their attributes and shader parameters may be given.
 *
 * Errors: RT_INVALID_ENUM for another mode, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtBegin(RTenum mode);

/**
 * Closes the primitive. Vertices that complete no triangle are dropped.
 *
 * Errors: RT_INVALID_OPERATION without rtBegin().
 */
RTAPI void rtEnd(void);

/**
 * A vertex of the primitive that is open. The current matrix is applied now (moving an object later is the
 * business of rtInstantiateObject()), then x, y and z are divided by w. Missing coordinates are 0 for z and
 * 1 for w. The vertex takes the current normal, texture coordinate and colour. Triangles with a corner that is
 * infinite or not a number keep their place in the numbering, and no ray hits them.
 *
 * Forms: rtVertex2, 3 and 4 with s (RTshort), i (RTint), f (RTfloat) or d (RTdouble); with v at the end, from
 * an array of that many values at v.
 *
 * Errors: RT_INVALID_OPERATION outside rtBegin() and rtEnd(), RT_INVALID_VALUE when v is NULL,
 * RT_OUT_OF_MEMORY.
 */
RTAPI void rtVertex2s(RTshort x, RTshort y);

/** A vertex from 2 values at v: see rtVertex2s(). */
RTAPI void rtVertex2sv(const RTshort *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex2i(RTint x, RTint y);

/** A vertex from 2 values at v: see rtVertex2s(). */
RTAPI void rtVertex2iv(const RTint *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex2f(RTfloat x, RTfloat y);

/** A vertex from 2 values at v: see rtVertex2s(). */
RTAPI void rtVertex2fv(const RTfloat *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex2d(RTdouble x, RTdouble y);

/** A vertex from 2 values at v: see rtVertex2s(). */
RTAPI void rtVertex2dv(const RTdouble *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex3s(RTshort x, RTshort y, RTshort z);

/** A vertex from 3 values at v: see rtVertex2s(). */
RTAPI void rtVertex3sv(const RTshort *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex3i(RTint x, RTint y, RTint z);

/** A vertex from 3 values at v: see rtVertex2s(). */
RTAPI void rtVertex3iv(const RTint *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex3f(RTfloat x, RTfloat y, RTfloat z);

/** A vertex from 3 values at v: see rtVertex2s(). */
RTAPI void rtVertex3fv(const RTfloat *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex3d(RTdouble x, RTdouble y, RTdouble z);

/** A vertex from 3 values at v: see rtVertex2s(). */
RTAPI void rtVertex3dv(const RTdouble *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex4s(RTshort x, RTshort y, RTshort z, RTshort w);

/** A vertex from 4 values at v: see rtVertex2s(). */
RTAPI void rtVertex4sv(const RTshort *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex4i(RTint x, RTint y, RTint z, RTint w);

/** A vertex from 4 values at v: see rtVertex2s(). */
RTAPI void rtVertex4iv(const RTint *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex4f(RTfloat x, RTfloat y, RTfloat z, RTfloat w);

/** A vertex from 4 values at v: see rtVertex2s(). */
RTAPI void rtVertex4fv(const RTfloat *v);

/** A vertex: see rtVertex2s(). */
RTAPI void rtVertex4d(RTdouble x, RTdouble y, RTdouble z, RTdouble w);

/** A vertex from 4 values at v: see rtVertex2s(). */
RTAPI void rtVertex4dv(const RTdouble *v);

/* Normals and texture coordinates ------------------------------------------------------------------------------- */

/**
 * Sets the normal of the vertices that follow. It is transformed by the inverse transpose of the matrix that
 * is current at the vertex, and need not have unit length. Objects without normals are shaded flat.
 * rtNewObject() begins without a normal.
 *
 * Forms: b (RTbyte), s (RTshort) and i (RTint), which are fractions of the largest value, f (RTfloat) and d
 * (RTdouble); with v at the end, from an array of 3 values at v.
 *
 * Errors: RT_INVALID_VALUE when v is NULL.
 */
RTAPI void rtNormal3b(RTbyte x, RTbyte y, RTbyte z);

/** Sets the normal from 3 values at v: see rtNormal3b(). */
RTAPI void rtNormal3bv(const RTbyte *v);

/** Sets the normal: see rtNormal3b(). */
RTAPI void rtNormal3s(RTshort x, RTshort y, RTshort z);

/** Sets the normal from 3 values at v: see rtNormal3b(). */
RTAPI void rtNormal3sv(const RTshort *v);

/** Sets the normal: see rtNormal3b(). */
RTAPI void rtNormal3i(RTint x, RTint y, RTint z);

/** Sets the normal from 3 values at v: see rtNormal3b(). */
RTAPI void rtNormal3iv(const RTint *v);

/** Sets the normal: see rtNormal3b(). */
RTAPI void rtNormal3f(RTfloat x, RTfloat y, RTfloat z);

/** Sets the normal from 3 values at v: see rtNormal3b(). */
RTAPI void rtNormal3fv(const RTfloat *v);

/** Sets the normal: see rtNormal3b(). */
RTAPI void rtNormal3d(RTdouble x, RTdouble y, RTdouble z);

/** Sets the normal from 3 values at v: see rtNormal3b(). */
RTAPI void rtNormal3dv(const RTdouble *v);

/**
 * Sets the texture coordinate of the vertices that follow: the image's lower left corner is (0, 0), its upper
 * right one (1, 1). Missing coordinates are t = 0, r = 0 and q = 1; s and t are divided by q, r is not used.
 *
 * Forms: rtTexCoord1, 2, 3 and 4 with s (RTshort), i (RTint), f (RTfloat) or d (RTdouble); with v at the end,
 * from an array of that many values at v.
 *
 * Errors: RT_INVALID_VALUE when v is NULL.
 */
RTAPI void rtTexCoord1s(RTshort s);

/** Sets the texture coordinate from 1 value at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord1sv(const RTshort *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord1i(RTint s);

/** Sets the texture coordinate from 1 value at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord1iv(const RTint *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord1f(RTfloat s);

/** Sets the texture coordinate from 1 value at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord1fv(const RTfloat *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord1d(RTdouble s);

/** Sets the texture coordinate from 1 value at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord1dv(const RTdouble *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord2s(RTshort s, RTshort t);

/** Sets the texture coordinate from 2 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord2sv(const RTshort *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord2i(RTint s, RTint t);

/** Sets the texture coordinate from 2 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord2iv(const RTint *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord2f(RTfloat s, RTfloat t);

/** Sets the texture coordinate from 2 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord2fv(const RTfloat *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord2d(RTdouble s, RTdouble t);

/** Sets the texture coordinate from 2 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord2dv(const RTdouble *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord3s(RTshort s, RTshort t, RTshort r);

/** Sets the texture coordinate from 3 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord3sv(const RTshort *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord3i(RTint s, RTint t, RTint r);

/** Sets the texture coordinate from 3 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord3iv(const RTint *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord3f(RTfloat s, RTfloat t, RTfloat r);

/** Sets the texture coordinate from 3 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord3fv(const RTfloat *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord3d(RTdouble s, RTdouble t, RTdouble r);

/** Sets the texture coordinate from 3 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord3dv(const RTdouble *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord4s(RTshort s, RTshort t, RTshort r, RTshort q);

/** Sets the texture coordinate from 4 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord4sv(const RTshort *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord4i(RTint s, RTint t, RTint r, RTint q);

/** Sets the texture coordinate from 4 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord4iv(const RTint *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord4f(RTfloat s, RTfloat t, RTfloat r, RTfloat q);

/** Sets the texture coordinate from 4 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord4fv(const RTfloat *v);

/** Sets the texture coordinate: see rtTexCoord1s(). */
RTAPI void rtTexCoord4d(RTdouble s, RTdouble t, RTdouble r, RTdouble q);

/** Sets the texture coordinate from 4 values at v: see rtTexCoord1s(). */
RTAPI void rtTexCoord4dv(const RTdouble *v);

/* Vertex colours ------------------------------------------------------------------------------------------------ */

/**
 * Sets the colour of the vertices that follow: linear red, green and blue, and opacity, 1 if not given. It is
 * interpolated and multiplies the colour of the shader. It begins as white.
 *
 * Forms: rtColor3 and rtColor4 with b (RTbyte), ub (RTubyte), s (RTshort), us (RTushort), i (RTint) and ui
 * (RTuint), which are fractions of the largest value, f (RTfloat) and d (RTdouble); with v at the end, from an
 * array of that many values at v.
 *
 * Errors: RT_INVALID_VALUE when v is NULL.
 */
RTAPI void rtColor3b(RTbyte red, RTbyte green, RTbyte blue);

/** Sets the colour from 3 values at v: see rtColor3b(). */
RTAPI void rtColor3bv(const RTbyte *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor3ub(RTubyte red, RTubyte green, RTubyte blue);

/** Sets the colour from 3 values at v: see rtColor3b(). */
RTAPI void rtColor3ubv(const RTubyte *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor3s(RTshort red, RTshort green, RTshort blue);

/** Sets the colour from 3 values at v: see rtColor3b(). */
RTAPI void rtColor3sv(const RTshort *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor3us(RTushort red, RTushort green, RTushort blue);

/** Sets the colour from 3 values at v: see rtColor3b(). */
RTAPI void rtColor3usv(const RTushort *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor3i(RTint red, RTint green, RTint blue);

/** Sets the colour from 3 values at v: see rtColor3b(). */
RTAPI void rtColor3iv(const RTint *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor3ui(RTuint red, RTuint green, RTuint blue);

/** Sets the colour from 3 values at v: see rtColor3b(). */
RTAPI void rtColor3uiv(const RTuint *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor3f(RTfloat red, RTfloat green, RTfloat blue);

/** Sets the colour from 3 values at v: see rtColor3b(). */
RTAPI void rtColor3fv(const RTfloat *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor3d(RTdouble red, RTdouble green, RTdouble blue);

/** Sets the colour from 3 values at v: see rtColor3b(). */
RTAPI void rtColor3dv(const RTdouble *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor4b(RTbyte red, RTbyte green, RTbyte blue, RTbyte alpha);

/** Sets the colour from 4 values at v: see rtColor3b(). */
RTAPI void rtColor4bv(const RTbyte *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor4ub(RTubyte red, RTubyte green, RTubyte blue, RTubyte alpha);

/** Sets the colour from 4 values at v: see rtColor3b(). */
RTAPI void rtColor4ubv(const RTubyte *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor4s(RTshort red, RTshort green, RTshort blue, RTshort alpha);

/** Sets the colour from 4 values at v: see rtColor3b(). */
RTAPI void rtColor4sv(const RTshort *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor4us(RTushort red, RTushort green, RTushort blue, RTushort alpha);

/** Sets the colour from 4 values at v: see rtColor3b(). */
RTAPI void rtColor4usv(const RTushort *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor4i(RTint red, RTint green, RTint blue, RTint alpha);

/** Sets the colour from 4 values at v: see rtColor3b(). */
RTAPI void rtColor4iv(const RTint *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor4ui(RTuint red, RTuint green, RTuint blue, RTuint alpha);

/** Sets the colour from 4 values at v: see rtColor3b(). */
RTAPI void rtColor4uiv(const RTuint *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor4f(RTfloat red, RTfloat green, RTfloat blue, RTfloat alpha);

/** Sets the colour from 4 values at v: see rtColor3b(). */
RTAPI void rtColor4fv(const RTfloat *v);

/** Sets the colour: see rtColor3b(). */
RTAPI void rtColor4d(RTdouble red, RTdouble green, RTdouble blue, RTdouble alpha);

/** Sets the colour from 4 values at v: see rtColor3b(). */
RTAPI void rtColor4dv(const RTdouble *v);

/* Vertex arrays: descriptions of application memory, read when something is drawn ------------------------------- */

/**
 * Says where vertices come from: size (2, 3 or 4) numbers of type RT_SHORT, RT_INT, RT_FLOAT or RT_DOUBLE
 * each, stride bytes apart (0 for no gap), beginning at pointer. The memory stays the application's. It is
 * read when rtDrawArrays() or rtDrawElements() is called, as far as they need, and may be changed or freed
 * after that.
 *
 * Errors: RT_INVALID_ENUM for another type, RT_INVALID_VALUE for another size or a negative stride,
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtVertexPointer(RTint size, RTenum type, RTsizei stride, const void *pointer);

/**
 * Says where normals come from: three numbers of type RT_BYTE, RT_SHORT, RT_INT, RT_FLOAT or RT_DOUBLE each.
 * See rtVertexPointer().
 */
RTAPI void rtNormalPointer(RTenum type, RTsizei stride, const void *pointer);

/**
 * Says where colours come from: size (3 or 4) numbers each, of any data type from RT_BYTE to RT_DOUBLE. See
 * rtVertexPointer().
 */
RTAPI void rtColorPointer(RTint size, RTenum type, RTsizei stride, const void *pointer);

/**
 * Says where texture coordinates come from: size (1 to 4) numbers of type RT_SHORT, RT_INT, RT_FLOAT or
 * RT_DOUBLE each. See rtVertexPointer().
 */
RTAPI void rtTexCoordPointer(RTint size, RTenum type, RTsizei stride, const void *pointer);

/**
 * Lets draws read an array: RT_VERTEX_ARRAY, RT_NORMAL_ARRAY, RT_COLOR_ARRAY or RT_TEXTURE_COORD_ARRAY. All
 * begin disabled. While an array is disabled, the current normal, colour or texture coordinate is used;
 * without RT_VERTEX_ARRAY nothing is drawn.
 *
 * Errors: RT_INVALID_ENUM for something else, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtEnableClientState(RTenum array);

/** Undoes rtEnableClientState(). */
RTAPI void rtDisableClientState(RTenum array);

/**
 * Draws count vertices of the enabled arrays, from vertex first on, as if by rtBegin(mode), an rtVertex each,
 * and rtEnd().
 *
 * Errors: RT_INVALID_ENUM for another mode, RT_INVALID_VALUE when first or count is negative or an enabled
 * array is at NULL, RT_INVALID_OPERATION between rtBegin() and rtEnd(), RT_OUT_OF_MEMORY. Nothing is drawn
 * then.
 */
RTAPI void rtDrawArrays(RTenum mode, RTint first, RTsizei count);

/**
 * Draws the count vertices whose numbers are at indices, of type RT_UNSIGNED_BYTE, RT_UNSIGNED_SHORT or
 * RT_UNSIGNED_INT. Each vertex that is used becomes one vertex of the object, in the order of the arrays, so
 * that rtUpdateVertices() counts them as the arrays do if none is left out.
 *
 * Errors: RT_INVALID_ENUM for another mode or type, RT_INVALID_VALUE when count is negative, or indices or an
 * enabled array is at NULL, RT_INVALID_OPERATION between rtBegin() and rtEnd(), RT_OUT_OF_MEMORY. Nothing is
 * drawn then.
 */
RTAPI void rtDrawElements(RTenum mode, RTsizei count, RTenum type, const void *indices);

/**
 * Moves the vertices first to first + count - 1 of an object, counted in the order in which its definition
 * gave them, from the next frame on. Each is three floats in object space, stride bytes apart (0 for no gap),
 * beginning at vertices; the current matrix has no part in it. The triangles stay what they are. The memory is
 * read before the call returns.
 *
 * Errors: RT_INVALID_VALUE when there is no such object, it has fewer vertices, a number is negative, or
 * vertices is NULL; RT_INVALID_OPERATION between rtBegin() and rtEnd(); RT_OUT_OF_MEMORY.
 */
RTAPI void rtUpdateVertices(RTuint object, RTsizei first, RTsizei count, RTsizei stride,
    const RTfloat *vertices);

/**
 * Moves count vertices of an object whose numbers are at indices, of type RT_UNSIGNED_BYTE, RT_UNSIGNED_SHORT or
 * RT_UNSIGNED_INT, as rtUpdateVertices() moves a range: the first to the position at vertices, and so on. Of a
 * vertex that is named twice the last position counts. What it costs depends on how many vertices are moved, not
 * on how many the object has, if its update strategy is RT_LAZY or RT_REFIT, or RT_AUTO and the object
 * RT_UNSTRUCTURED.
 *
 * Errors: RT_INVALID_VALUE when there is no such object, it has no such vertex, a number is negative, or indices or
 * vertices is NULL; RT_INVALID_ENUM for another type; RT_INVALID_OPERATION between rtBegin() and rtEnd();
 * RT_OUT_OF_MEMORY.
 */
RTAPI void rtUpdateVertexElements(RTuint object, RTsizei count, RTenum type, const void *indices,
    RTsizei stride, const RTfloat *vertices);

/**
 * Has a structure built for where the vertices of an object will be at about a time: count positions, one for each
 * vertex, as rtUpdateVertices() takes them. Nothing moves by that. Of the key frames of an object, the one nearest
 * to its RT_OBJECT_TIME (see rtObjectParameterf()) is active: its structure follows the vertices then, if the
 * update strategy is RT_LAZY or RT_REFIT; others do without. Good for animations that tear a mesh apart. A key
 * frame of the same time is replaced. rtEndObject() and rtDeleteKeyFrames() delete all of an object.
 *
 * Errors: RT_INVALID_VALUE when there is no such object, count is not the number of its vertices, the time is not
 * finite, the stride is negative, or vertices is NULL; RT_INVALID_OPERATION between rtBegin() and rtEnd();
 * RT_OUT_OF_MEMORY.
 */
RTAPI void rtKeyFrame(RTuint object, RTfloat time, RTsizei count, RTsizei stride, const RTfloat *vertices);

/**
 * Deletes the key frames of an object.
 *
 * Errors: RT_INVALID_VALUE when there is no such object, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtDeleteKeyFrames(RTuint object);

/**
 * Changes the normals of an object as rtUpdateVertices() changes its vertices.
 *
 * Errors: as rtUpdateVertices(); RT_INVALID_OPERATION also when the object was defined without normals.
 */
RTAPI void rtUpdateNormals(RTuint object, RTsizei first, RTsizei count, RTsizei stride,
    const RTfloat *normals);

/**
 * Stores the address of an array at params: RT_VERTEX_ARRAY_POINTER, RT_NORMAL_ARRAY_POINTER,
 * RT_COLOR_ARRAY_POINTER or RT_TEXTURE_COORD_ARRAY_POINTER.
 *
 * Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when params is NULL.
 */
RTAPI void rtGetPointerv(RTenum pname, void **params);

/* The matrix stack ---------------------------------------------------------------------------------------------- */

/**
 * Copies the current matrix on top of the stack. The stack holds at least 64 matrices; see
 * RT_MAX_MATRIX_STACK_DEPTH.
 *
 * Errors: RT_STACK_OVERFLOW when it is full, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtPushMatrix(void);

/**
 * Makes the matrix below the top the current one.
 *
 * Errors: RT_STACK_UNDERFLOW when there is none, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtPopMatrix(void);

/**
 * Replaces the current matrix by the identity.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtLoadIdentity(void);

/**
 * Replaces the current matrix by the 16 values at m, column by column.
 *
 * Errors: RT_INVALID_VALUE when m is NULL or an element of the product is not finite, RT_INVALID_OPERATION
 * between rtBegin() and rtEnd().
 */
RTAPI void rtLoadMatrixf(const RTfloat *m);

/** See rtLoadMatrixf(). */
RTAPI void rtLoadMatrixd(const RTdouble *m);

/**
 * Multiplies the current matrix from the right by the 16 values at m, column by column.
 *
 * Errors: RT_INVALID_VALUE when m is NULL or an element of the product is not finite, RT_INVALID_OPERATION
 * between rtBegin() and rtEnd().
 */
RTAPI void rtMultMatrixf(const RTfloat *m);

/** See rtMultMatrixf(). */
RTAPI void rtMultMatrixd(const RTdouble *m);

/**
 * Replaces the current matrix by the 16 values at m, row by row.
 *
 * Errors: RT_INVALID_VALUE when m is NULL or an element of the product is not finite, RT_INVALID_OPERATION
 * between rtBegin() and rtEnd().
 */
RTAPI void rtLoadTransposeMatrixf(const RTfloat *m);

/** See rtLoadTransposeMatrixf(). */
RTAPI void rtLoadTransposeMatrixd(const RTdouble *m);

/**
 * Multiplies the current matrix from the right by the 16 values at m, row by row.
 *
 * Errors: RT_INVALID_VALUE when m is NULL or an element of the product is not finite, RT_INVALID_OPERATION
 * between rtBegin() and rtEnd().
 */
RTAPI void rtMultTransposeMatrixf(const RTfloat *m);

/** See rtMultTransposeMatrixf(). */
RTAPI void rtMultTransposeMatrixd(const RTdouble *m);

/**
 * Multiplies the current matrix from the right by a translation.
 *
 * Errors: RT_INVALID_VALUE when an element of the product is not finite, RT_INVALID_OPERATION between
 * rtBegin() and rtEnd().
 */
RTAPI void rtTranslatef(RTfloat x, RTfloat y, RTfloat z);

/** See rtTranslatef(). */
RTAPI void rtTranslated(RTdouble x, RTdouble y, RTdouble z);

/**
 * Multiplies the current matrix from the right by a rotation of angle degrees about the axis (x, y, z),
 * counter-clockwise when the axis points at the viewer.
 *
 * Errors: RT_INVALID_VALUE when the axis has no length or a number is not finite, RT_INVALID_OPERATION between
 * rtBegin() and rtEnd().
 */
RTAPI void rtRotatef(RTfloat angle, RTfloat x, RTfloat y, RTfloat z);

/** See rtRotatef(). */
RTAPI void rtRotated(RTdouble angle, RTdouble x, RTdouble y, RTdouble z);

/**
 * Multiplies the current matrix from the right by a scaling. Factors of 0 flatten.
 *
 * Errors: RT_INVALID_VALUE when an element of the product is not finite, RT_INVALID_OPERATION between
 * rtBegin() and rtEnd().
 */
RTAPI void rtScalef(RTfloat x, RTfloat y, RTfloat z);

/** See rtScalef(). */
RTAPI void rtScaled(RTdouble x, RTdouble y, RTdouble z);

/* Instances, lights, camera and surroundings of the frame being assembled --------------------------------------- */

/**
 * Places an object in the frame being assembled, with the current matrix. Instances hold for one frame: all
 * are gone when it has started.
 *
 * Between rtNewObject() and rtEndObject() it makes the object part of the one that is being defined, with the
 * current matrix, as glCallList() does between glNewList() and glEndList(). Objects may have triangles and parts,
 * and parts may have parts, as deep as memory allows. Parts are named, not copied: one that is defined anew shows
 * from the next frame on wherever it is a part, one that is deleted shows nothing until an object of its name is
 * defined. Hits and RT_OBJECT_ID name the innermost object, whose triangle was hit; their instance is the one that
 * was placed in the frame.
 *
 * A matrix that flattens the object, as rtScalef(1, 1, 0) does, shows it flat; that takes memory and time for each
 * such instance, as does one that is smaller than 1e-12 of its object.
 *
 * Errors: RT_INVALID_VALUE when there is no such object, or the matrix has an element above 1.844e18, the largest
 * coordinate; RT_INVALID_OPERATION between rtBegin() and rtEnd(), when the last row of the current matrix is not
 * 0 0 0 1, or when the object would become a part of itself; RT_OUT_OF_MEMORY.
 */
RTAPI void rtInstantiateObject(RTuint object);

/**
 * Which rays see the instances placed from now on, as 32 bits: those whose own mask has a bit in common with it and with the object's RT_MASK (see
 * rtObjectParameteri()). All bits are set at first. It stays from frame to frame. A part of an object that is placed keeps the mask that it was given there,
 * and the mask of the whole counts for it, too.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtInstanceMask(RTbitfield mask);

/**
 * Places an object n times: once for each of the n matrices at matrices, which is multiplied on the current matrix
 * as by rtMultMatrixf(). A matrix is 16 numbers, column by column; from one to the next it is stride bytes, or 64
 * when stride is 0. The current matrix stays. As rtInstantiateObject() many times, but all are placed or none.
 *
 * Errors: as rtInstantiateObject(); RT_INVALID_VALUE also when n is negative, stride is neither 0 nor at least 64,
 * matrices is NULL, or a number is not finite.
 */
RTAPI void rtInstantiateObjects(RTuint object, RTsizei n, const RTfloat *matrices, RTsizei stride);

/**
 * Begins a new frame without rendering the one that was being assembled: its instances are dropped, and what was
 * drawn outside objects. Lights, camera and all else that persists from frame to frame stay. rtCommitScene() keeps
 * the instances, so a program that only asks rays places them, commits, asks, and calls this before it places them
 * anew.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject();
 * RT_OUT_OF_MEMORY.
 */
RTAPI void rtClearInstances(void);

/**
 * Lets a shader of a light class shine in the frame being assembled and those after it, until a later frame
 * names lights of its own. 0 takes all lights away.
 *
 * The current matrix is applied to its position and direction and to the edges of an area, as OpenGL applies it in
 * glLightfv(GL_POSITION); the parameters keep their values, so the same shader may be used several times in a
 * frame, each time with another matrix. The radius of a sphere changes with the cube root of the matrix's
 * determinant; attenuation is by distance in the world.
 *
 * Errors: RT_INVALID_VALUE when there is no such shader, or the matrix has an element above 1.844e18;
 * RT_INVALID_OPERATION when the shader is not a light, is used in this frame already with this matrix, when the last
 * row of the matrix is not 0 0 0 1, when it has no inverse and the light is a function of the application's, or
 * between rtBegin() and rtEnd().
 */
RTAPI void rtUseLight(RTuint shader);

/**
 * Sets the light that comes from everywhere, as glLightModelfv(GL_LIGHT_MODEL_AMBIENT) does: a surface reflects its
 * parameter ambient of it, and of lights of class ambient. Linear, not clamped. Before the first call it is 0.2 in
 * frames without lights of class ambient, and only surfaces reflect it whose ambient was set. The rendering object
 * path computes the light that this stands for, and leaves it out.
 *
 * Errors: RT_INVALID_VALUE when a number is not finite, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtAmbientLight(RTfloat red, RTfloat green, RTfloat blue);

/**
 * Looks through a shader of a camera class from the frame being assembled on. 0 goes back to the camera of
 * rtPerspective() and rtLookAt().
 *
 * Errors: RT_INVALID_VALUE when there is no such shader; RT_INVALID_OPERATION when it is not a camera, or
 * between rtBegin() and rtEnd().
 */
RTAPI void rtUseCamera(RTuint shader);

/**
 * Surrounds the scene with a shader of an environment class, from the frame being assembled on. 0 goes back to
 * the clear colour.
 *
 * Errors: RT_INVALID_VALUE when there is no such shader; RT_INVALID_OPERATION when it is not an environment,
 * or between rtBegin() and rtEnd().
 */
RTAPI void rtUseEnvironmentShader(RTuint shader);

/**
 * Renders with a shader of a rendering class from the frame being assembled on. 0 goes back to whitted.
 *
 * Errors: RT_INVALID_VALUE when there is no such shader; RT_INVALID_OPERATION when it is not a rendering
 * object, or between rtBegin() and rtEnd().
 */
RTAPI void rtUseRenderingObject(RTuint shader);

/**
 * Sets up a perspective camera: fovY degrees from the bottom to the top of the picture, aspect its width
 * divided by its height. near and far are checked as in OpenGL, but nothing is cut off at them. The camera
 * replaces the projection set before; the matrix stack has no part in it.
 *
 * Errors: RT_INVALID_VALUE unless 0 < fovY < 180, aspect > 0 and 0 < near < far; RT_INVALID_OPERATION between
 * rtBegin() and rtEnd().
 */
RTAPI void rtPerspective(RTdouble fovY, RTdouble aspect, RTdouble zNear, RTdouble zFar);

/**
 * Sets up a perspective camera by its window on the near plane. See rtPerspective().
 *
 * Errors: RT_INVALID_VALUE for an empty window, planes that are not 0 < zNear < zFar, or numbers that are not
 * finite; RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtFrustum(RTdouble left, RTdouble right, RTdouble bottom, RTdouble top, RTdouble zNear,
    RTdouble zFar);

/**
 * Sets up an orthographic camera by its window in world units. Rays begin in the plane of the eye. See
 * rtPerspective().
 *
 * Errors: RT_INVALID_VALUE for an empty window, zNear equal to zFar, or numbers that are not finite;
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtOrtho(RTdouble left, RTdouble right, RTdouble bottom, RTdouble top, RTdouble zNear,
    RTdouble zFar);

/**
 * Places the camera at eye, looking at center, with up upwards in the picture. Without it the camera is at the
 * origin and looks along -z. The matrix stack has no part in it.
 *
 * Errors: RT_INVALID_VALUE when eye is at center, up points along the view, or a number is not finite;
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtLookAt(RTdouble eyeX, RTdouble eyeY, RTdouble eyeZ, RTdouble centerX, RTdouble centerY,
    RTdouble centerZ, RTdouble upX, RTdouble upY, RTdouble upZ);

/**
 * Sets the colour that rays see which leave the scene, when there is no environment shader: linear red, green,
 * blue, and opacity. Not clamped.
 *
 * Errors: RT_INVALID_VALUE when a number is not finite, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtClearColor(RTfloat red, RTfloat green, RTfloat blue, RTfloat alpha);

/* Shader classes and shaders ------------------------------------------------------------------------------------ */

/* The shader classes of the library, and their parameters: name, number of values, default.
 * t: captured per triangle. v: captured per vertex and interpolated. The others hold for a whole shader.
 *
 * Surfaces, for rtBindShader()
 *   constant          color 3f 1 1 1; texture texture none; opacity 1f 1; alpha_texture texture none;
 *                     alpha_threshold 1f 0; alpha_blend 1i 0
 *   diffuse           color 3f 0.8 0.8 0.8; ambient 3f 0.2 0.2 0.2; texture texture none
 *   phong             ambient 3f 0.2 0.2 0.2; diffuse 3f 0.8 0.8 0.8; specular 3f 0 0 0; shininess 1f 32;
 *                     reflection 3f 0 0 0; transmission 3f 0 0 0; ior 1f 1; emission 3f 0 0 0; opacity 1f 1;
 *                     texture texture none; alpha_texture texture none; alpha_threshold 1f 0; alpha_blend 1i 0
 *   cutout            color 3f 0.8 0.8 0.8; ambient 3f 0.2 0.2 0.2; texture texture none; alpha_texture texture none;
 *                     alpha_threshold 1f 0.5
 *   mirror            color 3f 1 1 1; texture texture none
 *   glass             color 3f 1 1 1; ior 1f 1.5
 *   metal             color 3f 0.9 0.9 0.9; roughness 1f 0; texture texture none
 *   metallic_roughness
 *                     color 3f 0.8 0.8 0.8; ambient 3f 0.2 0.2 0.2; metallic 1f 0; roughness 1f 0.5;
 *                     specular 3f 0.04 0.04 0.04; emission 3f 0 0 0; transmission 1f 0; ior 1f 1;
 *                     texture texture none; metallic_roughness_texture texture none; normal_texture texture none;
 *                     normal_scale 2f 1 1; occlusion_texture texture none; occlusion_strength 1f 1;
 *                     emission_texture texture none; opacity 1f 1; alpha_texture texture none; alpha_threshold 1f 0;
 *                     alpha_blend 1i 0
 *   eyelight          color 3f 0.8 0.8 0.8; texture texture none
 *   normals
 *   wireframe         color 3f 0 0 0; background 3f 1 1 1; thickness 1f 1.5
 *
 * Lights, for rtUseLight()
 *   ambient           color 3f 0.2 0.2 0.2
 *   point             position 3f 0 0 0; color 3f 1 1 1; attenuation 3f 1 0 0
 *   directional       direction 3f 0 0 -1; color 3f 1 1 1
 *   spot              position 3f 0 0 0; direction 3f 0 0 -1; color 3f 1 1 1; attenuation 3f 1 0 0; cutoff 1f 45;
 *                     penumbra 1f 0; exponent 1f 0
 *   area              shape string "rectangle" (or "disc", "sphere"); position 3f 0 0 0; edge_u 3f 1 0 0;
 *                     edge_v 3f 0 0 1; radius 1f 0.5; color 3f 1 1 1; attenuation 3f 1 0 0; samples 1i 16
 *
 * Cameras, for rtUseCamera()
 *   pinhole           eye 3f 0 0 0; center 3f 0 0 -1; up 3f 0 1 0; fov 1f 60; aspect 1f 0; window 4f 0 0 0 0
 *   orthographic      eye 3f 0 0 0; center 3f 0 0 -1; up 3f 0 1 0; height 1f 2; aspect 1f 0; window 4f 0 0 0 0
 *   thinlens          eye 3f 0 0 0; center 3f 0 0 -1; up 3f 0 1 0; fov 1f 60; aspect 1f 0; window 4f 0 0 0 0;
 *                     aperture 1f 0.05; focus 1f 0
 *   environment       eye 3f 0 0 0; center 3f 0 0 -1; up 3f 0 1 0
 *
 * Environments, for rtUseEnvironmentShader()
 *   background        color 3f 0 0 0
 *   gradient          bottom 3f 0.3 0.25 0.2; horizon 3f 0.9 0.95 1; top 3f 0.25 0.45 0.9; up 3f 0 1 0
 *   latlong           texture texture none; intensity 1f 1; rotation 1f 0
 *
 * Rendering objects, for rtUseRenderingObject()
 *   whitted           max_depth 1i -1; shadows 1i 1
 *   raycast
 *   ambient_occlusion samples 1i 16; distance 1f 0
 *   path              max_depth 1i 32; roulette_depth 1i 4
 */

/**
 * Returns a name for a shader class, and binds the class; 0 on failure. With file NULL the class is one of
 * those that the library brings, which the table before this function lists. Otherwise file is the path of a
 * shader library that exports the function openrtQueryShaderClass (see RTqueryShaderClass); the library stays
 * loaded until the process ends. Asked again for the same class of the same file, it returns the same name.
 *
 * A shader library calls the rts functions of the program's own openrt: link it against libopenrt.so, or, if
 * the program contains libopenrt.a, link the program with -rdynamic and the shader library against nothing.
 *
 * Errors: RT_INVALID_VALUE when name is NULL, there is no such class, or the class contradicts itself;
 * RT_IO_ERROR when the library cannot be loaded, has no openrtQueryShaderClass or is made for another version;
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTuint rtGenNewShaderClass(const char *name, const char *file);

/**
 * Makes a shader class of the application's own functions, binds the class and returns its name; 0 on failure.
 * The structure and what it points to are copied, except userData. The functions must stay valid, and are
 * called from several threads at once while frames are rendered.
 *
 * Errors: RT_INVALID_VALUE when the pointer is NULL, the version is not RT_SHADER_CLASS_VERSION, or the class
 * contradicts itself, as rtGetErrorString() says; RT_INVALID_ENUM for an unknown kind, type or scope;
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTuint rtRegisterShaderClass(const struct RTshaderClass *shaderClass);

/**
 * Makes a shader of the bound class with the default parameters of the class, binds it, and returns its name;
 * 0 on failure.
 *
 * Errors: RT_INVALID_OPERATION when no class is bound, or between rtBegin() and rtEnd().
 */
RTAPI RTuint rtGenNewShader(void);

/**
 * Binds a shader class, for rtGenNewShader() and rtParameterHandle(), and unbinds the shader. 0 binds none.
 *
 * Errors: RT_INVALID_VALUE when there is no such class, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtBindShaderClass(RTuint shaderClass);

/**
 * Binds a shader and its class: parameters are set on it, and triangles that follow have it as their surface.
 * 0 binds the default surface, which is grey.
 *
 * Errors: RT_INVALID_VALUE when there is no such shader, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtBindShader(RTuint shader);

/**
 * Deletes a shader; 0 is passed over. It is unbound, and no longer a light, camera, environment or rendering
 * object. Triangles that have it get the default surface from the next frame on.
 *
 * Errors: RT_INVALID_VALUE when there is no such shader, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtDeleteShader(RTuint shader);

/**
 * RT_TRUE when shader names a shader.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTboolean rtIsShader(RTuint shader);

/**
 * Returns the handle of the parameter called name of the bound class; 0 on failure. It serves all shaders of
 * the class.
 *
 * Errors: RT_INVALID_OPERATION when no class is bound, or between rtBegin() and rtEnd(); RT_INVALID_VALUE when
 * name is NULL or the class has no such parameter.
 */
RTAPI RTuint rtParameterHandle(const char *name);

/**
 * Stores what a shader class is at params: RT_SHADER_KIND (RT_SURFACE_SHADER, RT_LIGHT_SHADER,
 * RT_CAMERA_SHADER, RT_ENVIRONMENT_SHADER or RT_RENDERING_OBJECT) or RT_PARAMETER_COUNT.
 *
 * Errors: RT_INVALID_ENUM for another pname; RT_INVALID_VALUE when there is no such class or params is NULL;
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtGetShaderClassiv(RTuint shaderClass, RTenum pname, RTint *params);

/**
 * Stores what parameter index of a shader class is at params: RT_PARAMETER_TYPE (as in RTshaderParam),
 * RT_PARAMETER_SCOPE or RT_PARAMETER_SIZE in bytes. Errors: as rtGetShaderClassiv(); RT_INVALID_VALUE also
 * when the class has no more parameters.
 */
RTAPI void rtGetShaderClassParameteriv(RTuint shaderClass, RTuint index, RTenum pname, RTint *params);

/**
 * Returns the name of a shader class; NULL on failure. The text is valid until the process ends. Errors: as
 * rtGetShaderClassiv().
 */
RTAPI const char *rtGetShaderClassName(RTuint shaderClass);

/** Returns the name of parameter index of a shader class; NULL on failure. See rtGetShaderClassName(). */
RTAPI const char *rtGetShaderClassParameterName(RTuint shaderClass, RTuint index);

/* Values of shader parameters ----------------------------------------------------------------------------------- */

/**
 * Sets a parameter of the bound shader to an integer. handle comes from rtParameterHandle(). A parameter of
 * type RT_TEXTURE takes the name of a texture as one integer. Values are read when a frame starts and hold for
 * all of it; parameters per triangle and per vertex are captured when a triangle is completed or a vertex
 * given, also between rtBegin() and rtEnd().
 *
 * Forms: rtParameter1, 2, 3 and 4 with i (RTint) or f (RTfloat), rtParameter16f for matrices, column by
 * column; with v at the end, from an array of that many values at v.
 *
 * Errors: RT_INVALID_VALUE when handle is none, v is NULL, a float is not a number, or there is no such
 * texture; RT_INVALID_OPERATION when no shader is bound, the handle belongs to another class, or the parameter
 * has another type or number of values.
 */
RTAPI void rtParameter1i(RTuint handle, RTint x);

/** Sets a parameter of the bound shader from 1 value at v: see rtParameter1i(). */
RTAPI void rtParameter1iv(RTuint handle, const RTint *v);

/** Sets a parameter of the bound shader: see rtParameter1i(). */
RTAPI void rtParameter1f(RTuint handle, RTfloat x);

/** Sets a parameter of the bound shader from 1 value at v: see rtParameter1i(). */
RTAPI void rtParameter1fv(RTuint handle, const RTfloat *v);

/** Sets a parameter of the bound shader: see rtParameter1i(). */
RTAPI void rtParameter2i(RTuint handle, RTint x, RTint y);

/** Sets a parameter of the bound shader from 2 values at v: see rtParameter1i(). */
RTAPI void rtParameter2iv(RTuint handle, const RTint *v);

/** Sets a parameter of the bound shader: see rtParameter1i(). */
RTAPI void rtParameter2f(RTuint handle, RTfloat x, RTfloat y);

/** Sets a parameter of the bound shader from 2 values at v: see rtParameter1i(). */
RTAPI void rtParameter2fv(RTuint handle, const RTfloat *v);

/** Sets a parameter of the bound shader: see rtParameter1i(). */
RTAPI void rtParameter3i(RTuint handle, RTint x, RTint y, RTint z);

/** Sets a parameter of the bound shader from 3 values at v: see rtParameter1i(). */
RTAPI void rtParameter3iv(RTuint handle, const RTint *v);

/** Sets a parameter of the bound shader: see rtParameter1i(). */
RTAPI void rtParameter3f(RTuint handle, RTfloat x, RTfloat y, RTfloat z);

/** Sets a parameter of the bound shader from 3 values at v: see rtParameter1i(). */
RTAPI void rtParameter3fv(RTuint handle, const RTfloat *v);

/** Sets a parameter of the bound shader: see rtParameter1i(). */
RTAPI void rtParameter4i(RTuint handle, RTint x, RTint y, RTint z, RTint w);

/** Sets a parameter of the bound shader from 4 values at v: see rtParameter1i(). */
RTAPI void rtParameter4iv(RTuint handle, const RTint *v);

/** Sets a parameter of the bound shader: see rtParameter1i(). */
RTAPI void rtParameter4f(RTuint handle, RTfloat x, RTfloat y, RTfloat z, RTfloat w);

/** Sets a parameter of the bound shader from 4 values at v: see rtParameter1i(). */
RTAPI void rtParameter4fv(RTuint handle, const RTfloat *v);

/** Sets a matrix parameter of the bound shader, column by column: see rtParameter1i(). */
RTAPI void rtParameter16f(RTuint handle, RTfloat m00, RTfloat m01, RTfloat m02, RTfloat m03, RTfloat m10,
    RTfloat m11, RTfloat m12, RTfloat m13, RTfloat m20, RTfloat m21, RTfloat m22, RTfloat m23, RTfloat m30,
    RTfloat m31, RTfloat m32, RTfloat m33);

/** Sets a matrix parameter of the bound shader from 16 values at v, column by column: see rtParameter1i(). */
RTAPI void rtParameter16fv(RTuint handle, const RTfloat *v);

/**
 * Sets a string parameter of the bound shader to a copy of text, which ends in a zero byte and is UTF-8.
 * Errors: as rtParameter1i().
 */
RTAPI void rtParameterString(RTuint handle, const char *text);

/**
 * Sets a parameter of the bound shader, of any type but string, from a copy of size bytes at data; size must
 * be that of the parameter. Errors: as rtParameter1i(); RT_INVALID_VALUE also when size is negative.
 */
RTAPI void rtParameterRaw(RTuint handle, const void *data, RTsizei size);

/** Sets a texture parameter of the bound shader; 0 is no texture. Errors: as rtParameter1i(). */
RTAPI void rtParameterTexture(RTuint handle, RTuint texture);

/**
 * Stores the value of an integer or texture parameter of the bound shader at params: always four numbers,
 * those that the parameter does not have being 0.
 *
 * Errors: RT_INVALID_VALUE when handle is none or params is NULL; RT_INVALID_OPERATION when no shader is
 * bound, the handle belongs to another class, the parameter has another type, or between rtBegin() and
 * rtEnd().
 */
RTAPI void rtGetParameteriv(RTuint handle, RTint *params);

/**
 * Stores the value of a float parameter of the bound shader at params: always four numbers, those that the
 * parameter does not have being 0, or the sixteen of a matrix. Errors: as rtGetParameteriv().
 */
RTAPI void rtGetParameterfv(RTuint handle, RTfloat *params);

/**
 * Returns the value of a string parameter of the bound shader; NULL on failure. The text belongs to the library and
 * is valid until the process ends. Errors: as rtGetParameteriv().
 */
RTAPI const char *rtGetParameterString(RTuint handle);

/* What a shader written in C may ask while it runs: the rts functions ------------------------------------------- */

/** For shaders: stores what is known of the point being shaded at point. */
RTAPI void rtsGetPoint(struct RTshadingContext *context, struct RTsurfacePoint *point);

/** For shaders: number of lights in the frame. */
RTAPI RTuint rtsLightCount(struct RTshadingContext *context);

/**
 * For shaders: stores at sample the light that comes from light index to the point, as if nothing were in the
 * way (see rtsShadowed()), and returns RT_TRUE; or returns RT_FALSE when there is no such light or it does not
 * shine there. For a light with an area, each call may choose another point on it.
 */
RTAPI RTboolean rtsIlluminate(struct RTshadingContext *context, RTuint index, struct RTlightSample *sample);

/**
 * For shaders: RT_TRUE when something opaque is between the point and the place at distance (in units of its
 * length, INFINITY for none) along direction (three floats).
 */
RTAPI RTboolean rtsShadowed(struct RTshadingContext *context, const RTfloat *direction, RTfloat distance);

/**
 * For shaders: stores at radiance (three floats) the light that comes to the point from direction (three
 * floats), by tracing a ray. Black beyond the limit of recursion.
 */
RTAPI void rtsTrace(struct RTshadingContext *context, const RTfloat *direction, RTfloat *radiance);

/**
 * For shaders: stores at direction (three floats) the unit direction in which the interpolated normal mirrors
 * the ray.
 */
RTAPI void rtsReflect(struct RTshadingContext *context, RTfloat *direction);

/**
 * For shaders: stores at rgba (four floats) the colour of a texture at (s, t), filtered as the texture asks;
 * white when there is no such texture.
 */
RTAPI void rtsTexture(struct RTshadingContext *context, RTuint texture, RTfloat s, RTfloat t, RTfloat *rgba);

/* Textures ------------------------------------------------------------------------------------------------------ */

/**
 * Stores n new texture names at textures.
 *
 * Errors: RT_INVALID_VALUE when n is negative or textures is NULL, RT_OUT_OF_MEMORY when no names are left,
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtGenTextures(RTsizei n, RTuint *textures);

/**
 * Deletes the n textures named at textures. 0 and names that are not in use are passed over. Shaders that
 * refer to one see white from the next frame on.
 *
 * Errors: RT_INVALID_VALUE when n is negative or textures is NULL, RT_INVALID_OPERATION between rtBegin() and
 * rtEnd().
 */
RTAPI void rtDeleteTextures(RTsizei n, const RTuint *textures);

/**
 * RT_TRUE when texture names a texture: one that was bound or loaded, and not deleted.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTboolean rtIsTexture(RTuint texture);

/**
 * Makes a texture the one that rtTexImage2D() and rtTexParameteri() change. target is RT_TEXTURE_2D. A name
 * that is not in use becomes a texture; 0 binds none. Shaders are given textures by rtParameterTexture(), not
 * by binding.
 *
 * Errors: RT_INVALID_ENUM for another target, RT_INVALID_VALUE for one of the 256 largest names,
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtBindTexture(RTenum target, RTuint texture);

/**
 * Gives the bound texture an image, read from pixels before the call returns: height rows of width pixels
 * without gaps, the lowest row first. NULL gives transparent black.
 *
 * target is RT_TEXTURE_2D, border 0. Level 0 replaces the whole image, and the smaller levels are averaged
 * from it; another level replaces only itself. internalFormat is 1 to 4, RT_RGB, RT_RGBA, RT_LUMINANCE,
 * RT_LUMINANCE_ALPHA, RT_ALPHA, RT_RED, RT_RGB8 or RT_RGBA8, or RT_SRGB8 or RT_SRGB8_ALPHA8, which also set
 * RT_TEXTURE_COLOR_SPACE to RT_SRGB; channels are always kept with 8 bits. format is RT_RGB, RT_RGBA, RT_BGR,
 * RT_BGRA, RT_LUMINANCE, RT_LUMINANCE_ALPHA, RT_ALPHA or RT_RED; type any data type from RT_BYTE to RT_DOUBLE.
 *
 * Errors: RT_INVALID_ENUM for another target, format or type; RT_INVALID_VALUE for another internalFormat or
 * border, a negative number, or a side above RT_MAX_TEXTURE_SIZE; RT_INVALID_OPERATION when no texture is
 * bound, the size does not fit that of level 0, or between rtBegin() and rtEnd(); RT_OUT_OF_MEMORY.
 */
RTAPI void rtTexImage2D(RTenum target, RTint level, RTint internalFormat, RTsizei width, RTsizei height,
    RTint border, RTenum format, RTenum type, const void *pixels);

/**
 * Sets a parameter of the bound texture: RT_TEXTURE_WRAP_S and RT_TEXTURE_WRAP_T to RT_REPEAT,
 * RT_CLAMP_TO_EDGE or RT_MIRRORED_REPEAT; RT_TEXTURE_MIN_FILTER to RT_NEAREST, RT_LINEAR or
 * RT_LINEAR_MIPMAP_LINEAR; RT_TEXTURE_MAG_FILTER to RT_NEAREST or RT_LINEAR; RT_TEXTURE_COLOR_SPACE to
 * RT_LINEAR_COLOR or RT_SRGB.
 *
 * Errors: RT_INVALID_ENUM for another target, parameter or value; RT_INVALID_OPERATION when no texture is
 * bound, or between rtBegin() and rtEnd(); RT_OUT_OF_MEMORY.
 */
RTAPI void rtTexParameteri(RTenum target, RTenum pname, RTint param);

/**
 * Sets the parameter RT_TEXTURE_MATRIX of the bound texture: 16 numbers, column by column, that take the texture
 * coordinates s and t of surfaces (with 0 and 1 as third and fourth) to those at which the image is looked up; only s and t
 * of the result count. The identity is the default. Other parameters as for rtTexParameterf().
 *
 * Errors: RT_INVALID_ENUM for another target, parameter or value; RT_INVALID_VALUE when params is NULL;
 * RT_INVALID_OPERATION when no texture is bound, or between rtBegin() and rtEnd(); RT_OUT_OF_MEMORY.
 */
RTAPI void rtTexParameterfv(RTenum target, RTenum pname, const RTfloat *params);

/** See rtTexParameteri(); the value is rounded. */
RTAPI void rtTexParameterf(RTenum target, RTenum pname, RTfloat param);

/**
 * Stores a parameter of the bound texture at params: one of those of rtTexParameteri(), RT_TEXTURE_WIDTH or
 * RT_TEXTURE_HEIGHT.
 *
 * Errors: RT_INVALID_ENUM for another target or parameter, RT_INVALID_VALUE when params is NULL,
 * RT_INVALID_OPERATION when no texture is bound, or between rtBegin() and rtEnd().
 */
RTAPI void rtGetTexParameteriv(RTenum target, RTenum pname, RTint *params);

/** See rtGetTexParameteriv(). RT_TEXTURE_MATRIX is 16 numbers, column by column. */
RTAPI void rtGetTexParameterfv(RTenum target, RTenum pname, RTfloat *params);

/**
 * Reads an image file (PNG, JPEG, EXR, HDR or PNM, told by its content) into a new texture, binds it and
 * returns its name; 0 on failure. Images made for screens are usually stored on the sRGB curve: set
 * RT_TEXTURE_COLOR_SPACE to RT_SRGB.
 *
 * Errors: RT_IO_ERROR when the file cannot be read, RT_INVALID_VALUE when file is NULL, RT_INVALID_OPERATION
 * between rtBegin() and rtEnd(), RT_OUT_OF_MEMORY.
 */
RTAPI RTuint rtLoadTexture(const char *file);

/* Scene files --------------------------------------------------------------------------------------------------- */

/**
 * Reads a scene file, defines its objects, shaders and textures in the current context, and puts the parts of
 * it that the bits name into the frame being assembled, as rtInstantiateLoadedScene() does, for the first moment
 * of its animation. Returns the name of the loaded scene; 0 on failure, and then nothing is defined.
 *
 * The format is told by the file's extension: .aff or .nff (BART and SPD), .obj with its .mtl, .ply, .gltf or .glb.
 * file is UTF-8. Files that the scene names are read from its own folder and those below, textures also
 * from folders beside it called textures or TextureFiles. What the file has and the library leaves out is told
 * by rtGetLoadedSceneString(), one text for each kind of thing; a file that cannot be understood is an error,
 * whose text begins with file and line.
 *
 * Objects, shaders and textures are ordinary ones: they may be instantiated, changed and deleted like any others.
 * The current matrix, what is bound, and the current colour, normal and texture coordinate stay as they are.
 * Colours of glTF files are meant for frame buffers with RT_FRAMEBUFFER_SRGB.
 *
 *   scene = rtLoadScene("museum.aff", RT_NONE);
 *   rtGetLoadedScenedv(scene, RT_SCENE_TIMES, times);   (the first and the last)
 *   for (i = 0; i < 100; i++) {
 *       rtInstantiateLoadedScene(scene, first + (last - first) * i / 99, RT_SCENE_ALL_BITS);
 *       rtRender();
 *   }
 *
 * Errors: RT_IO_ERROR when the file, or one that it cannot be without, cannot be read or is damaged;
 * RT_INVALID_VALUE when file is NULL or other bits are set; RT_INVALID_OPERATION when the library was built
 * without the readers (see RT_SCENE_READERS), between rtBegin() and rtEnd(), or between rtNewObject() and
 * rtEndObject(); RT_STACK_OVERFLOW when the matrix stack is full; RT_OUT_OF_MEMORY.
 */
RTAPI RTuint rtLoadScene(const char *file, RTbitfield parts);

/**
 * Puts parts of a loaded scene into the frame being assembled, as they are at a time of its animation, in
 * seconds on the file's own clock (RT_SCENE_TIMES); beyond its ends the animation rests, as far as the file does
 * not say otherwise. parts is a combination of:
 *
 * RT_SCENE_INSTANCES_BIT: instances of the objects that are visible then, under the current matrix. Vertices of
 * deforming objects have one state in a frame, that of the last call.
 * RT_SCENE_LIGHTS_BIT: the lights that are on, as by rtUseLight().
 * RT_SCENE_CAMERA_BIT: the file's first camera, or one that shows everything, as by rtPerspective() or rtOrtho()
 * and rtLookAt(). Its picture has the shape of the viewport, so rtViewport() comes before.
 * RT_SCENE_BACKGROUND_BIT: what rays see that leave the scene, as by rtClearColor() and rtUseEnvironmentShader().
 *
 * May be called while the frame before renders.
 *
 * Errors: RT_INVALID_VALUE when there is no such loaded scene, time is not finite, or other bits are set;
 * RT_INVALID_OPERATION between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject();
 * RT_STACK_OVERFLOW when the matrix stack is full; RT_OUT_OF_MEMORY.
 */
RTAPI void rtInstantiateLoadedScene(RTuint scene, RTdouble time, RTbitfield parts);

/**
 * Deletes a loaded scene with its objects, shaders and textures. What the frame being assembled shows of it is
 * still shown. 0 is ignored.
 *
 * Errors: RT_INVALID_VALUE when there is no such loaded scene; RT_INVALID_OPERATION between rtBegin() and rtEnd(),
 * or between rtNewObject() and rtEndObject(); RT_OUT_OF_MEMORY.
 */
RTAPI void rtDeleteLoadedScene(RTuint scene);

/**
 * RT_TRUE when scene names a loaded scene.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTboolean rtIsLoadedScene(RTuint scene);

/**
 * Stores a number of a loaded scene at params.
 *
 * RT_SCENE_FIRST_OBJECT, RT_SCENE_OBJECT_COUNT: its objects have this many names in a row, from the first on.
 * RT_SCENE_TRIANGLE_COUNT: triangles of all objects, each object counted once.
 * RT_SCENE_LIGHT_COUNT, RT_SCENE_CAMERA_COUNT: as many as the file has.
 * RT_SCENE_FRAME_COUNT: frames of the animation; 0 when nothing moves.
 * RT_SCENE_WARNING_COUNT: texts about what was left out.
 * RT_SCENE_SRGB: RT_TRUE when the colours are meant for RT_FRAMEBUFFER_SRGB.
 *
 * Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when there is no such loaded scene or params is NULL,
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtGetLoadedSceneiv(RTuint scene, RTenum pname, RTint *params);

/**
 * Stores numbers of a loaded scene at params.
 *
 * RT_SCENE_TIMES: first and last moment of the animation, in seconds on the file's clock; 0 0 when nothing moves.
 * RT_SCENE_BOUNDS: lowest x, y, z and highest x, y, z of what is there at the first moment; 0 for an empty scene.
 *
 * Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when there is no such loaded scene or params is NULL,
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtGetLoadedScenedv(RTuint scene, RTenum pname, RTdouble *params);

/**
 * A text of a loaded scene, which lives until the scene is deleted.
 *
 * RT_SCENE_WARNING: what was left out or is odd, index from 0 to below RT_SCENE_WARNING_COUNT; most begin with file
 * and line.
 * RT_SCENE_OBJECT_NAME: the file's name for an object, index from 0 to below RT_SCENE_OBJECT_COUNT.
 * RT_SCENE_FORMAT: "AFF", "NFF", "OBJ", "PLY" or "glTF"; index is 0.
 *
 * Returns NULL on failure.
 *
 * Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when there is no such loaded scene or no such text,
 * RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI const char *rtGetLoadedSceneString(RTuint scene, RTenum pname, RTuint index);

/* Frames: where pixels go, when they are rendered, how they are read back --------------------------------------- */

/**
 * Lets frames be stored in the application's memory: height rows of width pixels without gaps, the lowest row
 * first unless RT_ORIGIN_TOP_LEFT is enabled. format is RT_RGBA8, RT_BGRA8, RT_RGB8, RT_BGR8, RT_RGB32F,
 * RT_RGBA32F, RT_BGR32F or RT_BGRA32F.
 * Pixels of 8 bits hold linear values, or values on the sRGB curve when RT_FRAMEBUFFER_SRGB is enabled.
 *
 * The memory stays the application's. The library writes to it while a frame is rendered that was started with
 * it, that is, until rtRender(), rtEndRendering() or rtDestroyContext() returns; it must exist until then, and
 * it counts for all frames until another is set. NULL with a size of 0 by 0 goes back to the library's own
 * frame buffer, which rtReadPixels() and rtWriteImage() read in any case.
 *
 * Errors: RT_INVALID_ENUM for another format; RT_INVALID_VALUE when pixels is NULL, or width or height is
 * below 1 or above RT_MAX_FRAME_SIZE; RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtSetFrameBuffer(void *pixels, RTsizei width, RTsizei height, RTenum format);

/**
 * As rtSetFrameBuffer(), with stride bytes from one row to the next.
 *
 * Errors: also RT_INVALID_VALUE when stride is negative or less than a row.
 */
RTAPI void rtSetFrameBufferStride(void *pixels, RTsizei width, RTsizei height, RTenum format, RTsizei stride);

/**
 * Lets frames be stored in the library's own frame buffer, with this size. Without this call and without
 * rtSetFrameBuffer() it is as large as rtViewport() asks for.
 *
 * Errors: RT_INVALID_VALUE when a number is below 1 or above RT_MAX_FRAME_SIZE, RT_INVALID_OPERATION between
 * rtBegin() and rtEnd().
 */
RTAPI void rtSetFrameSize(RTsizei width, RTsizei height);

/**
 * Renders only a rectangle of the frame buffer, and lets the camera's picture fill it; (x, y) is its lower
 * left corner. Without this call, the whole frame buffer.
 *
 * Errors: RT_INVALID_VALUE when x or y is negative, width or height is below 1, or the rectangle reaches
 * beyond RT_MAX_FRAME_SIZE; RT_INVALID_OPERATION between rtBegin() and rtEnd(). Whether it fits the frame
 * buffer is asked when a frame starts.
 */
RTAPI void rtViewport(RTint x, RTint y, RTsizei width, RTsizei height);

/**
 * Renders the frame that was assembled and waits for it, or, if a frame was started by rtStartRendering(),
 * waits for that one. Then a new frame without instances begins.
 *
 * Errors: RT_INVALID_OPERATION without a frame buffer or viewport, when the viewport reaches beyond the frame
 * buffer, between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject(). RT_OUT_OF_MEMORY: when the
 * frame could not start, it is still assembled; otherwise it is over, and the picture is that of the frame before.
 * Objects, shaders and settings are what they were in either case.
 */
RTAPI void rtRender(void);

/**
 * Starts rendering the frame that was assembled, and returns at once. The scene, all shader parameters and the
 * frame buffer are those of this moment: whatever is called now shows in the next frame, which begins without
 * instances.
 *
 * Errors: as rtRender(); RT_INVALID_OPERATION also when a frame is being rendered already.
 */
RTAPI void rtStartRendering(void);

/**
 * Waits until the frame of rtStartRendering() is finished. Then its pixels are in the frame buffer, and the
 * callback of rtFrameCallback() has returned.
 *
 * Errors: RT_INVALID_OPERATION without rtStartRendering(), between rtBegin() and rtEnd(), or between
 * rtNewObject() and rtEndObject(); RT_OUT_OF_MEMORY.
 */
RTAPI void rtEndRendering(void);

/** Ends the frame in OpenRT's order of calls: another name of rtRender(). */
RTAPI void rtSwapBuffers(void);

/**
 * RT_TRUE when the frame of rtStartRendering() is finished, or none was started. Does not wait.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTboolean rtIsFrameDone(void);

/**
 * Waits at most this many milliseconds for the frame of rtStartRendering(); RT_TRUE when it is finished. It
 * still wants rtEndRendering().
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI RTboolean rtWaitFrame(RTuint milliseconds);

/**
 * Stops the frame of rtStartRendering() early, within milliseconds: parts of the picture that are not complete keep what they
 * showed before, and those that were begun may be of both. The frame still wants rtEndRendering(), and its statistics say that it was cancelled. Without a
 * frame this does nothing.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtCancel(void);

/**
 * Stops the frame that a context is rendering, as rtCancel() does. May be called on any thread, for a context
 * that is current on another one, for example while that thread waits in rtRender().
 *
 * Errors: RT_INVALID_VALUE when there is no such context.
 */
RTAPI void rtCancelContext(RTuint context);

/**
 * From now on, callback is called at the end of every frame that starts. NULL stops that. userData is handed
 * to the callback and otherwise not touched; it must stay valid until the last such frame has ended.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtFrameCallback(RTframeCallback callback, void *userData);

/**
 * Brings all acceleration structures up to date with the objects, and with the instances placed in this frame
 * so far, without rendering and without beginning a new frame (rtClearInstances() does that). Ray queries then
 * see them. Waits for a frame that is being rendered.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject();
 * RT_OUT_OF_MEMORY.
 */
RTAPI void rtCommitScene(void);

/**
 * Stores at stats what the last finished frame, or the last rtCommitScene(), cost.
 *
 * Errors: RT_INVALID_VALUE when stats is NULL, RT_INVALID_OPERATION between rtBegin() and rtEnd().
 */
RTAPI void rtGetFrameStats(struct RTframeStats *stats);

/**
 * Stores a rectangle of the last frame at pixels, row by row without gaps; row 0 is the lowest, or the topmost
 * when RT_ORIGIN_TOP_LEFT is enabled. (x, y) is the corner of the rectangle where row 0 begins to count.
 * format and type are RT_RGBA, RT_RGB, RT_BGRA or RT_BGR with RT_UNSIGNED_BYTE or RT_FLOAT;
 * RT_DEPTH_COMPONENT or RT_NORMAL (three numbers) with RT_FLOAT; RT_OBJECT_ID or RT_INSTANCE_ID with
 * RT_UNSIGNED_INT. Waits for a frame that is being rendered.
 *
 * Errors: RT_INVALID_ENUM for another format or type; RT_INVALID_VALUE when pixels is NULL, a number is
 * negative, or the rectangle reaches beyond the picture; RT_INVALID_OPERATION before the first frame, between
 * rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject().
 */
RTAPI void rtReadPixels(RTint x, RTint y, RTsizei width, RTsizei height, RTenum format, RTenum type,
    void *pixels);

/**
 * Sets how well JPEG files that rtWriteImage() writes show the picture: 1 (small files) to 100; 92 at first.
 *
 * Errors: RT_INVALID_VALUE when quality is below 1 or above 100, RT_INVALID_OPERATION between rtBegin() and
 * rtEnd().
 */
RTAPI void rtJpegQuality(RTint quality);

/**
 * Writes the last frame to a file whose extension names the format: .png, .jpg, .ppm, .hdr or .exr. Waits for
 * a frame that is being rendered.
 *
 * Errors: RT_IO_ERROR when the file cannot be written or the extension is unknown, RT_INVALID_VALUE when file
 * is NULL, RT_INVALID_OPERATION before the first frame, between rtBegin() and rtEnd(), or between
 * rtNewObject() and rtEndObject().
 */
RTAPI void rtWriteImage(const char *file);

/* Picking and batches of rays, in the scene of the current context ---------------------------------------------- */

/**
 * Stores at hit what the camera of the last frame sees at the window coordinates (x, y), and returns RT_TRUE
 * if it is anything. Pixel centres are at .5, and the origin is at the lower left, or at the upper left when
 * RT_ORIGIN_TOP_LEFT is enabled. Waits for a frame that is being rendered.
 *
 * Errors: RT_INVALID_VALUE when hit is NULL or a number is not finite; RT_INVALID_OPERATION before the first
 * frame, between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject().
 */
RTAPI RTboolean rtPick(RTfloat x, RTfloat y, struct RThit *hit);

/**
 * Stores at hits, for each of the n rays at rays, what it meets first in the scene of the last frame or
 * rtCommitScene(). flags is 0 or RT_COHERENT: neighbours in the array are neighbours in space. Rays that are not finite, or have no direction, hit
 * nothing. Up to some hundred rays are traced on the calling thread, without memory, lock or system call; more by all threads of the context. The two arrays must
 * not overlap. Waits for a frame that is being rendered. Other threads ask by rtAcquireScene().
 *
 * Errors: RT_INVALID_VALUE when n is negative, a pointer is NULL, or flags are unknown; RT_INVALID_OPERATION
 * between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject().
 */
RTAPI void rtIntersectRays(RTsizei n, const struct RTray *rays, struct RThit *hits, RTbitfield flags);

/**
 * Stores at occluded, for each of the n rays at rays, RT_TRUE when anything is in its way, else RT_FALSE.
 * Quicker than rtIntersectRays(), and otherwise as that.
 */
RTAPI void rtOccludedRays(RTsizei n, const struct RTray *rays, RTubyte *occluded, RTbitfield flags);

/* Snapshots of a scene, which any thread may ask, and questions beyond the closest hit -------------------------- */

/**
 * Takes a snapshot of the scene that was last rendered or committed. Any number of threads may ask it at a time, also ones on which no context is
 * current, without lock, memory or system call, while the context goes on: frames, commits and even rtDestroyContext() leave it as it is. Its memory is
 * shared with the context as far as nothing has changed since; what changes is copied while a snapshot holds it. Waits for a frame that is being rendered.
 * Returns NULL on an error.
 *
 * Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject(); RT_OUT_OF_MEMORY.
 */
RTAPI RTscene rtAcquireScene(void);

/** Gives a snapshot back, on any thread; nobody may be asking it any more. NULL is ignored. */
RTAPI void rtReleaseScene(RTscene scene);

/**
 * As rtIntersectRays(), in a snapshot: on the calling thread, however many rays there are. Any thread may call it at any time. For NULL it is
 * rtIntersectRays().
 *
 * Errors: RT_INVALID_VALUE when n is negative, a pointer is NULL, or flags are unknown. They are kept for the calling thread, or for the context
 * that is current on it.
 */
RTAPI void rtSceneIntersect(RTscene scene, RTsizei n, const struct RTray *rays, struct RThit *hits,
    RTbitfield flags);

/** As rtOccludedRays(), in a snapshot; otherwise as rtSceneIntersect(). */
RTAPI void rtSceneOccluded(RTscene scene, RTsizei n, const struct RTray *rays, RTubyte *occluded,
    RTbitfield flags);

/**
 * As rtSceneIntersect(), by the masks and the filter of query (NULL for none of them): stores at hits, for each of the n rays at rays, the first hit that counts.
 *
 * Errors: as rtSceneIntersect(). RT_INVALID_OPERATION for the scene NULL between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject().
 */
RTAPI void rtSceneQuery(RTscene scene, RTsizei n, const struct RTray *rays, struct RThit *hits,
    const struct RTquery *query);

/**
 * Stores at hits the first max hits of a ray that count by query (NULL: all), sorted by distance, hits at the same distance by instance and primitive. Returns
 * how many it has stored. Each costs the search for a closest hit.
 *
 * Errors: as rtSceneQuery().
 */
RTAPI RTsizei rtSceneAllHits(RTscene scene, const struct RTray *ray, RTsizei max, struct RThit *hits,
    const struct RTquery *query);

/**
 * Stores at surfaces what lies at the n hits at hits, which the rays at rays have made in the same scene. Where nothing was hit all members are 0.
 *
 * Errors: RT_INVALID_VALUE when n is negative, a pointer is NULL, or a hit is none of this scene (then nothing is stored from there on); else as
 * rtSceneQuery().
 */
RTAPI void rtSceneSurfaces(RTscene scene, RTsizei n, const struct RTray *rays, const struct RThit *hits,
    struct RTsurface *surfaces);

/**
 * Stores at closest the point that is nearest to the three numbers at point and no farther away than maxDistance (INFINITY for no limit), and returns whether there is
 * one. object 0 asks for the whole scene, in world space, among instances that have a bit of RT_QUERY_RAYS; the name of an object that the scene shows asks
 * for that object, in its own space. The first question after an object has changed sorts its triangles, on the calling thread.
 *
 * Errors: RT_INVALID_VALUE when a pointer is NULL, a number is not finite, maxDistance is negative, or the scene does not show the object; else as
 * rtSceneQuery().
 */
RTAPI RTboolean rtSceneClosestPoint(RTscene scene, RTuint object, const RTfloat *point, RTfloat maxDistance,
    struct RTclosestPoint *closest);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* OPENRT_RT_H */
