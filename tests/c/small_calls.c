/* Small calls: JPEG quality, frame buffers with blue first, the name of what is drawn outside objects, parameters before the definition, threads. Argument: a
 * folder to write in. */
#include "check.h"

static long size_of(const char *path)
{
    FILE *file = fopen(path, "rb");
    long size;
    CHECK(file != NULL && fseek(file, 0, SEEK_END) == 0);
    size = ftell(file);
    fclose(file);
    return size;
}

static void triangle(RTfloat z)
{
    rtBegin(RT_TRIANGLES);
    rtColor3f(1, 0, 0), rtVertex3f(-1, -1, z);
    rtColor3f(0, 1, 0), rtVertex3f(1, -1, z);
    rtColor3f(0, 0, 1), rtVertex3f(0, 1, z);
    rtEnd();
}

static void jpeg_quality(const char *folder)
{
    const RTint qualities[3] = {5, 92, 100};
    RTint i, quality;
    char path[2048];
    long sizes[3];
    rtGetIntegerv(RT_JPEG_QUALITY, &quality);
    CHECK(quality == 92);
    triangle(-2);
    rtRender();
    for (i = 0; i < 3; i++) {
        rtJpegQuality(qualities[i]);
        rtJpegQuality(101);
        CHECK(rtGetError() == RT_INVALID_VALUE);
        rtGetIntegerv(RT_JPEG_QUALITY, &quality);
        CHECK(quality == qualities[i]);
        snprintf(path, sizeof path, "%s/%d.jpg", folder, (int)qualities[i]);
        rtWriteImage(path);
        CHECK(rtGetError() == RT_NO_ERROR);
        sizes[i] = size_of(path);
    }
    CHECK(sizes[0] < sizes[1] && sizes[1] < sizes[2]);
}

static void blue_first(void)
{
    static const struct {
        RTenum format, read;
        int channels, floats;
    } formats[3] = {{RT_BGR8, RT_BGR, 3, 0}, {RT_BGR32F, RT_BGR, 3, 1}, {RT_BGRA32F, RT_BGRA, 4, 1}};
    int i;
    rtViewport(0, 0, 6, 4);
    rtClearColor(0.25f, 0.5f, 0.75f, 0.125f);
    for (i = 0; i < 3; i++) {
        RTfloat floats[6 * 4 * 4 + 1], read[6 * 4 * 4];
        RTubyte bytes[6 * 4 * 3 + 1], read_bytes[6 * 4 * 3];
        const int n = formats[i].channels, last = 6 * 4 * n;
        floats[last] = 77, bytes[6 * 4 * 3] = 77;
        rtSetFrameBuffer(formats[i].floats ? (void *)floats : (void *)bytes, 6, 4, formats[i].format);
        rtClearInstances();
        rtRender();
        rtReadPixels(0, 0, 6, 4, formats[i].read, formats[i].floats ? RT_FLOAT : RT_UNSIGNED_BYTE,
                     formats[i].floats ? (void *)read : (void *)read_bytes);
        CHECK(rtGetError() == RT_NO_ERROR);
        if (formats[i].floats) {
            CHECK(floats[last - n] == 0.75f && floats[last - n + 1] == 0.5f && floats[last - n + 2] == 0.25f);
            CHECK(floats[last] == 77 && memcmp(floats, read, sizeof *read * (size_t)last) == 0);
        } else {
            CHECK(bytes[last - 3] == 191 && bytes[last - 2] == 128 && bytes[last - 1] == 64);
            CHECK(bytes[last] == 77 && memcmp(bytes, read_bytes, sizeof read_bytes) == 0);
        }
    }
    rtSetFrameBuffer(NULL, 0, 0, RT_RGBA8);
    rtViewport(0, 0, 64, 48);
    CHECK(rtGetError() == RT_NO_ERROR);
}

