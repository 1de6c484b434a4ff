/* shapes.h - solid shapes with normals, to be called between rtNewObject and rtEndObject, as GLUT's are in a
 * display list. All are centred at the origin; the cone stands on it. The current matrix places them. */
#ifndef SHAPES_H
#define SHAPES_H

#include <math.h>
#include <openrt/rt.h>

#define PI 3.14159265358979323846

/* Point of a surface of revolution about y: `radius` and `height`, and the normal's slope, at `turn` of 0 to 1. */
static inline void shapeRevolved(double radius, double height, double out, double up, double turn)
{
    const double c = cos(2 * PI * turn), s = sin(2 * PI * turn);
    rtNormal3d(out * c, up, -out * s);
    rtVertex3d(radius * c, height, -radius * s);
}

static inline void solidSphere(double radius, int slices, int stacks)
{
    int i, j;
    for (j = 0; j < stacks; j++) {
        const double lower = PI * j / stacks - PI / 2, upper = PI * (j + 1) / stacks - PI / 2;
        rtBegin(RT_QUAD_STRIP);
        for (i = 0; i <= slices; i++) {
            const double turn = (double)i / slices;
            shapeRevolved(radius * cos(upper), radius * sin(upper), cos(upper), sin(upper), turn);
            shapeRevolved(radius * cos(lower), radius * sin(lower), cos(lower), sin(lower), turn);
        }
        rtEnd();
    }
}

/* A ring about the y axis: `tube` is the radius of the tube, `ring` of its centre line. */
static inline void solidTorus(double tube, double ring, int sides, int rings)
{
    int i, j;
    for (j = 0; j < sides; j++) {
        const double lower = 2 * PI * j / sides, upper = 2 * PI * (j + 1) / sides;
        rtBegin(RT_QUAD_STRIP);
        for (i = 0; i <= rings; i++) {
            const double turn = (double)i / rings;
            shapeRevolved(ring + tube * cos(upper), tube * sin(upper), cos(upper), sin(upper), turn);
            shapeRevolved(ring + tube * cos(lower), tube * sin(lower), cos(lower), sin(lower), turn);
        }
        rtEnd();
    }
}

/* A cone, or part of one, from radius `bottom` at y = 0 to radius `top` at y = `height`; open at both ends. */
static inline void solidCone(double bottom, double top, double height, int slices)
{
    const double slope = (bottom - top) / height, length = sqrt(1 + slope * slope);
    int i;
    rtBegin(RT_QUAD_STRIP);
    for (i = 0; i <= slices; i++) {
        const double turn = (double)i / slices;
        shapeRevolved(top, height, 1 / length, slope / length, turn);
        shapeRevolved(bottom, 0, 1 / length, slope / length, turn);
    }
    rtEnd();
}

static inline void solidCube(double size)
{
    static const float faces[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    const double h = size / 2;
    int i, corner;
    rtBegin(RT_QUADS);
    for (i = 0; i < 6; i++) {
        /* u and v span the face so that u x v is its normal n. */
        const float *n = faces[i];
        const float u[3] = {n[1], n[2], n[0]}, v[3] = {n[2], n[0], n[1]};
        const float sign = n[0] + n[1] + n[2];
        rtNormal3fv(n);
        for (corner = 0; corner < 4; corner++) {
            const double a = corner == 1 || corner == 2 ? h : -h, b = corner >= 2 ? -h * sign : h * sign;
            rtVertex3d(h * n[0] + a * u[0] + b * v[0], h * n[1] + a * u[1] + b * v[1], h * n[2] + a * u[2] + b * v[2]);
        }
    }
    rtEnd();
}

/* A square in the plane y = 0, seen from above. */
static inline void solidFloor(double size)
{
    const double h = size / 2;
    rtBegin(RT_QUADS);
    rtNormal3f(0, 1, 0);
    rtVertex3d(-h, 0, h);
    rtVertex3d(h, 0, h);
    rtVertex3d(h, 0, -h);
    rtVertex3d(-h, 0, -h);
    rtEnd();
}

#endif
