/* packet_avx512.c: packets of 16 x 16 rays: what sixteen lanes do. */
#include "base/isa.h"

#ifdef HT_X86
#define HT_TARGET __attribute__((target("avx2,popcnt,bmi,avx512f,avx512vl,avx512dq")))
#include "trace/trace.h"

#include <immintrin.h>

enum { LANES = 16 };

typedef __m512 lanes;
typedef __m512d half;

HT_TARGET HT_INLINE lanes spread(float x) {
    return _mm512_set1_ps(x);
}

HT_TARGET HT_INLINE lanes spread_lane(lanes x, uint32_t lane) {
    return _mm512_permutexvar_ps(_mm512_set1_epi32((int)lane), x);
}

HT_TARGET HT_INLINE lanes load(const float *from) {
    return _mm512_load_ps(from);
}

HT_TARGET HT_INLINE void store(float *to, lanes x) {
    _mm512_store_ps(to, x);
}

HT_TARGET HT_INLINE void storeu(float *to, lanes x) {
    _mm512_storeu_ps(to, x);
}

/* b where either is NaN. */
HT_TARGET HT_INLINE lanes least(lanes a, lanes b) {
    return _mm512_min_ps(a, b);
}

HT_TARGET HT_INLINE lanes greatest(lanes a, lanes b) {
    return _mm512_max_ps(a, b);
}

HT_TARGET HT_INLINE lanes either(lanes a, lanes b, const bool greater) {
    return greater ? greatest(a, b) : least(a, b);
}

HT_TARGET HT_INLINE lanes magnitude(lanes x) {
    return _mm512_abs_ps(x);
}

/* Of magnitudes: the larger one, NaN being larger than all. */
HT_TARGET HT_INLINE lanes larger_or_nan(lanes a, lanes b) {
    return _mm512_castsi512_ps(_mm512_max_epu32(_mm512_castps_si512(a), _mm512_castps_si512(b)));
}

HT_TARGET HT_INLINE uint32_t at_most(lanes a, lanes b) {
    return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
}

HT_TARGET HT_INLINE uint32_t below(lanes a, lanes b) {
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}

HT_TARGET HT_INLINE lanes pick(uint32_t mask, lanes yes, lanes no) {
    return _mm512_mask_blend_ps((__mmask16)mask, no, yes);
}

HT_TARGET HT_INLINE float lowest(lanes x, uint32_t mask) {
    return _mm512_mask_reduce_min_ps((__mmask16)mask, x);
}

HT_TARGET HT_INLINE float highest(lanes x, uint32_t mask) {
    return _mm512_mask_reduce_max_ps((__mmask16)mask, x);
}

/* Four rays in a row: origins with tmin, directions with tmax. */
HT_TARGET HT_INLINE void load_row(const htree_ray *rays, lanes *org, lanes *dir) {
    const lanes a = _mm512_loadu_ps(&rays[0]), b = _mm512_loadu_ps(&rays[2]);
    *org = _mm512_shuffle_f32x4(a, b, 0x88);
    *dir = _mm512_shuffle_f32x4(a, b, 0xdd);
}

/* Within each 128 bits, lane i of vector k becomes lane k of vector i. */
HT_TARGET HT_INLINE void transpose(lanes row[4]) {
    const __m512d a = _mm512_castps_pd(_mm512_unpacklo_ps(row[0], row[1]));
    const __m512d b = _mm512_castps_pd(_mm512_unpackhi_ps(row[0], row[1]));
    const __m512d c = _mm512_castps_pd(_mm512_unpacklo_ps(row[2], row[3]));
    const __m512d d = _mm512_castps_pd(_mm512_unpackhi_ps(row[2], row[3]));
    row[0] = _mm512_castpd_ps(_mm512_unpacklo_pd(a, c));
    row[1] = _mm512_castpd_ps(_mm512_unpackhi_pd(a, c));
    row[2] = _mm512_castpd_ps(_mm512_unpacklo_pd(b, d));
    row[3] = _mm512_castpd_ps(_mm512_unpackhi_pd(b, d));
}

