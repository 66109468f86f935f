/* wide_avx512.c: wide trees by AVX-512 on 256-bit vectors: it moves lanes to the front by itself. */
#include "base/isa.h"

#ifdef HT_X86
#define HT_TARGET __attribute__((target("avx2,popcnt,bmi,avx512f,avx512vl,avx512dq")))
#include "trace/x86/wide_x86.h"

HT_TARGET HT_INLINE __m256 compress(__m256 from, uint32_t mask) {
    return _mm256_maskz_compress_ps((__mmask8)mask, from);
}

HT_TARGET HT_INLINE __m256i compress_words(__m256i from, uint32_t mask) {
    return _mm256_maskz_compress_epi32((__mmask8)mask, from);
}

HT_DEFINE_BLOCK_WALKS(ht_wide_avx512_walks);
#else
typedef int ht_no_avx512; /* a file is not empty */
#endif
