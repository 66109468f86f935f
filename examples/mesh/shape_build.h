/* shape_build.h: what the makers of shapes.c are made of: append vertices, triangles, quads, boxes
 * and surfaces of revolution to arrays that were reserved at their exact size. */
#ifndef EXAMPLES_SHAPE_BUILD_H
#define EXAMPLES_SHAPE_BUILD_H

#include "numbers.h"
#include "shapes.h"

#include <stdlib.h>

static inline bool reserve(shape *s, uint64_t vertices, uint64_t triangles) {
    const uint64_t limit = SIZE_MAX / 16 < UINT32_MAX ? SIZE_MAX / 16 : UINT32_MAX;
    if (vertices > limit || triangles > limit) return false;
    s->positions = (float *)malloc((size_t)(vertices + 1) * 3 * sizeof(float));
    s->indices = (uint32_t *)malloc((size_t)(triangles + 1) * 3 * sizeof(uint32_t));
    return s->positions && s->indices;
}

static inline uint32_t add_vertex(shape *s, double x, double y, double z) {
    float *p = s->positions + 3 * s->vertex_count;
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
    return (uint32_t)s->vertex_count++;
}

static inline void add_triangle(shape *s, uint64_t a, uint64_t b, uint64_t c) {
    uint32_t *t = s->indices + 3 * s->triangle_count++;
    t[0] = (uint32_t)a;
    t[1] = (uint32_t)b;
    t[2] = (uint32_t)c;
}

/* Corners in order around the quad. */
static inline void add_quad(shape *s, uint64_t a, uint64_t b, uint64_t c, uint64_t d) {
    add_triangle(s, a, b, c);
    add_triangle(s, a, c, d);
}

static inline uint64_t root(double x) {
    return x > 1 ? (uint64_t)sqrt(x) : 1;
}

static inline uint64_t at_least(uint64_t x, uint64_t least) {
    return x > least ? x : least;
}

/* Cube root of 0 < x <= 1 by Newton's method from above, which cannot overshoot. */
static inline double cube_root(double x) {
    double y = 1;
    for (int i = 0; i < 64; ++i) y -= (y * y * y - x) / (3 * y * y);
    return y;
}

/* A surface of revolution whose poles are one vertex each, so that no triangle is degenerate.
 * Appends rings of `slices` vertices between two poles on the y axis through (x, y, z); point i of
 * the profile is radius, height, and points 0 and count - 1 are the poles. */
static inline void add_lathe(shape *s, const double (*profile)[2], uint64_t count, uint64_t slices,
                             const double *origin, double scale) {
    const uint64_t rings = count - 2;
    const uint64_t first = s->vertex_count, last = first + 1 + rings * slices;
    add_vertex(s, origin[0], origin[1] + scale * profile[0][1], origin[2]);
    for (uint64_t i = 1; i <= rings; ++i) {
        const double r = scale * profile[i][0], y = origin[1] + scale * profile[i][1];
        for (uint64_t j = 0; j < slices; ++j) {
            const double turn = (double)j / (double)slices;
            add_vertex(s, origin[0] + r * sin_turns(turn), y, origin[2] + r * cos_turns(turn));
        }
    }
    add_vertex(s, origin[0], origin[1] + scale * profile[count - 1][1], origin[2]);
    for (uint64_t j = 0; j < slices; ++j) {
        const uint64_t k = (j + 1) % slices;
        add_triangle(s, first, first + 1 + k, first + 1 + j);
        for (uint64_t i = 0; i + 1 < rings; ++i) {
            const uint64_t low = first + 1 + i * slices, high = low + slices;
            add_quad(s, low + j, low + k, high + k, high + j);
        }
        add_triangle(s, last - slices + j, last - slices + k, last);
    }
}

static inline void add_box(shape *s, const double *lo, const double *hi) {
    static const unsigned char face[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                             {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    const uint64_t first = s->vertex_count;
    for (int i = 0; i < 8; ++i)
        add_vertex(s, i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1], i & 4 ? hi[2] : lo[2]);
    for (int i = 0; i < 6; ++i)
        add_quad(s, first + face[i][0], first + face[i][1], first + face[i][2], first + face[i][3]);
}

static inline void normalise(double *v) {
    const double scale = 1 / sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; ++i) v[i] *= scale;
}

static inline void cross(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

#endif
