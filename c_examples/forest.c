/* forest.c - 661 instances of two trees on a hill: over ten million triangles in the memory of thirty thousand. */
#include "example.h"
#include "shapes.h"

enum { TREES = 661, GROUND = 200 };

/* A small generator of our own, so that the forest is the same everywhere. 0 <= result < 1. */
static double chance(void)
{
    static unsigned state = 1;
    state = state * 1664525u + 1013904223u;
    return (double)(state >> 8) / 16777216.0;
}

static double between(double low, double high)
{
    return low + (high - low) * chance();
}

static RTuint surface(float r, float g, float b)
{
    const RTuint shader = rtGenNewShader();
    rtParameter3f(rtParameterHandle("color"), r, g, b);
    return shader;
}

static double hill(double x, double z)
{
    return 6 * exp(-(x * x + z * z) / 900) + 0.8 * sin(0.21 * x + 1) * cos(0.17 * z) + 0.25 * sin(0.6 * x) * sin(0.5 * z);
}

static void hillVertex(int i, int j)
{
    const double x = 0.6 * (i - GROUND / 2), z = 0.6 * (j - GROUND / 2), d = 0.01;
    rtNormal3d(hill(x - d, z) - hill(x + d, z), 2 * d, hill(x, z - d) - hill(x, z + d));
    rtVertex3d(x, hill(x, z), z);
}

static void ground(void)
{
    int i, j;
    for (j = 0; j < GROUND; j++) {
        rtBegin(RT_TRIANGLE_STRIP);
        for (i = 0; i <= GROUND; i++) {
            hillVertex(i, j);
            hillVertex(i, j + 1);
        }
        rtEnd();
    }
}

/* A diamond of four triangles that droops from the origin along x, as a leaf or a tuft of needles. */
static void leaf(float length, float width)
{
    const float droop = -0.3f * length;
    rtBegin(RT_TRIANGLE_FAN);
    rtNormal3f(-droop, length, 0);
    rtVertex3f(0.4f * length, 0.1f * length, 0);
    rtVertex3f(0, 0, 0);
    rtVertex3f(0.4f * length, 0, width);
    rtVertex3f(length, droop, 0);
    rtVertex3f(0.4f * length, 0, -width);
    rtVertex3f(0, 0, 0);
    rtEnd();
}

/* Whorls of drooping branches on a straight trunk, each branch set with tufts on both sides. */
static void fir(RTuint bark, RTuint needles)
{
    int whorl, branch, tuft;
    rtBindShader(bark);
    solidCone(0.16, 0.01, 6, 12);
    for (whorl = 0; whorl < 24; whorl++) {
        const double length = 1.7 * (1 - whorl / 25.0) + 0.1;
        for (branch = 0; branch < 10; branch++) {
            rtPushMatrix();
            rtTranslated(0, 0.7 + 0.22 * whorl, 0);
            rtRotated(36 * branch + 17 * whorl + between(-8, 8), 0, 1, 0);
            rtRotated(between(-26, -14), 0, 0, 1);
            rtBindShader(needles);
            for (tuft = 0; tuft < 16; tuft++) {
                rtPushMatrix();
                rtTranslated(length * (tuft + 1) / 16, 0, 0);
                rtRotated(tuft % 2 ? 55 : -55, 0, 1, 0);
                leaf(0.3f * (float)length, 0.05f);
                rtPopMatrix();
            }
            rtPopMatrix();
        }
    }
}

/* A branch that divides `levels` times; the last twigs carry leaves. */
static void branch(int levels, double length, double thickness, RTuint bark, RTuint leaves)
{
    int i;
    rtBindShader(bark);
    solidCone(thickness, 0.7 * thickness, length, levels > 2 ? 10 : 5);
    rtTranslated(0, length, 0);
    if (levels == 0) {
        rtBindShader(leaves);
        for (i = 0; i < 12; i++) {
            rtPushMatrix();
            rtTranslated(between(-0.25, 0.25), between(-0.3, 0.15), between(-0.25, 0.25));
            rtRotated(between(0, 360), 0, 1, 0);
            rtRotated(between(-40, 40), 1, 0, 0);
            leaf(0.3f, 0.1f);
            rtPopMatrix();
        }
        return;
    }
    for (i = 0; i < 4; i++) {
        rtPushMatrix();
        rtRotated(90 * i + between(-25, 25), 0, 1, 0);
        rtRotated(between(22, 50), 0, 0, 1);
        branch(levels - 1, length * between(0.55, 0.75), 0.6 * thickness, bark, leaves);
        rtPopMatrix();
    }
}

int main(int argc, char **argv)
{
    Example e;
    RTframeStats stats;
    RTuint kinds, land, sun, ambient, sky, bark, needles, leaves, grass;
    int i;

    rtInit(&argc, argv);
    e = exampleOptions(argc, argv, 1);
    rtViewport(0, 0, e.width, e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtSamplesPerPixel(4);
    rtPerspective(40, (RTdouble)e.width / e.height, 0.1, 1000);
    rtLookAt(0, 17, 52, 0, 5, 0, 0, 1, 0);

    rtGenNewShaderClass("diffuse", NULL);
    bark = surface(0.22f, 0.14f, 0.08f);
    needles = surface(0.06f, 0.18f, 0.08f);
    leaves = surface(0.25f, 0.35f, 0.06f);
    grass = surface(0.25f, 0.27f, 0.1f);
    rtGenNewShaderClass("directional", NULL);
    sun = rtGenNewShader();
    rtParameter3f(rtParameterHandle("direction"), -1, -1.2f, -0.3f);
    rtParameter3f(rtParameterHandle("color"), 1.6f, 1.5f, 1.3f);
    rtGenNewShaderClass("ambient", NULL);
    ambient = surface(1.2f, 1.4f, 1.8f);
    rtGenNewShaderClass("gradient", NULL);
    sky = rtGenNewShader();

    kinds = rtGenObjects(3);
    rtNewObject(kinds, RT_COMPILE);
    fir(bark, needles);
    rtEndObject();
    rtNewObject(kinds + 1, RT_COMPILE);
    rtPushMatrix();
    branch(4, 1.9, 0.2, bark, leaves);
    rtPopMatrix();
    rtEndObject();
    land = kinds + 2;
    rtNewObject(land, RT_COMPILE | RT_STATIC);
    rtBindShader(grass);
    ground();
    rtEndObject();

    rtUseLight(ambient);
    rtUseLight(sun);
    rtUseEnvironmentShader(sky);
    rtInstantiateObject(land);
    for (i = 0; i < TREES; i++) {
        const double x = between(-45, 45), z = between(-55, 35), size = between(0.7, 1.2);
        rtPushMatrix();
        rtTranslated(x, hill(x, z) - 0.1, z);
        rtRotated(between(0, 360), 0, 1, 0);
        rtScaled(size, size, size);
        rtInstantiateObject(kinds + (RTuint)(chance() < 0.4));
        rtPopMatrix();
    }
    rtRender();
    exampleWrite(&e, "forest", 0);
    rtGetFrameStats(&stats);
    printf("%.0f instances, %.1f million triangles, %.0f MB of structures\n", stats.instances, stats.triangles / 1e6,
           stats.structureBytes / 1e6);
    return exampleEnd();
}
