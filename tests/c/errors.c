/* Error conformance: every function of the header, called where it is allowed and where it is not, and every wrong call of bad.inc, each with the exact
 * error and no other effect. Reading the MXCSR before and after each call shows that the library leaves the caller's floating-point environment alone. */
#include "world.h"

#include <pthread.h>

enum Place { OUTSIDE, SCENE, EVERYWHERE, INSIDE_ONLY, OBJECT_ONLY };
enum State { outside, inside, arrays_at_null, no_texture, viewport_outside, rendering };

static RTuint result;

static const RTshaderClass class_of_other_version = CLASS(2, RT_SURFACE_SHADER, "x", 0, 0, NULL, shade);
static const RTshaderClass class_of_unknown_kind = CLASS(1, RT_RENDERING_OBJECT, "x", 0, 0, NULL, shade);
static const RTshaderClass class_without_function = CLASS(1, RT_LIGHT_SHADER, "x", 0, 0, NULL, shade);
static const RTshaderClass class_without_name = CLASS(1, RT_SURFACE_SHADER, NULL, 0, 0, NULL, shade);
static const RTshaderClass class_without_params = CLASS(1, RT_SURFACE_SHADER, "x", 64, 1, NULL, shade);
static const RTshaderClass class_with_small_block = CLASS(1, RT_SURFACE_SHADER, "x", 1, PARAMS, surface_params, shade);
static const RTshaderClass class_with_many_params =
    CLASS(1, RT_SURFACE_SHADER, "x", 64, 0xFFFFFFFFu, surface_params, shade);

#define X(name, place, call) \
    static void good_##name(void) { call; }
#include "calls.inc"
#undef X

static const struct {
    const char *name;
    const char *text;
    enum Place place;
    void (*call)(void);
} good[] = {
#define X(name, place, call) {#name, #call, place, good_##name},
#include "calls.inc"
#undef X
};

#define CAT2(a, b) a##b
#define CAT(a, b) CAT2(a, b)
#define B(name, what, state, error, call) \
    static void CAT(bad_, __LINE__)(void) { call; }
#include "bad.inc"
#undef B

static const struct {
    const char *text;
    enum State state;
    RTenum error;
    void (*call)(void);
} bad[] = {
#define B(name, what, state, error, call) {#what ": " #call, state, error, CAT(bad_, __LINE__)},
#include "bad.inc"
#undef B
};

static RTenum told;
static int telling, names_itself;

static void on_error(RTenum error, const char *message, void *userData)
{
    CHECK(message && message[0] && userData == &told);
    /* The library may be called from here, also wrongly: that does not call this function again. */
    CHECK(!telling);
    telling = 1;
    CHECK(rtGetErrorString(error)[0] && rtGetCurrentContext() != 0);
    if (names_itself) {
        rtSamplesPerPixel(-1);
        CHECK(rtGetError() == error);
    }
    telling = 0;
    if (!told)
        told = error;
}

static unsigned mxcsr(void)
{
#if defined(__x86_64__)
    return __builtin_ia32_stmxcsr() & 0xFFC0u; /* without the flags that any addition may raise */
#else
    return 0;
#endif
}

static int failures;

static void complain(const char *what, const char *call, RTenum got, RTenum expected)
{
    fprintf(stderr, "%s: %s: error 0x%X, expected 0x%X\n", what, call, got, expected);
    failures++;
}

/* The text of the error that rtGetError() has returned begins with a function of the call. */
static void text_names(const char *call, RTenum error)
{
    const char *text = rtGetErrorString(error);
    const char *end = strchr(text, ':');
    char name[64] = "";
    if (end && end - text < (int)sizeof name)
        memcpy(name, text, (size_t)(end - text));
    if (error != RT_NO_ERROR && (strncmp(name, "rt", 2) != 0 || !strstr(call, name))) {
        fprintf(stderr, "the text of an error of %s is \"%s\"\n", call, text);
        failures++;
    }
}

