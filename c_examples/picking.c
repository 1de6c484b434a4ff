/* picking.c - which object is under the mouse? rtPick asks the last frame, rtIntersectRays any ray in the scene. */
#include "example.h"
#include "shapes.h"

enum { SHAPES = 4, ROWS = 3 };

static RTuint object[SHAPES], floor_, light, ambient;

static RTuint surface(const char *parameter, float r, float g, float b)
{
    const RTuint shader = rtGenNewShader();
    rtParameter3f(rtParameterHandle(parameter), r, g, b);
    return shader;
}

static void makeShapes(void)
{
    static const float colors[SHAPES][3] = {{0.8f, 0.2f, 0.1f}, {0.2f, 0.6f, 0.2f}, {0.1f, 0.3f, 0.8f}, {0.8f, 0.6f, 0.1f}};
    const RTuint first = rtGenObjects(SHAPES + 1);
    int i;
    rtGenNewShaderClass("diffuse", NULL);
    for (i = 0; i < SHAPES; i++) {
        object[i] = first + (RTuint)i;
        rtNewObject(object[i], RT_COMPILE);
        surface("color", colors[i][0], colors[i][1], colors[i][2]);
        switch (i) {
        case 0: solidSphere(0.8, 48, 24); break;
        case 1: solidCube(1.2); break;
        case 2: solidTorus(0.25, 0.6, 24, 48); break;
        default: solidCone(0.8, 0, 1.4, 48); break;
        }
        rtEndObject();
    }
    floor_ = first + SHAPES;
    rtNewObject(floor_, RT_COMPILE | RT_STATIC);
    surface("color", 0.5f, 0.5f, 0.5f);
    solidFloor(40);
    rtEndObject();
}

/* One frame; the instance `picked` is drawn higher, as if it were lifted by the mouse. */
static void draw(RTuint picked)
{
    int i;
    rtUseLight(ambient);
    rtUseLight(light);
    for (i = 0; i < SHAPES * ROWS; i++) {
        rtPushMatrix();
        rtTranslatef(2.4f * (float)(i % SHAPES) - 3.6f, (RTuint)i == picked ? 2.2f : 0.9f, -2.6f * (float)(i / SHAPES));
        rtInstantiateObject(object[(i + i / SHAPES) % SHAPES]);
        rtPopMatrix();
    }
    rtInstantiateObject(floor_);
    rtRender();
}

int main(int argc, char **argv)
{
    Example e;
    RThit hit;
    RTray ray = {{0, 10, 0}, 0, {0, -1, 0}, 1000};
    int click;

    rtInit(&argc, argv);
    e = exampleOptions(argc, argv, 4);
    rtViewport(0, 0, e.width, e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtClearColor(0.3f, 0.4f, 0.55f, 1);
    rtPerspective(40, (RTdouble)e.width / e.height, 0.1, 100);
    rtLookAt(0, 5, 10, 0, 0.5, -2, 0, 1, 0);
    makeShapes();
    rtGenNewShaderClass("directional", NULL);
    light = surface("direction", -0.5f, -1, -0.5f);
    rtGenNewShaderClass("ambient", NULL);
    ambient = surface("color", 1, 1, 1);

    for (click = 0; click < e.frames; click++) {
        /* Clicks walk across the picture; pixels count from the lower left corner. */
        const float x = (float)e.width * (0.2f + 0.6f * (float)click / (float)e.frames), y = (float)e.height * 0.4f;
        draw(SHAPES * ROWS);
        rtPick(x, y, &hit);
        if (hit.object)
            printf("pixel (%.0f, %.0f): object %u, instance %u, triangle %u, %.2f away\n", x, y, hit.object, hit.instance,
                   hit.primitive, hit.t);
        else
            printf("pixel (%.0f, %.0f): nothing\n", x, y);
        draw(hit.object && hit.object != floor_ ? hit.instance : SHAPES * ROWS);
        exampleWrite(&e, "picking", click);
    }

    rtIntersectRays(1, &ray, &hit, 0);
    printf("straight down from (0, 10, 0): object %u at height %.2f\n", hit.object, ray.origin[1] - hit.t);
    return exampleEnd();
}
