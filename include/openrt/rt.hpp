/* openrt for C++17: overloads for the families of calls, and objects that clean up after themselves.
 *
 * Everything here is inline over <openrt/rt.h>, and both can be mixed. The names are those of C without their rt, in namespace rt.
 * Errors become exceptions of type rt::Error where a class of this file makes the call, unless OPENRT_NO_EXCEPTIONS is
 * defined or exceptions are off; rt::check() does the same for calls that you make. Objects of this file must not outlive the context in
 * which they were made, and belong to it as their names do.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0 */
#ifndef OPENRT_RT_HPP
#define OPENRT_RT_HPP

#include <openrt/rt.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#if !defined(OPENRT_NO_EXCEPTIONS) && !defined(__cpp_exceptions)
#define OPENRT_NO_EXCEPTIONS
#endif

namespace rt {

/* ---- errors ---- */

/* What rtGetError() returned, with its text. */
class Error : public std::runtime_error {
public:
    explicit Error(RTenum code) : std::runtime_error(rtGetErrorString(code)), code_(code) {}
    RTenum code() const noexcept { return code_; }

private:
    RTenum code_;
};

/* Throws the error that was recorded since the last call of rtGetError(), if any. */
inline void check()
{
#ifndef OPENRT_NO_EXCEPTIONS
    if (const RTenum code = rtGetError(); code != RT_NO_ERROR)
        throw Error(code);
#endif
}

/* ---- vectors: anything with three or four numbers in a row ---- */

using Vec2 = std::array<RTfloat, 2>;
using Vec3 = std::array<RTfloat, 3>;
using Vec4 = std::array<RTfloat, 4>;
using Matrix = std::array<RTfloat, 16>; /* column by column */

/* ---- primitives ---- */

inline void vertex(RTfloat x, RTfloat y) { rtVertex2f(x, y); }
inline void vertex(RTfloat x, RTfloat y, RTfloat z) { rtVertex3f(x, y, z); }
inline void vertex(RTfloat x, RTfloat y, RTfloat z, RTfloat w) { rtVertex4f(x, y, z, w); }
inline void vertex(RTdouble x, RTdouble y) { rtVertex2d(x, y); }
inline void vertex(RTdouble x, RTdouble y, RTdouble z) { rtVertex3d(x, y, z); }
inline void vertex(RTdouble x, RTdouble y, RTdouble z, RTdouble w) { rtVertex4d(x, y, z, w); }
inline void vertex(RTint x, RTint y) { rtVertex2i(x, y); }
inline void vertex(RTint x, RTint y, RTint z) { rtVertex3i(x, y, z); }
inline void vertex(const Vec2 &v) { rtVertex2fv(v.data()); }
inline void vertex(const Vec3 &v) { rtVertex3fv(v.data()); }
inline void vertex(const Vec4 &v) { rtVertex4fv(v.data()); }

inline void normal(RTfloat x, RTfloat y, RTfloat z) { rtNormal3f(x, y, z); }
inline void normal(RTdouble x, RTdouble y, RTdouble z) { rtNormal3d(x, y, z); }
inline void normal(const Vec3 &v) { rtNormal3fv(v.data()); }

inline void texCoord(RTfloat s, RTfloat t) { rtTexCoord2f(s, t); }
inline void texCoord(RTdouble s, RTdouble t) { rtTexCoord2d(s, t); }
inline void texCoord(const Vec2 &v) { rtTexCoord2fv(v.data()); }

inline void color(RTfloat r, RTfloat g, RTfloat b) { rtColor3f(r, g, b); }
inline void color(RTfloat r, RTfloat g, RTfloat b, RTfloat a) { rtColor4f(r, g, b, a); }
inline void color(RTdouble r, RTdouble g, RTdouble b) { rtColor3d(r, g, b); }
inline void color(RTdouble r, RTdouble g, RTdouble b, RTdouble a) { rtColor4d(r, g, b, a); }
inline void color(const Vec3 &c) { rtColor3fv(c.data()); }
inline void color(const Vec4 &c) { rtColor4fv(c.data()); }

/* rtBegin(mode), what `body` does, rtEnd(). */
template <class Body> void primitive(RTenum mode, Body &&body)
{
    struct End {
        ~End() { rtEnd(); }
    };
    rtBegin(mode);
    const End end{};
    std::forward<Body>(body)();
}

/* ---- matrices ---- */

inline void translate(RTfloat x, RTfloat y, RTfloat z) { rtTranslatef(x, y, z); }
inline void translate(RTdouble x, RTdouble y, RTdouble z) { rtTranslated(x, y, z); }
inline void translate(const Vec3 &v) { rtTranslatef(v[0], v[1], v[2]); }
inline void rotate(RTfloat angle, RTfloat x, RTfloat y, RTfloat z) { rtRotatef(angle, x, y, z); }
inline void rotate(RTdouble angle, RTdouble x, RTdouble y, RTdouble z) { rtRotated(angle, x, y, z); }
inline void rotate(RTfloat angle, const Vec3 &axis) { rtRotatef(angle, axis[0], axis[1], axis[2]); }
inline void scale(RTfloat x, RTfloat y, RTfloat z) { rtScalef(x, y, z); }
inline void scale(RTdouble x, RTdouble y, RTdouble z) { rtScaled(x, y, z); }
inline void scale(RTfloat factor) { rtScalef(factor, factor, factor); }
inline void loadMatrix(const Matrix &m) { rtLoadMatrixf(m.data()); }
inline void multMatrix(const Matrix &m) { rtMultMatrixf(m.data()); }

inline Matrix currentMatrix()
{
    Matrix m{};
    rtGetFloatv(RT_MATRIX, m.data());
    return m;
}

/* Pushes the matrix, and pops it at the end of the scope. */
class MatrixScope {
public:
    MatrixScope() { rtPushMatrix(); }
    ~MatrixScope() { rtPopMatrix(); }
    MatrixScope(const MatrixScope &) = delete;
    MatrixScope &operator=(const MatrixScope &) = delete;
};

/* ---- things with names ---- */

/* A context of its own, current on this thread from here on. */
class Context {
public:
    Context() : Context(0) {}
    /* With so many worker threads; 0 for as many as rtThreads() has said. */
    explicit Context(RTsizei threads) : name_(rtCreateContextThreads(threads))
    {
        check();
        rtMakeCurrent(name_);
        check();
    }
    ~Context()
    {
        if (name_)
            rtDestroyContext(name_);
    }
    Context(Context &&other) noexcept : name_(std::exchange(other.name_, 0)) {}
    Context &operator=(Context &&other) noexcept
    {
        std::swap(name_, other.name_);
        return *this;
    }
    RTuint name() const noexcept { return name_; }
    void makeCurrent() const
    {
        rtMakeCurrent(name_);
        check();
    }
    /* Stops the frame that is being rendered. May be called on any thread. */
    void cancel() const { rtCancelContext(name_); }

private:
    RTuint name_;
};

/* An object, deleted at the end of the scope. */
class Object {
public:
    Object() : name_(rtGenObjects(1)) { check(); }

