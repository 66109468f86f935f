/* lanes.h: four floats at once, for builders and for rays made ready: SSE2 and NEON, which every
 * x86-64 and AArch64 has, and plain C elsewhere. The bits are the same: each lane does what vec.h
 * does. */
#ifndef HT_LANES4_H
#define HT_LANES4_H

#include "vec.h"

#if defined(__SSE2__)
#include <emmintrin.h>
typedef __m128 ht_f4;

HT_INLINE ht_f4 ht_f4_load(const float *from) {
    return _mm_loadu_ps(from);
}

HT_INLINE void ht_f4_store(float *to, ht_f4 a) {
    _mm_storeu_ps(to, a);
}

HT_INLINE ht_f4 ht_f4_set(float x, float y, float z, float w) {
    return _mm_setr_ps(x, y, z, w);
}

HT_INLINE ht_f4 ht_f4_add(ht_f4 a, ht_f4 b) {
    return _mm_add_ps(a, b);
}

HT_INLINE ht_f4 ht_f4_sub(ht_f4 a, ht_f4 b) {
    return _mm_sub_ps(a, b);
}

HT_INLINE ht_f4 ht_f4_mul(ht_f4 a, ht_f4 b) {
    return _mm_mul_ps(a, b);
}

HT_INLINE ht_f4 ht_f4_div(ht_f4 a, ht_f4 b) {
    return _mm_div_ps(a, b);
}

HT_INLINE ht_f4 ht_f4_min(ht_f4 a, ht_f4 b) {
    return _mm_min_ps(b, a);
}

HT_INLINE ht_f4 ht_f4_max(ht_f4 a, ht_f4 b) {
    return _mm_max_ps(b, a);
}

HT_INLINE ht_f4 ht_f4_magnitude(ht_f4 a) {
    return _mm_andnot_ps(_mm_set1_ps(-0.0f), a);
}

/* The last lane replaced by bits that are no number. */
HT_INLINE ht_f4 ht_f4_with_bits(ht_f4 a, uint32_t bits) {
    const __m128i xyz = _mm_srli_si128(_mm_set1_epi32(-1), 4);
    const __m128i last = _mm_slli_si128(_mm_cvtsi32_si128((int)bits), 12);
    return _mm_or_ps(_mm_and_ps(a, _mm_castsi128_ps(xyz)), _mm_castsi128_ps(last));
}

/* y z x w */
HT_INLINE ht_f4 ht_f4_rotate(ht_f4 a) {
    return _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 0, 2, 1));
}

/* x y z x */
HT_INLINE ht_f4 ht_f4_three(ht_f4 a) {
    return _mm_shuffle_ps(a, a, _MM_SHUFFLE(0, 2, 1, 0));
}

/* A bit for every lane where a > b. */
HT_INLINE uint32_t ht_f4_above(ht_f4 a, ht_f4 b) {
    return (uint32_t)_mm_movemask_ps(_mm_cmpgt_ps(a, b));
}

/* A bit for every lane where a <= b. */
HT_INLINE uint32_t ht_f4_at_most(ht_f4 a, ht_f4 b) {
    return (uint32_t)_mm_movemask_ps(_mm_cmple_ps(a, b));
}

/* In each lane: sign < 0 ? a : b. */
HT_INLINE ht_f4 ht_f4_by_sign(ht_f4 sign, ht_f4 a, ht_f4 b) {
    const __m128 below = _mm_cmplt_ps(sign, _mm_setzero_ps());
    return _mm_or_ps(_mm_and_ps(below, a), _mm_andnot_ps(below, b));
}

/* Towards zero; of numbers that fit. */
HT_INLINE void ht_f4_store_int(int32_t *to, ht_f4 a) {
    _mm_storeu_si128((__m128i *)(void *)to, _mm_cvttps_epi32(a));
}

/* Rows become columns. */
HT_INLINE void ht_f4_transpose(ht_f4 row[4]) {
    _MM_TRANSPOSE4_PS(row[0], row[1], row[2], row[3]);
}

#elif defined(__ARM_NEON) && defined(__aarch64__) && !defined(__AARCH64EB__)
#include <arm_neon.h>
typedef float32x4_t ht_f4;

HT_INLINE ht_f4 ht_f4_load(const float *from) {
    return vld1q_f32(from);
}

HT_INLINE void ht_f4_store(float *to, ht_f4 a) {
    vst1q_f32(to, a);
}

HT_INLINE ht_f4 ht_f4_set(float x, float y, float z, float w) {
    const float lanes[4] = {x, y, z, w};
    return vld1q_f32(lanes);
}

HT_INLINE ht_f4 ht_f4_add(ht_f4 a, ht_f4 b) {
    return vaddq_f32(a, b);
}

