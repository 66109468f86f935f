/* wide_avx2.c: wide trees by AVX2, which has no instruction to move lanes to the front: a table of
 * permutations does. */
#include "base/isa.h"

#ifdef HT_X86
#define HT_TARGET __attribute__((target("avx2,popcnt,bmi")))
#include "trace/to_front.h"
#include "trace/x86/wide_x86.h"

HT_TARGET HT_INLINE __m256i lanes_of(uint32_t mask) {
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((int64_t)ht_to_front[mask]));
}

HT_TARGET HT_INLINE __m256 compress(__m256 from, uint32_t mask) {
    return _mm256_permutevar8x32_ps(from, lanes_of(mask));
}

HT_TARGET HT_INLINE __m256i compress_words(__m256i from, uint32_t mask) {
    return _mm256_permutevar8x32_epi32(from, lanes_of(mask));
}

HT_DEFINE_BLOCK_WALKS(ht_wide_avx2_walks);
#else
typedef int ht_no_avx2; /* a file is not empty */
#endif
