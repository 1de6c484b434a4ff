//! The `RT_*` constants. Values are those of OpenGL where it has the same thing, so that tables made for one
//! serve the other. Plain literals below 2^31: cbindgen would write anything cleverer in a way that C reads
//! differently.

use super::types::{RTbitfield, RTboolean, RTenum, RTuint};

/// False.
pub const RT_FALSE: RTboolean = 0;
/// True.
pub const RT_TRUE: RTboolean = 1;
/// No object, flag or setting.
pub const RT_NONE: RTenum = 0;

/// Error: nothing went wrong since the last rtGetError().
pub const RT_NO_ERROR: RTenum = 0;
/// Error: an RTenum argument is none of the accepted values.
pub const RT_INVALID_ENUM: RTenum = 0x0500;
/// Error: a number is out of range or not a number, a pointer is NULL, or a name does not exist.
pub const RT_INVALID_VALUE: RTenum = 0x0501;
/// Error: the call is not allowed in this state, for example between rtBegin() and rtEnd(), or without a
/// context.
pub const RT_INVALID_OPERATION: RTenum = 0x0502;
/// Error: rtPushMatrix() on a full stack.
pub const RT_STACK_OVERFLOW: RTenum = 0x0503;
/// Error: rtPopMatrix() on the last matrix.
pub const RT_STACK_UNDERFLOW: RTenum = 0x0504;
/// Error: not enough memory; the state is as before the call.
pub const RT_OUT_OF_MEMORY: RTenum = 0x0505;
/// Error: a file or a plug-in could not be read, written or understood. rtGetErrorString() says why.
pub const RT_IO_ERROR: RTenum = 0x0510;
/// Error: a defect of the library itself. The context answers every call with this error until it is destroyed.
pub const RT_INTERNAL_ERROR: RTenum = 0x0511;

/// Primitive: every three vertices are a triangle.
pub const RT_TRIANGLES: RTenum = 0x0004;
/// Primitive: every vertex after the second makes a triangle with the two before it.
pub const RT_TRIANGLE_STRIP: RTenum = 0x0005;
/// Primitive: every vertex after the second makes a triangle with the one before it and the first.
pub const RT_TRIANGLE_FAN: RTenum = 0x0006;
/// Primitive: every four vertices are a quadrilateral.
pub const RT_QUADS: RTenum = 0x0007;
/// Primitive: every two vertices after the first two make a quadrilateral with the two before them.
pub const RT_QUAD_STRIP: RTenum = 0x0008;
/// Primitive: all vertices are one convex polygon.
pub const RT_POLYGON: RTenum = 0x0009;

/// Object mode: define the object.
pub const RT_COMPILE: RTbitfield = 0x1300;
/// Object mode: define the object, and instantiate it once at rtEndObject().
pub const RT_COMPILE_AND_INSTANTIATE: RTbitfield = 0x1301;
/// Object mode: another word for RT_COMPILE.
pub const RT_DEFINE: RTbitfield = 0x1300;
/// Object mode: another word for RT_COMPILE_AND_INSTANTIATE.
pub const RT_DEFINE_AND_INSTANTIATE: RTbitfield = 0x1301;
/// Motion flag of an object mode: neither the geometry nor its instances will move.
pub const RT_STATIC: RTbitfield = 0x10000;
/// Motion flag of an object mode: only the matrices of the instances will change. The default.
pub const RT_AFFINE: RTbitfield = 0x20000;
/// Motion flag of an object mode: vertices will move independently, by rtUpdateVertices() or by defining the
/// object anew.
pub const RT_UNSTRUCTURED: RTbitfield = 0x40000;