/* Lane i of the result is the least, or the greatest, of the lanes of v[i]. */
HT_TARGET HT_INLINE lanes fold(lanes v[16], const bool greater) {
    for (int i = 0; i < 8; ++i)
        v[i] = either(_mm512_unpacklo_ps(v[2 * i], v[2 * i + 1]),
                      _mm512_unpackhi_ps(v[2 * i], v[2 * i + 1]), greater);
    for (int i = 0; i < 4; ++i) {
        const __m512d a = _mm512_castps_pd(v[2 * i]), b = _mm512_castps_pd(v[2 * i + 1]);
        v[i] = either(_mm512_castpd_ps(_mm512_unpacklo_pd(a, b)),
                      _mm512_castpd_ps(_mm512_unpackhi_pd(a, b)), greater);
    }
    for (int i = 0; i < 2; ++i)
        v[i] = either(_mm512_shuffle_f32x4(v[2 * i], v[2 * i + 1], 0x88),
                      _mm512_shuffle_f32x4(v[2 * i], v[2 * i + 1], 0xdd), greater);
    return either(_mm512_shuffle_f32x4(v[0], v[1], 0x88), _mm512_shuffle_f32x4(v[0], v[1], 0xdd),
                  greater);
}

/* ---- Prims ---------------------------------------------------------------------------------- */

HT_TARGET HT_INLINE uint32_t prims_above(const uint32_t *prims, uint32_t prim) {
    return _mm512_cmpgt_epu32_mask(_mm512_load_si512(prims), _mm512_set1_epi32((int)prim));
}

HT_TARGET HT_INLINE uint32_t prims_hit(const uint32_t *prims) {
    return _mm512_cmpneq_epi32_mask(_mm512_load_si512(prims), _mm512_set1_epi32(-1));
}

HT_TARGET HT_INLINE void store_prim(uint32_t *prims, uint32_t mask, uint32_t prim) {
    _mm512_mask_store_epi32(prims, (__mmask16)mask, _mm512_set1_epi32((int)prim));
}

/* ---- Double --------------------------------------------------------------------------------- */

HT_TARGET HT_INLINE half widen(const float *from) {
    return _mm512_cvtps_pd(_mm256_load_ps(from));
}

HT_TARGET HT_INLINE lanes narrow(half low, half high) {
    const __m512 x = _mm512_castps256_ps512(_mm512_cvtpd_ps(low));
    return _mm512_insertf32x8(x, _mm512_cvtpd_ps(high), 1);
}

HT_TARGET HT_INLINE half load_half(const double *from) {
    return _mm512_load_pd(from);
}

HT_TARGET HT_INLINE void store_some(double *to, uint32_t mask, half x) {
    _mm512_mask_store_pd(to, (__mmask8)mask, x);
}

/* Where signs do not differ, and the triangle is not seen edge-on. */
HT_TARGET HT_INLINE uint32_t meets_triangle(half u, half v, half w, half det) {
    const half zero = _mm512_setzero_pd();
    const __mmask8 some_below =
        _mm512_cmp_pd_mask(_mm512_min_pd(_mm512_min_pd(u, v), w), zero, _CMP_LT_OQ);
    const __mmask8 outside = _mm512_mask_cmp_pd_mask(
        some_below, _mm512_max_pd(_mm512_max_pd(u, v), w), zero, _CMP_GT_OQ);
    return (uint32_t)_mm512_cmp_pd_mask(det, zero, _CMP_NEQ_UQ) & ~(uint32_t)outside & 0xff;
}

#include "trace/x86/packet_tile.h"

HT_DEFINE_TILE_WALKS(ht_packet_avx512_walks, ht_wide_avx512_walks);
#else
typedef int ht_no_avx512_packets; /* a file is not empty */
#endif
