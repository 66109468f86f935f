/* ready_x86.h: makes eight rays ready at a time, a lane each: included by wide_x86.h.
 *
 * It does what ht_ray_init does, but for box tests in one rounded step: t = plane * rdir +
 * enter, with enter = -(entry * rdir). The error of that product is e |entry| in space, however
 * near the plane may be: so origins are moved by 4 e |org| here, where ray.h moves them by 2 e
 * |org|. The proof there holds otherwise: rdir carries a rounding, and the sum is rounded once,
 * which is monotonic. FLT_MIN more is for products that underflow. Where one overflows, the ray
 * goes its way apart. */
#ifndef HT_READY_X86_H
#define HT_READY_X86_H

#include "trace/streams.h"

#include <immintrin.h>

/* yes where the mask is all ones, no where it is 0. */
HT_TARGET HT_INLINE __m256 pick(__m256 mask, __m256 yes, __m256 no);

/* Eight rays: org, tmin, dir, tmax. */
typedef struct eight_rays {
    __m256 org[3], dir[3], tmin, tmax;
} eight_rays;

HT_TARGET HT_INLINE __m256 spread(float x) {
    return _mm256_set1_ps(x);
}

HT_TARGET HT_INLINE __m256 magnitude(__m256 x) {
    return _mm256_andnot_ps(spread(-0.0f), x);
}

HT_TARGET HT_INLINE __m256 words(uint32_t x) {
    return _mm256_castsi256_ps(_mm256_set1_epi32((int)x));
}

/* Rows become columns. */
HT_TARGET HT_INLINE void transpose(__m256 row[8]) {
    __m256 pair[8], four[8];
    for (int i = 0; i < 4; ++i) {
        pair[2 * i] = _mm256_unpacklo_ps(row[2 * i], row[2 * i + 1]);
        pair[2 * i + 1] = _mm256_unpackhi_ps(row[2 * i], row[2 * i + 1]);
    }
    for (int i = 0; i < 8; i += 4) {
        four[i] = _mm256_shuffle_ps(pair[i], pair[i + 2], 0x44);
        four[i + 1] = _mm256_shuffle_ps(pair[i], pair[i + 2], 0xee);
        four[i + 2] = _mm256_shuffle_ps(pair[i + 1], pair[i + 3], 0x44);
        four[i + 3] = _mm256_shuffle_ps(pair[i + 1], pair[i + 3], 0xee);
    }
    for (int i = 0; i < 4; ++i) {
        row[i] = _mm256_permute2f128_ps(four[i], four[i + 4], 0x20);
        row[i + 4] = _mm256_permute2f128_ps(four[i], four[i + 4], 0x31);
    }
}

HT_TARGET HT_INLINE eight_rays load_rays(const htree_ray *rays) {
    eight_rays r;
    __m256 row[8];
    for (int i = 0; i < 8; ++i) row[i] = _mm256_loadu_ps((const float *)(const void *)&rays[i]);
    transpose(row);
    for (int k = 0; k < 3; ++k) {
        r.org[k] = row[k];
        r.dir[k] = row[4 + k];
    }
    r.tmin = row[3];
    r.tmax = row[7];
    return r;
}

/* Writes part `part` of each ray: eight of its words. */
HT_TARGET HT_INLINE void store_part(ready *out, uint32_t part, __m256 word[8]) {
    transpose(word);
    for (int i = 0; i < 8; ++i) _mm256_store_ps((float *)(void *)&out[i] + 8 * part, word[i]);
}

/* All ones for rays that htree.h does not declare a miss; NaN fails every comparison. */
HT_TARGET HT_INLINE __m256 valid_rays(const eight_rays *r, __m256 largest) {
    const __m256 limit = spread(HTREE_COORDINATE_MAX);
    __m256 valid = _mm256_cmp_ps(r->tmin, r->tmax, _CMP_LE_OQ);
    for (int k = 0; k < 3; ++k) {
        const __m256 org = _mm256_cmp_ps(magnitude(r->org[k]), limit, _CMP_LE_OQ);
        const __m256 dir = _mm256_cmp_ps(magnitude(r->dir[k]), limit, _CMP_LE_OQ);
        valid = _mm256_and_ps(valid, _mm256_and_ps(org, dir));
    }
    const __m256 moves = _mm256_cmp_ps(spread(1 / HTREE_COORDINATE_MAX), largest, _CMP_LE_OQ);
    return _mm256_and_ps(valid, moves);
}

