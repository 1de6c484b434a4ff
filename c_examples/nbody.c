/* nbody.c - two clusters of stars that fly through each other (after the n-body simulation of Kopta et al. 2012): all
 * small spheres are one object, whose triangles drift apart more and more. A refit gets slow, rotations do not: compare
 * the last frames of --strategy refit and --strategy rotate.
 */
#include "moving.h"
#include "icosphere.h"
#include "shapes.h"

typedef struct {
    double at[3], speed[3], pull[3];
} Star;

static double chance(void)
{
    static unsigned state = 5;
    state = state * 1664525u + 1013904223u;
    return (double)(state >> 8) / 16777216.0;
}

/* A ball of stars that turns about its axis. */
static void cluster(Star *star, int n, double x, double speed)
{
    int i, k;
    for (i = 0; i < n; i++) {
        double p[3], length;
        do {
            for (k = 0; k < 3; k++)
                p[k] = 2 * chance() - 1;
            length = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        } while (length > 1);
        for (k = 0; k < 3; k++)
            star[i].at[k] = 1.5 * p[k] * (k == 1 ? 0.6 : 1);
        star[i].speed[0] = speed - 0.55 * p[2];
        star[i].speed[1] = 0.1 * p[1];
        star[i].speed[2] = 0.55 * p[0];
        star[i].at[0] += x;
        star[i].at[2] += 0.3 * x;
    }
}

/* Gravitation of all on all, softened so that near ones do not fly off. All together weigh `mass`. */
static void attract(Star *star, int n, double mass)
{
    int i, j, k;
    for (i = 0; i < n; i++)
        for (k = 0; k < 3; k++)
            star[i].pull[k] = 0;
    for (i = 0; i < n; i++) {
        for (j = i + 1; j < n; j++) {
            const double x = star[j].at[0] - star[i].at[0], y = star[j].at[1] - star[i].at[1];
            const double z = star[j].at[2] - star[i].at[2], d = x * x + y * y + z * z + 0.02;
            const double pull = mass / n / (d * sqrt(d)), f[3] = {x * pull, y * pull, z * pull};
            for (k = 0; k < 3; k++) {
                star[i].pull[k] += f[k];
                star[j].pull[k] -= f[k];
            }
        }
    }
}

/* Leapfrog. */
static void step(Star *star, int n, double seconds)
{
    int i, k;
    attract(star, n, 1.2);
    for (i = 0; i < n; i++) {
        for (k = 0; k < 3; k++) {
            star[i].speed[k] += seconds * star[i].pull[k];
            star[i].at[k] += seconds * star[i].speed[k];
        }
    }
}

int main(int argc, char **argv)
{
    Moving m = movingBegin(argc, argv, 8, 146000);
    Icosphere ball = icosphere(1);
    const int n = (m.triangles + ball.triangles - 1) / ball.triangles, vertices = n * ball.vertices;
    Star *star = malloc((size_t)n * sizeof *star);
    float(*position)[3] = malloc((size_t)vertices * sizeof *position);
    float(*normal)[3] = malloc((size_t)vertices * sizeof *normal);
    float(*color)[3] = malloc((size_t)vertices * sizeof *color);
    RTuint(*index)[3] = malloc((size_t)n * (size_t)ball.triangles * sizeof *index);
    /* Few frames show as much of the flight as many do, in longer strides. */
    const int steps = m.e.frames < 80 ? 80 / m.e.frames : 1;
    RTuint stars, ground;
    int frame, i, j, k;

    if (!star || !position || !normal || !color || !index)
        return 1;
    cluster(star, n / 2, -2, 0.5);
    cluster(star + n / 2, n - n / 2, 2, -0.5);
    for (i = 0; i < n; i++) {
        for (j = 0; j < ball.vertices; j++) {
            const int v = i * ball.vertices + j;
            const float warm = i < n / 2 ? 1.0f : 0.3f;
            color[v][0] = 0.2f + 0.75f * warm, color[v][1] = 0.55f, color[v][2] = 1 - 0.8f * warm;
            for (k = 0; k < 3; k++)
                normal[v][k] = ball.position[j][k];
        }
        for (j = 0; j < ball.triangles; j++)
            for (k = 0; k < 3; k++)
                index[i * ball.triangles + j][k] = ball.triangle[j][k] + (RTuint)(i * ball.vertices);
    }

    rtClearColor(0.02f, 0.03f, 0.06f, 1);
    rtPerspective(42, (RTdouble)m.e.width / m.e.height, 0.1, 100);
    rtLookAt(0, 2.8, 6, 0, -0.3, 0, 0, 1, 0);
    rtGenNewShaderClass("point", NULL);
    rtUseLight(rtGenNewShader());
    rtParameter3f(rtParameterHandle("position"), -3, 9, 4);
    movingAmbient(0.25f);
    stars = rtGenObjects(2);
    ground = stars + 1;
    movingSurface(0.12f, 0.13f, 0.18f);
    rtNewObject(ground, RT_COMPILE | RT_STATIC);
    rtTranslated(0, -2.2, 0);
    solidFloor(60);
    rtLoadIdentity();
    rtEndObject();

    movingSurface(0.8f, 0.8f, 0.8f);
    rtParameter3f(rtParameterHandle("specular"), 0.3f, 0.3f, 0.3f);
    rtEnableClientState(RT_VERTEX_ARRAY);
    rtEnableClientState(RT_NORMAL_ARRAY);
    rtEnableClientState(RT_COLOR_ARRAY);
    rtVertexPointer(3, RT_FLOAT, 0, position);
    rtNormalPointer(RT_FLOAT, 0, normal);
    rtColorPointer(3, RT_FLOAT, 0, color);
    for (frame = 0; frame < m.e.frames; frame++) {
        for (i = 0; i < vertices; i++)
            for (k = 0; k < 3; k++)
                position[i][k] = (float)star[i / ball.vertices].at[k] + 0.045f * ball.position[i % ball.vertices][k];
        if (frame == 0) {
            rtNewObject(stars, RT_COMPILE | RT_UNSTRUCTURED);
            rtDrawElements(RT_TRIANGLES, 3 * n * ball.triangles, RT_UNSIGNED_INT, index);
            rtEndObject();
            movingStrategy(&m, stars);
        } else {
            rtUpdateVertices(stars, 0, vertices, 0, &position[0][0]);
        }
        rtInstantiateObject(ground);
        rtInstantiateObject(stars);
        movingFrame(&m, "nbody", frame);
        for (i = 0; i < steps; i++)
            step(star, n, 0.05);
    }
    free(star);
    free(position);
    free(normal);
    free(color);
    free(index);
    freeIcosphere(&ball);
    return movingEnd(&m, "nbody", n * ball.triangles);
}