HT_INLINE ht_f4 ht_f4_sub(ht_f4 a, ht_f4 b) {
    return vsubq_f32(a, b);
}

HT_INLINE ht_f4 ht_f4_mul(ht_f4 a, ht_f4 b) {
    return vmulq_f32(a, b);
}

HT_INLINE ht_f4 ht_f4_div(ht_f4 a, ht_f4 b) {
    return vdivq_f32(a, b);
}

/* Not vminq and vmaxq: they order -0 below 0. */
HT_INLINE ht_f4 ht_f4_min(ht_f4 a, ht_f4 b) {
    return vbslq_f32(vcltq_f32(b, a), b, a);
}

HT_INLINE ht_f4 ht_f4_max(ht_f4 a, ht_f4 b) {
    return vbslq_f32(vcgtq_f32(b, a), b, a);
}

HT_INLINE ht_f4 ht_f4_magnitude(ht_f4 a) {
    return vabsq_f32(a);
}

HT_INLINE ht_f4 ht_f4_with_bits(ht_f4 a, uint32_t bits) {
    return vreinterpretq_f32_u32(vsetq_lane_u32(bits, vreinterpretq_u32_f32(a), 3));
}

HT_INLINE ht_f4 ht_f4_rotate(ht_f4 a) {
    const float lanes[4] = {vgetq_lane_f32(a, 1), vgetq_lane_f32(a, 2), vgetq_lane_f32(a, 0),
                            vgetq_lane_f32(a, 3)};
    return vld1q_f32(lanes);
}

HT_INLINE ht_f4 ht_f4_three(ht_f4 a) {
    return vsetq_lane_f32(vgetq_lane_f32(a, 0), a, 3);
}

HT_INLINE uint32_t ht_f4_above(ht_f4 a, ht_f4 b) {
    const uint32_t bits[4] = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(vcgtq_f32(a, b), vld1q_u32(bits)));
}

HT_INLINE uint32_t ht_f4_at_most(ht_f4 a, ht_f4 b) {
    const uint32_t bits[4] = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(vcleq_f32(a, b), vld1q_u32(bits)));
}

HT_INLINE ht_f4 ht_f4_by_sign(ht_f4 sign, ht_f4 a, ht_f4 b) {
    return vbslq_f32(vcltzq_f32(sign), a, b);
}

HT_INLINE void ht_f4_store_int(int32_t *to, ht_f4 a) {
    vst1q_s32(to, vcvtq_s32_f32(a));
}

HT_INLINE void ht_f4_transpose(ht_f4 row[4]) {
    const float32x4x2_t xz = vzipq_f32(row[0], row[2]), yw = vzipq_f32(row[1], row[3]);
    const float32x4x2_t lo = vzipq_f32(xz.val[0], yw.val[0]), hi = vzipq_f32(xz.val[1], yw.val[1]);
    row[0] = lo.val[0];
    row[1] = lo.val[1];
    row[2] = hi.val[0];
    row[3] = hi.val[1];
}

#else
typedef struct ht_f4 {
    float v[4];
} ht_f4;

HT_INLINE ht_f4 ht_f4_load(const float *from) {
    ht_f4 a;
    memcpy(a.v, from, sizeof a.v);
    return a;
}

HT_INLINE void ht_f4_store(float *to, ht_f4 a) {
    memcpy(to, a.v, sizeof a.v);
}

HT_INLINE ht_f4 ht_f4_set(float x, float y, float z, float w) {
    const ht_f4 a = {{x, y, z, w}};
    return a;
}

HT_INLINE ht_f4 ht_f4_add(ht_f4 a, ht_f4 b) {
    for (int k = 0; k < 4; ++k) a.v[k] += b.v[k];
    return a;
}

HT_INLINE ht_f4 ht_f4_sub(ht_f4 a, ht_f4 b) {
    for (int k = 0; k < 4; ++k) a.v[k] -= b.v[k];
    return a;
}

HT_INLINE ht_f4 ht_f4_mul(ht_f4 a, ht_f4 b) {
    for (int k = 0; k < 4; ++k) a.v[k] *= b.v[k];
    return a;
}

HT_INLINE ht_f4 ht_f4_div(ht_f4 a, ht_f4 b) {
    for (int k = 0; k < 4; ++k) a.v[k] /= b.v[k];
    return a;
}

HT_INLINE ht_f4 ht_f4_min(ht_f4 a, ht_f4 b) {
    for (int k = 0; k < 4; ++k) a.v[k] = ht_min(a.v[k], b.v[k]);
    return a;
}

