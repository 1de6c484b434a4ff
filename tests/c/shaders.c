/* Shader classes of C functions, registered and from a shader library: parameters of each kind and scope reach the block, and the rts functions answer. */
#include "check.h"

#include <sys/resource.h>
#include <sys/time.h>

enum { SIZE = 32 };

typedef struct {
    RTfloat color[3];
    RTfloat per_triangle;
    RTint pair[2];
    const char *text;
    RTfloat matrix[16];
    RTuint texture;
    RTfloat per_vertex[2];
    unsigned char raw[3];
} Block;

static int calls, lights_seen; /* shaders run on several threads: only ever set to one value */
static RTsurfacePoint seen;
static RTlightSample lit;

static void shade(RTshadingContext *context, const void *params, void *userData, RTfloat *result)
{
    const Block *block = params;
    RTsurfacePoint point;
    RTlightSample sample;
    RTfloat mirrored[3], traced[3], texel[4];
    const RTfloat up[3] = {0, 1, 0};
    CHECK(userData == &calls);
    CHECK((size_t)params % 16 == 0);
    CHECK(block->pair[0] == 7 && block->pair[1] == -8);
    CHECK(!strcmp(block->text, "a text of the application"));
    CHECK(block->matrix[0] == 1 && block->matrix[13] == 5);
    CHECK(block->raw[0] == 1 && block->raw[2] == 3);
    CHECK(block->per_triangle == 0.25f);
    rtsGetPoint(context, &point);
    CHECK(fabs(point.position[2] + 2) < 1e-4 && point.normal[2] == 1 && point.geometricNormal[2] == 1);
    CHECK(point.depth == 0 && point.object != 0 && !point.backFacing && fabs(point.color[1] - 0.5) < 1e-6);
    /* The parameter per vertex is x + 1 and y: interpolated as the position is. */
    CHECK(fabs(block->per_vertex[0] - (point.position[0] + 1)) < 1e-4);
    CHECK(fabs(block->per_vertex[1] - point.position[1]) < 1e-4);
    CHECK(fabs(point.texCoord[0] - point.position[0]) < 1e-4);
    CHECK(rtsLightCount(context) == 1);
    CHECK(rtsIlluminate(context, 0, &sample) == RT_TRUE);
    CHECK(rtsIlluminate(context, 1, &sample) == RT_FALSE);
    CHECK(rtsIlluminate(context, 0, &sample) == RT_TRUE);
    CHECK(!rtsShadowed(context, up, INFINITY));
    rtsReflect(context, mirrored);
    CHECK(mirrored[2] > 0);
    rtsTrace(context, mirrored, traced);
    CHECK(fabs(traced[2] - 0.75) < 1e-5); /* the environment */
    rtsTexture(context, block->texture, 0.5f, 0.5f, texel);
    CHECK(texel[0] == 1 && texel[1] == 0);
    /* Bad arguments give nothing, and do no harm. */
    rtsGetPoint(context, NULL);
    rtsTrace(context, NULL, traced);
    CHECK(traced[0] == 0);
    rtsTrace(context, mirrored, NULL);
    rtsTexture(context, 12345, 0, 0, texel);
    CHECK(texel[0] == 1 && texel[3] == 1);
    /* No context is current in a shader. */
    CHECK(rtGetCurrentContext() == 0 && rtGenObjects(1) == 0 && rtGetError() == RT_INVALID_OPERATION);
    seen = point, lit = sample, lights_seen = 1, calls = 1;
    result[0] = block->color[0] * sample.radiance[0];
    result[1] = block->color[1];
    result[2] = block->color[2];
    result[3] = 1;
}

static RTboolean illuminate(const void *params, void *userData, const RTfloat *position, RTlightSample *sample)
{
    (void)params, (void)userData, (void)position;
    sample->direction[0] = sample->direction[1] = 0, sample->direction[2] = 1;
    sample->distance = INFINITY;
    sample->radiance[0] = 0.5f, sample->radiance[1] = sample->radiance[2] = 1;
    return RT_TRUE;
}

static RTboolean primary_ray(const void *params, void *userData, RTfloat x, RTfloat y, RTfloat aspect, RTray *ray)
{
    (void)params, (void)userData;
    CHECK(aspect == 1);
    if (x < 0.1f)
        return RT_FALSE;
    ray->origin[0] = ray->origin[1] = ray->origin[2] = 0;
    ray->direction[0] = x - 0.5f, ray->direction[1] = y - 0.5f, ray->direction[2] = -1;
    return RT_TRUE;
}

