/* After fork() the child goes on with the context, although its pool of threads stayed behind; so does the parent. */
#include "world.h"

#include <sys/wait.h>
#include <unistd.h>

static RTubyte image[64 * 64 * 4];

static void render(void)
{
    rtInstantiateObject(object);
    rtRender();
    CHECK(rtGetError() == RT_NO_ERROR);
}

/* A child that is born while a frame is rendered goes on: the frame is the parent's, everything else is there. */
static void fork_in_mid_frame(const RTubyte *expected)
{
    int status;
    pid_t child;
    rtSamplesPerPixel(4096);
    rtInstantiateObject(object);
    rtStartRendering();
    CHECK(!rtIsFrameDone());
    fflush(NULL);
    child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        CHECK(rtIsFrameDone() && rtWaitFrame(60000));
        rtEndRendering();
        CHECK(rtGetError() == RT_INVALID_OPERATION);
        rtSamplesPerPixel(1);
        memset(image, 0, sizeof image);
        render();
        CHECK(memcmp(image, expected, sizeof image) == 0);
        rtUpdateVertices(object, 0, 1, 0, floats);
        render();
        CHECK(memcmp(image, expected, sizeof image) != 0);
        rtExit();
        _exit(rtGetError() != RT_NO_ERROR);
    }
    rtCancel();
    rtEndRendering();
    CHECK(rtGetError() == RT_NO_ERROR);
    CHECK(waitpid(child, &status, 0) == child && status == 0);
    rtSamplesPerPixel(1);
    memset(image, 0, sizeof image);
    render();
    CHECK(memcmp(image, expected, sizeof image) == 0);
}

int main(void)
{
    RTubyte expected[sizeof image];
    int status, generation;
    pid_t child;
    setup();
    rtSetFrameBuffer(image, 64, 64, RT_RGBA8);
    render();
    memcpy(expected, image, sizeof image);
    for (generation = 0; generation < 3; generation++) {
        fflush(NULL);
        child = fork();
        CHECK(child >= 0);
        if (child == 0) {
            /* The old picture; new geometry; a context of the child's own; a grandchild. */
            memset(image, 0, sizeof image);
            render();
            CHECK(memcmp(image, expected, sizeof image) == 0);
            rtObjectParameteri(object, RT_UPDATE_STRATEGY, RT_SAH);
            rtUpdateVertices(object, 0, 1, 0, floats);
            render();
            CHECK(memcmp(image, expected, sizeof image) != 0);
            rtMakeCurrent(rtCreateContext());
            setup_without_init();
            if (generation == 1) {
                child = fork();
                CHECK(child >= 0);
                if (child == 0) {
                    rtRender();
                    _exit(rtGetError() != RT_NO_ERROR);
                }
                CHECK(waitpid(child, &status, 0) == child && status == 0);
            }
            /* Leaving by exit() runs the destructors of a library whose threads are gone. */
            if (generation == 2)
                exit(0);
            rtExit();
            _exit(rtGetError() != RT_NO_ERROR);
        }
        CHECK(waitpid(child, &status, 0) == child && status == 0);
        memset(image, 0, sizeof image);
        render();
        CHECK(memcmp(image, expected, sizeof image) == 0);
    }
    fork_in_mid_frame(expected);
    rtExit();
    remove(image_file);
    return 0;
}
