// The C++ face: overloads, scopes, names that go away, exceptions.
#include <openrt/rt.hpp>

#include <cstdio>

int main()
{
    rt::Context context;
    rtViewport(0, 0, 16, 16);

    rt::Shader red("diffuse");
    red.set("color", 0.8f, 0.1f, 0.1f);
    red.bind();
    const rt::Object triangle(RT_COMPILE, [] {
        rt::primitive(RT_TRIANGLES, [] {
            rt::normal(0, 0, 1.0f);
            rt::vertex(-9, -9);
            rt::vertex(9.0, -9.0, 0.0);
            rt::vertex(rt::Vec3{0, 9, 0});
        });
    });
    {
        const rt::MatrixScope scope;
        rt::translate(0.0f, 0.0f, -1.0f);
        triangle.instantiate();
    }
    if (rt::currentMatrix()[14] != 0)
        return 2;
    rt::render();
    const RThit hit = rt::pick(8, 8);
    if (hit.object != triangle.name())
        return 3;

    rt::frameParameter(RT_SUBSAMPLING, 5);
    rt::frameParameter(RT_TIME_BUDGET, 2.5f);
    RTint step = 0;
    RTfloat budget = 0;
    rtGetIntegerv(RT_SUBSAMPLING, &step);
    rtGetFloatv(RT_TIME_BUDGET, &budget);
    if (step != 5 || budget != 2.5f)
        return 8;

    RTuint gone;
    {
        rt::Object moved(RT_COMPILE, [] {});
        rt::Object other = std::move(moved);
        gone = other.name();
        if (!rtIsObject(gone))
            return 4;
    }
    if (rtIsObject(gone))
        return 5;

#ifndef OPENRT_NO_EXCEPTIONS
    try {
        red.set("no such parameter", 1.0f);
        return 6;
    } catch (const rt::Error &error) {
        if (error.code() != RT_INVALID_VALUE || std::string(error.what()).find("no such parameter") == std::string::npos)
            return 7;
    }
    try {
        rt::frameParameter(RT_SUBSAMPLING, -1);
        return 9;
    } catch (const rt::Error &error) {
        if (error.code() != RT_INVALID_VALUE)
            return 10;
    }
#endif
    std::printf("seen at %.1f\n", hit.t);
    return 0;
}