/// Object parameter: how the acceleration structure is built and updated; one of the strategies that follow.
pub const RT_UPDATE_STRATEGY: RTenum = 0x6000;
/// Object parameter, read only: the motion flag.
pub const RT_MOTION: RTenum = 0x6001;
/// Object parameter, read only: the number of triangles.
pub const RT_TRIANGLE_COUNT: RTenum = 0x6002;
/// Object parameter, read only: the number of vertices, as counted by rtUpdateVertices().
pub const RT_VERTEX_COUNT: RTenum = 0x6003;
/// Parameter of objects: how many triangles the subtrees have at most that RT_LAZY updates when a ray reaches them.
/// 0: subtrees at half the height.
pub const RT_LAZY_CUT: RTenum = 0x6004;
/// Parameter of objects: how many levels of such a subtree RT_LAZY updates at once; 0: all.
pub const RT_LAZY_LEVELS: RTenum = 0x6005;
/// Parameter of objects: a time, which chooses among key frames. See rtKeyFrame().
pub const RT_OBJECT_TIME: RTenum = 0x6006;
/// Object parameter, RT_TRUE or RT_FALSE: whether triangles of an RT_STATIC object may be cut for a better tree.
pub const RT_SPATIAL_SPLITS: RTenum = 0x6008;
/// Object parameter: which rays see the object, 32 bits.
pub const RT_MASK: RTenum = 0x6009;
/// Object parameter: whether shadow rays see the object.
pub const RT_CAST_SHADOW: RTenum = 0x600A;
/// Update strategy: chosen from the motion flag and from what was measured. The default.
pub const RT_AUTO: RTenum = 0x6010;
/// Update strategy: object BSP tree (Wald, Benthin and Slusallek 2003).
pub const RT_BSP: RTenum = 0x6011;
/// Update strategy: bounding volume hierarchy by the surface area heuristic, built anew when the geometry
/// changes.
pub const RT_SAH: RTenum = 0x6012;
/// Update strategy: bounding volume hierarchy by Morton codes, quick to build, built anew when the geometry
/// changes.
pub const RT_FAST_BUILD: RTenum = 0x6013;
/// Update strategy: built once, then boxes are fitted anew when vertices move (Larsson and Akenine-Moeller
/// 2003).
pub const RT_REFIT: RTenum = 0x6014;
/// Update strategy: as RT_REFIT, but boxes that drift apart change places (Kopta and others 2012), and the
/// structure is built anew when that is not enough.
pub const RT_ROTATE: RTenum = 0x6017;
/// Update strategy: grid of grids, made anew when the geometry changes (Larsson and Akenine-Moeller 2003), for triangles
/// of like size that move without any order.
pub const RT_GRID: RTenum = 0x6018;
/// Update strategy: visibility field (Khanna, Mortensen, Yu and Slater 2004), tiles that list triangles, for many
/// directions, drawn when rays ask for them; triangles that move are kept apart. Takes much memory.
pub const RT_VISIBILITY_FIELD: RTenum = 0x6019;
/// Update strategy: built once, then only what rays reach is brought up to date, when they reach it (Larsson and
/// Akenine-Moeller 2003).
pub const RT_LAZY: RTenum = 0x6016;
/// Top level: 8-wide bounding volume hierarchy over the instances, see rtTopLevel().
pub const RT_TOPLEVEL_BVH: RTenum = 0x6015;

/// Data type: RTbyte.
pub const RT_BYTE: RTenum = 0x1400;
/// Data type: RTubyte.
pub const RT_UNSIGNED_BYTE: RTenum = 0x1401;
/// Data type: RTshort.
pub const RT_SHORT: RTenum = 0x1402;
/// Data type: RTushort.
pub const RT_UNSIGNED_SHORT: RTenum = 0x1403;
/// Data type: RTint.
pub const RT_INT: RTenum = 0x1404;
/// Data type: RTuint.
pub const RT_UNSIGNED_INT: RTenum = 0x1405;
/// Data type: RTfloat.
pub const RT_FLOAT: RTenum = 0x1406;
/// Data type: RTdouble.
pub const RT_DOUBLE: RTenum = 0x140A;
/// Data type of shader parameters: two RTfloat.
pub const RT_FLOAT_VEC2: RTenum = 0x8B50;
/// Data type of shader parameters: three RTfloat.
pub const RT_FLOAT_VEC3: RTenum = 0x8B51;
/// Data type of shader parameters: four RTfloat.
pub const RT_FLOAT_VEC4: RTenum = 0x8B52;
/// Data type of shader parameters: two RTint.
pub const RT_INT_VEC2: RTenum = 0x8B53;
/// Data type of shader parameters: three RTint.
pub const RT_INT_VEC3: RTenum = 0x8B54;
/// Data type of shader parameters: four RTint.
pub const RT_INT_VEC4: RTenum = 0x8B55;
/// Data type of shader parameters: sixteen RTfloat, a column-major matrix.
pub const RT_FLOAT_MAT4: RTenum = 0x8B5C;
/// Data type of shader parameters: the name of a texture, an RTuint.
pub const RT_TEXTURE: RTenum = 0x1702;
/// Data type of shader parameters: a text.
pub const RT_STRING: RTenum = 0x6020;
/// Data type of shader parameters: any number of bytes.
pub const RT_RAW: RTenum = 0x6021;

