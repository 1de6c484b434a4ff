/* Scene files from C: what is defined, what a frame gets, what is told. In a library without the readers: that it says so. Arguments: a folder to write
 * in, and the file tests/data/every.aff. */
#include "check.h"

static void write_file(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    CHECK(file != NULL);
    fputs(text, file);
    fclose(file);
}

static RTint number(RTuint scene, RTenum pname)
{
    RTint value = -1;
    rtGetLoadedSceneiv(scene, pname, &value);
    CHECK(rtGetError() == RT_NO_ERROR);
    return value;
}

static RTint state(RTenum pname)
{
    RTint value = -1;
    rtGetIntegerv(pname, &value);
    return value;
}

static void without_readers(const char *file)
{
    CHECK(rtLoadScene(file, RT_SCENE_ALL_BITS) == 0);
    CHECK(rtGetError() == RT_INVALID_OPERATION);
    CHECK(strstr(rtGetErrorString(RT_INVALID_OPERATION), "without the readers of scene files") != NULL);
    rtInstantiateLoadedScene(1, 0, RT_SCENE_ALL_BITS);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    CHECK(!rtIsLoadedScene(1));
}

static void moving_scene(const char *file)
{
    const char *names[3];
    RTdouble times[2], bounds[6], matrix[16];
    RTuint scene, object;
    RThit hit;
    RTint i;
    rtViewport(0, 0, 64, 48);
    rtTranslatef(0, 0, 0.5f);
    rtColor3f(0.25f, 0.5f, 0.75f);
    scene = rtLoadScene(file, RT_NONE);
    CHECK(scene != 0 && rtGetError() == RT_NO_ERROR && rtIsLoadedScene(scene));
    CHECK(state(RT_INSTANCE_COUNT) == 0 && state(RT_LIGHT_COUNT) == 0 && state(RT_SHADER_BINDING) == 0);
    CHECK(number(scene, RT_SCENE_LIGHT_COUNT) == 2 && number(scene, RT_SCENE_CAMERA_COUNT) == 1);
    CHECK(number(scene, RT_SCENE_FRAME_COUNT) == 21 && number(scene, RT_SCENE_WARNING_COUNT) == 0);
    CHECK(number(scene, RT_SCENE_SRGB) == 0 && number(scene, RT_SCENE_TRIANGLE_COUNT) > 10);
    object = (RTuint)number(scene, RT_SCENE_FIRST_OBJECT);
    for (i = 0; i < number(scene, RT_SCENE_OBJECT_COUNT); i++) {
        CHECK(rtIsObject(object + (RTuint)i));
        CHECK(rtGetLoadedSceneString(scene, RT_SCENE_OBJECT_NAME, (RTuint)i)[0]);
    }
    names[0] = rtGetLoadedSceneString(scene, RT_SCENE_FORMAT, 0);
    names[1] = rtGetLoadedSceneString(scene, RT_SCENE_OBJECT_NAME, 0);
    CHECK(strcmp(names[0], "AFF") == 0 && strlen(names[1]) > 0); /* both live */
    rtGetLoadedScenedv(scene, RT_SCENE_TIMES, times);
    CHECK(times[0] == 0 && times[1] == 2);
    rtGetLoadedScenedv(scene, RT_SCENE_BOUNDS, bounds);
    CHECK(bounds[0] == -5 && bounds[3] == 5 && bounds[4] >= 4);

    /* The flap is visible until 1.5 s. */
    rtInstantiateLoadedScene(scene, times[0], RT_SCENE_ALL_BITS);
    i = state(RT_INSTANCE_COUNT);
    CHECK(i >= number(scene, RT_SCENE_OBJECT_COUNT) && state(RT_LIGHT_COUNT) == 3); /* with the ambient light */
    rtGetDoublev(RT_MATRIX, matrix);
    CHECK(matrix[14] == 0.5 && state(RT_MATRIX_STACK_DEPTH) == 1);
    rtRender();
    CHECK(rtGetError() == RT_NO_ERROR);
    CHECK(rtPick(32.5f, 24.5f, &hit) && hit.object >= object); /* the sphere that the camera looks at */
    rtInstantiateLoadedScene(scene, times[1], RT_SCENE_INSTANCES_BIT);
    CHECK(state(RT_INSTANCE_COUNT) < i);
    rtRender();
    rtInstantiateLoadedScene(scene, 0.5, RT_SCENE_INSTANCES_BIT);
    rtDeleteLoadedScene(scene);
    CHECK(!rtIsLoadedScene(scene) && !rtIsObject(object) && state(RT_INSTANCE_COUNT) > 0);
    rtRender();
    CHECK(rtGetError() == RT_NO_ERROR);
    rtInstantiateLoadedScene(scene, 0, RT_SCENE_ALL_BITS);
    CHECK(rtGetError() == RT_INVALID_VALUE);
}

/* What is left out is told; what cannot be read is an error with file and line, and defines nothing. */
static void faults(const char *folder)
{
    char path[2048];
    RTuint scene, before = rtGenObjects(1);
    const char *text;
    snprintf(path, sizeof path, "%s/odd.nff", folder);
    write_file(path, "b 1 0 0\nzz 1 2 3\ns 0 0 0 1\n");
    scene = rtLoadScene(path, RT_SCENE_INSTANCES_BIT);
    CHECK(scene != 0 && number(scene, RT_SCENE_WARNING_COUNT) == 1 && state(RT_INSTANCE_COUNT) == 1);
    text = rtGetLoadedSceneString(scene, RT_SCENE_WARNING, 0);
    CHECK(text && strstr(text, "odd.nff:2: ") && strstr(text, "zz"));
    CHECK(rtGetLoadedSceneString(scene, RT_SCENE_WARNING, 1) == NULL && rtGetError() == RT_INVALID_VALUE);
    write_file(path, "\n\ns 0 0 0 x\n");
    CHECK(rtLoadScene(path, RT_SCENE_ALL_BITS) == 0 && rtGetError() == RT_IO_ERROR);
    CHECK(strstr(rtGetErrorString(RT_IO_ERROR), "odd.nff:3: ") != NULL);
    snprintf(path, sizeof path, "%s/nothing.obj", folder);
    CHECK(rtLoadScene(path, RT_SCENE_ALL_BITS) == 0 && rtGetError() == RT_IO_ERROR);
    CHECK(strstr(rtGetErrorString(RT_IO_ERROR), "nothing.obj") != NULL);
    CHECK(state(RT_INSTANCE_COUNT) == 1 && rtGenObjects(1) == before + 2); /* the sphere had one name */
}

int main(int argc, char **argv)
{
    CHECK(argc == 3);
    rtInit(NULL, NULL);
    if (!state(RT_SCENE_READERS)) {
        without_readers(argv[2]);
        printf("a library without the readers\n");
    } else {
        moving_scene(argv[2]);
        faults(argv[1]);
    }
    rtExit();
    CHECK(rtGetError() == RT_NO_ERROR);
    return 0;
}
