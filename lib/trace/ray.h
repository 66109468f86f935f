/* ray.h: a ray made ready for walks, and the conservative plane tests that all walks are made of.
 *
 * The promise: if the triangle test accepts a hit at the computed t, then every box and plane test
 * on the way to that triangle lets t pass. With e = 2^-24 and D = the largest distance along an
 * axis from org to the bounds:
 *
 *  - The test moves a corner by at most 6 e D across the ray (one rounding of the difference, one
 *    of the quotient, one of the product, one of the sum, all scaled by at most 2 D) and by e D
 *    along its main axis. Everything after is exact to 2^-51, and t itself is rounded once: e D
 *    more. So org + t dir lies within 7 e D of the triangle's box on every axis.
 *  - A slab distance (plane - org) * rdir carries three roundings: 3 e D in space.
 *
 * Hence planes are moved outward by PAD = 32 e D, with slack for the roundings of user callbacks,
 * and by FLT_MIN at least, where products underflow. It costs nothing per box: entry planes are met
 * from an origin moved forward, exit planes from one moved back, each rounded outward by 2 e |org|.
 * After T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013, which pads the quotient instead.
 *
 * Where a component of dir is 0 or tiny, it is replaced by 2^-40 of the largest one: over all of D
 * the ray then strays by less than e D, and neither an infinity nor a NaN can arise. */
#ifndef HT_RAY_H
#define HT_RAY_H

#include "triangle.h"

#include <float.h>

#define HT_RAY_PAD   1.9073486328125e-6f    /* 32 e */
#define HT_RAY_ROUND 1.1920928955078125e-7f /* 2 e */
#define HT_RAY_TINY  9.094947017729282e-13f /* 2^-40 */

typedef struct ht_ray {
    float rdir[3];
    float entry[3]; /* org moved forward: where entry planes are measured from */
    float exit[3];  /* org moved back: where exit planes are measured from */
    uint32_t negative[3];
    float reach;       /* D: the largest distance along an axis from org to the bounds */
    float tmin;        /* the caller's: where hits begin to count */
    float tnear, tfar; /* the part of [tmin, tmax] inside the bounds */
    ht_shear shear;
} ht_ray;

/* Lower bound of t beyond a plane of `axis` that bounds a region from the ray's side. */
HT_INLINE float ht_ray_entry(const ht_ray *r, uint32_t axis, float plane) {
    return (plane - r->entry[axis]) * r->rdir[axis];
}

/* Upper bound of t before a plane of `axis` that bounds a region from the far side. */
HT_INLINE float ht_ray_exit(const ht_ray *r, uint32_t axis, float plane) {
    return (plane - r->exit[axis]) * r->rdir[axis];
}

/* Narrows [*tnear, *tfar] to the slab lo..hi of `axis`. */
HT_INLINE void ht_ray_clip(const ht_ray *r, uint32_t axis, float lo, float hi, float *tnear,
                           float *tfar) {
    const uint32_t negative = r->negative[axis];
    *tnear = ht_max(*tnear, ht_ray_entry(r, axis, negative ? hi : lo));
    *tfar = ht_min(*tfar, ht_ray_exit(r, axis, negative ? lo : hi));
}

HT_INLINE void ht_ray_clip_box(const ht_ray *r, const float *lo, const float *hi, float *tnear,
                               float *tfar) {
    for (uint32_t axis = 0; axis < 3; ++axis) ht_ray_clip(r, axis, lo[axis], hi[axis], tnear, tfar);
}

/* Returns false if the ray misses by its numbers alone, or misses the bounds, which must not be
 * empty. */
HT_INLINE bool ht_ray_init(ht_ray *r, const htree_ray *ray, const htree_box *bounds) {
    if (!ht_shear_init(&r->shear, ray)) return false;
    float reach = 0;
    for (int i = 0; i < 3; ++i) {
        reach = ht_max(reach, ht_magnitude(bounds->lo[i] - ray->org[i]));
        reach = ht_max(reach, ht_magnitude(bounds->hi[i] - ray->org[i]));
    }
    const float tiny = HT_RAY_TINY * ht_magnitude(ray->dir[r->shear.kz]);
    for (int i = 0; i < 3; ++i) {
        const float pad =
            ht_max(HT_RAY_PAD * reach + HT_RAY_ROUND * ht_magnitude(ray->org[i]), FLT_MIN);
        const float size = ht_max(tiny, ht_magnitude(ray->dir[i]));
        /* By numbers: signs are as good as random, and branches would be too. */
        const uint32_t negative = ray->dir[i] < 0;
        const float sign = 1 - 2 * (float)negative;
        r->negative[i] = negative;
        r->rdir[i] = 1 / (sign * size);
        r->entry[i] = ray->org[i] + sign * pad;
        r->exit[i] = ray->org[i] - sign * pad;
    }
    r->reach = reach;
    r->tmin = ray->tmin;
    r->tnear = ray->tmin;
    r->tfar = ray->tmax;
    for (uint32_t i = 0; i < 3; ++i) {
        const float planes[2] = {bounds->lo[i], bounds->hi[i]};
        r->tnear = ht_max(r->tnear, ht_ray_entry(r, i, planes[r->negative[i]]));
        r->tfar = ht_min(r->tfar, ht_ray_exit(r, i, planes[1 - r->negative[i]]));
    }
    return r->tnear <= r->tfar;
}

#endif