/// Vertex array: positions.
pub const RT_VERTEX_ARRAY: RTenum = 0x8074;
/// Vertex array: normals.
pub const RT_NORMAL_ARRAY: RTenum = 0x8075;
/// Vertex array: colours.
pub const RT_COLOR_ARRAY: RTenum = 0x8076;
/// Vertex array: texture coordinates.
pub const RT_TEXTURE_COORD_ARRAY: RTenum = 0x8078;

/// Value of RTshaderClass.version that this header describes.
pub const RT_SHADER_CLASS_VERSION: RTuint = 1;
/// Shader kind: colours points of surfaces.
pub const RT_SURFACE_SHADER: RTenum = 0x6030;
/// Shader kind: sends light to points.
pub const RT_LIGHT_SHADER: RTenum = 0x6031;
/// Shader kind: makes the rays through the pixels.
pub const RT_CAMERA_SHADER: RTenum = 0x6032;
/// Shader kind: colours rays that leave the scene.
pub const RT_ENVIRONMENT_SHADER: RTenum = 0x6033;
/// Shader kind: the algorithm that turns rays into pixels.
pub const RT_RENDERING_OBJECT: RTenum = 0x6034;
/// Scope of a shader parameter: one value per shader; the value at the start of a frame holds for the whole
/// frame.
pub const RT_PER_SHADER: RTenum = 0x6038;
/// Scope of a shader parameter: captured when a triangle is completed.
pub const RT_PER_TRIANGLE: RTenum = 0x6039;
/// Scope of a shader parameter: captured at each rtVertex, and interpolated.
pub const RT_PER_VERTEX: RTenum = 0x603A;

/// Shader class property: its kind.
pub const RT_SHADER_KIND: RTenum = 0x6080;
/// Shader class property: number of parameters.
pub const RT_PARAMETER_COUNT: RTenum = 0x6081;
/// Shader parameter property: its data type.
pub const RT_PARAMETER_TYPE: RTenum = 0x6082;
/// Shader parameter property: its scope.
pub const RT_PARAMETER_SCOPE: RTenum = 0x6083;
/// Shader parameter property: its size in bytes.
pub const RT_PARAMETER_SIZE: RTenum = 0x6084;