    /* The object that `body` draws. mode is RT_COMPILE, OR-ed with a motion flag. */
    template <class Body> explicit Object(RTenum mode, Body &&body) : Object() { define(mode, std::forward<Body>(body)); }

    ~Object()
    {
        if (name_)
            rtDeleteObjects(name_, 1);
    }
    Object(Object &&other) noexcept : name_(std::exchange(other.name_, 0)) {}
    Object &operator=(Object &&other) noexcept
    {
        std::swap(name_, other.name_);
        return *this;
    }

    /* Replaces the geometry by what `body` draws. */
    template <class Body> void define(RTenum mode, Body &&body)
    {
        struct End {
            ~End() { rtEndObject(); }
        };
        rtNewObject(name_, mode);
        check();
        {
            const End end{};
            std::forward<Body>(body)();
        }
        check();
    }

    /* Places the object with the current matrix in the frame being assembled, or in the object being defined. */
    void instantiate() const { rtInstantiateObject(name_); }
    /* Places it once for each matrix, which is multiplied on the current one. */
    void instantiate(const std::vector<Matrix> &matrices) const
    {
        rtInstantiateObjects(name_, static_cast<RTsizei>(matrices.size()), matrices.empty() ? nullptr : matrices[0].data(), 0);
        check();
    }

