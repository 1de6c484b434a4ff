/* plugin_shader.c - a shader library: polished tiles. It asks its context for the lights, for shadows and for a mirror image.
 *
 * Built as plugin_shader.so; plugin.c loads it by name. It needs the header only, not the library. */
#include <math.h>
#include <openrt/rt.h>
#include <stddef.h>
#include <string.h>

/* The parameter block: one value per rtParameterHandle name. */
typedef struct {
    RTfloat light[3], dark[3];
    RTfloat size, polish;
} Tiles;

static const Tiles defaults = {{0.8f, 0.75f, 0.65f}, {0.15f, 0.2f, 0.18f}, 1, 0.04f};

static const RTshaderParam parameters[] = {
    {"light", RT_FLOAT_VEC3, RT_PER_SHADER, offsetof(Tiles, light), 0, defaults.light},
    {"dark", RT_FLOAT_VEC3, RT_PER_SHADER, offsetof(Tiles, dark), 0, defaults.dark},
    {"size", RT_FLOAT, RT_PER_SHADER, offsetof(Tiles, size), 0, &defaults.size},
    {"polish", RT_FLOAT, RT_PER_SHADER, offsetof(Tiles, polish), 0, &defaults.polish},
};

static float dot(const float *a, const float *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Linear RGB that leaves the point towards the ray's origin, and opacity. Runs on several threads at once. */
static void shade(RTshadingContext *context, const void *params, void *userData, RTfloat *result)
{
    const Tiles *tiles = params;
    const float *color;
    float mirrored[3], image[3], sum[3] = {0.1f, 0.1f, 0.1f}, fresnel;
    RTsurfacePoint p;
    RTlightSample light;
    RTuint i;
    int k, odd = 0;

    (void)userData;
    rtsGetPoint(context, &p);

    /* Half a millimetre is added so that a face that lies on the border of two tiles takes one of them. */
    for (k = 0; k < 3; k++)
        odd += (int)floorf(p.position[k] / tiles->size + 0.0005f);
    color = odd & 1 ? tiles->dark : tiles->light;

    for (i = 0; i < rtsLightCount(context); i++) {
        if (rtsIlluminate(context, i, &light)) {
            const float cosine = dot(p.normal, light.direction);
            if (cosine > 0 && !rtsShadowed(context, light.direction, light.distance))
                for (k = 0; k < 3; k++)
                    sum[k] += cosine * light.radiance[k];
        }
    }

    /* Polished stone mirrors more at grazing angles: Schlick's approximation of Fresnel's equations. */
    fresnel = tiles->polish + (1 - tiles->polish) * powf(1 + dot(p.normal, p.incoming), 5);
    rtsReflect(context, mirrored);
    rtsTrace(context, mirrored, image);
    for (k = 0; k < 3; k++)
        result[k] = (1 - fresnel) * color[k] * sum[k] + fresnel * image[k];
    result[3] = 1;
}

static const RTshaderClass tilesClass = {
    RT_SHADER_CLASS_VERSION,
    RT_SURFACE_SHADER,
    "tiles",
    sizeof(Tiles),
    sizeof parameters / sizeof parameters[0],
    parameters,
    shade,
    NULL,
    NULL,
    NULL,
    NULL,
};

/* What rtGenNewShaderClass asks the library for. */
extern const RTshaderClass *openrtQueryShaderClass(const char *name);
const RTshaderClass *openrtQueryShaderClass(const char *name)
{
    return strcmp(name, "tiles") == 0 ? &tilesClass : NULL;
}