/// Texture target, the only one.
pub const RT_TEXTURE_2D: RTenum = 0x0DE1;
/// Texture parameter: filter when a texel covers many pixels: RT_NEAREST or RT_LINEAR.
pub const RT_TEXTURE_MAG_FILTER: RTenum = 0x2800;
/// Texture parameter: filter when a pixel covers many texels: RT_NEAREST, RT_LINEAR or RT_LINEAR_MIPMAP_LINEAR.
pub const RT_TEXTURE_MIN_FILTER: RTenum = 0x2801;
/// Texture parameter: what happens outside 0..1 along s: RT_REPEAT, RT_CLAMP_TO_EDGE or RT_MIRRORED_REPEAT.
pub const RT_TEXTURE_WRAP_S: RTenum = 0x2802;
/// Texture parameter: the same along t.
pub const RT_TEXTURE_WRAP_T: RTenum = 0x2803;
/// Texture parameter, read only: width of level 0.
pub const RT_TEXTURE_WIDTH: RTenum = 0x1000;
/// Texture parameter, read only: height of level 0.
pub const RT_TEXTURE_HEIGHT: RTenum = 0x1001;
/// Texture parameter: RT_LINEAR_COLOR or RT_SRGB.
pub const RT_TEXTURE_COLOR_SPACE: RTenum = 0x6040;
/// Texture parameter, for rtTexParameterfv(): where the image lies on surfaces.
pub const RT_TEXTURE_MATRIX: RTenum = 0x0BA8;
/// Texture colour space: stored values are used as they are.
pub const RT_LINEAR_COLOR: RTenum = 0x6041;
/// Texture colour space: stored values are on the sRGB curve.
pub const RT_SRGB: RTenum = 0x8C40;
/// Internal texture format: three channels on the sRGB curve.
pub const RT_SRGB8: RTenum = 0x8C41;
/// Internal texture format: three channels on the sRGB curve and opacity.
pub const RT_SRGB8_ALPHA8: RTenum = 0x8C43;
/// Texture filter: the nearest texel.
pub const RT_NEAREST: RTenum = 0x2600;
/// Texture filter: the four nearest texels, blended.
pub const RT_LINEAR: RTenum = 0x2601;
/// Texture filter: bilinear on the two nearest mip-map levels, blended. The default.
pub const RT_LINEAR_MIPMAP_LINEAR: RTenum = 0x2703;
/// Texture wrap: only the fraction counts. The default.
pub const RT_REPEAT: RTenum = 0x2901;
/// Texture wrap: the border texel continues.
pub const RT_CLAMP_TO_EDGE: RTenum = 0x812F;
/// Texture wrap: every second repetition is mirrored.
pub const RT_MIRRORED_REPEAT: RTenum = 0x8370;

/// Pixel format: one channel, red.
pub const RT_RED: RTenum = 0x1903;
/// Pixel format: one channel, opacity.
pub const RT_ALPHA: RTenum = 0x1906;
/// Pixel format: one channel used for red, green and blue.
pub const RT_LUMINANCE: RTenum = 0x1909;
/// Pixel format: one channel of grey and one of opacity.
pub const RT_LUMINANCE_ALPHA: RTenum = 0x190A;
/// Pixel format: three channels.
pub const RT_RGB: RTenum = 0x1907;
/// Pixel format: four channels.
pub const RT_RGBA: RTenum = 0x1908;
/// Pixel format: three channels, blue first.
pub const RT_BGR: RTenum = 0x80E0;
/// Pixel format: four channels, blue first, opacity last.
pub const RT_BGRA: RTenum = 0x80E1;
/// Pixel data of rtReadPixels(): distance from the camera along the ray, infinite where nothing was hit.
/// RT_FLOAT.
pub const RT_DEPTH_COMPONENT: RTenum = 0x1902;
/// Pixel data of rtReadPixels(): unit normal in world space, three RT_FLOAT, 0 where nothing was hit.
pub const RT_NORMAL: RTenum = 0x6050;
/// Pixel data of rtReadPixels(): name of the object, RT_UNSIGNED_INT, 0 where nothing was hit.
pub const RT_OBJECT_ID: RTenum = 0x6051;
/// Pixel data of rtReadPixels(): number of the instance, RT_UNSIGNED_INT, 0xFFFFFFFF where nothing was hit.
pub const RT_INSTANCE_ID: RTenum = 0x6052;
/// Frame buffer format: four bytes: red, green, blue, opacity.
pub const RT_RGBA8: RTenum = 0x8058;
/// Frame buffer format: four bytes: blue, green, red, opacity.
pub const RT_BGRA8: RTenum = 0x93A1;
/// Frame buffer format: three bytes: red, green, blue.
pub const RT_RGB8: RTenum = 0x8051;
/// Frame buffer format: three RTfloat: red, green, blue; linear, not clamped.
pub const RT_RGB32F: RTenum = 0x8815;
/// Frame buffer format: four RTfloat: red, green, blue, opacity; linear, not clamped.
pub const RT_RGBA32F: RTenum = 0x8814;
/// Frame buffer format: 8 bits each of blue, green, red.
pub const RT_BGR8: RTenum = 0x60C0;
/// Frame buffer format: blue, green, red as linear floats.
pub const RT_BGR32F: RTenum = 0x60C1;
/// Frame buffer format: blue, green, red, alpha as linear floats.
pub const RT_BGRA32F: RTenum = 0x60C2;