static void radiance(const void *params, void *userData, const RTfloat *direction, RTfloat *result)
{
    (void)userData, (void)direction;
    memcpy(result, params, 3 * sizeof(RTfloat));
}

static const RTfloat default_color[3] = {0.5f, 0.25f, 0.125f}, blue[3] = {0, 0, 0.75f};
static const RTint default_pair[2] = {7, -8};
static const unsigned char default_raw[3] = {1, 2, 3};

#define AT(member) (RTuint)offsetof(Block, member)
static const RTshaderParam params[] = {
    {"color", RT_FLOAT_VEC3, RT_PER_SHADER, AT(color), 0, default_color},
    {"triangle", RT_FLOAT, RT_PER_TRIANGLE, AT(per_triangle), 0, NULL},
    {"pair", RT_INT_VEC2, RT_PER_SHADER, AT(pair), 0, default_pair},
    {"text", RT_STRING, RT_PER_SHADER, AT(text), 0, "a default"},
    {"matrix", RT_FLOAT_MAT4, RT_PER_SHADER, AT(matrix), 0, NULL},
    {"texture", RT_TEXTURE, RT_PER_SHADER, AT(texture), 0, NULL},
    {"vertex", RT_FLOAT_VEC2, RT_PER_VERTEX, AT(per_vertex), 0, NULL},
    {"raw", RT_RAW, RT_PER_SHADER, AT(raw), 3, default_raw},
};
static const RTshaderParam environment_params[] = {{"color", RT_FLOAT_VEC3, RT_PER_SHADER, 0, 0, blue}};

static RTshaderClass class_of(RTenum kind, const char *name)
{
    RTshaderClass c;
    memset(&c, 0, sizeof c);
    c.version = RT_SHADER_CLASS_VERSION;
    c.kind = kind;
    c.name = name;
    return c;
}

/* What a class says of its sizes is looked at before anything of that size is made. */
static void refused_sizes(void)
{
    static RTshaderParam params[4096];
    static char names[4096][8];
    RTshaderClass c = class_of(RT_SURFACE_SHADER, "large");
    struct rusage before, after;
    unsigned i;
    getrusage(RUSAGE_SELF, &before);
    for (i = 0; i < 4096; i++) {
        const RTshaderParam raw = {names[i], RT_RAW, RT_PER_SHADER, 0, 1 << 20, NULL};
        snprintf(names[i], sizeof names[i], "p%u", i);
        params[i] = raw;
    }
    c.shade = shade, c.params = params;
    c.paramCount = 4096, c.blockSize = 1 << 20; /* all at one place */
    CHECK(rtRegisterShaderClass(&c) == 0 && rtGetError() == RT_INVALID_VALUE);
    CHECK(strstr(rtGetErrorString(RT_INVALID_VALUE), "parameter \"p1\""));
    params[0].size = 0x7fffffff;
    c.paramCount = 1, c.blockSize = 64;
    CHECK(rtRegisterShaderClass(&c) == 0 && rtGetError() == RT_INVALID_VALUE);
    params[0].size = 64;
    c.blockSize = 0x7fffffff;
    CHECK(rtRegisterShaderClass(&c) == 0 && rtGetError() == RT_INVALID_VALUE);
    c.paramCount = 0x7fffffff, c.blockSize = 64;
    CHECK(rtRegisterShaderClass(&c) == 0 && rtGetError() == RT_INVALID_VALUE);
    getrusage(RUSAGE_SELF, &after);
    CHECK(after.ru_maxrss - before.ru_maxrss < 16 << 10); /* KiB */
    c.paramCount = 1;
    CHECK(rtRegisterShaderClass(&c) != 0 && rtGetError() == RT_NO_ERROR);
}

