/* lights.c - lights, shadows, a mirror and glass: what display lists could not do, with one call each. */
#include "example.h"
#include "shapes.h"

/* A shader of a built-in class, with one colour, position or direction set. It stays bound. */
static RTuint make(const char *name, const char *parameter, float x, float y, float z)
{
    RTuint shader;
    rtGenNewShaderClass(name, NULL);
    shader = rtGenNewShader();
    rtParameter3f(rtParameterHandle(parameter), x, y, z);
    return shader;
}

/* Squares of two colours on a floor that receives everything else's shadow. */
static void chessBoard(void)
{
    int i, j;
    make("phong", "reflection", 0.08f, 0.08f, 0.08f);
    rtBegin(RT_QUADS);
    rtNormal3f(0, 1, 0);
    for (i = -8; i < 8; i++) {
        for (j = -8; j < 8; j++) {
            const float shade = (i + j) % 2 ? 0.15f : 0.8f;
            rtColor3f(shade, shade, shade);
            rtVertex3f((float)i, 0, (float)j + 1);
            rtVertex3f((float)i + 1, 0, (float)j + 1);
            rtVertex3f((float)i + 1, 0, (float)j);
            rtVertex3f((float)i, 0, (float)j);
        }
    }
    rtEnd();
}

int main(int argc, char **argv)
{
    Example e;
    RTuint spot, lamp, ambient, sky, objects;
    int i;

    rtInit(&argc, argv);
    e = exampleOptions(argc, argv, 1);
    rtViewport(0, 0, e.width, e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtSamplesPerPixel(4);
    rtPerspective(38, (RTdouble)e.width / e.height, 0.1, 100);
    rtLookAt(0, 3.4, 9, 0, 0.9, 0, 0, 1, 0);

    spot = make("spot", "position", -5, 6, -1.5f);
    rtParameter3f(rtParameterHandle("direction"), 5, -6, 1.5f);
    rtParameter3f(rtParameterHandle("color"), 0.9f, 0.85f, 0.7f);
    rtParameter1f(rtParameterHandle("cutoff"), 32);
    rtParameter1f(rtParameterHandle("penumbra"), 10);

    lamp = make("area", "position", 4, 5, -2);
    rtParameter3f(rtParameterHandle("edge_u"), 0, 0, 1.5f);
    rtParameter3f(rtParameterHandle("edge_v"), -1.5f, 0, 0);
    rtParameter3f(rtParameterHandle("color"), 0.35f, 0.4f, 0.5f);

    ambient = make("ambient", "color", 0.3f, 0.3f, 0.4f);
    sky = make("gradient", "top", 0.1f, 0.2f, 0.5f);

    objects = rtGenObjects(4);
    rtNewObject(objects, RT_COMPILE | RT_STATIC);
    chessBoard();
    rtEndObject();

    rtNewObject(objects + 1, RT_COMPILE);
    make("mirror", "color", 0.95f, 0.95f, 0.95f);
    rtColor3f(1, 1, 1);
    solidSphere(1, 96, 48);
    rtEndObject();

    rtNewObject(objects + 2, RT_COMPILE);
    make("glass", "color", 0.95f, 1, 0.97f);
    solidSphere(1, 96, 48);
    rtEndObject();

    rtNewObject(objects + 3, RT_COMPILE);
    make("phong", "diffuse", 0.7f, 0.1f, 0.08f);
    rtParameter3f(rtParameterHandle("specular"), 0.6f, 0.6f, 0.6f);
    rtParameter1f(rtParameterHandle("shininess"), 60);
    solidTorus(0.35, 0.8, 40, 80);
    rtEndObject();

    rtUseEnvironmentShader(sky);
    rtUseLight(ambient);
    rtUseLight(spot);
    rtUseLight(lamp);

    rtInstantiateObject(objects);
    for (i = 0; i < 3; i++) {
        rtPushMatrix();
        rtTranslatef(2.3f * (float)(i - 1), i == 2 ? 1.15f : 1, i == 1 ? 0.8f : -0.4f);
        rtRotatef(i == 2 ? 70.0f : 0.0f, 1, 0, 0.4f);
        rtInstantiateObject(objects + 1 + (RTuint)i);
        rtPopMatrix();
    }
    rtRender();
    exampleWrite(&e, "lights", 0);
    return exampleEnd();
}