/// String of rtGetString(): who made the library.
pub const RT_VENDOR: RTenum = 0x1F00;
/// String of rtGetString(): the rendering object in use.
pub const RT_RENDERER: RTenum = 0x1F01;
/// String of rtGetString(): the version, major.minor.patch.
pub const RT_VERSION: RTenum = 0x1F02;
/// String of rtGetString(): the instruction set in use.
pub const RT_SIMD_LEVEL: RTenum = 0x6060;
/// String of rtGetString(): who executes the frames.
pub const RT_BACKEND: RTenum = 0x6061;

/// Ray query flag: neighbouring rays are alike, as camera or shadow rays are; they may be traced together.
pub const RT_COHERENT: RTbitfield = 0x0001;

/// In masks: rays from the camera.
pub const RT_CAMERA_RAYS: RTbitfield = 0x0001;
/// In masks: rays from a surface to a light, and those that look for occluders nearby.
pub const RT_SHADOW_RAYS: RTbitfield = 0x0002;
/// In masks: rays that are reflected, refracted or scattered.
pub const RT_REFLECTION_RAYS: RTbitfield = 0x0004;
/// In masks: rays of queries that name no mask of their own.
pub const RT_QUERY_RAYS: RTbitfield = 0x0008;

/// Capability: 8-bit pixels are stored on the sRGB curve, as screens and image files want them, instead of
/// linear.
pub const RT_FRAMEBUFFER_SRGB: RTenum = 0x8DB9;
/// Capability: row 0 of pictures is the topmost, and rtPick() counts from the top.
pub const RT_ORIGIN_TOP_LEFT: RTenum = 0x6070;
/// Capability: frames are averaged as long as neither scene nor camera changes.
pub const RT_ACCUMULATE: RTenum = 0x6071;
/// Capability: as RT_ACCUMULATE; and if frames are sub-sampled, each next one samples blocks of half the size, as
/// long as neither scene nor camera changes.
pub const RT_PROGRESSIVE: RTenum = 0x6072;

/// Frame parameter: one pixel in each block of so many on a side is sampled.
pub const RT_SUBSAMPLING: RTenum = 0x60B0;
/// Frame parameter: how pixels that are not sampled get their colours.
pub const RT_UPSAMPLING: RTenum = 0x60B1;
/// Up-sampling: bilinear. The default.
pub const RT_BILINEAR: RTenum = 0x60B2;
/// Up-sampling: linear in the four triangles around the middle of each block.
pub const RT_MIDPOINT: RTenum = 0x60B3;
/// Frame parameter: each frame renders one in so many pixels and keeps the others.
pub const RT_FRAMELESS: RTenum = 0x60B4;
/// Frame parameter: milliseconds that a frame may take; negative without a limit.
pub const RT_TIME_BUDGET: RTenum = 0x60B5;

