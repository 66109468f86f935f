/* wide_avx512.c: wide trees by AVX-512 on 256-bit vectors: it moves lanes to the front by itself. */
#include "base/isa.h"

#ifdef HT_X86
#define HT_TARGET __attribute__((target("avx2,fma,popcnt,bmi,avx512f,avx512vl,avx512dq")))
#include "trace/x86/wide_x86.h"

HT_TARGET HT_INLINE uint32_t store_met(__m256 enter, __m256 leave, __m256i words, uint32_t *child,
                                       float *tnear) {
    const __mmask8 met = _mm256_cmp_ps_mask(enter, leave, _CMP_LE_OQ);
    if (tnear) _mm256_storeu_ps(tnear, _mm256_maskz_compress_ps(met, enter));
    _mm256_storeu_si256((__m256i *)(void *)child, _mm256_maskz_compress_epi32(met, words));
    return (uint32_t)_mm_popcnt_u32(_cvtmask8_u32(met));
}

HT_TARGET HT_INLINE __m256 larger(__m256 a, __m256 b) {
    return _mm256_range_ps(a, b, 11); /* the maximum, 3, of magnitudes, without a sign, 8 */
}

HT_TARGET HT_INLINE __m256 pick(__m256 mask, __m256 yes, __m256 no) {
    return _mm256_castsi256_ps(_mm256_ternarylogic_epi32(
        _mm256_castps_si256(mask), _mm256_castps_si256(yes), _mm256_castps_si256(no), 0xca));
}

HT_TARGET HT_INLINE ray_set sort_out(const uint32_t next[STREAMS], ray_set *ended) {
    ray_set elsewhere = 0;
    *ended = 0;
    for (uint32_t i = 0; i < STREAMS; i += 2 * HT_LANES) {
        const __m512i word = _mm512_loadu_si512(next + i), none = _mm512_set1_epi32(-1);
        elsewhere |= (ray_set)_mm512_movepi32_mask(word) << i;
        *ended |= (ray_set)_mm512_cmpeq_epi32_mask(word, none) << i;
    }
    return elsewhere;
}

HT_DEFINE_BLOCK_WALKS(ht_wide_avx512_walks);
#else
typedef int ht_no_avx512; /* a file is not empty */
#endif
