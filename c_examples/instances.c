/* instances.c - one object, many instances: a turning chain whose links are all the same ring. */
#include "example.h"
#include "shapes.h"

enum { LINKS = 40 };

static RTuint surface(const char *parameter, float r, float g, float b)
{
    const RTuint shader = rtGenNewShader();
    rtParameter3f(rtParameterHandle(parameter), r, g, b);
    return shader;
}

int main(int argc, char **argv)
{
    Example e;
    RTuint link, floor, steel, stone, light, ambient;
    int frame, i;

    rtInit(&argc, argv);
    e = exampleOptions(argc, argv, 8);
    rtViewport(0, 0, e.width, e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtSamplesPerPixel(4);
    rtClearColor(0.35f, 0.45f, 0.6f, 1);
    rtPerspective(40, (RTdouble)e.width / e.height, 0.1, 100);
    rtLookAt(0, 7, 13, 0, 1.2, 0, 0, 1, 0);

    rtGenNewShaderClass("metal", NULL);
    steel = surface("color", 0.9f, 0.75f, 0.4f);
    rtGenNewShaderClass("diffuse", NULL);
    stone = surface("color", 0.5f, 0.5f, 0.5f);
    rtGenNewShaderClass("directional", NULL);
    light = surface("direction", -0.4f, -1, -0.3f);

    rtGenNewShaderClass("ambient", NULL);
    ambient = surface("color", 1, 1, 1);

    link = rtGenObjects(2);
    rtNewObject(link, RT_COMPILE);
    rtBindShader(steel);
    rtPushMatrix();
    rtScalef(1.5f, 1, 1);
    solidTorus(0.12, 0.42, 24, 48);
    rtPopMatrix();
    rtEndObject();

    floor = link + 1;
    rtNewObject(floor, RT_COMPILE | RT_STATIC);
    rtBindShader(stone);
    solidFloor(40);
    rtEndObject();

    for (frame = 0; frame < e.frames; frame++) {
        rtUseLight(ambient);
        rtUseLight(light);
        rtInstantiateObject(floor);
        for (i = 0; i < LINKS; i++) {
            rtPushMatrix();
            rtRotatef(360.0f * i / LINKS + 2 * 360.0f / LINKS * frame / e.frames, 0, 1, 0);
            rtTranslatef(0, 1.6f + 0.8f * (float)sin(4 * PI * i / LINKS), 5);
            rtRotatef(i % 2 ? 45.0f : -45.0f, 1, 0, 0);
            rtInstantiateObject(link);
            rtPopMatrix();
        }
        rtRender();
        exampleWrite(&e, "instances", frame);
    }
    return exampleEnd();
}