/* Makes a call that must fail, from outside rtBegin and rtEnd. */
static void must_fail(const char *what, const char *source, const char *name, void (*call)(void), RTenum expected)
{
    static char before[sizeof state_text];
    const unsigned environment_before = mxcsr();
    RTenum got;
    strcpy(before, snapshot());
    result = 0x5A5A;
    told = 0;
    call();
    CHECK(mxcsr() == environment_before);
    got = rtGetError();
    if (got != expected || told != expected)
        complain(what, name, got, expected);
    text_names(source, got);
    if (result != 0 && result != 0x5A5A)
        complain("result of a failed call", name, result, 0);
    if (strcmp(before, snapshot()) != 0) {
        complain("the state changed", name, 0, 0);
        fprintf(stderr, "--- before\n%s--- after\n%s", before, state_text);
    }
}

/* The same between rtBegin and rtEnd, where nothing can be asked. */
static void must_fail_inside(const char *what, const char *source, const char *name, void (*call)(void),
                             RTenum expected)
{
    static char before[sizeof state_text];
    RTenum got;
    strcpy(before, snapshot());
    told = 0;
    result = 0x5A5A;
    rtBegin(RT_TRIANGLES);
    call();
    rtEnd();
    got = rtGetError();
    if (got != expected || told != expected)
        complain(what, name, got, expected);
    text_names(source, got);
    if (result != 0 && result != 0x5A5A)
        complain("result of a failed call", name, result, 0);
    if (strcmp(before, snapshot()) != 0)
        complain("the state changed", name, 0, 0);
}

static void without_context(const char *what)
{
    size_t i;
    for (i = 0; i < sizeof good / sizeof good[0]; i++) {
        RTenum got;
        result = 0x5A5A;
        good[i].call();
        got = rtGetError();
        if (got != RT_INVALID_OPERATION || (result != 0 && result != 0x5A5A))
            complain(what, good[i].name, got, RT_INVALID_OPERATION);
        text_names(good[i].text, got);
    }
    CHECK(rtGetCurrentContext() == 0);
}

static void *on_another_thread(void *context)
{
    without_context("on a thread without a context");
    rtMakeCurrent(*(RTuint *)context);
    CHECK(rtGetError() == RT_INVALID_OPERATION); /* current elsewhere */
    rtDestroyContext(*(RTuint *)context);
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    rtCancelContext(*(RTuint *)context);
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    return NULL;
}

/* Functions that a library without the readers of scene files refuses. */
static int needs_readers(const char *name)
{
    return !strcmp(name, "rtLoadScene") || (strstr(name, "LoadedScene") && strcmp(name, "rtIsLoadedScene"));
}

static void good_calls_are_good(void)
{
    size_t i;
    for (i = 0; i < sizeof good / sizeof good[0]; i++) {
        const int opens = !strcmp(good[i].name, "rtBegin");
        const unsigned environment_before = mxcsr();
        RTenum error;
        setup();
        result = 0x5A5A;
        if (good[i].place == INSIDE_ONLY || good[i].place == EVERYWHERE)
            rtBegin(RT_TRIANGLES);
        if (good[i].place == OBJECT_ONLY)
            rtNewObject(object, RT_COMPILE);
        good[i].call();
        if (opens || ((good[i].place == INSIDE_ONLY || good[i].place == EVERYWHERE) && strcmp(good[i].name, "rtEnd")))
            rtEnd();
        CHECK(mxcsr() == environment_before);
        error = rtGetError();
        if (loaded == 0 && needs_readers(good[i].name)) {
            if (error != RT_INVALID_OPERATION && error != RT_INVALID_VALUE && strcmp(good[i].name, "rtDeleteLoadedScene"))
                complain("without the readers", good[i].name, error, RT_INVALID_OPERATION);
        } else if (error != RT_NO_ERROR)
            complain(rtGetErrorString(error), good[i].name, error, RT_NO_ERROR);
        rtExit();
        CHECK(rtGetError() == RT_NO_ERROR);
    }
}

