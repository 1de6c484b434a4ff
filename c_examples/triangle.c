/* triangle.c - the first picture: one triangle with a colour at each corner. */
#include "example.h"

int main(int argc, char **argv)
{
    Example e;
    RTuint triangle;

    rtInit(&argc, argv);
    e = exampleOptions(argc, argv, 1);
    rtViewport(0, 0, e.width, e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtClearColor(0.02f, 0.02f, 0.03f, 1);
    rtPerspective(45, (RTdouble)e.width / e.height, 0.1, 100);
    rtLookAt(0, 0, 3, 0, 0, 0, 0, 1, 0);

    /* Surfaces without a light are shown as seen with a lamp at the eye; `constant` shows the colour itself. */
    rtGenNewShaderClass("constant", NULL);
    rtGenNewShader();

    triangle = rtGenObjects(1);
    rtNewObject(triangle, RT_COMPILE);
    rtBegin(RT_TRIANGLES);
    rtColor3f(1, 0, 0);
    rtVertex3f(-1, -0.8f, 0);
    rtColor3f(0, 1, 0);
    rtVertex3f(1, -0.8f, 0);
    rtColor3f(0, 0, 1);
    rtVertex3f(0, 0.9f, 0);
    rtEnd();
    rtEndObject();

    rtInstantiateObject(triangle);
    rtRender();
    exampleWrite(&e, "triangle", 0);
    return exampleEnd();
}
