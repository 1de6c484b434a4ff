/* out_of_memory SCENARIO FIRST STEP SIZES DURATION: runs a scenario again and again, each time in a fresh context, and has the n-th allocation fail, n from
 * FIRST on by STEP, until the scenario has fewer. SIZES all, large (from 1 KiB on) or small: which allocations count. DURATION 1: one fails; 0: all after it, too, until the
 * scenario has ended.
 *
 * Prints a line for each n: "n bytes outcome", outcome good or memory, or a text that says what is wrong; a program that aborts has printed "n bytes" only.
 * "count" in place of all that prints for each update strategy how many allocations the library makes in a steady frame, and in one after vertices have moved.
 *
 * malloc and its siblings are those of this file, for the library too. */
#include <openrt/rt.h>

#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- allocations --- */

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t), *__libc_memalign(size_t, size_t);

static long counted, failed, fail_at, fail_for;
static size_t failed_bytes, least = 0, most = SIZE_MAX;
static int armed;

static int refused(size_t bytes)
{
    if (!__atomic_load_n(&armed, __ATOMIC_ACQUIRE) || bytes < least || bytes > most)
        return 0;
    long n = __atomic_add_fetch(&counted, 1, __ATOMIC_RELAXED);
    if (fail_at == 0 || n < fail_at || (fail_for != 0 && n >= fail_at + fail_for))
        return 0;
    if (__atomic_fetch_add(&failed, 1, __ATOMIC_RELAXED) == 0)
        failed_bytes = bytes;
    errno = ENOMEM;
    return 1;
}

void *malloc(size_t n) { return refused(n) ? NULL : __libc_malloc(n); }
void *calloc(size_t n, size_t m) { return refused(n * m) ? NULL : __libc_calloc(n, m); }
void *realloc(void *p, size_t n) { return refused(n) ? NULL : __libc_realloc(p, n); }
void *memalign(size_t align, size_t n) { return refused(n) ? NULL : __libc_memalign(align, n); }
void *aligned_alloc(size_t align, size_t n) { return memalign(align, n); }

int posix_memalign(void **p, size_t align, size_t n)
{
    *p = memalign(align, n);
    return *p ? 0 : ENOMEM;
}

static void arm(long at)
{
    counted = failed = 0;
    failed_bytes = 0;
    fail_at = at;
    __atomic_store_n(&armed, 1, __ATOMIC_RELEASE);
}

static void disarm(void) { __atomic_store_n(&armed, 0, __ATOMIC_RELEASE); }

/* --- the scene --- */

enum { ROUND = 20, ACROSS = 15, VERTICES = ROUND * ACROSS, WIDTH = 32, HEIGHT = 24 };
static float still[3 * VERTICES], moved[3 * VERTICES];
static unsigned indices[6 * VERTICES];

static void torus(float time, float *to)
{
    for (int i = 0; i < ROUND; i++)
        for (int j = 0; j < ACROSS; j++, to += 3) {
            float u = 6.2831853f * i / ROUND, v = 6.2831853f * j / ACROSS, r = .4f + .15f * sinf(3 * u + time);
            to[0] = (1 + r * cosf(v)) * cosf(u), to[1] = (1 + r * cosf(v)) * sinf(u), to[2] = r * sinf(v);
        }
}

static void make_arrays(void)
{
    torus(0, still);
    torus(1, moved);
    for (int i = 0, *to = (int *)indices; i < ROUND; i++)
        for (int j = 0; j < ACROSS; j++, to += 6) {
            int a = i * ACROSS + j, b = (i + 1) % ROUND * ACROSS + j, d = i * ACROSS + (j + 1) % ACROSS;
            int c = (i + 1) % ROUND * ACROSS + (j + 1) % ACROSS, quad[6] = {a, b, c, a, c, d};
            memcpy(to, quad, sizeof quad);
        }
}

/* What the calls of the scenario have reported: nothing, no memory, or another error. */
static enum { NOTHING, MEMORY, OTHER } seen;
static char what[200];

static void note(void)
{
    for (RTenum error; (error = rtGetError()) != RT_NO_ERROR && seen != OTHER;) {
        if (error == RT_OUT_OF_MEMORY) {
            seen = MEMORY;
            continue;
        }
        /* A call that needs what an earlier one could not make is in error, too. */
        if (seen == MEMORY && error != RT_INTERNAL_ERROR)
            continue;
        seen = OTHER;
        snprintf(what, sizeof what, "%s", rtGetErrorString(error));
    }
}

