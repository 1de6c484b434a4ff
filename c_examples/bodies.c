/* bodies.c - nine deforming bodies on a table (after Larsson and Akenine-Moller 2003, figure 3): every vertex moves
 * in every frame, two lamps, one reflection, a camera that comes and goes, so that now all bodies are seen and now a few.
 *
 * The scene of the paper: bodies --triangles 737280 --frames 280 --subsampling 5 --strategy lazy, against refit.
 */
#include "moving.h"
#include "icosphere.h"
#include "shapes.h"

enum { BODIES = 9 };

/* A body is a ball with waves on it, each with its own. */
static void deform(const Icosphere *ball, float (*position)[3], float (*normal)[3], int body, double time)
{
    const double a = 2 + body % 3, b = 3 + body / 3, phase = 0.7 * body;
    int i, k;
    for (i = 0; i < ball->vertices; i++) {
        const float *p = ball->position[i];
        const double sideways = sin(a * 1.6 * p[0] + 2 * time + phase) * cos(b * 1.6 * p[2] - time);
        const float radius = (float)(0.8 + 0.11 * (sideways + sin(b * 1.8 * p[1] + 1.5 * time)));
        for (k = 0; k < 3; k++) {
            position[i][k] = radius * p[k];
            normal[i][k] = 0;
        }
    }
    /* The normal of a vertex is the mean of its triangles', the larger ones counting more. */
    for (i = 0; i < ball->triangles; i++) {
        const RTuint *t = ball->triangle[i];
        const float *p = position[t[0]], *q = position[t[1]], *r = position[t[2]];
        const float u[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]}, v[3] = {r[0] - p[0], r[1] - p[1], r[2] - p[2]};
        const float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        int corner;
        for (corner = 0; corner < 3; corner++)
            for (k = 0; k < 3; k++)
                normal[t[corner]][k] += n[k];
    }
}

static void lamp(float x, float y, float z)
{
    rtGenNewShaderClass("point", NULL);
    rtUseLight(rtGenNewShader());
    rtParameter3f(rtParameterHandle("position"), x, y, z);
    rtParameter3f(rtParameterHandle("color"), 0.55f, 0.55f, 0.5f);
}

int main(int argc, char **argv)
{
    static const float color[BODIES][3] = {{0.7f, 0.2f, 0.15f}, {0.2f, 0.5f, 0.2f},  {0.2f, 0.3f, 0.7f},
                                           {0.7f, 0.6f, 0.2f},  {0.6f, 0.6f, 0.62f}, {0.6f, 0.25f, 0.6f},
                                           {0.2f, 0.6f, 0.6f},  {0.75f, 0.4f, 0.1f}, {0.4f, 0.3f, 0.25f}};
    Moving m = movingBegin(argc, argv, 8, 46080);
    Icosphere ball;
    RTuint body, table;
    float(*position)[3], (*normal)[3];
    int frame, i, level = 0;

    while (level < 8 && BODIES * (20 << 2 * level) < m.triangles)
        level++;
    ball = icosphere(level);
    position = malloc((size_t)ball.vertices * sizeof *position);
    normal = malloc((size_t)ball.vertices * sizeof *normal);
    if (!position || !normal)
        return 1;

    rtMaxDepth(1);
    rtClearColor(0.5f, 0.6f, 0.75f, 1);
    rtPerspective(45, (RTdouble)m.e.width / m.e.height, 0.1, 100);
    lamp(-5, 7, 3);
    lamp(6, 6, -2);
    movingAmbient(0.25f);

    body = rtGenObjects(BODIES + 1);
    table = body + BODIES;
    movingSurface(0.45f, 0.4f, 0.35f);
    rtNewObject(table, RT_COMPILE | RT_STATIC);
    solidFloor(40);
    rtEndObject();

    rtEnableClientState(RT_VERTEX_ARRAY);
    rtEnableClientState(RT_NORMAL_ARRAY);
    rtVertexPointer(3, RT_FLOAT, 0, position);
    rtNormalPointer(RT_FLOAT, 0, normal);
    for (i = 0; i < BODIES; i++) {
        deform(&ball, position, normal, i, 0);
        movingSurface(color[i][0], color[i][1], color[i][2]);
        rtParameter3f(rtParameterHandle("specular"), 0.4f, 0.4f, 0.4f);
        rtParameter3f(rtParameterHandle("reflection"), 0.3f, 0.3f, 0.3f);
        rtNewObject(body + (RTuint)i, RT_COMPILE | RT_UNSTRUCTURED);
        rtDrawElements(RT_TRIANGLES, 3 * ball.triangles, RT_UNSIGNED_INT, ball.triangle);
        rtEndObject();
        movingStrategy(&m, body + (RTuint)i);
    }

    for (frame = 0; frame < m.e.frames; frame++) {
        const double share = (double)frame / m.e.frames, turn = 2 * PI * share, away = 6.5 + 2.5 * cos(2 * turn);
        rtLookAt(away * sin(turn), 2.6 + 0.3 * away, away * cos(turn), 0, 0.5, 0, 0, 1, 0);
        rtInstantiateObject(table);
        for (i = 0; i < BODIES; i++) {
            deform(&ball, position, normal, i, 14 * share);
            rtUpdateVertices(body + (RTuint)i, 0, ball.vertices, 0, &position[0][0]);
            rtUpdateNormals(body + (RTuint)i, 0, ball.vertices, 0, &normal[0][0]);
            rtPushMatrix();
            rtTranslated(2.4 * (i % 3 - 1), 1.05, 2.4 * (i / 3 - 1));
            rtInstantiateObject(body + (RTuint)i);
            rtPopMatrix();
        }
        movingFrame(&m, "bodies", frame);
    }
    free(position);
    free(normal);
    freeIcosphere(&ball);
    return movingEnd(&m, "bodies", BODIES * ball.triangles);
}
