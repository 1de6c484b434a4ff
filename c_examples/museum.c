/* museum.c - a work of art in a museum: triangles without order that fly from one of five shapes to the next, and
 * mirror the room (after the BART museum, as in Larsson and Akenine-Moller 2003 and Kopta et al. 2012). The shapes are
 * key frames: a structure is kept for each, which the strategies lazy and refit use.
 *
 * --triangles 64 ... 65536; --frames 300 for the whole animation of four seconds.
 */
#include "moving.h"
#include "shapes.h"

enum { KEYS = 5 };

static double chance(unsigned *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (double)(*state >> 8) / 16777216.0;
}

/* A point of shape `key`; x and y are 0 to 1. */
static void shape(int key, double x, double y, double *p)
{
    const double turn = 2 * PI * x, up = PI * (y - 0.5), tube = 2 * PI * y;
    switch (key) {
    case 0: /* a ball */
        p[0] = cos(up) * cos(turn), p[1] = sin(up), p[2] = cos(up) * sin(turn);
        break;
    case 1: /* a ring */
        p[0] = (0.9 + 0.35 * cos(tube)) * cos(turn), p[1] = 0.35 * sin(tube);
        p[2] = (0.9 + 0.35 * cos(tube)) * sin(turn);
        break;
    case 2: /* a winding stair */
        p[0] = y * cos(3 * turn), p[1] = 2.2 * x - 1.1, p[2] = y * sin(3 * turn);
        break;
    case 3: /* four pillars */
        p[0] = (x < 0.5 ? -0.8 : 0.8) + 0.2 * cos(8 * turn), p[1] = 2.2 * y - 1.1;
        p[2] = (fmod(4 * x, 2) < 1 ? -0.8 : 0.8) + 0.2 * sin(8 * turn);
        break;
    default: /* a wave */
        p[0] = 2.6 * x - 1.3, p[1] = 0.4 * sin(9 * x) * cos(7 * y), p[2] = 2.6 * y - 1.3;
    }
}

/* Where the triangles are in shape `key`: each somewhere else than in the one before. */
static void keyFrame(int key, int triangles, float (*position)[3])
{
    const double size = 7 / sqrt((double)triangles);
    unsigned state = 1u + 7919u * (unsigned)key;
    int i, j, k;
    for (i = 0; i < triangles; i++) {
        double centre[3];
        const double x = chance(&state), y = chance(&state);
        shape(key, x, y, centre);
        for (j = 0; j < 3; j++)
            for (k = 0; k < 3; k++)
                position[3 * i + j][k] = (float)(1.5 * centre[k] + size * (2 * chance(&state) - 1));
    }
}

/* A hall with pillars, a frieze of pictures and a plinth. */
static void hall(RTuint object)
{
    int i;
    movingSurface(0.75f, 0.72f, 0.65f);
    rtNewObject(object, RT_COMPILE | RT_STATIC);
    solidCube(14);
    for (i = 0; i < 8; i++) {
        rtPushMatrix();
        rtRotated(90 * (i / 2), 0, 1, 0);
        rtTranslated(i % 2 ? 6.3 : 2, -7, 6.3);
        solidCone(0.5, 0.4, 14, 24);
        rtPopMatrix();
    }
    movingSurface(0.35f, 0.2f, 0.12f);
    rtPushMatrix();
    rtTranslated(0, -6.99, 0);
    solidFloor(14);
    rtTranslated(0, 2.5, 0);
    rtScaled(1, 5, 1);
    solidCube(1.1);
    rtPopMatrix();
    for (i = 0; i < 8; i++) {
        movingSurface(i % 3 == 0 ? 0.8f : 0.2f, i % 3 == 1 ? 0.7f : 0.2f, i % 2 ? 0.75f : 0.25f);
        rtPushMatrix();
        rtRotated(90 * (i / 2), 0, 1, 0);
        rtTranslated(i % 2 ? 3.2 : -3.2, -0.5, -6.95);
        rtScaled(1, 0.7, 0.02);
        solidCube(3);
        rtPopMatrix();
    }
    rtEndObject();
}

int main(int argc, char **argv)
{
    Moving m = movingBegin(argc, argv, 8, 4096);
    const int vertices = 3 * m.triangles;
    float(*key[KEYS])[3], (*position)[3] = malloc((size_t)vertices * sizeof *position);
    RTuint art, room;
    int frame, i, k;

    rtMaxDepth(1);
    rtPerspective(60, (RTdouble)m.e.width / m.e.height, 0.1, 100);
    for (i = 0; i < 2; i++) {
        rtGenNewShaderClass("point", NULL);
        rtUseLight(rtGenNewShader());
        rtParameter3f(rtParameterHandle("position"), i ? 4.0f : -3.5f, 5.5f, i ? -3.0f : 4.0f);
        rtParameter3f(rtParameterHandle("color"), 0.45f, 0.43f, 0.38f);
    }
    movingAmbient(0.2f);
    art = rtGenObjects(2);
    room = art + 1;
    hall(room);

    for (k = 0; k < KEYS; k++) {
        key[k] = malloc((size_t)vertices * sizeof *position);
        if (!key[k] || !position)
            return 1;
        keyFrame(k, m.triangles, key[k]);
    }
    movingSurface(0.35f, 0.3f, 0.1f);
    rtParameter3f(rtParameterHandle("reflection"), 0.5f, 0.45f, 0.3f);
    rtEnableClientState(RT_VERTEX_ARRAY);
    rtVertexPointer(3, RT_FLOAT, 0, key[0]);
    rtNewObject(art, RT_COMPILE | RT_UNSTRUCTURED);
    rtDrawArrays(RT_TRIANGLES, 0, vertices);
    rtEndObject();
    movingStrategy(&m, art);
    for (k = 0; k < KEYS; k++)
        rtKeyFrame(art, (RTfloat)k, vertices, 0, &key[k][0][0]);

    for (frame = 0; frame < m.e.frames; frame++) {
        const double share = (double)frame / m.e.frames, time = (KEYS - 1) * share;
        const int from = (int)time;
        const float part = (float)(time - from);
        for (i = 0; i < 3 * vertices; i++)
            (&position[0][0])[i] = (1 - part) * (&key[from][0][0])[i] + part * (&key[from + 1][0][0])[i];
        rtUpdateVertices(art, 0, vertices, 0, &position[0][0]);
        rtObjectParameterf(art, RT_OBJECT_TIME, (RTfloat)time);
        rtLookAt(5.2 * sin(3 * share), 1.2, 5.2 * cos(3 * share), 0, -0.5, 0, 0, 1, 0);
        rtInstantiateObject(room);
        rtInstantiateObject(art);
        movingFrame(&m, "museum", frame);
    }
    for (k = 0; k < KEYS; k++)
        free(key[k]);
    free(position);
    return movingEnd(&m, "museum", m.triangles);
}