HT_INLINE ht_f4 ht_f4_max(ht_f4 a, ht_f4 b) {
    for (int k = 0; k < 4; ++k) a.v[k] = ht_max(a.v[k], b.v[k]);
    return a;
}

HT_INLINE ht_f4 ht_f4_magnitude(ht_f4 a) {
    for (int k = 0; k < 4; ++k) a.v[k] = ht_magnitude(a.v[k]);
    return a;
}

HT_INLINE ht_f4 ht_f4_with_bits(ht_f4 a, uint32_t bits) {
    memcpy(&a.v[3], &bits, sizeof bits);
    return a;
}

HT_INLINE ht_f4 ht_f4_rotate(ht_f4 a) {
    return ht_f4_set(a.v[1], a.v[2], a.v[0], a.v[3]);
}

HT_INLINE ht_f4 ht_f4_three(ht_f4 a) {
    return ht_f4_set(a.v[0], a.v[1], a.v[2], a.v[0]);
}

HT_INLINE uint32_t ht_f4_above(ht_f4 a, ht_f4 b) {
    uint32_t mask = 0;
    for (int k = 0; k < 4; ++k) mask |= (uint32_t)(a.v[k] > b.v[k]) << k;
    return mask;
}

HT_INLINE uint32_t ht_f4_at_most(ht_f4 a, ht_f4 b) {
    uint32_t mask = 0;
    for (int k = 0; k < 4; ++k) mask |= (uint32_t)(a.v[k] <= b.v[k]) << k;
    return mask;
}

HT_INLINE ht_f4 ht_f4_by_sign(ht_f4 sign, ht_f4 a, ht_f4 b) {
    for (int k = 0; k < 4; ++k) a.v[k] = sign.v[k] < 0 ? a.v[k] : b.v[k];
    return a;
}

HT_INLINE void ht_f4_store_int(int32_t *to, ht_f4 a) {
    for (int k = 0; k < 4; ++k) to[k] = (int32_t)a.v[k];
}

HT_INLINE void ht_f4_transpose(ht_f4 row[4]) {
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < i; ++k) {
            const float from = row[i].v[k];
            row[i].v[k] = row[k].v[i];
            row[k].v[i] = from;
        }
    }
}
#endif

HT_INLINE ht_f4 ht_f4_all(float x) {
    return ht_f4_set(x, x, x, x);
}

/* The largest of the first three lanes, in each of them. */
HT_INLINE ht_f4 ht_f4_largest(ht_f4 a) {
    const ht_f4 next = ht_f4_rotate(a);
    return ht_f4_max(a, ht_f4_max(next, ht_f4_rotate(next)));
}

HT_INLINE ht_f4 ht_f4_least(ht_f4 a) {
    const ht_f4 next = ht_f4_rotate(a);
    return ht_f4_min(a, ht_f4_min(next, ht_f4_rotate(next)));
}

HT_INLINE float ht_f4_first(ht_f4 a) {
    float lanes[4];
    ht_f4_store(lanes, a);
    return lanes[0];
}

/* ---- Boxes; the last lane means nothing ----------------------------------------------------- */

typedef struct ht_box4 {
    ht_f4 lo, hi;
} ht_box4;

HT_INLINE ht_box4 ht_box4_empty(void) {
    const ht_box4 box = {ht_f4_all(INFINITY), ht_f4_all(-INFINITY)};
    return box;
}

HT_INLINE void ht_box4_add(ht_box4 *box, ht_f4 lo, ht_f4 hi) {
    box->lo = ht_f4_min(box->lo, lo);
    box->hi = ht_f4_max(box->hi, hi);
}

HT_INLINE ht_box4 ht_box4_of(const htree_box *box) {
    const ht_box4 of = {ht_f4_set(box->lo[0], box->lo[1], box->lo[2], 0),
                        ht_f4_set(box->hi[0], box->hi[1], box->hi[2], 0)};
    return of;
}

/* Half the surface area: the bits of ht_box_area. */
HT_INLINE float ht_box4_area(const ht_box4 *box) {
    const ht_f4 x = ht_f4_max(ht_f4_all(0), ht_f4_sub(box->hi, box->lo));
    const ht_f4 y = ht_f4_rotate(x), z = ht_f4_rotate(y);
    return ht_f4_first(ht_f4_add(ht_f4_mul(x, ht_f4_add(y, z)), ht_f4_mul(y, z)));
}

HT_INLINE htree_box ht_box4_box(const ht_box4 *box) {
    float lo[4], hi[4];
    htree_box out;
    ht_f4_store(lo, box->lo);
    ht_f4_store(hi, box->hi);
    memcpy(out.lo, lo, sizeof out.lo);
    memcpy(out.hi, hi, sizeof out.hi);
    return out;
}

#endif
