/* wide_avx512.c: wide trees by AVX-512 on 256-bit vectors: it moves lanes to the front by itself. */
#include "base/isa.h"

#ifdef HT_X86
#define HT_TARGET __attribute__((target("avx2,popcnt,bmi,avx512f,avx512vl,avx512dq")))
#include "trace/x86/wide_x86.h"

HT_TARGET HT_INLINE lanes compress(lanes from, uint32_t mask) {
    const lanes front = {_mm256_maskz_compress_ps((__mmask8)mask, from.tnear),
                         _mm256_maskz_compress_epi32((__mmask8)mask, from.child)};
    return front;
}

HT_DEFINE_BLOCK_WALKS(ht_wide_avx512_walks);
#else
typedef int ht_no_avx512; /* a file is not empty */
#endif
