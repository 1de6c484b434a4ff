/* Image files are written and read on a thread with the smallest stack that there is; what the library computes needs none of it. */
#include "check.h"

#include <limits.h>
#include <pthread.h>

static const char *extensions[] = {"png", "jpg", "exr", "hdr", "ppm"};

static void *small(void *unused)
{
    size_t i;
    (void)unused;
    rtInit(NULL, NULL);
    rtViewport(0, 0, 32, 32);
    rtRender();
    for (i = 0; i < sizeof extensions / sizeof extensions[0]; i++) {
        char file[32];
        snprintf(file, sizeof file, "small_stack.%s", extensions[i]);
        rtWriteImage(file);
        CHECK(rtGetError() == RT_NO_ERROR);
        CHECK(rtLoadTexture(file) != 0);
        CHECK(rtGetError() == RT_NO_ERROR);
        remove(file);
    }
    CHECK(rtLoadTexture("small_stack.png") == 0);
    CHECK(rtGetError() == RT_IO_ERROR);
    rtExit();
    return NULL;
}

int main(void)
{
    pthread_attr_t attributes;
    pthread_t thread;
    pthread_attr_init(&attributes);
    CHECK(pthread_attr_setstacksize(&attributes, 65536) == 0);
    CHECK(pthread_create(&thread, &attributes, small, NULL) == 0);
    CHECK(pthread_join(thread, NULL) == 0);
    return 0;
}