    void updateVertices(const std::vector<Vec3> &vertices, RTsizei first = 0) const
    {
        rtUpdateVertices(name_, first, static_cast<RTsizei>(vertices.size()), 0, vertices.empty() ? nullptr : vertices[0].data());
        check();
    }
    void updateNormals(const std::vector<Vec3> &normals, RTsizei first = 0) const
    {
        rtUpdateNormals(name_, first, static_cast<RTsizei>(normals.size()), 0, normals.empty() ? nullptr : normals[0].data());
        check();
    }
    /* Where the vertices are at a time: see rtKeyFrame(). */
    void keyFrame(RTfloat time, const std::vector<Vec3> &vertices) const
    {
        rtKeyFrame(name_, time, static_cast<RTsizei>(vertices.size()), 0, vertices.empty() ? nullptr : vertices[0].data());
        check();
    }
    void deleteKeyFrames() const
    {
        rtDeleteKeyFrames(name_);
        check();
    }
    void setStrategy(RTenum strategy) const
    {
        rtObjectParameteri(name_, RT_UPDATE_STRATEGY, static_cast<RTint>(strategy));
        check();
    }
    void setSpatialSplits(bool wanted) const
    {
        rtObjectParameteri(name_, RT_SPATIAL_SPLITS, wanted ? RT_TRUE : RT_FALSE);
        check();
    }
    /* See rtObjectParameteri(). */
    void set(RTenum parameter, RTint value) const
    {
        rtObjectParameteri(name_, parameter, value);
        check();
    }
    void set(RTenum parameter, RTfloat value) const
    {
        rtObjectParameterf(name_, parameter, value);
        check();
    }
    RTint get(RTenum parameter) const
    {
        RTint value = 0;
        rtGetObjectParameteriv(name_, parameter, &value);
        check();
        return value;
    }
    RTuint name() const noexcept { return name_; }

private:
    RTuint name_;
};

/* A texture, deleted at the end of the scope. */
class Texture {
public:
    /* Read from an image file. */
    explicit Texture(const std::string &file) : name_(rtLoadTexture(file.c_str())) { check(); }

    /* An image in memory: see rtTexImage2D(). */
    Texture(RTsizei width, RTsizei height, RTenum format, RTenum type, const void *pixels)
    {
        rtGenTextures(1, &name_);
        rtBindTexture(RT_TEXTURE_2D, name_);
        rtTexImage2D(RT_TEXTURE_2D, 0, RT_RGBA, width, height, 0, format, type, pixels);
        check();
    }
    ~Texture()
    {
        if (name_)
            rtDeleteTextures(1, &name_);
    }
    Texture(Texture &&other) noexcept : name_(std::exchange(other.name_, 0)) {}
    Texture &operator=(Texture &&other) noexcept
    {
        std::swap(name_, other.name_);
        return *this;
    }
    void set(RTenum parameter, RTenum value) const
    {
        rtBindTexture(RT_TEXTURE_2D, name_);
        rtTexParameteri(RT_TEXTURE_2D, parameter, static_cast<RTint>(value));
        check();
    }
    RTuint name() const noexcept { return name_; }

private:
    RTuint name_ = 0;
};

/* A shader, deleted at the end of the scope. Making one and setting its parameters binds it. */
class Shader {
public:
    /* A shader of a class of the library, or of a shader library. */
    explicit Shader(const char *className, const char *file = nullptr)
    {
        rtGenNewShaderClass(className, file);
        check();
        name_ = rtGenNewShader();
        check();
    }
    /* A shader of a class that was made before. */
    explicit Shader(RTuint shaderClass)
    {
        rtBindShaderClass(shaderClass);
        name_ = rtGenNewShader();
        check();
    }
    ~Shader()
    {
        if (name_)
            rtDeleteShader(name_);
    }
    Shader(Shader &&other) noexcept : name_(std::exchange(other.name_, 0)) {}
    Shader &operator=(Shader &&other) noexcept
    {
        std::swap(name_, other.name_);
        return *this;
    }

    /* Surface of the triangles that follow. */
    void bind() const { rtBindShader(name_); }

