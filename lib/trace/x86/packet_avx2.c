/* packet_avx2.c: packets of 8 x 8 rays: what eight lanes do. */
#include "base/isa.h"

#ifdef HT_X86
#define HT_TARGET __attribute__((target("avx2,popcnt,bmi")))
#include "trace/trace.h"

#include <immintrin.h>

enum { LANES = 8 };

typedef __m256 lanes;
typedef __m256d half;

HT_TARGET HT_INLINE __m256i lanes_of(uint32_t mask) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int)mask), bit), bit);
}

HT_TARGET HT_INLINE lanes spread(float x) {
    return _mm256_set1_ps(x);
}

HT_TARGET HT_INLINE lanes spread_lane(lanes x, uint32_t lane) {
    return _mm256_permutevar8x32_ps(x, _mm256_set1_epi32((int)lane));
}

HT_TARGET HT_INLINE lanes load(const float *from) {
    return _mm256_load_ps(from);
}

HT_TARGET HT_INLINE void store(float *to, lanes x) {
    _mm256_store_ps(to, x);
}

HT_TARGET HT_INLINE void storeu(float *to, lanes x) {
    _mm256_storeu_ps(to, x);
}

/* b where either is NaN. */
HT_TARGET HT_INLINE lanes least(lanes a, lanes b) {
    return _mm256_min_ps(a, b);
}

HT_TARGET HT_INLINE lanes greatest(lanes a, lanes b) {
    return _mm256_max_ps(a, b);
}

HT_TARGET HT_INLINE lanes either(lanes a, lanes b, const bool greater) {
    return greater ? greatest(a, b) : least(a, b);
}

HT_TARGET HT_INLINE lanes magnitude(lanes x) {
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), x);
}

/* Of magnitudes: the larger one, NaN being larger than all. */
HT_TARGET HT_INLINE lanes larger_or_nan(lanes a, lanes b) {
    return _mm256_castsi256_ps(_mm256_max_epu32(_mm256_castps_si256(a), _mm256_castps_si256(b)));
}

HT_TARGET HT_INLINE uint32_t at_most(lanes a, lanes b) {
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LE_OQ));
}

HT_TARGET HT_INLINE uint32_t below(lanes a, lanes b) {
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ));
}

HT_TARGET HT_INLINE lanes pick(uint32_t mask, lanes yes, lanes no) {
    return _mm256_blendv_ps(no, yes, _mm256_castsi256_ps(lanes_of(mask)));
}

HT_TARGET HT_INLINE float extreme(lanes x, const bool greater) {
    x = either(x, _mm256_permute2f128_ps(x, x, 1), greater);
    x = either(x, _mm256_permute_ps(x, 0x4e), greater);
    return _mm256_cvtss_f32(either(x, _mm256_permute_ps(x, 0xb1), greater));
}

HT_TARGET HT_INLINE float lowest(lanes x, uint32_t mask) {
    return extreme(pick(mask, x, spread(INFINITY)), false);
}

HT_TARGET HT_INLINE float highest(lanes x, uint32_t mask) {
    return extreme(pick(mask, x, spread(-INFINITY)), true);
}

/* Two rays in a row: origins with tmin, directions with tmax. */
HT_TARGET HT_INLINE void load_row(const htree_ray *rays, lanes *org, lanes *dir) {
    const lanes a = _mm256_loadu_ps((const float *)(const void *)&rays[0]);
    const lanes b = _mm256_loadu_ps((const float *)(const void *)&rays[1]);
    *org = _mm256_permute2f128_ps(a, b, 0x20);
    *dir = _mm256_permute2f128_ps(a, b, 0x31);
}

/* Within each 128 bits, lane i of vector k becomes lane k of vector i. */
HT_TARGET HT_INLINE void transpose(lanes row[4]) {
    const __m256d a = _mm256_castps_pd(_mm256_unpacklo_ps(row[0], row[1]));
    const __m256d b = _mm256_castps_pd(_mm256_unpackhi_ps(row[0], row[1]));
    const __m256d c = _mm256_castps_pd(_mm256_unpacklo_ps(row[2], row[3]));
    const __m256d d = _mm256_castps_pd(_mm256_unpackhi_ps(row[2], row[3]));
    row[0] = _mm256_castpd_ps(_mm256_unpacklo_pd(a, c));
    row[1] = _mm256_castpd_ps(_mm256_unpackhi_pd(a, c));
    row[2] = _mm256_castpd_ps(_mm256_unpacklo_pd(b, d));
    row[3] = _mm256_castpd_ps(_mm256_unpackhi_pd(b, d));
}

