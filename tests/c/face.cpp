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

    // Composites, and rays without a frame.
    rt::frameParameter(RT_SUBSAMPLING, 1);
    rt::frameParameter(RT_TIME_BUDGET, -1);
    const rt::Object two(RT_COMPILE, [&] {
        const rt::Matrix there{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 30, 0, -2, 1};
        triangle.instantiate({rt::Matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1}, there});
    });
    rt::clearInstances();
    two.instantiate();
    rt::commitScene();
    const auto met = rt::intersect(rt::ray({30, 0, 0}, {0, 0, -1}));
    if (!met || met->t != 2 || met->object != triangle.name() || met->instance != 0)
        return 11;
    if (rt::intersect(rt::ray({30, 0, 0}, {0, 0, 1})) || !rt::occluded(rt::ray({0, 0, 0}, {0, 0, -1})))
        return 12;
    const std::vector<RTray> rays{rt::ray({0, 0, 0}, {0, 0, -1}), rt::ray({0, 0, 0}, {0, 0, -1}, 0, 0.5f)};
    if (rt::intersect(rays)[0].t != 1 || rt::intersect(rays, RT_COHERENT)[1].t >= 0 || rt::occluded(rays)[1])
        return 13;
    two.set(RT_UPDATE_STRATEGY, RT_BSP);
    if (two.get(RT_UPDATE_STRATEGY) != RT_BSP)
        return 14;

    // Shaders of lambdas, each of a kind.
    const rt::Vec3 tint{0.25f, 0.5f, 1.0f};
    const rt::Shader surface = rt::surfaceShader("tinted", [tint](const rt::Shading &shading) {
        rt::Vec4 color{0, 0, 0, 1};
        for (RTuint light = 0; light < shading.lightCount(); light++)
            if (const auto sample = shading.illuminate(light); sample && !shading.shadowed(*sample))
                for (std::size_t i = 0; i < 3; i++)
                    color[i] += tint[i] * sample->radiance[i] * shading.point().normal[2];
        return color;
    });
    const rt::Shader lamp = rt::lightShader("lamp", [](const rt::Vec3 &) {
        return std::optional<RTlightSample>(RTlightSample{{0, 0, 1}, INFINITY, {1, 1, 0.5f}});
    });
    const rt::Shader down = rt::cameraShader("down", [](RTfloat x, RTfloat y, RTfloat) {
        return x < 0.5f ? std::optional<RTray>(rt::ray({x, y, 0}, {0, 0, -1})) : std::nullopt;
    });
    const rt::Shader sky = rt::environmentShader("sky", [](const rt::Vec3 &direction) {
        return rt::Vec3{0, 0, -direction[2]};
    });
    surface.bind();
    const rt::Object lit(RT_COMPILE, [] {
        rt::primitive(RT_TRIANGLES, [] {
            rt::vertex(-9.0f, -9.0f, -1.0f);
            rt::vertex(9.0f, -9.0f, -1.0f);
            rt::vertex(0.0f, 9.0f, -1.0f);
        });
    });
    const auto pixel = [] {
        RTfloat rgba[4];
        rtReadPixels(3, 8, 1, 1, RT_RGBA, RT_FLOAT, rgba);
        return rt::Vec4{rgba[0], rgba[1], rgba[2], rgba[3]};
    };
    rt::useLight(lamp);
    rt::useCamera(down);
    rt::useEnvironment(sky);
    const rt::Shader raycast("raycast");
    rt::useRenderingObject(raycast);
    rt::clearInstances();
    rt::render();
    if (pixel() != rt::Vec4{0, 0, 1, 1})
        return 15;
    lit.instantiate();
    rt::render();
    if (pixel() != rt::Vec4{0.25f, 0.5f, 0.5f, 1})
        return 16;

#ifndef OPENRT_NO_EXCEPTIONS
    // What a function throws does not come out of the frame.
    const rt::Shader thrower = rt::surfaceShader("thrower", [](const rt::Shading &) -> rt::Vec4 { throw 1; });
    thrower.bind();
    const rt::Object dark(RT_COMPILE, [] {
        rt::primitive(RT_TRIANGLES, [] {
            rt::vertex(-9.0f, -9.0f, -0.5f);
            rt::vertex(9.0f, -9.0f, -0.5f);
            rt::vertex(0.0f, 9.0f, -0.5f);
        });
    });
    dark.instantiate();
    rt::render();
    if (pixel() != rt::Vec4{0, 0, 0, 1})
        return 17;
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
