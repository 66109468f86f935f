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

#include "base/lanes.h"

/* What the triangle test needs of a ray. */
typedef struct ht_shear {
    float org[3];
    float sx, sy;        /* dir[kx] / dir[kz], dir[ky] / dir[kz]: at most 1 in magnitude */
    double dz;           /* dir[kz] */
    uint32_t kx, ky, kz; /* kz: the axis of the largest component of dir */
} ht_shear;

/* Three numbers out of a ray, the first once more in the fourth lane. */
HT_INLINE ht_f4 ht_ray_org(const htree_ray *ray) {
    return ht_f4_three(ht_f4_load((const float *)ray));
}

HT_INLINE ht_f4 ht_ray_dir(const htree_ray *ray) {
    return ht_f4_three(ht_f4_load((const float *)ray + 4));
}

/* Returns false for the rays that htree.h declares a miss; NaN fails every comparison. */
HT_INLINE bool ht_shear_init(ht_shear *s, const htree_ray *ray) {
    /* By numbers: which axis is the largest is as good as random, and branches would be too. Bits of
     * the row: y exceeds x, z exceeds y, z exceeds x. */
    static const uint8_t axes[8][3] = {{1, 2, 0}, {2, 0, 1}, {1, 2, 0}, {2, 0, 1},
                                       {1, 2, 0}, {2, 0, 1}, {0, 1, 2}, {0, 1, 2}};
    const ht_f4 limit = ht_f4_all(HTREE_COORDINATE_MAX),
                least = ht_f4_all(1 / HTREE_COORDINATE_MAX);
    const ht_f4 org = ht_f4_magnitude(ht_ray_org(ray)), dir = ht_f4_magnitude(ht_ray_dir(ray));
    const uint32_t within = ht_f4_at_most(org, limit) & ht_f4_at_most(dir, limit);
    const bool valid = within == 15 && ht_f4_at_most(least, dir) && ray->tmin <= ray->tmax;
    if (HT_UNLIKELY(!valid)) return false;
    const ht_f4 next = ht_f4_rotate(dir);
    const uint8_t *const k = axes[(ht_f4_above(next, dir) & 3) | (ht_f4_above(dir, next) & 4)];
    s->kx = k[0];
    s->ky = k[1];
    s->kz = k[2];
    s->sx = ray->dir[s->kx] / ray->dir[s->kz];
    s->sy = ray->dir[s->ky] / ray->dir[s->kz];
    s->dz = (double)ray->dir[s->kz];
    memcpy(s->org, ray->org, sizeof s->org);
    return true;
}

/* The verdict in double, on sheared corners a, b, c = {x, y, z}; dz as in ht_shear. */
HT_INLINE bool ht_triangle_verdict(double dz, const float *a, const float *b, const float *c,
                                   float tmin, float tmax, htree_hit *hit) {
    const double u = (double)c[0] * (double)b[1] - (double)c[1] * (double)b[0];
    const double v = (double)a[0] * (double)c[1] - (double)a[1] * (double)c[0];
    const double w = (double)b[0] * (double)a[1] - (double)b[1] * (double)a[0];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const double det = u + v + w;
    if (det == 0) return false; /* the triangle is seen edge-on: its neighbours are hit */
    const double z = u * (double)a[2] + v * (double)b[2] + w * (double)c[2];
    const float t = (float)(z / (det * dz));
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
    return ht_triangle_verdict(s->dz, p[0], p[1], p[2], tmin, tmax, hit);
}

#endif