    Shader &set(const char *parameter, RTint v) { return apply(parameter, [v](RTuint h) { rtParameter1i(h, v); }); }
    Shader &set(const char *parameter, RTfloat v) { return apply(parameter, [v](RTuint h) { rtParameter1f(h, v); }); }
    Shader &set(const char *parameter, RTdouble v) { return set(parameter, static_cast<RTfloat>(v)); }
    Shader &set(const char *parameter, RTfloat x, RTfloat y)
    {
        return apply(parameter, [=](RTuint h) { rtParameter2f(h, x, y); });
    }
    Shader &set(const char *parameter, RTfloat x, RTfloat y, RTfloat z)
    {
        return apply(parameter, [=](RTuint h) { rtParameter3f(h, x, y, z); });
    }
    Shader &set(const char *parameter, RTfloat x, RTfloat y, RTfloat z, RTfloat w)
    {
        return apply(parameter, [=](RTuint h) { rtParameter4f(h, x, y, z, w); });
    }
    Shader &set(const char *parameter, const Vec3 &v) { return set(parameter, v[0], v[1], v[2]); }
    Shader &set(const char *parameter, const Vec4 &v) { return set(parameter, v[0], v[1], v[2], v[3]); }
    Shader &set(const char *parameter, const Matrix &m)
    {
        return apply(parameter, [&m](RTuint h) { rtParameter16fv(h, m.data()); });
    }
    Shader &set(const char *parameter, const char *text)
    {
        return apply(parameter, [text](RTuint h) { rtParameterString(h, text); });
    }
    Shader &set(const char *parameter, const Texture &texture)
    {
        return apply(parameter, [&texture](RTuint h) { rtParameterTexture(h, texture.name()); });
    }
    RTuint name() const noexcept { return name_; }

private:
    template <class Set> Shader &apply(const char *parameter, Set set)
    {
        bind();
        set(rtParameterHandle(parameter));
        check();
        return *this;
    }
    RTuint name_ = 0;
};

/* ---- shaders of C++ functions ----
 *
 * A lambda or another function object becomes a class and a shader of it. It is kept until the process ends, and called from several threads
 * at once while frames are rendered. Exceptions that leave it are dropped, and the answer is black, or none. */

/* What a surface may ask; valid during the call only. */
class Shading {
public:
    explicit Shading(RTshadingContext *context) : context_(context) { rtsGetPoint(context, &point_); }
    const RTsurfacePoint &point() const noexcept { return point_; }
    RTuint lightCount() const { return rtsLightCount(context_); }
    /* Light from one of the lights, before anything stands in its way. */
    std::optional<RTlightSample> illuminate(RTuint light) const
    {
        RTlightSample sample{};
        return rtsIlluminate(context_, light, &sample) ? std::optional<RTlightSample>(sample) : std::nullopt;
    }
    bool shadowed(const RTfloat *direction, RTfloat distance) const
    {
        return rtsShadowed(context_, direction, distance) != RT_FALSE;
    }
    bool shadowed(const RTlightSample &sample) const { return shadowed(sample.direction, sample.distance); }
    /* Linear red, green and blue that arrive from a direction. */
    Vec3 trace(const Vec3 &direction) const
    {
        Vec3 radiance{};
        rtsTrace(context_, direction.data(), radiance.data());
        return radiance;
    }
    /* The direction of a mirror. */
    Vec3 reflect() const
    {
        Vec3 direction{};
        rtsReflect(context_, direction.data());
        return direction;
    }
    Vec4 texture(const Texture &texture, RTfloat s, RTfloat t) const
    {
        Vec4 rgba{};
        rtsTexture(context_, texture.name(), s, t, rgba.data());
        return rgba;
    }

private:
    RTshadingContext *context_;
    RTsurfacePoint point_{};
};

namespace detail {

/* Calls a function object, and nothing that it throws gets further. */
template <class Call> void guarded(Call &&call) noexcept
{
#ifndef OPENRT_NO_EXCEPTIONS
    try {
        std::forward<Call>(call)();
    } catch (...) {
    }
#else
    std::forward<Call>(call)();
#endif
}

template <class F> Shader shaderOf(RTenum kind, const char *name, F &&function, RTshaderClass described)
{
    described.version = RT_SHADER_CLASS_VERSION;
    described.kind = kind;
    described.name = name;
    /* For ever: a frame may call it as long as there is one. */
    described.userData = new std::decay_t<F>(std::forward<F>(function));
    const RTuint shaderClass = rtRegisterShaderClass(&described);
    check();
    return Shader(shaderClass);
}

inline RTquery query(RTuint mask)
{
    RTquery query{};
    query.mask = mask;
    return query;
}

/* The filter must live as long as the question. */
template <class Filter> RTquery query(RTuint mask, Filter &filter)
{
    RTquery query = detail::query(mask);
    query.filter = [](void *userData, const RTray *ray, const RThit *hit) -> RTboolean {
        bool counts = true;
        guarded([&] { counts = (*static_cast<std::remove_reference_t<Filter> *>(userData))(*ray, *hit); });
        return counts ? RT_TRUE : RT_FALSE;
    };
    query.userData = const_cast<void *>(static_cast<const void *>(&filter));
    return query;
}

} /* namespace detail */

/* A surface: function(const rt::Shading &) gives linear red, green, blue and opacity as rt::Vec4. */
template <class F> Shader surfaceShader(const char *name, F &&function)
{
    RTshaderClass described{};
    described.shade = [](RTshadingContext *context, const void *, void *userData, RTfloat *result) {
        Vec4 color{0, 0, 0, 1};
        detail::guarded([&] { color = (*static_cast<std::decay_t<F> *>(userData))(Shading(context)); });
        for (std::size_t i = 0; i < 4; i++)
            result[i] = color[i];
    };
    return detail::shaderOf(RT_SURFACE_SHADER, name, std::forward<F>(function), described);
}

/* A light: function(const rt::Vec3 &position) gives std::optional<RTlightSample>. */
template <class F> Shader lightShader(const char *name, F &&function)
{
    RTshaderClass described{};
    described.illuminate = [](const void *, void *userData, const RTfloat *position, RTlightSample *sample) -> RTboolean {
        std::optional<RTlightSample> light;
        detail::guarded([&] {
            light = (*static_cast<std::decay_t<F> *>(userData))(Vec3{position[0], position[1], position[2]});
        });
        if (light)
            *sample = *light;
        return light ? RT_TRUE : RT_FALSE;
    };
    return detail::shaderOf(RT_LIGHT_SHADER, name, std::forward<F>(function), described);
}

/* A camera: function(RTfloat x, RTfloat y, RTfloat aspect) gives std::optional<RTray>. */
template <class F> Shader cameraShader(const char *name, F &&function)
{
    RTshaderClass described{};
    described.primaryRay = [](const void *, void *userData, RTfloat x, RTfloat y, RTfloat aspect, RTray *ray) -> RTboolean {
        std::optional<RTray> primary;
        detail::guarded([&] { primary = (*static_cast<std::decay_t<F> *>(userData))(x, y, aspect); });
        if (primary)
            *ray = *primary;
        return primary ? RT_TRUE : RT_FALSE;
    };
    return detail::shaderOf(RT_CAMERA_SHADER, name, std::forward<F>(function), described);
}

/* An environment: function(const rt::Vec3 &direction) gives linear red, green and blue as rt::Vec3. */
template <class F> Shader environmentShader(const char *name, F &&function)
{
    RTshaderClass described{};
    described.radiance = [](const void *, void *userData, const RTfloat *direction, RTfloat *radiance) {
        Vec3 color{};
        detail::guarded([&] {
            color = (*static_cast<std::decay_t<F> *>(userData))(Vec3{direction[0], direction[1], direction[2]});
        });
        for (std::size_t i = 0; i < 3; i++)
            radiance[i] = color[i];
    };
    return detail::shaderOf(RT_ENVIRONMENT_SHADER, name, std::forward<F>(function), described);
}

/* ---- frames ---- */

inline void useLight(const Shader &light) { rtUseLight(light.name()); }
inline void useCamera(const Shader &camera) { rtUseCamera(camera.name()); }
inline void useEnvironment(const Shader &environment) { rtUseEnvironmentShader(environment.name()); }
inline void useRenderingObject(const Shader &renderer) { rtUseRenderingObject(renderer.name()); }
inline void ambientLight(const Vec3 &color) { rtAmbientLight(color[0], color[1], color[2]); }
inline void clearColor(const Vec4 &color) { rtClearColor(color[0], color[1], color[2], color[3]); }
inline void perspective(RTdouble fovY, RTdouble aspect, RTdouble zNear = 0.1, RTdouble zFar = 1000.0)
{
    rtPerspective(fovY, aspect, zNear, zFar);
}
inline void ortho(RTdouble left, RTdouble right, RTdouble bottom, RTdouble top, RTdouble zNear = -1.0, RTdouble zFar = 1.0)
{
    rtOrtho(left, right, bottom, top, zNear, zFar);
}
inline void viewport(RTint x, RTint y, RTsizei width, RTsizei height) { rtViewport(x, y, width, height); }

inline void lookAt(const std::array<RTdouble, 3> &eye, const std::array<RTdouble, 3> &center, const std::array<RTdouble, 3> &up)
{
    rtLookAt(eye[0], eye[1], eye[2], center[0], center[1], center[2], up[0], up[1], up[2]);
}

/* What frames from now on are sampled like: see rtFrameParameteri(). */
inline void frameParameter(RTenum name, RTint value)
{
    rtFrameParameteri(name, value);
    check();
}
inline void frameParameter(RTenum name, RTfloat value)
{
    rtFrameParameterf(name, value);
    check();
}

inline void render()
{
    rtRender();
    check();
}

/* Starts a frame and returns; it wants endRendering(). */
inline void startRendering()
{
    rtStartRendering();
    check();
}
inline void endRendering()
{
    rtEndRendering();
    check();
}

/* Brings all structures up to date without rendering; ray queries then see what was placed. */
inline void commitScene()
{
    rtCommitScene();
    check();
}

/* A new frame without rendering. */
inline void clearInstances()
{
    rtClearInstances();
    check();
}

inline void writeImage(const std::string &file)
{
    rtWriteImage(file.c_str());
    check();
}

/* How well JPEG files show the picture: 1 to 100. */
inline void jpegQuality(RTint quality)
{
    rtJpegQuality(quality);
    check();
}

/* A rectangle of the last frame; T is RTfloat, RTubyte or RTuint, as type says: see rtReadPixels(). */
template <class T> std::vector<T> readPixels(RTint x, RTint y, RTsizei width, RTsizei height, RTenum format, std::size_t channels)
{
    static_assert(std::is_same_v<T, RTfloat> || std::is_same_v<T, RTubyte> || std::is_same_v<T, RTuint>, "no type of pixels");
    const auto size = [](RTsizei n) { return n > 0 ? static_cast<std::size_t>(n) : 0; };
    std::vector<T> pixels(size(width) * size(height) * channels);
    const RTenum type = std::is_same_v<T, RTfloat> ? RT_FLOAT : std::is_same_v<T, RTubyte> ? RT_UNSIGNED_BYTE : RT_UNSIGNED_INT;
    rtReadPixels(x, y, width, height, format, type, pixels.data());
    check();
    return pixels;
}

/* What is seen at the window coordinates (x, y); its object is 0 if nothing is. */
inline RThit pick(RTfloat x, RTfloat y)
{
    RThit hit{};
    rtPick(x, y, &hit);
    check();
    return hit;
}

/* Which rays see the instances that are placed from now on: see rtInstanceMask(). */
inline void instanceMask(RTuint mask) { rtInstanceMask(mask); }

inline RTframeStats frameStats()
{
    RTframeStats stats{};
    rtGetFrameStats(&stats);
    return stats;
}

/* ---- rays ---- */

inline RTray ray(const Vec3 &origin, const Vec3 &direction, RTfloat tmin = 0, RTfloat tmax = INFINITY)
{
    RTray r{};
    for (std::size_t i = 0; i < 3; i++) {
        r.origin[i] = origin[i];
        r.direction[i] = direction[i];
    }
    r.tmin = tmin;
    r.tmax = tmax;
    return r;
}

/* Questions to the scene that the current context has last rendered or committed, or to a snapshot. mask says which instances rays meet: those with a
 * bit in common, see RT_MASK. A filter is called as filter(ray, hit) and says whether the hit counts, or lets the ray go on; what it throws is
 * dropped, and the hit counts. */
class Queries {
public:
    /* What a ray meets first; none if nothing is in its way. */
    std::optional<RThit> intersect(const RTray &ray) const
    {
        RThit hit{};
        rtSceneIntersect(scene_, 1, &ray, &hit, 0);
        check();
        return found(hit);
    }
    std::optional<RThit> intersect(const RTray &ray, RTuint mask) const { return ask(ray, detail::query(mask)); }
    template <class Filter, class = std::enable_if_t<std::is_invocable_v<Filter &, const RTray &, const RThit &>>>
    std::optional<RThit> intersect(const RTray &ray, Filter &&filter, RTuint mask = RT_QUERY_RAYS) const
    {
        return ask(ray, detail::query(mask, filter));
    }

