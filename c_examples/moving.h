/* moving.h - what the examples of deforming scenes share: their command line, and what each frame costs.
 *
 *   --out, --frames, --size   as all examples
 *   --strategy NAME           how the structure of what moves is kept up to date: auto, bsp, sah, ...
 *   --triangles N             how large the scene is
 *   --threads N               otherwise as many as the process may use
 *   --subsampling N           one ray for each block of N x N pixels
 *   --upsampling NAME         bilinear or midpoint
 *   --frameless N             one in N pixels per frame
 *   --budget MS               time per frame: rays from the camera first, others as long as there is time
 *   --every N                 writes every N-th picture, 0 none
 */
#ifndef MOVING_H
#define MOVING_H

#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200112L /* setenv */
#endif
#include "example.h"

/* Strategies by name. */
static const struct {
    const char *name;
    RTenum strategy;
} movingStrategies[] = {
    {"auto", RT_AUTO},       {"bsp", RT_BSP},   {"sah", RT_SAH},   {"fast_build", RT_FAST_BUILD}, {"refit", RT_REFIT},
    {"rotate", RT_ROTATE},   {"lazy", RT_LAZY}, {"grid", RT_GRID}, {"visibility_field", RT_VISIBILITY_FIELD},
};
enum { STRATEGIES = sizeof movingStrategies / sizeof movingStrategies[0] };

typedef struct {
    Example e;
    int strategy; /* a line of the table */
    int triangles, threads, subsampling, midpoint, frameless, every;
    float budget;
    /* Sums over the frames, in milliseconds. */
    double update, trace, total;
} Moving;

enum { MOST = 1 << 24 };

static inline int movingNumber(const char *value, int least, int most, int *number)
{
    return sscanf(value, "%d", number) == 1 && least <= *number && *number <= most;
}

static inline int movingOption(Moving *m, const char *option, const char *value)
{
    if (!strcmp(option, "--strategy")) {
        for (m->strategy = 0; m->strategy < STRATEGIES; m->strategy++)
            if (!strcmp(value, movingStrategies[m->strategy].name))
                return 1;
        return 0;
    }
    if (!strcmp(option, "--upsampling")) {
        m->midpoint = !strcmp(value, "midpoint");
        return m->midpoint || !strcmp(value, "bilinear");
    }
    if (!strcmp(option, "--triangles"))
        return movingNumber(value, 1, MOST, &m->triangles);
    if (!strcmp(option, "--threads"))
        return movingNumber(value, 1, 1024, &m->threads);
    if (!strcmp(option, "--subsampling"))
        return movingNumber(value, 1, 65536, &m->subsampling);
    if (!strcmp(option, "--frameless"))
        return movingNumber(value, 1, 1024, &m->frameless);
    if (!strcmp(option, "--every"))
        return movingNumber(value, 0, MOST, &m->every);
    if (!strcmp(option, "--budget"))
        return sscanf(value, "%f", &m->budget) == 1;
    return exampleOption(&m->e, option, value);
}

/* Reads the command line, begins with the library, and sets what the command line says of frames. `frames` and
 * `triangles` are what it need not say. */
static inline Moving movingBegin(int argc, char **argv, int frames, int triangles)
{
    Moving m = {{".", 1, 640, 480}, 0, 1, 0, 1, 0, 1, 1, -1, 0, 0, 0};
    int i;
    m.e.frames = frames;
    m.triangles = triangles;
    for (i = 1; i < argc; i += 2) {
        if (i + 1 == argc || !movingOption(&m, argv[i], argv[i + 1])) {
            fprintf(stderr, "usage: %s [--out DIR] [--frames N] [--size WxH] [--triangles N] [--threads N] [--every N]\n"
                    "  [--subsampling N] [--upsampling bilinear|midpoint] [--frameless N] [--budget MS] [--strategy NAME]\n"
                    "  NAME:", argv[0]);
            for (i = 0; i < STRATEGIES; i++)
                fprintf(stderr, " %s", movingStrategies[i].name);
            fprintf(stderr, "\n");
            exit(2);
        }
    }
    if (m.threads > 0) {
        char number[16];
        snprintf(number, sizeof number, "%d", m.threads);
        setenv("OPENRT_NUM_THREADS", number, 1);
    }
    rtInit(&argc, argv);
    rtViewport(0, 0, m.e.width, m.e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtFrameParameteri(RT_SUBSAMPLING, m.subsampling);
    rtFrameParameteri(RT_UPSAMPLING, m.midpoint ? RT_MIDPOINT : RT_BILINEAR);
    rtFrameParameteri(RT_FRAMELESS, m.frameless);
    rtFrameParameterf(RT_TIME_BUDGET, m.budget);
    return m;
}

/* Lets an object that moves be kept up to date as the command line says. */
static inline void movingStrategy(const Moving *m, RTuint object)
{
    rtObjectParameteri(object, RT_UPDATE_STRATEGY, (RTint)movingStrategies[m->strategy].strategy);
}

/* Light from everywhere, so that shadows are not black. */
static inline void movingAmbient(float strength)
{
    rtGenNewShaderClass("ambient", NULL);
    rtUseLight(rtGenNewShader());
    rtParameter3f(rtParameterHandle("color"), strength, strength, strength);
}

/* A surface of this colour, also in the light from everywhere. It stays bound, for more to be said of it. */
static inline void movingSurface(float r, float g, float b)
{
    rtGenNewShaderClass("phong", NULL);
    rtGenNewShader();
    rtParameter3f(rtParameterHandle("diffuse"), r, g, b);
    rtParameter3f(rtParameterHandle("ambient"), r, g, b);
}

/* Renders the frame, says what it cost, and writes its picture if it is its turn. */
static inline void movingFrame(Moving *m, const char *name, int frame)
{
    RTframeStats s;
    rtRender();
    rtGetFrameStats(&s);
    m->update += 1e3 * s.updateSeconds;
    m->trace += 1e3 * s.renderSeconds;
    m->total += 1e3 * s.totalSeconds;
    printf("%s %3d: update %8.2f ms, trace %8.2f ms, total %8.2f ms, %8.0f rays", name, frame, 1e3 * s.updateSeconds,
           1e3 * s.renderSeconds, 1e3 * s.totalSeconds, s.primaryRays + s.shadowRays + s.secondaryRays);
    if (s.refined < 1)
        printf(", %3.0f %% refined", 100 * s.refined);
    printf("\n");
    if (m->every > 0 && frame % m->every == 0)
        exampleWrite(&m->e, name, frame);
}

/* Says what all frames cost, and ends. The exit status. */
static inline int movingEnd(const Moving *m, const char *name, int triangles)
{
    const double n = m->e.frames;
    printf("%s, %d moving triangles, %s: %d frames, update %.2f ms, trace %.2f ms, total %.2f ms per frame\n", name,
           triangles, movingStrategies[m->strategy].name, m->e.frames, m->update / n, m->trace / n, m->total / n);
    return exampleEnd();
}

#endif
