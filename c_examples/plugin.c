/* plugin.c - loads a shader class from a library (plugin_shader.c), and uses it like a built-in one. */
#include "example.h"
#include "shapes.h"

/* The library lies beside the program. */
static void libraryPath(char *path, size_t size, const char *program)
{
    const char *slash = strrchr(program, '/');
    if (slash)
        snprintf(path, size, "%.*s/plugin_shader.so", (int)(slash - program), program);
    else
        snprintf(path, size, "./plugin_shader.so");
}

int main(int argc, char **argv)
{
    Example e;
    char path[1024];
    RTuint large, small, sun, lamp, sky, objects;
    int i;

    rtInit(&argc, argv);
    e = exampleOptions(argc, argv, 1);
    rtViewport(0, 0, e.width, e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtPerspective(38, (RTdouble)e.width / e.height, 0.1, 100);
    rtLookAt(0, 3.2, 9, 0, 0.9, 0, 0, 1, 0);

    libraryPath(path, sizeof path, argv[0]);
    rtGenNewShaderClass("tiles", path);
    large = rtGenNewShader();
    small = rtGenNewShader();
    rtParameter1f(rtParameterHandle("size"), 0.25f);
    rtParameter3f(rtParameterHandle("light"), 0.85f, 0.6f, 0.2f);
    rtParameter3f(rtParameterHandle("dark"), 0.3f, 0.05f, 0.05f);
    rtParameter1f(rtParameterHandle("polish"), 0.15f);

    rtGenNewShaderClass("directional", NULL);
    sun = rtGenNewShader();
    rtParameter3f(rtParameterHandle("direction"), -0.9f, -1, 0.3f);
    rtParameter3f(rtParameterHandle("color"), 0.8f, 0.75f, 0.65f);
    rtGenNewShaderClass("point", NULL);
    lamp = rtGenNewShader();
    rtParameter3f(rtParameterHandle("position"), -3, 4, 4);
    rtParameter3f(rtParameterHandle("color"), 0.15f, 0.18f, 0.22f);
    rtGenNewShaderClass("gradient", NULL);
    sky = rtGenNewShader();

    objects = rtGenObjects(3);
    rtNewObject(objects, RT_COMPILE | RT_STATIC);
    rtBindShader(large);
    solidFloor(40);
    rtEndObject();
    rtNewObject(objects + 1, RT_COMPILE);
    rtBindShader(small);
    solidSphere(0.9, 96, 48);
    rtEndObject();
    rtNewObject(objects + 2, RT_COMPILE);
    rtBindShader(small);
    solidCube(1.4);
    rtEndObject();

    rtUseLight(sun);
    rtUseLight(lamp);
    rtUseEnvironmentShader(sky);
    rtInstantiateObject(objects);
    for (i = 0; i < 3; i++) {
        rtPushMatrix();
        rtTranslatef(2.3f * (float)(i - 1), 0.9f, 0);
        rtRotatef(30, 0, 1, 0);
        rtInstantiateObject(objects + (i == 1 ? 2 : 1));
        rtPopMatrix();
    }
    rtRender();
    exampleWrite(&e, "plugin", 0);
    return exampleEnd();
}