    /* The same for many; t is negative where nothing is. flags is 0 or RT_COHERENT. */
    std::vector<RThit> intersect(const std::vector<RTray> &rays, RTbitfield flags = 0) const
    {
        std::vector<RThit> hits(rays.size());
        rtSceneIntersect(scene_, static_cast<RTsizei>(rays.size()), rays.data(), hits.data(), flags);
        check();
        return hits;
    }

    /* The first max hits of a ray, the nearest first. */
    std::vector<RThit> allHits(const RTray &ray, RTsizei max, RTuint mask = RT_QUERY_RAYS) const
    {
        return all(ray, max, detail::query(mask));
    }
    template <class Filter, class = std::enable_if_t<std::is_invocable_v<Filter &, const RTray &, const RThit &>>>
    std::vector<RThit> allHits(const RTray &ray, RTsizei max, Filter &&filter, RTuint mask = RT_QUERY_RAYS) const
    {
        return all(ray, max, detail::query(mask, filter));
    }

    /* Whether anything is in the way of a ray. */
    bool occluded(const RTray &ray) const
    {
        RTubyte answer = RT_FALSE;
        rtSceneOccluded(scene_, 1, &ray, &answer, 0);
        check();
        return answer != RT_FALSE;
    }
    std::vector<RTubyte> occluded(const std::vector<RTray> &rays, RTbitfield flags = 0) const
    {
        std::vector<RTubyte> answers(rays.size());
        rtSceneOccluded(scene_, static_cast<RTsizei>(rays.size()), rays.data(), answers.data(), flags);
        check();
        return answers;
    }