/* Lane i of the result is the least, or the greatest, of the lanes of v[i]. */
HT_TARGET HT_INLINE lanes fold(lanes v[8], const bool greater) {
    for (int i = 0; i < 4; ++i)
        v[i] = either(_mm256_unpacklo_ps(v[2 * i], v[2 * i + 1]),
                      _mm256_unpackhi_ps(v[2 * i], v[2 * i + 1]), greater);
    for (int i = 0; i < 2; ++i) {
        const __m256d a = _mm256_castps_pd(v[2 * i]), b = _mm256_castps_pd(v[2 * i + 1]);
        v[i] = either(_mm256_castpd_ps(_mm256_unpacklo_pd(a, b)),
                      _mm256_castpd_ps(_mm256_unpackhi_pd(a, b)), greater);
    }
    return either(_mm256_permute2f128_ps(v[0], v[1], 0x20),
                  _mm256_permute2f128_ps(v[0], v[1], 0x31), greater);
}

/* ---- Prims ---------------------------------------------------------------------------------- */

/* By turning the sign: AVX2 compares no unsigned words. */
HT_TARGET HT_INLINE uint32_t prims_above(const uint32_t *prims, uint32_t prim) {
    const __m256i sign = _mm256_set1_epi32(INT32_MIN);
    const __m256i all = _mm256_load_si256((const __m256i *)(const void *)prims);
    const __m256i one = _mm256_set1_epi32((int)prim);
    const __m256i above =
        _mm256_cmpgt_epi32(_mm256_xor_si256(all, sign), _mm256_xor_si256(one, sign));
    return (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(above));
}

HT_TARGET HT_INLINE uint32_t prims_hit(const uint32_t *prims) {
    const __m256i all = _mm256_load_si256((const __m256i *)(const void *)prims);
    const __m256i none = _mm256_cmpeq_epi32(all, _mm256_set1_epi32(-1));
    return ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(none)) & 0xff;
}

HT_TARGET HT_INLINE void store_prim(uint32_t *prims, uint32_t mask, uint32_t prim) {
    _mm256_maskstore_epi32((int *)(void *)prims, lanes_of(mask), _mm256_set1_epi32((int)prim));
}

/* ---- Double --------------------------------------------------------------------------------- */

HT_TARGET HT_INLINE half widen(const float *from) {
    return _mm256_cvtps_pd(_mm_load_ps(from));
}

HT_TARGET HT_INLINE lanes narrow(half low, half high) {
    return _mm256_set_m128(_mm256_cvtpd_ps(high), _mm256_cvtpd_ps(low));
}

HT_TARGET HT_INLINE half load_half(const double *from) {
    return _mm256_load_pd(from);
}

HT_TARGET HT_INLINE void store_some(double *to, uint32_t mask, half x) {
    const __m256i bit = _mm256_setr_epi64x(1, 2, 4, 8);
    const __m256i all = _mm256_set1_epi64x((int64_t)mask);
    _mm256_maskstore_pd(to, _mm256_cmpeq_epi64(_mm256_and_si256(all, bit), bit), x);
}

/* Where signs do not differ, and the triangle is not seen edge-on. */
HT_TARGET HT_INLINE uint32_t meets_triangle(half u, half v, half w, half det) {
    const half zero = _mm256_setzero_pd();
    const half low = _mm256_min_pd(_mm256_min_pd(u, v), w);
    const half high = _mm256_max_pd(_mm256_max_pd(u, v), w);
    const half outside =
        _mm256_and_pd(_mm256_cmp_pd(low, zero, _CMP_LT_OQ), _mm256_cmp_pd(high, zero, _CMP_GT_OQ));
    const half met = _mm256_andnot_pd(outside, _mm256_cmp_pd(det, zero, _CMP_NEQ_UQ));
    return (uint32_t)_mm256_movemask_pd(met);
}

#include "trace/x86/packet_tile.h"

HT_DEFINE_TILE_WALKS(ht_packet_avx2_walks, ht_wide_avx2_walks);
#else
typedef int ht_no_avx2_packets; /* a file is not empty */
#endif