static void begin(void)
{
    rtViewport(0, 0, WIDTH, HEIGHT);
    rtLookAt(0, -6, 4, 0, 0, 0, 0, 0, 1);
    rtEnableClientState(RT_VERTEX_ARRAY);
    rtVertexPointer(3, RT_FLOAT, 0, still);
    rtObjectParameteri(rtGenObjects(2), RT_UPDATE_STRATEGY, RT_AUTO);
}

static void shaders(void)
{
    static unsigned char image[64 * 64 * 3];
    rtGenNewShaderClass("phong", 0);
    rtGenNewShader();
    rtParameter3f(rtParameterHandle("diffuse"), .5f, .2f, .1f);
    note();
    rtGenNewShaderClass("point", 0);
    RTuint light = rtGenNewShader();
    rtParameter3f(rtParameterHandle("position"), 3, 3, 9);
    rtUseLight(light);
    note();
    RTuint texture = 0;
    rtGenTextures(1, &texture);
    rtBindTexture(RT_TEXTURE_2D, texture);
    rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGB, 64, 64, 0, RT_RGB, RT_UNSIGNED_BYTE, image);
    note();
}

static void objects(void)
{
    rtNewObject(1, RT_COMPILE | RT_UNSTRUCTURED);
    rtDrawElements(RT_TRIANGLES, 6 * VERTICES, RT_UNSIGNED_INT, indices);
    rtEndObject();
    note();
    rtNewObject(2, RT_COMPILE | RT_STATIC);
    rtBegin(RT_QUADS);
    for (int i = 0; i < 64; i++)
        for (int k = 0; k < 4; k++) {
            rtColor3f(i / 64.f, .5f, .2f);
            rtVertex3f(i % 8 + (k == 1 || k == 2) - 4, i / 8 + (k > 1) - 4, -1);
        }
    rtEnd();
    rtEndObject();
    note();
}

static void place(void)
{
    rtLoadIdentity();
    rtInstantiateObject(2);
    for (int i = 0; i < 5; i++) {
        rtPushMatrix();
        rtTranslatef(i - 2, .3f * i, 0);
        rtInstantiateObject(1);
        rtPopMatrix();
    }
    note();
}

static void frame(void)
{
    place();
    rtRender();
    note();
}

static void move_to(float *to)
{
    rtUpdateVertices(1, 0, VERTICES, 0, to);
    note();
}

static void make_scene(void)
{
    shaders();
    objects();
}

static void warm_up(void)
{
    make_scene();
    for (int i = 0; i < 4; i++) {
        frame();
        move_to(i & 1 ? still : moved);
    }
    frame();
}

static uint64_t picture(void)
{
    static float pixels[WIDTH * HEIGHT * 4];
    memset(pixels, 0, sizeof pixels);
    rtReadPixels(0, 0, WIDTH, HEIGHT, RT_RGBA, RT_FLOAT, pixels);
    note();
    uint64_t hash = 14695981039346656037u;
    for (size_t i = 0; i < sizeof pixels; i++)
        hash = (hash ^ ((unsigned char *)pixels)[i]) * 1099511628211u;
    return hash;
}

/* --- scenarios --- */

static void nothing(void) {}

static void init(void)
{
    rtMakeCurrent(0);
    RTuint context = rtCreateContext();
    note();
    if (context) {
        rtMakeCurrent(context);
        begin();
        note();
    }
}

static void first_frame(void)
{
    frame();
    move_to(moved);
    frame();
}

static void moved_frame(void)
{
    move_to(moved);
    frame();
}

static void again(void)
{
    objects();
    frame();
}

static void beside(void)
{
    place();
    rtStartRendering();
    note();
    move_to(moved);
    rtEndRendering();
    note();
}

static void queries(void)
{
    static RTray rays[1000];
    static RThit hits[1000];
    static RTubyte hidden[1000];
    place();
    rtCommitScene();
    note();
    for (int i = 0; i < 1000; i++) {
        rays[i].origin[0] = i % 40 * .1f - 2;
        rays[i].origin[2] = 5;
        rays[i].direction[2] = -1;
        rays[i].tmax = INFINITY;
    }
    rtIntersectRays(1000, rays, hits, 0);
    rtIntersectRays(1000, rays, hits, RT_COHERENT);
    rtOccludedRays(1000, rays, hidden, 0);
    note();
    RTscene scene = rtAcquireScene();
    note();
    rtReleaseScene(scene);
}

static void images(void)
{
    const char *names[] = {"oom.png", "oom.jpg", "oom.exr", "oom.hdr", "oom.ppm"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        rtWriteImage(names[i]);
        note();
        rtLoadTexture(names[i]);
        note();
    }
}

