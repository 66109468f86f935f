/* wide_avx2.c: wide trees by AVX2, which has no instruction to move lanes to the front: a table of
 * permutations does. */
#include "base/isa.h"

#ifdef HT_X86
#define HT_TARGET __attribute__((target("avx2,popcnt,bmi")))
#include "trace/x86/wide_x86.h"

/* Byte k of row m: the number of the k-th lane of mask m. */
#define LANE(m, k) (uint64_t)((m) >> (k)&1)
#define COUNT(m, k)                                                                                \
    (((k) > 0 ? LANE(m, 0) : 0) + ((k) > 1 ? LANE(m, 1) : 0) + ((k) > 2 ? LANE(m, 2) : 0) +        \
     ((k) > 3 ? LANE(m, 3) : 0) + ((k) > 4 ? LANE(m, 4) : 0) + ((k) > 5 ? LANE(m, 5) : 0) +        \
     ((k) > 6 ? LANE(m, 6) : 0))
#define PLACE(m, k) (LANE(m, k) * ((uint64_t)(k) << 8 * COUNT(m, k)))
#define ROW(m)                                                                                     \
    (PLACE(m, 0) + PLACE(m, 1) + PLACE(m, 2) + PLACE(m, 3) + PLACE(m, 4) + PLACE(m, 5) +           \
     PLACE(m, 6) + PLACE(m, 7))
#define ROWS4(m)  ROW(m), ROW((m) + 1), ROW((m) + 2), ROW((m) + 3)
#define ROWS16(m) ROWS4(m), ROWS4((m) + 4), ROWS4((m) + 8), ROWS4((m) + 12)
#define ROWS64(m) ROWS16(m), ROWS16((m) + 16), ROWS16((m) + 32), ROWS16((m) + 48)

static const uint64_t to_front[256] = {ROWS64(0), ROWS64(64), ROWS64(128), ROWS64(192)};

HT_TARGET HT_INLINE __m256i lanes_of(uint32_t mask) {
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((int64_t)to_front[mask]));
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
