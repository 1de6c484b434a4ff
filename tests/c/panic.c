/* A defect inside the library ends the context, not the program. Debug builds have a defect on demand. */
#include "world.h"

static RTenum told;

static void on_error(RTenum error, const char *message, void *userData)
{
    (void)userData;
    CHECK(strstr(message, "defect"));
    told = error;
}

int main(void)
{
    RTuint broken, sound;
    int i;
    setup();
    broken = rtGetCurrentContext();
    sound = rtCreateContext();
    rtErrorCallback(on_error, NULL);
    rtEnable(0x7FFFDEADu);
    if (told == RT_INVALID_ENUM) {
        printf("SKIPPED: this build of the library has no defect on demand\n");
        return 0;
    }
    CHECK(told == RT_INTERNAL_ERROR);

    /* Every later call says so, again and again, and does nothing. */
    for (i = 0; i < 3; i++) {
        CHECK(rtGetError() == RT_INTERNAL_ERROR);
        CHECK(strstr(rtGetErrorString(RT_INTERNAL_ERROR), "the defect that tests ask for"));
        rtVertex3f(0, 0, 0);
        rtRender();
        CHECK(rtGenObjects(1) == 0 && !rtIsObject(object));
    }

    /* Other contexts are not touched by it, and the broken one can be destroyed. */
    rtMakeCurrent(sound);
    CHECK(rtGetCurrentContext() == sound && rtGenObjects(1) != 0 && rtGetError() == RT_NO_ERROR);
    rtDestroyContext(broken);
    CHECK(rtGetError() == RT_NO_ERROR);
    rtDestroyContext(sound);
    setup();
    CHECK(rtGetError() == RT_NO_ERROR);
    rtExit();
    remove(image_file);
    printf("alive\n");
    return 0;
}