/* ---- What the triangle test needs ----------------------------------------------------------- */

/* Picks by the main axis: the component kz = 0, 1 or 2. */
typedef struct main_axis {
    __m256 is_y, is_z;
} main_axis;

HT_TARGET HT_INLINE __m256 pick_axis(main_axis kz, __m256 x, __m256 y, __m256 z) {
    return pick(kz.is_z, z, pick(kz.is_y, y, x));
}

/* By the rule of ht_shear_init. */
HT_TARGET HT_INLINE main_axis find_main_axis(const eight_rays *r) {
    const __m256 x = magnitude(r->dir[0]), y = magnitude(r->dir[1]), z = magnitude(r->dir[2]);
    main_axis kz;
    kz.is_z = _mm256_and_ps(_mm256_cmp_ps(z, y, _CMP_GT_OQ), _mm256_cmp_ps(z, x, _CMP_GT_OQ));
    kz.is_y = _mm256_cmp_ps(y, x, _CMP_GT_OQ);
    return kz;
}

/* Writes parts 1 and 2 but for `leave`, which is given. */
HT_TARGET HT_INLINE void shear_rays(const eight_rays *r, const __m256 leave[3], __m256 reach,
                                    __m256 order, ready *out) {
    const __m256 *const d = r->dir, *const o = r->org;
    const __m256 row[3] = {words(0), words(HT_LANES), words(2 * HT_LANES)};
    const main_axis kz = find_main_axis(r);
    const __m256 dz = pick_axis(kz, d[0], d[1], d[2]);
    const __m256 sx = _mm256_div_ps(pick_axis(kz, d[1], d[2], d[0]), dz);
    const __m256 sy = _mm256_div_ps(pick_axis(kz, d[2], d[0], d[1]), dz);
    const __m256 first = _mm256_mul_ps(r->tmin, dz);
    const __m256 near = _mm256_cmp_ps(reach, spread(HT_STREAM_FAR), _CMP_LE_OQ);
    const __m256 slack = _mm256_add_ps(magnitude(first), spread(HT_STREAM_LEAST));
    __m256 part[8] = {
        leave[0], leave[1], leave[2], r->tmin, first, pick(near, slack, spread(INFINITY)), dz, sx};
    store_part(out, 1, part);
    __m256 next[8] = {sy,
                      pick_axis(kz, o[1], o[2], o[0]),
                      pick_axis(kz, o[2], o[0], o[1]),
                      pick_axis(kz, o[0], o[1], o[2]),
                      pick_axis(kz, row[1], row[2], row[0]),
                      pick_axis(kz, row[2], row[0], row[1]),
                      pick_axis(kz, row[0], row[1], row[2]),
                      order};
    store_part(out, 2, next);
}

/* ---- What the box test needs ---------------------------------------------------------------- */

/* Distances from the origins to the far end of the bounds. */
HT_TARGET HT_INLINE __m256 find_reach(const htree_box *bounds, const eight_rays *r) {
    __m256 reach = _mm256_setzero_ps();
    for (int k = 0; k < 3; ++k) {
        const __m256 lo = magnitude(_mm256_sub_ps(spread(bounds->lo[k]), r->org[k]));
        const __m256 hi = magnitude(_mm256_sub_ps(spread(bounds->hi[k]), r->org[k]));
        reach = _mm256_max_ps(reach, _mm256_max_ps(lo, hi));
    }
    return reach;
}

/* One axis of eight rays. */
typedef struct slab {
    __m256 rdir, enter, leave, below; /* below: all ones where dir is negative */
} slab;

