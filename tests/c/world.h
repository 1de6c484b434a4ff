/* A context with one of everything, a picture of its whole state, as text. */
#ifndef WORLD_H
#define WORLD_H

#include "check.h"

#define NOT_A_NUMBER ((float)NAN)

const RTfloat floats[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
const RTdouble doubles[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
const RTint ints[4] = {1, 2, 3, 4};
const RTuint uints[4] = {1, 2, 3, 4};
const RTshort shorts[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
const RTushort ushorts[4] = {1, 2, 3, 4};
const RTbyte bytes[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
const RTubyte ubytes[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
const RTray rays[2] = {{{0, 0, 5}, 0, {0, 0, -1}, 100}, {{50, 0, 5}, 0, {0, 0, -1}, 100}};
RTfloat nans[16];
RTdouble dnans[16];

RTint out_ints[64];
RTuint out_uints[64];
RTfloat out_floats[64];
RTdouble out_doubles[64];
RTubyte out_bytes[64];
RThit out_hits[8];
RTframeStats out_stats;
RTsurface out_surfaces[2];
RTclosestPoint out_closest;
const RThit no_hits[2] = {{-1, 0, 0, 0, 0, 0}, {-1, 0, 0, 0, 0, 0}};
const RThit strange_hits[1] = {{1, 0, 0, 0, 12345, 0}};
const RTquery query_of_unknown_flags = {0x80, 0, NULL, NULL, NULL};
void *out_pointer;
RTfloat pixels[4 * 4 * 4];
char image_file[1024] = "c_api_world.png";
char scene_file[1040];

RTuint object, flat_object, deleted_object, texture, deleted_texture, deleted_shader;
/* 0 in a library without the readers of scene files. */
RTuint loaded;
RTuint shader_class, surface, light, camera, environment, renderer;
RTuint h_1i, h_2i, h_3i, h_4i, h_1f, h_2f, h_3f, h_4f, h_16f, h_string, h_raw, h_texture, foreign_handle;

typedef struct {
    RTint i[4];
    RTfloat f[4], m[16];
    const char *text;
    unsigned char raw[12];
    RTuint texture;
} Block;

static void shade(RTshadingContext *context, const void *params, void *userData, RTfloat *result)
{
    const Block *block = params;
    (void)context, (void)userData;
    result[0] = block->f[0], result[1] = result[2] = 0.5f, result[3] = 1;
}

#define PARAM(name, type, member, size) {name, type, RT_PER_SHADER, (RTuint)offsetof(Block, member), size, NULL}
static const RTshaderParam surface_params[] = {
    PARAM("i1", RT_INT, i, 0),           PARAM("i2", RT_INT_VEC2, i, 0),   PARAM("i3", RT_INT_VEC3, i, 0),
    PARAM("i4", RT_INT_VEC4, i, 0),      PARAM("f1", RT_FLOAT, f, 0),      PARAM("f2", RT_FLOAT_VEC2, f, 0),
    PARAM("f3", RT_FLOAT_VEC3, f, 0),    PARAM("f4", RT_FLOAT_VEC4, f, 0), PARAM("matrix", RT_FLOAT_MAT4, m, 0),
    PARAM("text", RT_STRING, text, 0),   PARAM("raw", RT_RAW, raw, 12),    PARAM("texture", RT_TEXTURE, texture, 0),
};
enum { PARAMS = sizeof surface_params / sizeof surface_params[0] };
#define CLASS(version, kind, name, size, count, params, function) \
    {version, kind, name, size, count, params, function, NULL, NULL, NULL, NULL}
static const RTshaderClass surface_class =
    CLASS(RT_SHADER_CLASS_VERSION, RT_SURFACE_SHADER, "world", sizeof(Block), PARAMS, surface_params, shade);

static inline RTuint shader_of(const char *class_name)
{
    rtGenNewShaderClass(class_name, NULL);
    return rtGenNewShader();
}

/* A scene file of one triangle. */
static inline RTuint load_scene(void)
{
    RTint readers = 0;
    FILE *file;
    snprintf(scene_file, sizeof scene_file, "%s.obj", image_file);
    rtGetIntegerv(RT_SCENE_READERS, &readers);
    if (!readers)
        return 0;
    file = fopen(scene_file, "w");
    CHECK(file != NULL);
    fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nodd 1\n", file);
    fclose(file);
    return rtLoadScene(scene_file, RT_NONE);
}

/* What is in the context is the same after each call. No error is left. */
static inline void setup_without_init(void)
{
    int i;
    for (i = 0; i < 16; i++)
        dnans[i] = nans[i] = NOT_A_NUMBER;
    rtSetFrameSize(4, 4);
    rtPushMatrix();
    rtTranslatef(0, 0, 1);
    light = shader_of("point");
    camera = shader_of("pinhole");
    environment = shader_of("gradient");
    renderer = shader_of("raycast");
    deleted_shader = shader_of("diffuse");
    foreign_handle = rtParameterHandle("color");
    rtDeleteShader(deleted_shader);
    shader_class = rtRegisterShaderClass(&surface_class);
    surface = rtGenNewShader();
    h_1i = rtParameterHandle("i1"), h_2i = rtParameterHandle("i2"), h_3i = rtParameterHandle("i3");
    h_4i = rtParameterHandle("i4"), h_1f = rtParameterHandle("f1"), h_2f = rtParameterHandle("f2");
    h_3f = rtParameterHandle("f3"), h_4f = rtParameterHandle("f4"), h_16f = rtParameterHandle("matrix");
    h_string = rtParameterHandle("text"), h_raw = rtParameterHandle("raw"), h_texture = rtParameterHandle("texture");

    object = rtGenObjects(3);
    flat_object = object + 1;
    deleted_object = object + 2;
    rtDeleteObjects(deleted_object, 1);
    for (i = 0; i < 2; i++) {
        rtNewObject(object + (RTuint)i, RT_COMPILE | RT_UNSTRUCTURED);
        rtBegin(RT_TRIANGLES);
        if (i == 0)
            rtNormal3f(0, 0, 1);
        rtVertex3f(-1, -1, -4);
        rtVertex3f(1, -1, -4);
        rtVertex3f(0, 1, -4);
        rtEnd();
        rtEndObject();
    }

    rtGenTextures(1, &texture);
    rtGenTextures(1, &deleted_texture);
    rtDeleteTextures(1, &deleted_texture);
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGBA, 2, 2, 0, RT_RGBA, RT_UNSIGNED_BYTE, ubytes);

    rtVertexPointer(3, RT_FLOAT, 0, floats);
    rtEnableClientState(RT_VERTEX_ARRAY);
    rtPerspective(60, 1, 1, 100);
    loaded = load_scene();
    rtInstantiateObject(object);
    rtRender();
    rtWriteImage(image_file);
    rtInstantiateObject(object);
    CHECK(rtGetError() == RT_NO_ERROR);
}

static inline void setup(void)
{
    rtInit(NULL, NULL);
    setup_without_init();
}

/* ---- the whole state as text ---- */

char state_text[1 << 16];
size_t state_length;

static inline void note_doubles(const char *what, const RTdouble *values, int n)
{
    int i;
    state_length += (size_t)snprintf(state_text + state_length, sizeof state_text - state_length, "%s", what);
    for (i = 0; i < n; i++)
        state_length += (size_t)snprintf(state_text + state_length, sizeof state_text - state_length, " %a", values[i]);
    state_length += (size_t)snprintf(state_text + state_length, sizeof state_text - state_length, "\n");
    CHECK(state_length < sizeof state_text);
}

static inline void note_int(const char *what, RTint value)
{
    RTdouble number = value;
    note_doubles(what, &number, 1);
}

#define STATE(name, n)                       \
    do {                                     \
        RTdouble v[16];                      \
        rtGetDoublev(name, v);               \
        note_doubles(#name, v, n);           \
    } while (0)
#define INT_OF(call, ...)                    \
    do {                                     \
        RTint v = 0;                         \
        call(__VA_ARGS__, &v);               \
        note_int(#call " " #__VA_ARGS__, v); \
    } while (0)

/* Everything that a getter tells. Only outside rtBegin and rtEnd. */
static inline const char *snapshot(void)
{
    RTuint o;
    RTint iv[4];
    RTfloat fv[16];
    void *pointer;
    int k, i;
    const RTuint handles_i[] = {h_1i, h_2i, h_3i, h_4i, h_texture}, handles_f[] = {h_1f, h_2f, h_3f, h_4f};
    state_length = 0;
    STATE(RT_MATRIX, 16);
    STATE(RT_MATRIX_STACK_DEPTH, 1);
    STATE(RT_CURRENT_COLOR, 4);
    STATE(RT_CURRENT_NORMAL, 3);
    STATE(RT_CURRENT_TEXTURE_COORDS, 4);
    STATE(RT_CURRENT_OBJECT, 1);
    STATE(RT_CURRENT_OBJECT_MODE, 1);
    STATE(RT_SHADER_CLASS_BINDING, 1);
    STATE(RT_SHADER_BINDING, 1);
    STATE(RT_TEXTURE_BINDING_2D, 1);
    STATE(RT_CAMERA, 1);
    STATE(RT_ENVIRONMENT, 1);
    STATE(RT_CURRENT_RENDERING_OBJECT, 1);
    STATE(RT_LIGHT_COUNT, 1);
    STATE(RT_INSTANCE_COUNT, 1);
    STATE(RT_COLOR_CLEAR_VALUE, 4);
    STATE(RT_VIEWPORT, 4);
    STATE(RT_FRAME_SIZE, 2);
    STATE(RT_SAMPLES_PER_PIXEL, 1);
    STATE(RT_RAY_DEPTH, 1);
    STATE(RT_RENDERING, 1);
    STATE(RT_FRAME_NUMBER, 1);
    STATE(RT_TOPLEVEL, 1);
    STATE(RT_SUBSAMPLING, 1);
    STATE(RT_UPSAMPLING, 1);
    STATE(RT_FRAMELESS, 1);
    STATE(RT_TIME_BUDGET, 1);
    STATE(RT_FRAMEBUFFER_SRGB, 1);
    STATE(RT_ORIGIN_TOP_LEFT, 1);
    STATE(RT_ACCUMULATE, 1);
    STATE(RT_PROGRESSIVE, 1);
    STATE(RT_VERTEX_ARRAY, 1);
    STATE(RT_VERTEX_ARRAY_SIZE, 1);
    STATE(RT_VERTEX_ARRAY_TYPE, 1);
    STATE(RT_VERTEX_ARRAY_STRIDE, 1);
    STATE(RT_NORMAL_ARRAY, 1);
    STATE(RT_NORMAL_ARRAY_TYPE, 1);
    STATE(RT_NORMAL_ARRAY_STRIDE, 1);
    STATE(RT_COLOR_ARRAY, 1);
    STATE(RT_COLOR_ARRAY_SIZE, 1);
    STATE(RT_COLOR_ARRAY_TYPE, 1);
    STATE(RT_COLOR_ARRAY_STRIDE, 1);
    STATE(RT_TEXTURE_COORD_ARRAY, 1);
    STATE(RT_TEXTURE_COORD_ARRAY_SIZE, 1);
    STATE(RT_TEXTURE_COORD_ARRAY_TYPE, 1);
    STATE(RT_TEXTURE_COORD_ARRAY_STRIDE, 1);
    rtGetPointerv(RT_VERTEX_ARRAY_POINTER, &pointer);
    note_int("vertex array moved", pointer != floats && pointer != NULL);
    rtGetPointerv(RT_COLOR_ARRAY_POINTER, &pointer);
    note_int("colour array is set", pointer != NULL);
    for (o = object; o < object + 2; o++) {
        INT_OF(rtGetObjectParameteriv, o, RT_UPDATE_STRATEGY);
        INT_OF(rtGetObjectParameteriv, o, RT_MOTION);
        INT_OF(rtGetObjectParameteriv, o, RT_SPATIAL_SPLITS);
        INT_OF(rtGetObjectParameteriv, o, RT_TRIANGLE_COUNT);
        INT_OF(rtGetObjectParameteriv, o, RT_VERTEX_COUNT);
        INT_OF(rtGetObjectParameteriv, o, RT_LAZY_CUT);
        INT_OF(rtGetObjectParameteriv, o, RT_LAZY_LEVELS);
        INT_OF(rtGetObjectParameteriv, o, RT_OBJECT_TIME);
    }
    note_int("deleted object", rtIsObject(deleted_object));
    note_int("loaded scene", rtIsLoadedScene(loaded));
    note_int("texture", rtIsTexture(texture));
    note_int("deleted texture", rtIsTexture(deleted_texture));
    for (o = light; o <= surface; o++)
        note_int("shader", rtIsShader(o));
    INT_OF(rtGetIntegerv, RT_TEXTURE_BINDING_2D);
    rtGetIntegerv(RT_TEXTURE_BINDING_2D, iv);
    if (iv[0]) {
        INT_OF(rtGetTexParameteriv, RT_TEXTURE_2D, RT_TEXTURE_WIDTH);
        INT_OF(rtGetTexParameteriv, RT_TEXTURE_2D, RT_TEXTURE_HEIGHT);
        INT_OF(rtGetTexParameteriv, RT_TEXTURE_2D, RT_TEXTURE_WRAP_S);
        INT_OF(rtGetTexParameteriv, RT_TEXTURE_2D, RT_TEXTURE_WRAP_T);
        INT_OF(rtGetTexParameteriv, RT_TEXTURE_2D, RT_TEXTURE_MIN_FILTER);
        INT_OF(rtGetTexParameteriv, RT_TEXTURE_2D, RT_TEXTURE_MAG_FILTER);
        INT_OF(rtGetTexParameteriv, RT_TEXTURE_2D, RT_TEXTURE_COLOR_SPACE);
    }
    for (k = 0; k < 5; k++) {
        rtGetParameteriv(handles_i[k], iv);
        for (i = 0; i < 4; i++)
            note_int("integer parameter", iv[i]);
    }
    for (k = 0; k < 4; k++) {
        rtGetParameterfv(handles_f[k], fv);
        for (i = 0; i < 4; i++)
            note_int("float parameter", (RTint)(fv[i] * 1024));
    }
    rtGetParameterfv(h_16f, fv);
    for (i = 0; i < 16; i++)
        note_int("matrix parameter", (RTint)(fv[i] * 1024));
    note_int("text parameter", (RTint)strlen(rtGetParameterString(h_string)));
    rtGetFrameStats(&out_stats);
    note_int("rays of the last frame", (RTint)out_stats.primaryRays);
    CHECK(rtGetError() == RT_NO_ERROR);
    return state_text;
}

#endif