/// State: the current matrix, column by column.
pub const RT_MATRIX: RTenum = 0x0BA6;
/// State: number of matrices on the stack; at least 1.
pub const RT_MATRIX_STACK_DEPTH: RTenum = 0x0BA3;
/// State: most matrices on the stack.
pub const RT_MAX_MATRIX_STACK_DEPTH: RTenum = 0x0D36;
/// State: the current colour.
pub const RT_CURRENT_COLOR: RTenum = 0x0B00;
/// State: the current normal; 0, 0, 0 when there is none.
pub const RT_CURRENT_NORMAL: RTenum = 0x0B02;
/// State: the current texture coordinate.
pub const RT_CURRENT_TEXTURE_COORDS: RTenum = 0x0B03;
/// State: the object that is being defined, or 0.
pub const RT_CURRENT_OBJECT: RTenum = 0x0B33;
/// State: RT_COMPILE or RT_COMPILE_AND_INSTANTIATE while an object is being defined, else 0.
pub const RT_CURRENT_OBJECT_MODE: RTenum = 0x0B30;
/// State: the bound shader class, or 0.
pub const RT_SHADER_CLASS_BINDING: RTenum = 0x60A0;
/// State: the bound shader, or 0.
pub const RT_SHADER_BINDING: RTenum = 0x60A1;
/// State: the bound texture, or 0.
pub const RT_TEXTURE_BINDING_2D: RTenum = 0x8069;
/// State: the shader of rtUseCamera(), or 0.
pub const RT_CAMERA: RTenum = 0x60A2;
/// State: the shader of rtUseEnvironmentShader(), or 0.
pub const RT_ENVIRONMENT: RTenum = 0x60A3;
/// State: the shader of rtUseRenderingObject(), or 0.
pub const RT_CURRENT_RENDERING_OBJECT: RTenum = 0x60A4;
/// State: number of lights of the frame being assembled.
pub const RT_LIGHT_COUNT: RTenum = 0x60A5;
/// State: the lights of the frame being assembled.
pub const RT_LIGHTS: RTenum = 0x60A6;
/// State: number of instances of the frame being assembled.
pub const RT_INSTANCE_COUNT: RTenum = 0x60A7;
/// State: the clear colour.
pub const RT_COLOR_CLEAR_VALUE: RTenum = 0x0C22;
/// See rtJpegQuality().
pub const RT_JPEG_QUALITY: RTenum = 0x60B6;
/// See rtAmbientLight(): 3 numbers.
pub const RT_AMBIENT_LIGHT: RTenum = 0x0B53;
/// State: the viewport.
pub const RT_VIEWPORT: RTenum = 0x0BA2;
/// State: width and height of the frame buffer; 0 before there is one.
pub const RT_FRAME_SIZE: RTenum = 0x60A8;
/// State: largest width and height of a frame buffer.
pub const RT_MAX_FRAME_SIZE: RTenum = 0x60A9;
/// State: largest width and height of a texture.
pub const RT_MAX_TEXTURE_SIZE: RTenum = 0x0D33;
/// State: what rtSamplesPerPixel() set.
pub const RT_SAMPLES_PER_PIXEL: RTenum = 0x80A9;
/// State: most samples per pixel.
pub const RT_MAX_SAMPLES: RTenum = 0x8D57;
/// State: what rtMaxDepth() set.
pub const RT_RAY_DEPTH: RTenum = 0x60AA;
/// State: largest value for rtMaxDepth().
pub const RT_MAX_RAY_DEPTH: RTenum = 0x60AB;
/// State: number of worker threads.
pub const RT_THREADS: RTenum = 0x60AC;
/// State: RT_TRUE from rtStartRendering() to rtEndRendering().
pub const RT_RENDERING: RTenum = 0x60AD;
/// State: number of frames started so far.
pub const RT_FRAME_NUMBER: RTenum = 0x60AE;
/// State: the structure over the instances, see rtTopLevel().
pub const RT_TOPLEVEL: RTenum = 0x60AF;
/// State: numbers per vertex in the vertex array.
pub const RT_VERTEX_ARRAY_SIZE: RTenum = 0x807A;
/// State: data type of the vertex array.
pub const RT_VERTEX_ARRAY_TYPE: RTenum = 0x807B;
/// State: stride of the vertex array, as given.
pub const RT_VERTEX_ARRAY_STRIDE: RTenum = 0x807C;
/// State: data type of the normal array.
pub const RT_NORMAL_ARRAY_TYPE: RTenum = 0x807E;
/// State: stride of the normal array, as given.
pub const RT_NORMAL_ARRAY_STRIDE: RTenum = 0x807F;
/// State: numbers per vertex in the colour array.
pub const RT_COLOR_ARRAY_SIZE: RTenum = 0x8081;
/// State: data type of the colour array.
pub const RT_COLOR_ARRAY_TYPE: RTenum = 0x8082;
/// State: stride of the colour array, as given.
pub const RT_COLOR_ARRAY_STRIDE: RTenum = 0x8083;
/// State: numbers per vertex in the texture coordinate array.
pub const RT_TEXTURE_COORD_ARRAY_SIZE: RTenum = 0x8088;
/// State: data type of the texture coordinate array.
pub const RT_TEXTURE_COORD_ARRAY_TYPE: RTenum = 0x8089;
/// State: stride of the texture coordinate array, as given.
pub const RT_TEXTURE_COORD_ARRAY_STRIDE: RTenum = 0x808A;
/// Pointer of rtGetPointerv(): the vertex array.
pub const RT_VERTEX_ARRAY_POINTER: RTenum = 0x808E;
/// Pointer of rtGetPointerv(): the normal array.
pub const RT_NORMAL_ARRAY_POINTER: RTenum = 0x808F;
/// Pointer of rtGetPointerv(): the colour array.
pub const RT_COLOR_ARRAY_POINTER: RTenum = 0x8090;
/// Pointer of rtGetPointerv(): the texture coordinate array.
pub const RT_TEXTURE_COORD_ARRAY_POINTER: RTenum = 0x8092;

