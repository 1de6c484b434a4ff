/* The caller's floating-point environment is not changed by any call, and has no influence on the picture: neither flushing of denormals nor a
 * direction of rounding, now or when the threads were made. Nothing raises signals, if the caller has asked for them. */
#include "check.h"

#if defined(__x86_64__)

enum { SIZE = 48 };

/* Numbers that are computed before the environment is changed. */
static double circle[13][3];
static float depth[6], red[6];

static void prepare(void)
{
    int i, k;
    for (k = 0; k <= 12; k++)
        circle[k][0] = cos(k * 0.5236), circle[k][1] = sin(k * 0.5236), circle[k][2] = 0.1 * k;
    for (i = 0; i < 6; i++)
        depth[i] = 1e-39f * (float)(i % 2) + 0.3f, red[i] = 0.2f * (float)i;
}

/* Divisions by 0, overflows and numbers that are none, in all kinds of calls. */
static void exceptional(void)
{
    rtBegin(RT_TRIANGLES);
    rtTexCoord4f(1, 1, 0, 0);
    rtVertex4f(0, 0, 0, 0), rtVertex4f(1, 2, 3, 0), rtVertex3d(1e300, -1e300, 1e-300);
    rtVertex3f(3e38f, 3e38f, 3e38f), rtVertex3f(0, 0, 1e-40f), rtVertex4f(1, 0, 0, 1e-45f);
    rtEnd();
    rtPushMatrix();
    rtScaled(1e300, 1e-300, 0), rtScalef(1e30f, 1e-30f, 0), rtScalef(1e30f, 1e-30f, 0);
    rtRotatef(0.1f, 0, 0, 0), rtRotatef(0.1f, 1e-30f, 1e30f, 0);
    rtBegin(RT_TRIANGLES);
    rtNormal3f(0, 0, 1);
    rtVertex3f(3, 4, 5), rtVertex3f(1, 2, 3), rtVertex3f(3, 1, 2);
    rtEnd();
    rtPopMatrix();
    while (rtGetError() != RT_NO_ERROR) {
    }
}

static void scene(float *image)
{
    int i, k;
    rtSetFrameBuffer(image, SIZE, SIZE, RT_RGBA32F);
    for (i = 0; i < 6; i++) {
        rtPushMatrix();
        rtTranslatef((float)(i % 3) - 1, (float)(i / 3) - 0.5f, -3);
        rtRotatef(17 * (float)i, 1, 2, 3);
        rtScalef(0.4f, 0.4f, depth[i]);
        rtBegin(RT_TRIANGLE_FAN);
        rtNormal3f(0, 0, 1);
        rtColor3f(red[i], 1, 1e-40f);
        rtVertex3f(0, 0, 1e-40f);
        for (k = 0; k <= 12; k++)
            rtVertex3d(circle[k][0], circle[k][1], circle[k][2]);
        rtEnd();
        rtPopMatrix();
    }
    rtRender();
    CHECK(rtGetError() == RT_NO_ERROR);
}

int main(void)
{
    static float plain[SIZE * SIZE * 4], other[SIZE * SIZE * 4];
    /* Flush to zero, denormals are zero; each way of rounding. */
    static const unsigned settings[] = {0x8040, 0x0040, 0x8000, 0x2000, 0x4000, 0x6000, 0xE040};
    const unsigned normal = __builtin_ia32_stmxcsr();
    size_t i;
    prepare();
    rtInit(NULL, NULL);
    scene(plain);
    rtExit();
    for (i = 0; i < sizeof settings / sizeof settings[0]; i++) {
        const unsigned mine = (normal & ~0xFFFFu) | 0x1F80u | settings[i];
        /* The pool is born under the setting, then the setting is gone; and the other way round. */
        int born;
        for (born = 0; born < 2; born++) {
            __builtin_ia32_ldmxcsr(born ? mine : normal);
            rtInit(NULL, NULL);
            __builtin_ia32_ldmxcsr(born ? normal : mine);
            memset(other, 0, sizeof other);
            scene(other);
            CHECK((__builtin_ia32_stmxcsr() & 0xFFC0u) == ((born ? normal : mine) & 0xFFC0u));
            __builtin_ia32_ldmxcsr(normal);
            if (memcmp(plain, other, sizeof plain) != 0) {
                fprintf(stderr, "another picture with MXCSR 0x%X (%s)\n", mine, born ? "when the pool was made" : "when drawing");
                return 1;
            }
            rtExit();
        }
    }
    /* All exceptions but those of inexact and denormal numbers are signals: the first one would end the program. */
    rtInit(NULL, NULL);
    __builtin_ia32_ldmxcsr((normal & ~0xFFFFu) | 0x1100u);
    exceptional();
    rtRender();
    rtExit();
    __builtin_ia32_ldmxcsr(normal);
    printf("%u settings\n", (unsigned)(sizeof settings / sizeof settings[0]));
    return 0;
}

#else

int main(void)
{
    printf("SKIPPED: only the x86 has an MXCSR\n");
    return 0;
}

#endif