int main(int argc, char **argv)
{
    const RTfloat matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1};
    const RTubyte red[4] = {255, 0, 0, 255};
    static RTfloat image[SIZE][SIZE][4];
    RTshaderClass c;
    RTuint texture, vertex, class_name;
    RTint value;
    int i;
    char path[1024];
    CHECK(argc == 2);
    rtInit(NULL, NULL);
    rtSetFrameBuffer(image, SIZE, SIZE, RT_RGBA32F);
    rtClearColor(9, 9, 9, 1);

    c = class_of(RT_LIGHT_SHADER, "sky light");
    c.illuminate = illuminate;
    rtRegisterShaderClass(&c);
    rtUseLight(rtGenNewShader());
    c = class_of(RT_CAMERA_SHADER, "half-blind");
    c.primaryRay = primary_ray;
    rtRegisterShaderClass(&c);
    rtUseCamera(rtGenNewShader());
    c = class_of(RT_ENVIRONMENT_SHADER, "blue");
    c.radiance = radiance;
    c.params = environment_params, c.paramCount = 1, c.blockSize = 12;
    rtRegisterShaderClass(&c);
    rtUseEnvironmentShader(rtGenNewShader());

    rtGenTextures(1, &texture);
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGBA, 1, 1, 0, RT_RGBA, RT_UNSIGNED_BYTE, red);

    c = class_of(RT_SURFACE_SHADER, "all kinds");
    c.shade = shade;
    c.params = params, c.paramCount = sizeof params / sizeof params[0], c.blockSize = sizeof(Block);
    c.userData = &calls;
    class_name = rtRegisterShaderClass(&c);
    memset(&c, 0xFF, sizeof c); /* was copied */
    rtGetShaderClassiv(class_name, RT_PARAMETER_COUNT, &value);
    CHECK(value == 8 && !strcmp(rtGetShaderClassName(class_name), "all kinds"));
    CHECK(!strcmp(rtGetShaderClassParameterName(class_name, 4), "matrix"));
    rtGetShaderClassParameteriv(class_name, 6, RT_PARAMETER_SCOPE, &value);
    CHECK(value == RT_PER_VERTEX);
    rtGenNewShader();
    vertex = rtParameterHandle("vertex");
    rtParameter1f(rtParameterHandle("triangle"), 0.25f);
    rtParameter16fv(rtParameterHandle("matrix"), matrix);
    rtParameterTexture(rtParameterHandle("texture"), texture);
    CHECK(rtGetError() == RT_NO_ERROR);
    rtBegin(RT_TRIANGLES);
    rtColor3f(0.5f, 0.5f, 0.5f);
    for (i = 0; i < 3; i++) {
        static const RTfloat corner[3][2] = {{-4, -4}, {4, -4}, {0, 4}};
        rtParameter2f(vertex, corner[i][0] + 1, corner[i][1]);
        rtTexCoord2f(corner[i][0], 0);
        rtVertex3f(corner[i][0], corner[i][1], -2);
    }
    rtEnd();
    /* Bound late: set after the geometry, counts for the frame. */
    rtParameterString(rtParameterHandle("text"), "a text of the application");
    rtRender();
    if (rtGetError() != RT_NO_ERROR) {
        fprintf(stderr, "%s\n", rtGetErrorString(rtGetError()));
        return 1;
    }
    CHECK(calls && lights_seen);
    CHECK(image[SIZE / 2][SIZE / 2][0] == 0.25f && image[SIZE / 2][SIZE / 2][1] == 0.25f);
    CHECK(image[SIZE / 2][0][0] == 9);

    refused_sizes();

    /* The class that was asked for before, built in or not. */
    {
        RTuint phong = rtGenNewShaderClass("phong", NULL), metal = rtGenNewShaderClass("metal", NULL);
        RTint bound;
        CHECK(phong != metal && rtGenNewShaderClass("phong", NULL) == phong);
        rtGetIntegerv(RT_SHADER_CLASS_BINDING, &bound);
        CHECK(bound == (RTint)phong);
    }

    /* A shader library: found, refused for each thing that can be wrong with one. */
    snprintf(path, sizeof path, "%s/plugin.so", argv[1]);
    class_name = rtGenNewShaderClass("striped", path);
    CHECK(class_name != 0 && !strcmp(rtGetShaderClassName(class_name), "striped"));
    CHECK(rtGenNewShaderClass("striped", path) == class_name);
    rtGenNewShader();
    rtBegin(RT_TRIANGLES);
    rtVertex3f(-4, -4, -2), rtVertex3f(4, -4, -2), rtVertex3f(0, 4, -2);
    rtEnd();
    rtRender();
    CHECK(rtGetError() == RT_NO_ERROR);
    CHECK(image[SIZE / 2][SIZE / 2 + 1][1] == 0.75f);
    CHECK(rtGenNewShaderClass("no such class", path) == 0);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    CHECK(strstr(rtGetErrorString(RT_INVALID_VALUE), "no such class"));
    CHECK(rtGenNewShaderClass("from the future", path) == 0);
    CHECK(rtGetError() == RT_IO_ERROR);
    CHECK(strstr(rtGetErrorString(RT_IO_ERROR), "version 2"));
    CHECK(rtGenNewShaderClass("contradictory", path) == 0);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    rtExit();
    return 0;
}
