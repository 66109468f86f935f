/* rows_avx512.h: corners of triangles as rows of a vector, for scans and errands by AVX-512. */
#ifndef HT_ROWS_AVX512_H
#define HT_ROWS_AVX512_H

#include "build/wide.h"

#include <immintrin.h>

#define HT_TARGET                                                                                  \
    __attribute__((target("avx2,popcnt,bmi,bmi2,avx512f,avx512vl,avx512dq,avx512bw,prfchw")))

/* With intent to write; which memory it is does not matter. */
HT_TARGET HT_INLINE void ht_ask_for(const void *memory, uint32_t bytes) {
    for (uint32_t at = 0; at < bytes; at += 64) __builtin_prefetch((const char *)memory + at, 1);
}

/* Four triangles: a corner of each, or the lower or upper corners of their boxes. */
typedef __m512 ht_rows;

HT_TARGET HT_INLINE __m512i ht_lanes16(void) {
    return _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}

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

/* Bytes from the first position to the corners of sixteen prims; false if one of them is the last
 * vertex. */
HT_TARGET HT_INLINE bool ht_find_corners(const ht_source *source, __m512i prims,
                                         uint32_t from[3][16]) {
    const __m512i first = _mm512_add_epi32(prims, _mm512_add_epi32(prims, prims));
    const __m512i stride = _mm512_set1_epi32((int)source->stride);
    const __m512i last = _mm512_set1_epi32((int)(source->vertex_count - 1));
    __mmask16 found = 0;
    for (int k = 0; k < 3; ++k) {
        const __m512i vertex = source->indices
                                   ? _mm512_i32gather_epi32(first, source->indices + k, 4)
                                   : _mm512_add_epi32(first, _mm512_set1_epi32(k));
        _mm512_store_si512(from[k], _mm512_mullo_epi32(vertex, stride));
        found |= _mm512_cmpeq_epi32_mask(vertex, last);
    }
    return found == 0;
}

/* One corner of sixteen prims, coordinate by coordinate. */
HT_TARGET HT_INLINE void ht_load_corner(const char *positions, const uint32_t *from, __m512 v[3]) {
    ht_rows row[4];
    for (uint32_t i = 0; i < 4; ++i) row[i] = ht_load_rows(positions, from + i, 4);
    const __m512 xz = _mm512_unpacklo_ps(row[0], row[2]), yw = _mm512_unpacklo_ps(row[1], row[3]);
    const __m512 zx = _mm512_unpackhi_ps(row[0], row[2]), wy = _mm512_unpackhi_ps(row[1], row[3]);
    v[0] = _mm512_unpacklo_ps(xz, yw);
    v[1] = _mm512_unpackhi_ps(xz, yw);
    v[2] = _mm512_unpacklo_ps(zx, wy);
}

#endif
