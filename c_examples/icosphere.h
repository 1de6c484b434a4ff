/* icosphere.h - a unit sphere of triangles of about the same size, whose vertices are shared: an icosahedron, each of
 * whose triangles is cut into four, `level` times. 20 * 4^level triangles, 10 * 4^level + 2 vertices. */
#ifndef ICOSPHERE_H
#define ICOSPHERE_H

#include <math.h>
#include <openrt/rt.h>
#include <stdlib.h>

typedef struct {
    int vertices, triangles;
    float (*position)[3];
    RTuint (*triangle)[3];
} Icosphere;

static inline void icosphereVertex(Icosphere *s, double x, double y, double z)
{
    const double length = sqrt(x * x + y * y + z * z);
    float *p = s->position[s->vertices++];
    p[0] = (float)(x / length);
    p[1] = (float)(y / length);
    p[2] = (float)(z / length);
}

/* The vertex in the middle of an edge: that of the triangle beside, if it has come before. `edges` has four
 * numbers for each that it can hold: both ends, the middle, and whether it holds one. */
static inline RTuint icosphereMiddle(Icosphere *s, RTuint (*edges)[4], RTuint room, RTuint a, RTuint b)
{
    const RTuint low = a < b ? a : b, high = a < b ? b : a;
    RTuint at = (low * 2654435761u ^ high * 2246822519u) % room;
    while (edges[at][3] && (edges[at][0] != low || edges[at][1] != high))
        at = (at + 1) % room;
    if (!edges[at][3]) {
        const float *p = s->position[a], *q = s->position[b];
        edges[at][0] = low, edges[at][1] = high, edges[at][2] = (RTuint)s->vertices, edges[at][3] = 1;
        icosphereVertex(s, p[0] + q[0], p[1] + q[1], p[2] + q[2]);
    }
    return edges[at][2];
}

static inline Icosphere icosphere(int level)
{
    static const double corner[12][3] = {
        {-1, 1.618, 0}, {1, 1.618, 0}, {-1, -1.618, 0}, {1, -1.618, 0}, {0, -1, 1.618}, {0, 1, 1.618},
        {0, -1, -1.618}, {0, 1, -1.618}, {1.618, 0, -1}, {1.618, 0, 1}, {-1.618, 0, -1}, {-1.618, 0, 1}};
    static const RTuint face[20][3] = {
        {0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6},
        {7, 1, 8}, {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8}, {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7},
        {9, 8, 1}};
    const int all = 20 << 2 * level;
    Icosphere s = {0, 20, NULL, NULL};
    const RTuint room = 4 * (RTuint)all + 1;
    RTuint(*edges)[4] = malloc(room * sizeof *edges);
    int i, k;
    s.position = malloc(((size_t)all / 2 + 2) * sizeof *s.position);
    s.triangle = malloc((size_t)all * sizeof *s.triangle);
    if (!edges || !s.position || !s.triangle)
        exit(1);
    for (i = 0; i < 12; i++)
        icosphereVertex(&s, corner[i][0], corner[i][1], corner[i][2]);
    for (i = 0; i < 20; i++)
        for (k = 0; k < 3; k++)
            s.triangle[i][k] = face[i][k];
    for (; level > 0; level--) {
        RTuint at;
        for (at = 0; at < room; at++)
            edges[at][3] = 0;
        /* A triangle becomes the one in its middle; the others go to the end. */
        for (i = 0, k = s.triangles; i < s.triangles; i++) {
            RTuint *t = s.triangle[i];
            const RTuint a = t[0], b = t[1], c = t[2], ab = icosphereMiddle(&s, edges, room, a, b);
            const RTuint bc = icosphereMiddle(&s, edges, room, b, c), ca = icosphereMiddle(&s, edges, room, c, a);
            const RTuint cut[3][3] = {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}};
            int j;
            for (j = 0; j < 9; j++)
                s.triangle[k + j / 3][j % 3] = cut[j / 3][j % 3];
            k += 3;
            t[0] = ab, t[1] = bc, t[2] = ca;
        }
        s.triangles = k;
    }
    free(edges);
    return s;
}

static inline void freeIcosphere(Icosphere *s)
{
    free(s->position);
    free(s->triangle);
}

#endif