HT_TARGET HT_INLINE slab make_slab(__m256 org, __m256 dir, __m256 reach, __m256 tiny) {
    const __m256 least = spread(FLT_MIN);
    const __m256 away = _mm256_mul_ps(spread(2 * HT_RAY_ROUND), magnitude(org));
    const __m256 pad = _mm256_max_ps(_mm256_fmadd_ps(spread(HT_RAY_PAD), reach, away), least);
    slab s;
    s.below = _mm256_cmp_ps(dir, _mm256_setzero_ps(), _CMP_LT_OQ);
    const __m256 sign = _mm256_and_ps(s.below, spread(-0.0f));
    const __m256 forward = _mm256_or_ps(pad, sign);
    const __m256 run = _mm256_or_ps(_mm256_max_ps(tiny, magnitude(dir)), sign);
    s.rdir = _mm256_div_ps(spread(1), run);
    s.enter = _mm256_fnmsub_ps(_mm256_add_ps(org, forward), s.rdir, least);
    s.leave = _mm256_fnmadd_ps(_mm256_sub_ps(org, forward), s.rdir, least);
    return s;
}

/* Offsets of planes, which begin at `first` where dir is positive, `other` where it is negative. */
HT_TARGET HT_INLINE __m256 offset(slab s, uint32_t first, uint32_t other) {
    return pick(s.below, words(other), words(first));
}

HT_TARGET HT_INLINE uint32_t make_ready(const htree_box *bounds, const htree_ray *rays, ready *out,
                                        uint32_t *apart) {
    const eight_rays r = load_rays(rays);
    const __m256 largest =
        _mm256_max_ps(_mm256_max_ps(magnitude(r.dir[0]), magnitude(r.dir[1])), magnitude(r.dir[2]));
    const __m256 tiny = _mm256_mul_ps(spread(HT_RAY_TINY), largest);
    const __m256 reach = find_reach(bounds, &r), limit = spread(FLT_MAX);
    __m256 tnear = r.tmin, tfar = r.tmax, order = _mm256_setzero_ps(), small = words(~0u);
    __m256 leave[3], near[8], from[8];
    for (uint32_t k = 0; k < 3; ++k) {
        const slab s = make_slab(r.org[k], r.dir[k], reach, tiny);
        const __m256 lo = spread(bounds->lo[k]), hi = spread(bounds->hi[k]);
        const __m256 first = pick(s.below, hi, lo), last = pick(s.below, lo, hi);
        tnear = _mm256_max_ps(tnear, _mm256_fmadd_ps(first, s.rdir, s.enter));
        tfar = _mm256_min_ps(tfar, _mm256_fmadd_ps(last, s.rdir, s.leave));
        small = _mm256_and_ps(small, _mm256_cmp_ps(magnitude(s.enter), limit, _CMP_LE_OQ));
        small = _mm256_and_ps(small, _mm256_cmp_ps(magnitude(s.leave), limit, _CMP_LE_OQ));
        order = _mm256_or_ps(order, offset(s, 0, 1u << k));
        near[k] = offset(s, HT_LANES * k, HT_LANES * (k + 3));
        near[3 + k] = offset(s, HT_LANES * (k + 3), HT_LANES * k);
        from[k] = s.rdir;
        from[3 + k] = s.enter;
        leave[k] = s.leave;
    }
    near[6] = near[7] = _mm256_setzero_ps();
    from[6] = tnear;
    from[7] = r.tmax;
    store_part(out, 0, from);
    shear_rays(&r, leave, reach, order, out);
    store_part(out, 3, near);
    const __m256 valid = valid_rays(&r, largest);
    const __m256 meets = _mm256_and_ps(valid, _mm256_cmp_ps(tnear, tfar, _CMP_LE_OQ));
    *apart = (uint32_t)_mm256_movemask_ps(_mm256_andnot_ps(small, valid));
    return (uint32_t)_mm256_movemask_ps(_mm256_and_ps(meets, small));
}

#endif
