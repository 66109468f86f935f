/* triangle.h: the one triangle test. Every kind, every batch, the oracle and the devices call it
 * (or its twin in cl/common.cl), so a hit is a pure function of the ray and the three corners.
 *
 * S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, with the
 * roles of float and double split by what each proves:
 *
 *  - Corners are moved to the ray's origin and sheared so that the ray is the z axis. This is done
 *    in float, per corner, so triangles that share a corner see the same 2D point.
 *  - An edge function is a difference of two products. Rounding is monotonic, so a float edge
 *    function has the exact sign or is 0. Mixed strict signs therefore reject without doubt: the
 *    common case.
 *  - What is left is decided in double, where a product of two floats is exact: signs are exact, so
 *    neighbours agree about a shared edge and about a shared corner. And the barycentrics are
 *    accurate to 2^-51 even for slivers, which bounds the error of t, and that bound is what lets
 *    boxes be padded by a proven amount (ray.h).
 *
 * FP contraction would break the exact negation between neighbours: all builds turn it off. */
#ifndef HT_TRIANGLE_H
#define HT_TRIANGLE_H

#include "base/vec.h"

/* What the triangle test needs of a ray. */
typedef struct ht_shear {
    float org[3];
    float sx, sy;        /* dir[kx] / dir[kz], dir[ky] / dir[kz]: at most 1 in magnitude */
    double dz;           /* dir[kz] */
    uint32_t kx, ky, kz; /* kz: the axis of the largest component of dir */
} ht_shear;

/* Returns false for the rays that htree.h declares a miss; NaN fails every comparison. */
HT_INLINE bool ht_shear_init(ht_shear *s, const htree_ray *ray) {
    const float limit = HTREE_COORDINATE_MAX;
    const float x = ht_magnitude(ray->dir[0]);
    const float y = ht_magnitude(ray->dir[1]);
    const float z = ht_magnitude(ray->dir[2]);
    const bool valid = ht_magnitude(ray->org[0]) <= limit && ht_magnitude(ray->org[1]) <= limit &&
                       ht_magnitude(ray->org[2]) <= limit && x <= limit && y <= limit &&
                       z <= limit && (x >= 1 / limit || y >= 1 / limit || z >= 1 / limit) &&
                       ray->tmin <= ray->tmax;
    if (HT_UNLIKELY(!valid)) return false;
    /* By numbers: which axis is the largest is as good as random, and branches would be too. */
    static const uint8_t next[3] = {1, 2, 0};
    const uint32_t y_over_x = y > x, z_over_both = (z > x) & (z > y);
    s->kz = y_over_x + (2 - y_over_x) * z_over_both;
    s->kx = next[s->kz];
    s->ky = next[s->kx];
    s->sx = ray->dir[s->kx] / ray->dir[s->kz];
    s->sy = ray->dir[s->ky] / ray->dir[s->kz];
    s->dz = (double)ray->dir[s->kz];
    memcpy(s->org, ray->org, sizeof s->org);
    return true;
}

/* The verdict in double, on sheared corners a, b, c = {x, y, z}. */
HT_INLINE bool ht_triangle_verdict(const ht_shear *s, const float *a, const float *b,
                                   const float *c, float tmin, float tmax, htree_hit *hit) {
    const double u = (double)c[0] * (double)b[1] - (double)c[1] * (double)b[0];
    const double v = (double)a[0] * (double)c[1] - (double)a[1] * (double)c[0];
    const double w = (double)b[0] * (double)a[1] - (double)b[1] * (double)a[0];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const double det = u + v + w;
    if (det == 0) return false; /* the triangle is seen edge-on: its neighbours are hit */
    const double z = u * (double)a[2] + v * (double)b[2] + w * (double)c[2];
    const float t = (float)(z / (det * s->dz));
    if (!(tmin <= t && t <= tmax)) return false;
    hit->t = t;
    hit->u = (float)(v / det);
    hit->v = (float)(w / det);
    return true;
}

/* Writes t, u, v of *hit and returns true if the ray meets the triangle with tmin <= t <= tmax. */
HT_INLINE bool ht_triangle_intersect(const ht_shear *s, const float *v0, const float *v1,
                                     const float *v2, float tmin, float tmax, htree_hit *hit) {
    const float *const corner[3] = {v0, v1, v2};
    float p[3][3];
    for (int i = 0; i < 3; ++i) {
        p[i][2] = corner[i][s->kz] - s->org[s->kz];
        p[i][0] = (corner[i][s->kx] - s->org[s->kx]) - s->sx * p[i][2];
        p[i][1] = (corner[i][s->ky] - s->org[s->ky]) - s->sy * p[i][2];
    }
    const float u = p[2][0] * p[1][1] - p[2][1] * p[1][0];
    const float v = p[0][0] * p[2][1] - p[0][1] * p[2][0];
    const float w = p[1][0] * p[0][1] - p[1][1] * p[0][0];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    return ht_triangle_verdict(s, p[0], p[1], p[2], tmin, tmax, hit);
}

#endif
