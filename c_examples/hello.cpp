// hello.cpp - the C++ face: things with names clean up after themselves, errors are exceptions.
#include "example.h"
#include "shapes.h"

#include <openrt/rt.hpp>

#include <cstdio>
#include <vector>

namespace {

void draw(const Example &e)
{
    rtViewport(0, 0, e.width, e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtSamplesPerPixel(4);
    rtPerspective(40, static_cast<double>(e.width) / e.height, 0.1, 100);
    rt::lookAt({0, 5, 11}, {0, 2, 0}, {0, 1, 0});

    rt::Shader sun("directional"), ambient("ambient"), sky("gradient"), stone("diffuse"), glass("glass"), gold("metal");
    sun.set("direction", -0.6f, -1.0f, -0.3f);
    ambient.set("color", 1.2f, 1.2f, 1.3f);
    stone.set("color", 0.55f, 0.5f, 0.45f);
    glass.set("color", 0.9f, 1.0f, 0.95f);
    gold.set("color", 0.95f, 0.75f, 0.3f);

    const rt::Object ground(RT_COMPILE | RT_STATIC, [&] {
        stone.bind();
        solidFloor(40);
    });
    const rt::Object step(RT_COMPILE, [&] {
        stone.bind();
        solidCube(1);
    });
    std::vector<rt::Object> balls;
    for (const rt::Shader *surface : {&glass, &gold}) {
        balls.emplace_back(RT_COMPILE, [&] {
            surface->bind();
            solidSphere(0.38, 64, 32);
        });
    }

    rt::useLight(ambient);
    rt::useLight(sun);
    rtUseEnvironmentShader(sky.name());
    ground.instantiate();
    for (int i = 0; i < 20; i++) {
        const rt::MatrixScope stair;
        rt::rotate(24.0 * i, 0.0, 1.0, 0.0);
        rt::translate(2.2, 0.2 + 0.22 * i, 0.0);
        {
            const rt::MatrixScope slab;
            rt::scale(2.0, 0.15, 0.9);
            step.instantiate();
        }
        rt::translate(0.5, 0.46, 0.0);
        balls[static_cast<std::size_t>(i % 2)].instantiate();
    }
    rt::render();
    exampleWrite(&e, "hello", 0);
}

} // namespace

int main(int argc, char **argv)
{
    rtInit(&argc, argv);
    try {
        draw(exampleOptions(argc, argv, 1));
        rt::check();
    } catch (const rt::Error &error) {
        std::fprintf(stderr, "openrt: %s\n", error.what());
        return 1;
    }
    return exampleEnd();
}