static void calls_in_the_wrong_place(void)
{
    size_t i;
    for (i = 0; i < sizeof good / sizeof good[0]; i++) {
        switch (good[i].place) {
        case OUTSIDE: must_fail_inside("inside", good[i].text, good[i].name, good[i].call, RT_INVALID_OPERATION); break;
        case SCENE:
            must_fail_inside("inside", good[i].text, good[i].name, good[i].call, RT_INVALID_OPERATION);
            rtNewObject(object, RT_COMPILE);
            must_fail("in an object", good[i].text, good[i].name, good[i].call, RT_INVALID_OPERATION);
            rtBindShader(surface);
            rtBegin(RT_TRIANGLES);
            rtNormal3f(0, 0, 1);
            rtVertex3f(-1, -1, -4), rtVertex3f(1, -1, -4), rtVertex3f(0, 1, -4);
            rtEnd();
            rtEndObject();
            break;
        case OBJECT_ONLY:
            must_fail_inside("inside", good[i].text, good[i].name, good[i].call, RT_INVALID_OPERATION);
            must_fail("outside", good[i].text, good[i].name, good[i].call, RT_INVALID_OPERATION);
            break;
        case INSIDE_ONLY: must_fail("outside", good[i].text, good[i].name, good[i].call, RT_INVALID_OPERATION); break;
        case EVERYWHERE: break;
        }
    }
}

static void wrong_calls(void)
{
    size_t i;
    for (i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        switch (bad[i].state) {
        case outside: must_fail("wrong", bad[i].text, bad[i].text, bad[i].call, bad[i].error); break;
        case inside: must_fail_inside("wrong", bad[i].text, bad[i].text, bad[i].call, bad[i].error); break;
        case arrays_at_null:
            rtVertexPointer(3, RT_FLOAT, 0, NULL);
            must_fail("wrong", bad[i].text, bad[i].text, bad[i].call, bad[i].error);
            rtVertexPointer(3, RT_FLOAT, 0, floats);
            break;
        case no_texture:
            rtBindTexture(RT_TEXTURE_2D, 0);
            must_fail("wrong", bad[i].text, bad[i].text, bad[i].call, bad[i].error);
            rtBindTexture(RT_TEXTURE_2D, texture);
            break;
        case viewport_outside:
            rtViewport(1, 1, 4, 4);
            must_fail("wrong", bad[i].text, bad[i].text, bad[i].call, bad[i].error);
            rtViewport(0, 0, 4, 4);
            break;
        case rendering:
            rtStartRendering();
            must_fail("wrong", bad[i].text, bad[i].text, bad[i].call, bad[i].error);
            rtEndRendering();
            rtInstantiateObject(object);
            break;
        }
    }
}

static void stacks_and_stickiness(void)
{
    RTint depth, deepest;
    RTint i;
    rtGetIntegerv(RT_MATRIX_STACK_DEPTH, &depth);
    rtGetIntegerv(RT_MAX_MATRIX_STACK_DEPTH, &deepest);
    CHECK(deepest >= 64);
    for (i = depth; i < deepest; i++)
        rtPushMatrix();
    CHECK(rtGetError() == RT_NO_ERROR);
    must_fail("full stack", "rtPushMatrix", "rtPushMatrix", good_rtPushMatrix, RT_STACK_OVERFLOW);
    for (i = 1; i < deepest; i++)
        rtPopMatrix();
    CHECK(rtGetError() == RT_NO_ERROR);
    must_fail("empty stack", "rtPopMatrix", "rtPopMatrix", good_rtPopMatrix, RT_STACK_UNDERFLOW);

    /* The first error stays until it is read, with its text. */
    rtBegin(99);
    rtSamplesPerPixel(-1);
    CHECK(rtGetError() == RT_INVALID_ENUM);
    CHECK(strcmp(rtGetErrorString(RT_INVALID_ENUM), rtGetErrorString(RT_INVALID_VALUE)) != 0);
    CHECK(rtGetError() == RT_NO_ERROR);

    /* rtGetError itself is an error between rtBegin and rtEnd. */
    rtBegin(RT_TRIANGLES);
    CHECK(rtGetError() == RT_NO_ERROR);
    rtEnd();
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    CHECK(rtGetError() == RT_NO_ERROR);
}

