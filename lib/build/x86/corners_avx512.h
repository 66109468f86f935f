/* corners_avx512.h: corners of sixteen prims coordinate by coordinate, for leaves by AVX-512. */
#ifndef HT_CORNERS_AVX512_H
#define HT_CORNERS_AVX512_H

#include "rows_avx512.h"

/* With intent to write, of memory that begins so many bytes behind `from`; there need not be any. */
HT_TARGET HT_INLINE void ht_ask_for(const void *from, uint64_t behind, uint32_t bytes) {
    const uintptr_t first = (uintptr_t)from + (uintptr_t)behind;
    for (uint32_t at = 0; at < bytes; at += 64) __builtin_prefetch((const void *)(first + at), 1);
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
