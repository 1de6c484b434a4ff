/* Texts: they live as long as the process, and those of errors name the call, the argument and its value. */
#include "check.h"

static void says(RTenum error, const char *expected)
{
    const RTenum got = rtGetError();
    const char *text = rtGetErrorString(got);
    if (got != error || strcmp(text, expected) != 0) {
        fprintf(stderr, "0x%X \"%s\"\n  instead of 0x%X \"%s\"\n", got, text, error, expected);
        exit(1);
    }
}

/* Several texts in one line, as OpenGL programs print them. */
static void texts_live_on(void)
{
    char line[128];
    const char *vendor = rtGetString(RT_VENDOR), *version = rtGetString(RT_VERSION), *name, *shape, *error;
    RTuint class_, handle;
    snprintf(line, sizeof line, "%s|%s|%s", rtGetString(RT_VENDOR), rtGetString(RT_RENDERER), rtGetString(RT_BACKEND));
    CHECK(strcmp(line, "The openrt project|whitted|local") == 0);
    CHECK(vendor == rtGetString(RT_VENDOR));
    class_ = rtGenNewShaderClass("area", NULL);
    rtGenNewShader();
    name = rtGetShaderClassName(class_);
    handle = rtParameterHandle("shape");
    shape = rtGetParameterString(handle);
    rtParameterString(handle, "disc");
    CHECK(strcmp(rtGetParameterString(handle), "disc") == 0 && strcmp(shape, "rectangle") == 0);
    CHECK(strcmp(rtGetShaderClassParameterName(class_, 1), "position") == 0 && strcmp(name, "area") == 0);
    rtInstantiateObject(5);
    error = rtGetErrorString(rtGetError());
    rtInstantiateObject(6);
    CHECK(strcmp(rtGetErrorString(rtGetError()), error) != 0);
    rtExit();
    CHECK(strcmp(error, "rtInstantiateObject: there is no object 5") == 0 && version[0] == '0');
    rtInit(0, 0);
}

static void errors_say_what_was_wrong(void)
{
    static const RTfloat matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, INFINITY, 0, 0, 0, 0, 1};
    RTuint area, color;
    rtInstantiateObject(77);
    says(RT_INVALID_VALUE, "rtInstantiateObject: there is no object 77");
    rtDeleteObjects(1, -3);
    says(RT_INVALID_VALUE, "rtDeleteObjects: n is -3; it must not be negative");
    rtBegin(99);
    says(RT_INVALID_ENUM, "rtBegin: mode is 0x0063, which is not a primitive");
    rtSamplesPerPixel(0);
    says(RT_INVALID_VALUE, "rtSamplesPerPixel: the value is 0; it must be 1 to 65536");
    rtLoadMatrixf(matrix);
    says(RT_INVALID_VALUE, "rtLoadMatrixf: the matrix would have the element inf in row 2, column 2");
    rtLoadMatrixf(NULL);
    says(RT_INVALID_VALUE, "rtLoadMatrixf: m is NULL");
    rtRotatef(1, 0, 0, 0);
    says(RT_INVALID_VALUE, "rtRotatef: the axis is [0, 0, 0]; it must be finite and not 0");
    rtScalef(1e19f, 1, 1);
    rtNewObject(4, RT_COMPILE);
    rtEndObject();
    rtInstantiateObject(4);
    says(RT_INVALID_VALUE,
         "rtInstantiateObject: the current matrix has an element of magnitude 1e19; coordinates reach to 1.844e18");
    rtLoadIdentity();
    rtNewObject(4, RT_COMPILE);
    rtRender();
    says(RT_INVALID_OPERATION, "rtRender: not allowed while object 4 is being defined");
    rtInstantiateObject(4);
    says(RT_INVALID_OPERATION, "rtInstantiateObject: object 4 cannot be a part of itself");
    rtEndObject();
    rtBindShader(12);
    says(RT_INVALID_VALUE, "rtBindShader: there is no shader 12");
    CHECK(rtGenNewShaderClass("Phong", NULL) == 0);
    says(RT_INVALID_VALUE, "rtGenNewShaderClass: there is no built-in shader class \"Phong\"; "
                           "did you mean \"phong\"? Upper and lower case count");
    CHECK(rtGenNewShaderClass("glas", NULL) == 0);
    says(RT_INVALID_VALUE,
         "rtGenNewShaderClass: there is no built-in shader class \"glas\"; did you mean \"glass\"?");
    CHECK(rtGenNewShaderClass("banana", NULL) == 0);
    says(RT_INVALID_VALUE, "rtGenNewShaderClass: there is no built-in shader class \"banana\"");
    CHECK(rtGenNewShaderClass("area", NULL) != 0);
    area = rtGenNewShader();
    CHECK(rtParameterHandle("colour") == 0);
    says(RT_INVALID_VALUE,
         "rtParameterHandle: shader class \"area\" has no parameter \"colour\"; did you mean \"color\"?");
    color = rtParameterHandle("color");
    rtParameter1f(color, 1);
    says(RT_INVALID_OPERATION,
         "rtParameter1f: parameter \"color\" of shader class \"area\" is 3 floats, and was given a float");
    rtParameterString(rtParameterHandle("shape"), "banana");
    says(RT_INVALID_VALUE, "rtParameterString: parameter \"shape\" cannot be \"banana\"; "
                           "it is one of [\"rectangle\", \"disc\", \"sphere\"]");
    CHECK(strcmp(rtGetParameterString(rtParameterHandle("shape")), "rectangle") == 0);
    rtUseCamera(area);
    says(RT_INVALID_OPERATION, "rtUseCamera: shader 1, of class \"area\", is not a camera");
    rtVertex3f(1, 2, 3);
    says(RT_INVALID_OPERATION, "rtVertex3f: no primitive is open: a vertex belongs between begin and end");
    rtBegin(RT_TRIANGLES);
    rtVertex3fv(NULL);
    rtEnd();
    says(RT_INVALID_VALUE, "rtVertex3fv: v is NULL");
    rtTexImage2D(RT_TEXTURE_2D, -1, RT_RGBA, 1, 1, 0, RT_RGBA, RT_UNSIGNED_BYTE, NULL);
    says(RT_INVALID_VALUE, "rtTexImage2D: level is -1; it must not be negative");
    rtMakeCurrent(55);
    says(RT_INVALID_VALUE, "rtMakeCurrent: there is no context 55");
    rtWriteImage("nothing.png");
    says(RT_INVALID_OPERATION, "rtWriteImage: nothing was rendered yet");
    /* Any other error is named in general. */
    CHECK(strcmp(rtGetErrorString(RT_INVALID_ENUM), "invalid enumerant") == 0);
    CHECK(strcmp(rtGetErrorString(RT_NO_ERROR), "no error") == 0);
}

/* Texts of errors do not grow without bound. */
static void many_errors(void)
{
    RTuint i;
    const char *text = "";
    for (i = 1000; i < 100000; i++) {
        rtInstantiateObject(i);
        text = rtGetErrorString(rtGetError());
    }
    CHECK(strcmp(text, "invalid value") == 0);
    rtInstantiateObject(77);
    says(RT_INVALID_VALUE, "rtInstantiateObject: there is no object 77");
}

int main(void)
{
    rtInit(0, 0);
    texts_live_on();
    errors_say_what_was_wrong();
    many_errors();
    return 0;
}
