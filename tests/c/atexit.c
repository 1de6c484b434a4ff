/* atexit(rtExit), as GLUT programs do it: contexts are destroyed, also with a frame in flight, and no call made so late does harm. */
#include "world.h"

static RTubyte image[64 * 64 * 4];
static RTuint second;

static void last(void)
{
    RThit hit;
    CHECK(rtGetError() == RT_NO_ERROR);
    rtVertex3f(1, 2, 3);
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    CHECK(rtGetErrorString(RT_INVALID_OPERATION)[0] != 0);
    rtRender();
    CHECK(!rtPick(1, 1, &hit));
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    CHECK(rtGetError() == RT_NO_ERROR);
    /* A context cannot be current any more, but made and destroyed. */
    rtInit(NULL, NULL);
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    rtExit();
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    rtDestroyContext(rtCreateContext());
    CHECK(rtGetError() == RT_NO_ERROR);
    puts("after exit");
}

static void bye(void)
{
    CHECK(rtGetCurrentContext() == 0);
    rtExit();
    CHECK(rtGetError() == RT_NO_ERROR);
    rtDestroyContext(second);
    CHECK(rtGetError() == RT_NO_ERROR);
    remove(image_file);
}

int main(void)
{
    RTuint first;
    setup();
    first = rtGetCurrentContext();
    second = rtCreateContext();
    rtMakeCurrent(second);
    rtViewport(0, 0, 8, 8);
    rtRender();
    rtMakeCurrent(first);
    rtSetFrameBuffer(image, 64, 64, RT_RGBA8);
    rtSamplesPerPixel(64);
    rtInstantiateObject(object);
    rtStartRendering();
    CHECK(rtGetError() == RT_NO_ERROR);
    atexit(last);
    atexit(bye);
    return 0;
}
