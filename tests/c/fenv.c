/* The caller's floating-point environment is not changed by any call. Flushing denormals has no influence on the picture, and neither has
 * any setting that was on when the threads were made. (A direction of rounding does have, on vertices, which the caller's thread transforms.) */
#include "check.h"

#if defined(__x86_64__)

enum { SIZE = 48 };

static void scene(float *image)
{
    int i, k;
    rtSetFrameBuffer(image, SIZE, SIZE, RT_RGBA32F);
    for (i = 0; i < 6; i++) {
        rtPushMatrix();
        rtTranslatef((float)(i % 3) - 1, (float)(i / 3) - 0.5f, -3);
        rtRotatef(17 * (float)i, 1, 2, 3);
        rtScalef(0.4f, 0.4f, 1e-39f * (float)(i % 2) + 0.3f);
        rtBegin(RT_TRIANGLE_FAN);
        rtNormal3f(0, 0, 1);
        rtColor3f(0.2f * (float)i, 1, 1e-40f);
        rtVertex3f(0, 0, 1e-40f);
        for (k = 0; k <= 12; k++)
            rtVertex3d(cos(k * 0.5236), sin(k * 0.5236), 0.1 * k);
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
    static const unsigned settings[] = {0x8040, 0x0040, 0x8000, 0x2000, 0x4000, 0x6000, 0xE040}, rounding = 0x6000;
    const unsigned normal = __builtin_ia32_stmxcsr();
    size_t i;
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
            if ((born || !(settings[i] & rounding)) && memcmp(plain, other, sizeof plain) != 0) {
                fprintf(stderr, "another picture with MXCSR 0x%X (%s)\n", mine, born ? "when the pool was made" : "when drawing");
                return 1;
            }
            rtExit();
        }
    }
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
