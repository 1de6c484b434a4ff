/* example.h - what the examples share: the command line, writing a frame, and the last error check.
 *
 *   --out DIR    folder for the pictures (default: the current one)
 *   --frames N   how many frames a moving scene shows
 *   --size WxH   size of the pictures
 */
#ifndef EXAMPLE_H
#define EXAMPLE_H

#include <openrt/rt.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    const char *out;
    int frames, width, height;
} Example;

/* Takes one option of the command line: 1 when it is one of ours and its value is good. */
static inline int exampleOption(Example *e, const char *option, const char *value)
{
    if (!strcmp(option, "--out")) {
        e->out = value;
        return 1;
    }
    if (!strcmp(option, "--frames"))
        return sscanf(value, "%d", &e->frames) == 1 && e->frames > 0;
    if (!strcmp(option, "--size"))
        return sscanf(value, "%dx%d", &e->width, &e->height) == 2 && e->width > 0 && e->height > 0;
    return 0;
}

/* Reads the command line; `frames` is what is shown without --frames. */
static inline Example exampleOptions(int argc, char **argv, int frames)
{
    Example e = {".", 1, 640, 480};
    int i;
    e.frames = frames;
    for (i = 1; i < argc; i += 2) {
        if (i + 1 == argc || !exampleOption(&e, argv[i], argv[i + 1])) {
            fprintf(stderr, "usage: %s [--out DIR] [--frames N] [--size WxH]\n", argv[0]);
            exit(2);
        }
    }
    return e;
}

/* Writes the frame as DIR/NAME.png, or as DIR/NAME_007.png if the scene moves. */
static inline void exampleWrite(const Example *e, const char *name, int frame)
{
    char path[1024];
    if (e->frames > 1)
        snprintf(path, sizeof path, "%s/%s_%03d.png", e->out, name, frame);
    else
        snprintf(path, sizeof path, "%s/%s.png", e->out, name);
    rtWriteImage(path);
    printf("%s\n", path);
}

/* The exit status: says the first error that the library has met since rtInit, if any. */
static inline int exampleEnd(void)
{
    RTenum error = rtGetError();
    if (error != RT_NO_ERROR)
        fprintf(stderr, "openrt: %s\n", (const char *)rtGetErrorString(error));
    rtExit();
    return error == RT_NO_ERROR ? 0 : 1;
}

#endif