static void immediate_triangles_have_a_name(void)
{
    RTuint ids[1];
    RThit hit;
    rtClearInstances();
    triangle(-2);
    rtRender();
    CHECK(rtPick(32, 20, &hit) && hit.object == RT_IMMEDIATE_OBJECT && hit.primitive == 0);
    rtReadPixels(32, 20, 1, 1, RT_OBJECT_ID, RT_UNSIGNED_INT, ids);
    CHECK(ids[0] == RT_IMMEDIATE_OBJECT);
    /* No call takes it. */
    rtInstantiateObject(RT_IMMEDIATE_OBJECT);
    CHECK(rtGetError() == RT_INVALID_VALUE);
    rtNewObject(RT_IMMEDIATE_OBJECT, RT_COMPILE);
    CHECK(rtGetError() == RT_INVALID_VALUE);
}

static RTenum of(RTuint object, RTenum pname)
{
    RTint value = 0;
    rtGetObjectParameteriv(object, pname, &value);
    CHECK(rtGetError() == RT_NO_ERROR);
    return (RTenum)value;
}

static void parameters_before_the_definition_count(void)
{
    const RTuint object = rtGenObjects(1);
    RThit hit;
    rtObjectParameteri(object, RT_MOTION, RT_STATIC);
    rtObjectParameteri(object, RT_UPDATE_STRATEGY, RT_BSP);
    rtObjectParameteri(object, RT_MASK, 0x100);
    rtNewObject(object, RT_COMPILE);
    triangle(-2);
    rtEndObject();
    CHECK(of(object, RT_MOTION) == RT_STATIC && of(object, RT_UPDATE_STRATEGY) == RT_BSP && of(object, RT_MASK) == 0x100);
    rtClearInstances();
    rtInstantiateObject(object);
    rtRender();
    CHECK(!rtPick(32, 20, &hit)); /* no camera ray sees it */
    /* A flag of the definition counts more, and so does what is set within it. */
    rtNewObject(object, RT_COMPILE | RT_UNSTRUCTURED);
    rtEndObject();
    CHECK(of(object, RT_MOTION) == RT_UNSTRUCTURED && of(object, RT_UPDATE_STRATEGY) == RT_BSP);
    rtNewObject(4711, RT_COMPILE | RT_AFFINE);
    rtObjectParameteri(4711, RT_MOTION, RT_STATIC);
    rtObjectParameteri(4711, RT_UPDATE_STRATEGY, RT_GRID);
    rtEndObject();
    CHECK(of(4711, RT_MOTION) == RT_STATIC && of(4711, RT_UPDATE_STRATEGY) == RT_GRID);
    rtObjectParameteri(4712, RT_MOTION, RT_STATIC);
    CHECK(rtGetError() == RT_INVALID_VALUE);
}

static void a_context_has_the_threads_it_was_given(void)
{
    const RTuint first = rtGetCurrentContext();
    const RTsizei given[3] = {1, 3, 0};
    RTint threads;
    int i;
    rtThreads(2);
    for (i = 0; i < 3; i++) {
        const RTuint context = rtCreateContextThreads(given[i]);
        rtMakeCurrent(context);
        rtGetIntegerv(RT_THREADS, &threads);
        CHECK(threads == (given[i] ? given[i] : 2));
        rtViewport(0, 0, 8, 8);
        triangle(-2);
        rtRender();
        CHECK(rtGetError() == RT_NO_ERROR);
        rtDestroyContext(context);
    }
    rtMakeCurrent(first);
}

int main(int argc, char **argv)
{
    RTint threads;
    CHECK(argc == 2);
    rtThreads(2);
    rtInit(NULL, NULL);
    rtGetIntegerv(RT_THREADS, &threads);
    CHECK(threads == 2);
    rtThreads(0);
    rtViewport(0, 0, 64, 48);
    jpeg_quality(argv[1]);
    blue_first();
    immediate_triangles_have_a_name();
    parameters_before_the_definition_count();
    a_context_has_the_threads_it_was_given();
    rtExit();
    CHECK(rtGetError() == RT_NO_ERROR);
    return 0;
}
