/* isa.h: which vector instructions this machine has: asked once per tree, so that a library built for
 * any machine uses what it finds. Hits do not depend on it. */
#ifndef HT_ISA_H
#define HT_ISA_H

#include "base.h"

typedef enum ht_isa { HT_PORTABLE, HT_NEON, HT_AVX2, HT_AVX512 } ht_isa;

/* x86-64 with a compiler that knows function targets has files in trace/x86/. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(HTREE_PORTABLE)
#define HT_X86 1

HT_INLINE ht_isa ht_isa_here(void) {
    __builtin_cpu_init();
    const bool eight = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    if (!eight) return HT_PORTABLE;
    const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
    return wide ? HT_AVX512 : HT_AVX2;
}

/* Every 64-bit ARM has NEON with IEEE's arithmetic, and files in trace/arm/; those of 32 bits flush
 * subnormals, and lanes of big-endian ones are numbered another way. */
#elif defined(__aarch64__) && defined(__ARM_NEON) && defined(__GNUC__) &&                          \
    !defined(__AARCH64EB__) && !defined(HTREE_PORTABLE)
#define HT_ARM 1

HT_INLINE ht_isa ht_isa_here(void) {
    return HT_NEON;
}

#else

HT_INLINE ht_isa ht_isa_here(void) {
    return HT_PORTABLE;
}

#endif

#endif
