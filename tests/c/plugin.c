/* A shader library for shaders.c, with one good class and some that are wrong. */
#include <openrt/rt.h>

#include <string.h>

const RTshaderClass *openrtQueryShaderClass(const char *name);

static void striped(RTshadingContext *context, const void *params, void *userData, RTfloat *result)
{
    RTsurfacePoint point;
    (void)userData;
    memset(&point, 0, sizeof point);
    rtsGetPoint(context, &point);
    result[0] = point.position[0] > 0;
    result[1] = *(const RTfloat *)params;
    result[2] = 0;
}

static const RTfloat three_quarters = 0.75f;
static const RTshaderParam params[] = {{"green", RT_FLOAT, RT_PER_SHADER, 0, 0, &three_quarters}};

static const RTshaderClass classes[] = {
    {RT_SHADER_CLASS_VERSION, RT_SURFACE_SHADER, "striped", 4, 1, params, striped, 0, 0, 0, 0},
    {2, RT_SURFACE_SHADER, "from the future", 4, 1, params, striped, 0, 0, 0, 0},
    {RT_SHADER_CLASS_VERSION, RT_CAMERA_SHADER, "contradictory", 4, 1, params, striped, 0, 0, 0, 0},
};

const RTshaderClass *openrtQueryShaderClass(const char *name)
{
    unsigned i;
    for (i = 0; i < sizeof classes / sizeof classes[0]; i++)
        if (!strcmp(name, classes[i].name))
            return &classes[i];
    return 0;
}
