/* Contexts and threads: each thread renders in a context of its own; contexts wander; a thread that ends lets go; frames are cancelled from elsewhere. */
#include "check.h"

#include <pthread.h>

enum { THREADS = 4, ROUNDS = 8 };

static void draw(float x)
{
    rtBegin(RT_TRIANGLES);
    rtColor3f(1, 0.5f, 0.25f);
    rtVertex3f(-1 + x, -1, -4);
    rtVertex3f(1 + x, -1, -4);
    rtVertex3f(x, 1, -4);
    rtEnd();
}

static void render_into(RTubyte *image, float x)
{
    rtSetFrameBuffer(image, 16, 16, RT_RGBA8);
    draw(x);
    rtRender();
    CHECK(rtGetError() == RT_NO_ERROR);
}

static void *own_context(void *expected)
{
    int round;
    for (round = 0; round < ROUNDS; round++) {
        RTubyte image[16 * 16 * 4];
        const RTuint context = rtCreateContext();
        CHECK(context != 0);
        rtMakeCurrent(context);
        render_into(image, 0.25f);
        CHECK(memcmp(image, expected, sizeof image) == 0);
        rtDestroyContext(context);
        CHECK(rtGetCurrentContext() == 0 && rtGetError() == RT_NO_ERROR);
    }
    return NULL;
}

/* Takes the context, and ends while it is current. */
static void *takes_and_ends(void *context)
{
    RTubyte image[16 * 16 * 4];
    rtMakeCurrent(*(RTuint *)context);
    CHECK(rtGetCurrentContext() == *(RTuint *)context);
    render_into(image, 0);
    return NULL;
}

static void *cancels(void *context)
{
    rtCancelContext(*(RTuint *)context);
    CHECK(rtGetError() == RT_NO_ERROR);
    return NULL;
}

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t told = PTHREAD_COND_INITIALIZER;
static int frames_done, frames_cancelled;

static void on_frame(RTboolean cancelled, void *userData)
{
    CHECK(userData == &frames_done);
    CHECK(rtGetCurrentContext() == 0);
    pthread_mutex_lock(&mutex);
    frames_done++;
    frames_cancelled += cancelled;
    pthread_cond_signal(&told);
    pthread_mutex_unlock(&mutex);
}

int main(void)
{
    RTubyte expected[16 * 16 * 4], image[16 * 16 * 4];
    RTfloat pixels[4 * 4 * 4];
    RTfloat *large;
    pthread_t threads[THREADS];
    RTuint context;
    RTframeStats stats;
    int i;

    rtInit(NULL, NULL);
    context = rtGetCurrentContext();
    render_into(expected, 0.25f);
    for (i = 0; i < THREADS; i++)
        CHECK(pthread_create(&threads[i], NULL, own_context, expected) == 0);
    render_into(image, 0.25f);
    CHECK(memcmp(image, expected, sizeof image) == 0);
    for (i = 0; i < THREADS; i++)
        CHECK(pthread_join(threads[i], NULL) == 0);

    /* Free, then taken by a thread that ends with it, then ours again. */
    rtMakeCurrent(0);
    CHECK(pthread_create(&threads[0], NULL, takes_and_ends, &context) == 0);
    CHECK(pthread_join(threads[0], NULL) == 0);
    rtMakeCurrent(context);
    CHECK(rtGetError() == RT_NO_ERROR && rtGetCurrentContext() == context);

    /* Asynchronous frames: the next one is assembled meanwhile; a callback tells of the end. */
    rtFrameCallback(on_frame, &frames_done);
    for (i = 0; i < 3; i++) {
        rtSetFrameBuffer(i % 2 ? image : expected, 16, 16, RT_RGBA8);
        draw(0.25f);
        rtStartRendering();
        draw(5);
        CHECK(rtGetError() == RT_NO_ERROR);
        pthread_mutex_lock(&mutex);
        while (frames_done <= i)
            pthread_cond_wait(&told, &mutex);
        pthread_mutex_unlock(&mutex);
        rtEndRendering();
        rtSetFrameBuffer(pixels, 4, 4, RT_RGBA32F);
        rtFrameCallback(NULL, NULL);
        rtRender(); /* shows what was drawn at x = 5, and empties the frame */
        rtFrameCallback(on_frame, &frames_done);
    }
    CHECK(memcmp(image, expected, sizeof image) == 0);
    CHECK(frames_cancelled == 0);

    /* A frame that takes long is cancelled from another thread, and from this one. */
    large = malloc(sizeof *large * 4 * 1024 * 1024);
    CHECK(large != NULL);
    rtSamplesPerPixel(4096);
    rtSetFrameBuffer(large, 1024, 1024, RT_RGBA32F);
    for (i = 0; i < 2; i++) {
        draw(0);
        rtStartRendering();
        CHECK(!rtWaitFrame(1) && !rtIsFrameDone());
        if (i == 0) {
            CHECK(pthread_create(&threads[0], NULL, cancels, &context) == 0);
            CHECK(pthread_join(threads[0], NULL) == 0);
        } else {
            rtCancel();
        }
        rtEndRendering();
        CHECK(rtIsFrameDone());
        rtGetFrameStats(&stats);
        CHECK(stats.cancelled && rtGetError() == RT_NO_ERROR);
    }
    CHECK(frames_cancelled == 2);

    /* Destroyed in mid-frame: waits until nobody writes to the memory any more. */
    draw(0);
    rtStartRendering();
    rtExit();
    free(large);
    CHECK(rtGetCurrentContext() == 0 && frames_cancelled == 3);
    return 0;
}