/// Part of a loaded scene, for rtLoadScene() and rtInstantiateLoadedScene(): instances of its objects.
pub const RT_SCENE_INSTANCES_BIT: RTbitfield = 0x100000;
/// Part of a loaded scene: its lights.
pub const RT_SCENE_LIGHTS_BIT: RTbitfield = 0x200000;
/// Part of a loaded scene: its camera.
pub const RT_SCENE_CAMERA_BIT: RTbitfield = 0x400000;
/// Part of a loaded scene: clear colour or environment.
pub const RT_SCENE_BACKGROUND_BIT: RTbitfield = 0x800000;
/// All parts of a loaded scene.
pub const RT_SCENE_ALL_BITS: RTbitfield = 0xF00000;
/// State: RT_TRUE when the library was built with the readers of scene files, see rtLoadScene().
pub const RT_SCENE_READERS: RTenum = 0x6100;
/// Number of a loaded scene: its first object.
pub const RT_SCENE_FIRST_OBJECT: RTenum = 0x6101;
/// Number of a loaded scene: how many objects it has.
pub const RT_SCENE_OBJECT_COUNT: RTenum = 0x6102;
/// Number of a loaded scene: triangles of its objects.
pub const RT_SCENE_TRIANGLE_COUNT: RTenum = 0x6103;
/// Number of a loaded scene: lights.
pub const RT_SCENE_LIGHT_COUNT: RTenum = 0x6104;
/// Number of a loaded scene: cameras.
pub const RT_SCENE_CAMERA_COUNT: RTenum = 0x6105;
/// Number of a loaded scene: frames of its animation.
pub const RT_SCENE_FRAME_COUNT: RTenum = 0x6106;
/// Number of a loaded scene: texts about what was left out.
pub const RT_SCENE_WARNING_COUNT: RTenum = 0x6107;
/// Number of a loaded scene: whether its colours are meant for RT_FRAMEBUFFER_SRGB.
pub const RT_SCENE_SRGB: RTenum = 0x6108;
/// Numbers of a loaded scene: first and last moment of its animation.
pub const RT_SCENE_TIMES: RTenum = 0x6109;
/// Numbers of a loaded scene: the box around it.
pub const RT_SCENE_BOUNDS: RTenum = 0x610A;
/// Text of a loaded scene: something that was left out.
pub const RT_SCENE_WARNING: RTenum = 0x610B;
/// Text of a loaded scene: the name of an object.
pub const RT_SCENE_OBJECT_NAME: RTenum = 0x610C;
/// Text of a loaded scene: the format of the file.
pub const RT_SCENE_FORMAT: RTenum = 0x610D;
/// Object of triangles that are drawn outside objects, in hits and RT_OBJECT_ID.
pub const RT_IMMEDIATE_OBJECT: RTuint = 0xFFFF_FFFF;