    /* What lies where a ray has met the scene. */
    RTsurface surface(const RTray &ray, const RThit &hit) const
    {
        RTsurface surface{};
        rtSceneSurfaces(scene_, 1, &ray, &hit, &surface);
        check();
        return surface;
    }

    /* The nearest point within a distance, in world space; or on one object, in its own space. */
    std::optional<RTclosestPoint> closestPoint(const Vec3 &point, RTfloat maxDistance = INFINITY) const
    {
        return closest(0, point, maxDistance);
    }
    std::optional<RTclosestPoint> closestPoint(const Object &object, const Vec3 &point, RTfloat maxDistance = INFINITY) const
    {
        return closest(object.name(), point, maxDistance);
    }

protected:
    explicit Queries(RTscene scene) noexcept : scene_(scene) {}
    friend Queries queries() noexcept;
    RTscene scene_;

private:
    static std::optional<RThit> found(const RThit &hit) { return hit.t < 0 ? std::nullopt : std::optional<RThit>(hit); }
    std::optional<RThit> ask(const RTray &ray, const RTquery &query) const
    {
        RThit hit{};
        rtSceneQuery(scene_, 1, &ray, &hit, &query);
        check();
        return found(hit);
    }
    std::vector<RThit> all(const RTray &ray, RTsizei max, const RTquery &query) const
    {
        std::vector<RThit> hits(max > 0 ? static_cast<std::size_t>(max) : 0);
        const RTsizei count = rtSceneAllHits(scene_, &ray, max, hits.data(), &query);
        check();
        hits.resize(static_cast<std::size_t>(count));
        return hits;
    }
    std::optional<RTclosestPoint> closest(RTuint object, const Vec3 &point, RTfloat maxDistance) const
    {
        RTclosestPoint answer{};
        const bool is = rtSceneClosestPoint(scene_, object, point.data(), maxDistance, &answer) != RT_FALSE;
        check();
        return is ? std::optional<RTclosestPoint>(answer) : std::nullopt;
    }
};

/* Questions to the current context. */
inline Queries queries() noexcept { return Queries(nullptr); }
inline std::optional<RThit> intersect(const RTray &ray) { return queries().intersect(ray); }
inline std::vector<RThit> intersect(const std::vector<RTray> &rays, RTbitfield flags = 0) { return queries().intersect(rays, flags); }
inline bool occluded(const RTray &ray) { return queries().occluded(ray); }
inline std::vector<RTubyte> occluded(const std::vector<RTray> &rays, RTbitfield flags = 0) { return queries().occluded(rays, flags); }

/* The scene that the current context has last rendered or committed, as it was then. Any number of threads may ask it at a time, and it may outlive
 * the context. One that was moved from may only be assigned to or destroyed. */
class Snapshot : public Queries {
public:
    Snapshot() : Queries(rtAcquireScene()) { check(); }
    ~Snapshot() { rtReleaseScene(scene_); }
    Snapshot(Snapshot &&other) noexcept : Queries(std::exchange(other.scene_, nullptr)) {}
    Snapshot &operator=(Snapshot &&other) noexcept
    {
        std::swap(scene_, other.scene_);
        return *this;
    }
    /* For the calls of C. */
    RTscene get() const noexcept { return scene_; }
};

/* ---- scene files ---- */

/* A scene file, read. At the end of the scope it is deleted with its objects, shaders and textures. See rtLoadScene(). */
class LoadedScene {
public:
    /* parts is what the frame being assembled gets of it at once. */
    explicit LoadedScene(const std::string &file, RTbitfield parts = RT_NONE) : name_(rtLoadScene(file.c_str(), parts)) { check(); }
    ~LoadedScene()
    {
        if (name_)
            rtDeleteLoadedScene(name_);
    }
    LoadedScene(LoadedScene &&other) noexcept : name_(std::exchange(other.name_, 0)) {}
    LoadedScene &operator=(LoadedScene &&other) noexcept
    {
        std::swap(name_, other.name_);
        return *this;
    }

