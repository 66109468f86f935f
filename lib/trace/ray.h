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
    float rdir[4];  /* the fourth repeats the first */
    float entry[4]; /* org moved forward: where entry planes are measured from */
    float exit[4];  /* org moved back: where exit planes are measured from */
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
    const ht_f4 org = ht_ray_org(ray), dir = ht_ray_dir(ray), zero = ht_f4_all(0);
    if (!ht_shear_init(&r->shear, ray)) return false;
    const ht_f4 lo = ht_f4_set(bounds->lo[0], bounds->lo[1], bounds->lo[2], bounds->lo[0]);
    const ht_f4 hi = ht_f4_set(bounds->hi[0], bounds->hi[1], bounds->hi[2], bounds->hi[0]);
    const ht_f4 size = ht_f4_magnitude(dir), distance = ht_f4_magnitude(org);
    const ht_f4 reach = ht_f4_largest(
        ht_f4_max(ht_f4_magnitude(ht_f4_sub(lo, org)), ht_f4_magnitude(ht_f4_sub(hi, org))));
    const ht_f4 pad = ht_f4_max(ht_f4_add(ht_f4_mul(ht_f4_all(HT_RAY_PAD), reach),
                                          ht_f4_mul(ht_f4_all(HT_RAY_ROUND), distance)),
                                ht_f4_all(FLT_MIN));
    const ht_f4 run = ht_f4_max(ht_f4_mul(ht_f4_all(HT_RAY_TINY), ht_f4_largest(size)), size);
    const ht_f4 forward = ht_f4_by_sign(dir, ht_f4_sub(zero, pad), pad);
    const ht_f4 rdir = ht_f4_div(ht_f4_all(1), ht_f4_by_sign(dir, ht_f4_sub(zero, run), run));
    const ht_f4 entry = ht_f4_add(org, forward), exit = ht_f4_sub(org, forward);
    const ht_f4 enter = ht_f4_mul(ht_f4_sub(ht_f4_by_sign(dir, hi, lo), entry), rdir);
    const ht_f4 leave = ht_f4_mul(ht_f4_sub(ht_f4_by_sign(dir, lo, hi), exit), rdir);
    const uint32_t negative = ht_f4_above(zero, dir);
    for (uint32_t i = 0; i < 3; ++i) r->negative[i] = negative >> i & 1;
    ht_f4_store(r->rdir, rdir);
    ht_f4_store(r->entry, entry);
    ht_f4_store(r->exit, exit);
    r->reach = ht_f4_first(reach);
    r->tmin = ray->tmin;
    r->tnear = ht_max(ray->tmin, ht_f4_first(ht_f4_largest(enter)));
    r->tfar = ht_min(ray->tmax, ht_f4_first(ht_f4_least(leave)));
    return r->tnear <= r->tfar;
}

#endif