/* The callback makes an error of its own, and reads the one it is told of. */
static void errors_in_the_callback(void)
{
    names_itself = 1;
    rtBegin(99);
    names_itself = 0;
    CHECK(rtGetError() == RT_NO_ERROR);
}

/* Names that stay valid while something still shows what they named. */
static void deletion_while_in_use(void)
{
    rtRender();
    rtInstantiateObject(flat_object);
    rtDeleteObjects(flat_object, 1);
    CHECK(!rtIsObject(flat_object));
    rtDeleteObjects(flat_object, INT_MAX);
    rtUseLight(light);
    rtDeleteShader(light);
    rtDeleteTextures(1, &texture);
    rtRender();
    rtStartRendering();
    rtDeleteObjects(1, INT_MAX);
    rtEndRendering();
    rtRender();
    CHECK(rtGetError() == RT_NO_ERROR);
    CHECK(rtGenObjects(INT_MAX) != 0);
    CHECK(rtGetError() == RT_NO_ERROR);
}

/* Shader functions called from outside a shader have nobody to ask. */
static void rts_functions_without_a_context(void)
{
    RTsurfacePoint point;
    RTlightSample sample;
    RTfloat v[4] = {9, 9, 9, 9};
    memset(&point, 1, sizeof point);
    rtsGetPoint(NULL, &point);
    CHECK(rtsLightCount(NULL) == 0);
    CHECK(rtsIlluminate(NULL, 0, &sample) == RT_FALSE);
    CHECK(rtsShadowed(NULL, v, 1) == RT_FALSE);
    rtsTrace(NULL, v, v);
    CHECK(v[0] == 0);
    rtsReflect(NULL, v);
    rtsTexture(NULL, 1, 0, 0, v);
    CHECK(v[0] == 1);
}

int main(int argc, char **argv)
{
    RTuint context, other;
    pthread_t thread;
    if (argc > 1)
        snprintf(image_file, sizeof image_file, "%s", argv[1]);

    without_context("before rtInit");
    rtExit();
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    rtMakeCurrent(77);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    rtDestroyContext(0);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    rtCancelContext(1);
    rtReleaseScene(0);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    rtThreads(-1);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    rtThreads(1025);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    CHECK(rtCreateContextThreads(-1) == 0 && rtGetError() == RT_INVALID_VALUE);
    rts_functions_without_a_context();

    setup();
    context = rtGetCurrentContext();
    CHECK(context != 0);
    rtInit(&argc, argv);
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    rtErrorCallback(on_error, &told);
    CHECK(pthread_create(&thread, NULL, on_another_thread, &context) == 0);
    CHECK(pthread_join(thread, NULL) == 0);

    calls_in_the_wrong_place();
    wrong_calls();
    stacks_and_stickiness();
    errors_in_the_callback();
    deletion_while_in_use();

    /* Names of one context mean nothing in another. */
    other = rtCreateContext();
    CHECK(other != 0 && other != context && rtGetCurrentContext() == context);
    rtMakeCurrent(other);
    CHECK(rtGetCurrentContext() == other && !rtIsObject(object));
    rtInstantiateObject(object);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    rtMakeCurrent(context);
    rtDestroyContext(other);
    CHECK(rtGetError() == RT_NO_ERROR);
    rtMakeCurrent(other);
    CHECK(rtGetError() == RT_INVALID_VALUE && rtGetCurrentContext() == context);
    rtMakeCurrent(0);
    CHECK(rtGetCurrentContext() == 0);
    without_context("with no context current");
    rtMakeCurrent(context);
    rtExit();
    without_context("after rtExit");

    good_calls_are_good();
    remove(image_file);
    remove(scene_file);
    CHECK(failures == 0);
    printf("%u calls, %u wrong ones\n", (unsigned)(sizeof good / sizeof good[0]), (unsigned)(sizeof bad / sizeof bad[0]));
    return 0;
}