    /* Puts parts of it into the frame being assembled, as they are at a time: see rtInstantiateLoadedScene(). */
    void instantiate(RTdouble time, RTbitfield parts = RT_SCENE_ALL_BITS) const
    {
        rtInstantiateLoadedScene(name_, time, parts);
        check();
    }
    /* First and last moment of the animation, in seconds. */
    std::array<RTdouble, 2> times() const { return numbers<2>(RT_SCENE_TIMES); }
    /* Lowest x, y, z and highest x, y, z at the first moment. */
    std::array<RTdouble, 6> bounds() const { return numbers<6>(RT_SCENE_BOUNDS); }
    /* RT_SCENE_FIRST_OBJECT, RT_SCENE_OBJECT_COUNT and others of rtGetLoadedSceneiv(). */
    RTint get(RTenum number) const
    {
        RTint value = 0;
        rtGetLoadedSceneiv(name_, number, &value);
        check();
        return value;
    }
    std::string format() const { return text(RT_SCENE_FORMAT, 0); }
    /* The file's name for object RT_SCENE_FIRST_OBJECT + index. */
    std::string objectName(RTuint index) const { return text(RT_SCENE_OBJECT_NAME, index); }
    /* What was left out or is odd. */
    std::vector<std::string> warnings() const
    {
        std::vector<std::string> all;
        for (RTuint i = 0, n = static_cast<RTuint>(get(RT_SCENE_WARNING_COUNT)); i < n; i++)
            all.push_back(text(RT_SCENE_WARNING, i));
        return all;
    }
    RTuint name() const noexcept { return name_; }

private:
    template <std::size_t N> std::array<RTdouble, N> numbers(RTenum which) const
    {
        std::array<RTdouble, N> values{};
        rtGetLoadedScenedv(name_, which, values.data());
        check();
        return values;
    }
    std::string text(RTenum which, RTuint index) const
    {
        const char *text = rtGetLoadedSceneString(name_, which, index);
        check();
        return text ? text : "";
    }
    RTuint name_;
};

} /* namespace rt */

#endif