static const struct scenario {
    const char *name;
    void (*before)(void), (*run)(void);
    /* The next frame is that of before. */
    int keeps;
} scenarios[] = {
    {"init", nothing, init, 0},         {"shaders", nothing, shaders, 0},   {"objects", nothing, objects, 0},
    {"first", make_scene, first_frame, 0}, {"steady", warm_up, frame, 1},      {"moved", warm_up, moved_frame, 0},
    {"again", warm_up, again, 0},       {"beside", warm_up, beside, 0},     {"queries", warm_up, queries, 1},
    {"images", warm_up, images, 1},
};

/* Everything once more, with memory: the picture must be what it would have been. */
static uint64_t recover(void)
{
    seen = NOTHING;
    rtBindShader(0);
    rtUseLight(0);
    objects();
    move_to(moved);
    frame();
    frame();
    return picture();
}

static RTuint fresh(void)
{
    RTuint context = rtCreateContext();
    rtMakeCurrent(context);
    begin();
    return context;
}

/* Most allocations of a frame among some, before each of which `change` was called. */
static long most_allocations(void (*change)(void))
{
    long found = 0;
    for (int i = 0; i < 20; i++) {
        change();
        arm(0);
        frame();
        disarm();
        found = counted > found ? counted : found;
    }
    return found;
}

static void move(void)
{
    static int turn;
    move_to(turn++ & 1 ? still : moved);
}

static int count(void)
{
    static const struct {
        const char *name;
        RTenum strategy;
    } ways[] = {
        {"auto", RT_AUTO}, {"bsp", RT_BSP},   {"sah", RT_SAH},   {"fast_build", RT_FAST_BUILD},       {"refit", RT_REFIT},
        {"rotate", RT_ROTATE}, {"grid", RT_GRID}, {"lazy", RT_LAZY}, {"visibility_field", RT_VISIBILITY_FIELD},
    };
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        RTuint context = fresh();
        rtObjectParameteri(1, RT_UPDATE_STRATEGY, ways[i].strategy);
        warm_up();
        /* What is done from time to time, like merging, is done by then. */
        most_allocations(move);
        long in_moved = most_allocations(move);
        frame();
        printf("%s %ld %ld\n", ways[i].name, most_allocations(nothing), in_moved);
        rtDestroyContext(context);
    }
    if (seen != NOTHING)
        fprintf(stderr, "%s\n", what);
    return seen != NOTHING;
}

int main(int argc, char **argv)
{
    make_arrays();
    if (argc == 2 && strcmp(argv[1], "count") == 0)
        return count();
    if (argc != 6)
        return 2;
    const struct scenario *s = scenarios;
    while (strcmp(s->name, argv[1]) != 0)
        if (++s == scenarios + sizeof scenarios / sizeof *scenarios)
            return 2;
    if (strcmp(argv[4], "large") == 0)
        least = 1024;
    if (strcmp(argv[4], "small") == 0)
        most = 1023;
    fail_for = atol(argv[5]);
    setvbuf(stdout, NULL, _IONBF, 0);

    RTuint context = fresh();
    s->before();
    s->run();
    if (seen != NOTHING) {
        printf("0 0 without a failure: %s\n", what);
        return 0;
    }
    context = rtGetCurrentContext();
    uint64_t wanted = recover();
    rtDestroyContext(context);
    for (long n = atol(argv[2]);; n += atol(argv[3])) {
        seen = NOTHING;
        context = fresh();
        s->before();
        if (seen != NOTHING) {
            printf("%ld 0 before: %s\n", n, what);
            return 0;
        }
        uint64_t old = s->keeps ? picture() : 0;
        printf("%ld ", n);
        arm(n);
        s->run();
        disarm();
        note();
        printf("%zu ", failed_bytes);
        if (failed == 0) {
            printf("end\n");
            return 0;
        }
        int outcome = seen;
        if (!rtGetCurrentContext())
            rtMakeCurrent(context);
        else if (rtGetCurrentContext() != context) {
            RTuint other = context;
            context = rtGetCurrentContext();
            rtDestroyContext(other);
        }
        if (s->keeps) {
            /* An error has changed neither the picture nor the state. */
            if (outcome == MEMORY && picture() != old)
                printf("the picture before is gone; ");
            rtClearInstances();
            frame();
            if (picture() != old)
                printf("the state is another one; ");
        }
        rtEnd();
        rtEndObject();
        while (rtGetError() != RT_NO_ERROR && seen != OTHER)
            ;
        uint64_t now = recover();
        if (outcome == OTHER || seen != NOTHING)
            printf("an error%s: %s\n", seen != NOTHING ? " afterwards" : "", what);
        else if (now != wanted)
            printf("another picture\n");
        else
            printf("%s\n", outcome == MEMORY ? "memory" : "good");
        rtDestroyContext(context);
    }
}
