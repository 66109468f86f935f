/* wide_avx2.c: wide trees by AVX2, which has no instruction to move lanes to the front: a table of
 * permutations does. */
#include "base/isa.h"

#ifdef HT_X86
#define HT_TARGET __attribute__((target("avx2,fma,popcnt,bmi")))
#include "trace/to_front.h"
#include "trace/x86/wide_x86.h"

HT_TARGET HT_INLINE uint32_t store_met(__m256 enter, __m256 leave, __m256i words, uint32_t *child,
                                       float *tnear) {
    const uint32_t met = (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ));
    const __m256i from = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((int64_t)ht_to_front[met]));
    if (tnear) _mm256_storeu_ps(tnear, _mm256_permutevar8x32_ps(enter, from));
    _mm256_storeu_si256((__m256i *)(void *)child, _mm256_permutevar8x32_epi32(words, from));
    return (uint32_t)_mm_popcnt_u32(met);
}

HT_TARGET HT_INLINE __m256 larger(__m256 a, __m256 b) {
    const __m256 sign = _mm256_set1_ps(-0.0f);
    return _mm256_max_ps(_mm256_andnot_ps(sign, a), _mm256_andnot_ps(sign, b));
}

HT_TARGET HT_INLINE __m256 pick(__m256 mask, __m256 yes, __m256 no) {
    return _mm256_blendv_ps(no, yes, mask);
}

HT_TARGET HT_INLINE ray_set sort_out(const uint32_t next[STREAMS], ray_set *ended) {
    ray_set elsewhere = 0;
    *ended = 0;
    for (uint32_t i = 0; i < STREAMS; i += HT_LANES) {
        const __m256i word = _mm256_loadu_si256((const __m256i *)(const void *)(next + i));
        const __m256i end = _mm256_cmpeq_epi32(word, _mm256_set1_epi32((int)HT_WIDE_NONE));
        elsewhere |= (ray_set)(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(word)) << i;
        *ended |= (ray_set)(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(end)) << i;
    }
    return elsewhere;
}

HT_DEFINE_BLOCK_WALKS(ht_wide_avx2_walks);
#else
typedef int ht_no_avx2; /* a file is not empty */
#endif
