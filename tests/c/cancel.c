/* A frame that would take days ends soon after it is cancelled, whatever takes so long; averages stay as they were. */
#include "check.h"

#include <time.h>
#include <unistd.h>

enum { SIDE = 32 };

static void wait_us(long microseconds)
{
    struct timespec time = {0, 0};
    time.tv_nsec = 1000 * microseconds;
    nanosleep(&time, NULL);
}

/* Days or years of work; a cancelled frame has to end within seconds on the slowest machine. */
static void cancelled(const char *what)
{
    RTframeStats stats;
    rtStartRendering();
    wait_us(20000);
    CHECK(!rtIsFrameDone());
    rtCancel();
    if (!rtWaitFrame(20000)) {
        fprintf(stderr, "%s: the frame does not end\n", what);
        _exit(1);
    }
    rtEndRendering();
    CHECK(rtGetError() == RT_NO_ERROR);
    rtGetFrameStats(&stats);
    CHECK(stats.cancelled);
}

static RTuint renderer(const char *name, const char *parameter, RTint value)
{
    RTuint shader;
    rtGenNewShaderClass(name, NULL);
    shader = rtGenNewShader();
    rtParameter1i(rtParameterHandle(parameter), value);
    CHECK(rtGetError() == RT_NO_ERROR);
    return shader;
}

static void scene(void)
{
    rtBegin(RT_TRIANGLES);
    rtVertex3f(-90, -90, -3), rtVertex3f(90, -90, -3), rtVertex3f(0, 190, -3);
    rtEnd();
}

static RTuint object;
static RTfloat two[SIDE * SIDE * 4], three[SIDE * SIDE * 4], seen[SIDE * SIDE * 4];

/* Renders so many frames that are averaged. */
static void average(int frames)
{
    rtDisable(RT_ACCUMULATE);
    rtInstantiateObject(object), rtRender();
    rtEnable(RT_ACCUMULATE);
    while (frames-- > 0)
        rtInstantiateObject(object), rtRender();
}

static void read_picture(RTfloat *pixels)
{
    rtReadPixels(0, 0, SIDE, SIDE, RT_RGBA, RT_FLOAT, pixels);
    CHECK(rtGetError() == RT_NO_ERROR);
}

/* A frame of averages that is cancelled adds a whole tile of 16 by 16 pixels to them, or nothing of it. */
static void averages_are_whole(void)
{
    RTframeStats stats;
    int attempt, x, y, whole = 0, were_cancelled = 0;
    object = rtGenObjects(1);
    rtNewObject(object, RT_COMPILE);
    scene();
    /* Some of the sky is hidden: what is seen of it differs from frame to frame. */
    rtBegin(RT_TRIANGLES);
    rtVertex3f(2, -90, -3), rtVertex3f(2, 90, -3), rtVertex3f(2, 0, 5);
    rtEnd();
    rtEndObject();
    rtUseRenderingObject(renderer("ambient_occlusion", "samples", 300));
    average(3), read_picture(three);
    average(2), read_picture(two);
    CHECK(memcmp(two, three, sizeof two) != 0);
    for (attempt = 0; attempt < 8; attempt++) {
        average(2);
        rtInstantiateObject(object);
        rtStartRendering();
        wait_us(1000 + 4000 * attempt);
        rtCancel();
        rtEndRendering();
        rtGetFrameStats(&stats);
        were_cancelled += stats.cancelled != 0;
        read_picture(seen);
        for (y = 0; y < SIDE; y += 16)
            for (x = 0; x < SIDE; x += 16) {
                int row, of_two = 1, of_three = 1;
                for (row = 0; row < 16; row++) {
                    size_t at = (size_t)((y + row) * SIDE + x) * 4, bytes = 16 * 4 * sizeof(RTfloat);
                    of_two &= memcmp(seen + at, two + at, bytes) == 0;
                    of_three &= memcmp(seen + at, three + at, bytes) == 0;
                }
                CHECK(of_two || of_three);
                whole++;
            }
    }
    CHECK(whole == 8 * 4);
    CHECK(were_cancelled > 0);
}

int main(void)
{
    RTuint ambient_occlusion, path, light;
    rtInit(NULL, NULL);
    rtViewport(0, 0, SIDE, SIDE);

    ambient_occlusion = renderer("ambient_occlusion", "samples", 65536);
    rtUseRenderingObject(ambient_occlusion);
    rtSamplesPerPixel(65536);
    scene(), cancelled("ambient occlusion");

    path = renderer("path", "max_depth", 1000000);
    rtUseRenderingObject(path);
    scene(), cancelled("path");

    rtUseRenderingObject(0);
    scene(), cancelled("samples per pixel");

    /* Points of area lights. */
    rtGenNewShaderClass("area", NULL);
    light = rtGenNewShader();
    rtParameter1i(rtParameterHandle("samples"), 65536);
    rtUseLight(light);
    CHECK(rtGetError() == RT_NO_ERROR);
    scene(), cancelled("area light");
    rtSamplesPerPixel(1);

    averages_are_whole();
    rtExit();
    CHECK(rtGetError() == RT_NO_ERROR);
    return 0;
}
