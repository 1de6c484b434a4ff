/* wave.c - an unstructured motion: every vertex of the water moves in every frame, its triangles stay the same. */
#include "example.h"
#include "shapes.h"

enum { N = 160 }; /* squares along each side */
#define SIZE 10.0f

static float position[(N + 1) * (N + 1)][3], normal[(N + 1) * (N + 1)][3];
static RTuint index_[N * N * 6];

/* Rings around two drops. Slopes are taken from the heights beside, so that the normals fit any height. */
static float height(float x, float z, float time)
{
    const float a = (float)sqrt((x + 2) * (x + 2) + (z - 1) * (z - 1));
    const float b = (float)sqrt((x - 3) * (x - 3) + (z + 2) * (z + 2));
    return 0.16f * (float)(sin(4 * a - time) / (1 + 0.5 * a) + sin(4 * b - time + 2) / (1 + 0.5 * b));
}

static void moveWater(float time)
{
    const float d = 0.01f;
    int i, k;
    for (k = i = 0; i <= N; i++) {
        int j;
        for (j = 0; j <= N; j++, k++) {
            const float x = SIZE * ((float)j / N - 0.5f), z = SIZE * ((float)i / N - 0.5f);
            position[k][0] = x;
            position[k][1] = height(x, z, time);
            position[k][2] = z;
            normal[k][0] = height(x - d, z, time) - height(x + d, z, time);
            normal[k][1] = 2 * d;
            normal[k][2] = height(x, z - d, time) - height(x, z + d, time);
        }
    }
}

static void connectWater(void)
{
    RTuint *t = index_;
    int i, j;
    for (i = 0; i < N; i++) {
        for (j = 0; j < N; j++) {
            const RTuint a = (RTuint)(i * (N + 1) + j), b = a + 1, c = a + N + 1, d = c + 1;
            *t++ = a, *t++ = c, *t++ = b;
            *t++ = b, *t++ = c, *t++ = d;
        }
    }
}

int main(int argc, char **argv)
{
    Example e;
    RTuint water, ball, light;
    int frame;

    rtInit(&argc, argv);
    e = exampleOptions(argc, argv, 8);
    rtViewport(0, 0, e.width, e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtClearColor(0.45f, 0.6f, 0.8f, 1);
    rtPerspective(40, (RTdouble)e.width / e.height, 0.1, 100);
    rtLookAt(0, 4.5, 10, 0, -0.3, 0, 0, 1, 0);

    rtGenNewShaderClass("directional", NULL);
    light = rtGenNewShader();
    rtParameter3f(rtParameterHandle("direction"), -0.6f, -1, -0.5f);

    water = rtGenObjects(2);
    ball = water + 1;
    rtGenNewShaderClass("phong", NULL);
    rtGenNewShader();
    rtParameter3f(rtParameterHandle("diffuse"), 0.05f, 0.2f, 0.35f);
    rtParameter3f(rtParameterHandle("reflection"), 0.4f, 0.4f, 0.4f);

    moveWater(0);
    connectWater();
    rtEnableClientState(RT_VERTEX_ARRAY);
    rtEnableClientState(RT_NORMAL_ARRAY);
    rtVertexPointer(3, RT_FLOAT, 0, position);
    rtNormalPointer(RT_FLOAT, 0, normal);
    rtNewObject(water, RT_COMPILE | RT_UNSTRUCTURED);
    rtDrawElements(RT_TRIANGLES, N * N * 6, RT_UNSIGNED_INT, index_);
    rtEndObject();

    rtGenNewShader();
    rtParameter3f(rtParameterHandle("diffuse"), 0.8f, 0.15f, 0.05f);
    rtNewObject(ball, RT_COMPILE);
    solidSphere(0.7, 48, 24);
    rtEndObject();

    for (frame = 0; frame < e.frames; frame++) {
        const float time = (float)(2 * PI) * (float)frame / (float)e.frames;
        moveWater(time);
        rtUpdateVertices(water, 0, (N + 1) * (N + 1), 0, &position[0][0]);
        rtUpdateNormals(water, 0, (N + 1) * (N + 1), 0, &normal[0][0]);

        rtUseLight(light);
        rtInstantiateObject(water);
        rtPushMatrix();
        rtTranslatef(0.5f, height(0.5f, 0.5f, time) + 0.35f, 0.5f);
        rtInstantiateObject(ball);
        rtPopMatrix();
        rtRender();
        exampleWrite(&e, "wave", frame);
    }
    return exampleEnd();
}
