/* rows_avx512.h: corners of triangles as rows of a vector, for scans and errands by AVX-512. */
#ifndef HT_ROWS_AVX512_H
#define HT_ROWS_AVX512_H

#include "build/wide.h"

#include <immintrin.h>

#define HT_TARGET                                                                                  \
    __attribute__((target("avx2,popcnt,bmi,bmi2,avx512f,avx512vl,avx512dq,avx512bw,prfchw")))

/* Four triangles: a corner of each, or the lower or upper corners of their boxes. */
typedef __m512 ht_rows;

/* Whether there are vertices, all within reach of 32 bits. */
HT_INLINE bool ht_source_is_narrow(const ht_source *source) {
    return source->vertex_count > 0 && source->vertex_count * source->stride <= UINT32_MAX &&
           source->triangle_count <= INT32_MAX / 3;
}

/* Of four vertices by their bytes from the first position, none of them the last one: after that no
 * fourth float may be read. */
HT_TARGET HT_INLINE ht_rows ht_load_rows(const char *positions, const uint32_t *from,
                                         uint32_t step) {
    const float *p[4];
    for (uint32_t i = 0; i < 4; ++i)
        p[i] = (const float *)(const void *)(positions + from[i * step]);
    ht_rows rows = _mm512_castps128_ps512(_mm_loadu_ps(p[0]));
    rows = _mm512_insertf32x4(rows, _mm_loadu_ps(p[1]), 1);
    rows = _mm512_insertf32x4(rows, _mm_loadu_ps(p[2]), 2);
    return _mm512_insertf32x4(rows, _mm_loadu_ps(p[3]), 3);
}

#endif
