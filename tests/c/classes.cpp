// The classes of rt.hpp for rays, snapshots and scene files. Arguments: a folder to write in, and the file tests/data/every.aff.
#include <openrt/rt.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#define CHECK(condition)                                                                      \
    do {                                                                                      \
        if (!(condition)) {                                                                   \
            std::fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);              \
            std::exit(1);                                                                     \
        }                                                                                     \
    } while (0)

static rt::Object wall(float z)
{
    return rt::Object(RT_COMPILE, [z] {
        rt::primitive(RT_TRIANGLES, [z] {
            rt::color(0.5f, 0.25f, 1.0f, 1.0f);
            rt::vertex(-9.0f, -9.0f, z);
            rt::vertex(9.0f, -9.0f, z);
            rt::vertex(0.0f, 9.0f, z);
        });
    });
}

static const RTray FORWARD = rt::ray({0, 0, 0}, {0, 0, -1});

static void questions()
{
    const rt::Object near_ = wall(-1), far_ = wall(-4);
    near_.instantiate();
    rt::instanceMask(0x30);
    far_.instantiate();
    rt::instanceMask(0xFFFFFFFF);
    rt::commitScene();
    const rt::Queries all = rt::queries();
    CHECK(all.intersect(FORWARD)->object == near_.name());
    CHECK(all.intersect(FORWARD, 0x10)->object == near_.name() && !all.intersect(rt::ray({0, 0, 0}, {0, 1, 0}), 0x10));
    // The far one is there for 0x30 alone.
    CHECK(all.allHits(FORWARD, 8).size() == 1 && all.allHits(FORWARD, 8, 0x20).size() == 2);
    CHECK(all.allHits(FORWARD, 1, 0x20).size() == 1 && all.allHits(FORWARD, 0).empty());
    RTuint asked = 0;
    const auto not_near = [&](const RTray &ray, const RThit &hit) {
        asked++;
        return ray.direction[2] == -1 && hit.object != near_.name();
    };
    const auto behind = all.intersect(FORWARD, not_near, 0x20);
    CHECK(behind && behind->object == far_.name() && behind->t == 4 && asked == 2);
    CHECK(!all.intersect(FORWARD, not_near));
    CHECK(all.allHits(FORWARD, 8, not_near, 0x20).size() == 1);
    CHECK(all.intersect(std::vector<RTray>{FORWARD, FORWARD}, RT_COHERENT)[1].t == 1);
    CHECK(all.occluded(FORWARD) && all.occluded({FORWARD, rt::ray({0, 0, 0}, {0, 0, 1})}) == std::vector<RTubyte>({1, 0}));
    const RTsurface surface = all.surface(FORWARD, *all.intersect(FORWARD));
    CHECK(surface.position[2] == -1 && surface.color[2] == 1 && surface.color[1] == 0.25f && surface.frontFacing);
    const auto point = all.closestPoint({0, 0, 0});
    CHECK(point && point->distance == 1 && point->object == near_.name());
    CHECK(!all.closestPoint({0, 0, 0}, 0.5f));
    CHECK(all.closestPoint(far_, {0, 0, 0})->distance == 4);
#ifndef OPENRT_NO_EXCEPTIONS
    // An exception stays in the filter.
    CHECK(all.intersect(FORWARD, [](const RTray &, const RThit &) -> bool { throw 1; })->t == 1);
    try {
        all.closestPoint({0, 0, 0}, -1);
        CHECK(false);
    } catch (const rt::Error &error) {
        CHECK(error.code() == RT_INVALID_VALUE);
    }
#endif
}

static void snapshots()
{
    std::optional<rt::Snapshot> before;
    {
        const rt::Context inner;
        const rt::Object one = wall(-1);
        one.instantiate();
        rt::commitScene();
        before.emplace();
        rt::Snapshot moved = std::move(*before);
        *before = std::move(moved);
        CHECK(before->get() != nullptr);
        rt::clearInstances();
        rt::commitScene();
        CHECK(!rt::intersect(FORWARD) && before->intersect(FORWARD));
    }
    // Without the context, on threads that have none.
    std::vector<std::thread> threads;
    for (int i = 0; i < 3; i++)
        threads.emplace_back([&before] {
            for (int n = 0; n < 100; n++)
                CHECK(before->intersect(FORWARD)->t == 1 && before->occluded(FORWARD));
            CHECK(rtGetError() == RT_NO_ERROR);
        });
    for (std::thread &thread : threads)
        thread.join();
}

static void scene_files(const std::string &file)
{
    RTint readers = 0;
    rtGetIntegerv(RT_SCENE_READERS, &readers);
    if (!readers) {
        std::printf("a library without the readers\n");
        return;
    }
    RTuint object = 0;
    {
        rt::LoadedScene read(file);
        rt::LoadedScene scene = std::move(read);
        CHECK(scene.format() == "AFF" && scene.times()[0] == 0 && scene.times()[1] == 2 && scene.warnings().empty());
        CHECK(scene.bounds()[0] == -5 && scene.get(RT_SCENE_OBJECT_COUNT) > 1 && !scene.objectName(0).empty());
        object = static_cast<RTuint>(scene.get(RT_SCENE_FIRST_OBJECT));
        scene.instantiate(0.5);
        rt::render();
        CHECK(rt::frameStats().instances > 1 && rtIsObject(object));
    }
    CHECK(!rtIsObject(object));
#ifndef OPENRT_NO_EXCEPTIONS
    try {
        const rt::LoadedScene none("/there/is/none.obj");
        CHECK(false);
    } catch (const rt::Error &error) {
        CHECK(error.code() == RT_IO_ERROR);
    }
#endif
}

static void frames(const std::string &folder)
{
    rt::clearColor({0.25f, 0.5f, 0.75f, 1});
    rt::clearInstances();
    rt::render();
    const auto blue_first = rt::readPixels<RTfloat>(1, 1, 2, 2, RT_BGRA, 4);
    CHECK(blue_first.size() == 16 && blue_first[0] == 0.75f && blue_first[2] == 0.25f);
    CHECK(rt::readPixels<RTubyte>(0, 0, 1, 1, RT_BGR, 3) == std::vector<RTubyte>({191, 128, 64}));
    CHECK(rt::readPixels<RTuint>(0, 0, 1, 1, RT_OBJECT_ID, 1)[0] == 0);
    rt::jpegQuality(40);
    rt::writeImage(folder + "/low.jpg");
    RTint quality = 0;
    rtGetIntegerv(RT_JPEG_QUALITY, &quality);
    CHECK(quality == 40);
}

int main(int argc, char **argv)
{
    CHECK(argc == 3);
    const rt::Context context(2);
    RTint threads = 0;
    rtGetIntegerv(RT_THREADS, &threads);
    CHECK(threads == 2);
    rt::viewport(0, 0, 16, 12);
    questions();
    scene_files(argv[2]);
    frames(argv[1]);
    snapshots();
    return 0;
}
