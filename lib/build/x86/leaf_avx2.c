/* leaf_avx2.c: eight triangles into a wide leaf by AVX2; the bits are those of wide_nodes.c. */
#include "base/isa.h"

#ifdef HT_X86
#include "build/wide.h"

#include <immintrin.h>

#define HT_TARGET __attribute__((target("avx2")))

/* Bytes from the first position to corner k of each triangle. False if one of them is the last
 * vertex, after which no fourth float may be read. */
HT_TARGET HT_INLINE bool find_corners(const ht_source *source, __m256i prims,
                                      uint32_t from[3][HT_LANES]) {
    const __m256i first = _mm256_add_epi32(prims, _mm256_add_epi32(prims, prims));
    const __m256i stride = _mm256_set1_epi32((int)source->stride);
    const __m256i last = _mm256_set1_epi32((int)(source->vertex_count - 1));
    __m256i found = _mm256_setzero_si256();
    for (int k = 0; k < 3; ++k) {
        const __m256i vertex =
            source->indices
                ? _mm256_i32gather_epi32((const int *)(const void *)source->indices + k, first, 4)
                : _mm256_add_epi32(first, _mm256_set1_epi32(k));
        const __m256i bytes = _mm256_mullo_epi32(vertex, stride);
        _mm256_store_si256((__m256i *)(void *)from[k], bytes);
        found = _mm256_or_si256(found, _mm256_cmpeq_epi32(vertex, last));
    }
    return _mm256_testz_si256(found, found);
}

HT_TARGET HT_INLINE __m256 load_two(const char *positions, const uint32_t *from) {
    const float *low = (const float *)(const void *)(positions + from[0]);
    const float *high = (const float *)(const void *)(positions + from[4]);
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(low)), _mm_loadu_ps(high), 1);
}

/* Rows of triangles i and i + 4 become x, y and z of all; those of idle lanes become 0. */
HT_TARGET HT_INLINE void store_corner(const __m256 row[4], __m256 live, float v[3][8]) {
    const __m256 xz = _mm256_unpacklo_ps(row[0], row[2]), yw = _mm256_unpacklo_ps(row[1], row[3]);
    const __m256 zx = _mm256_unpackhi_ps(row[0], row[2]), wy = _mm256_unpackhi_ps(row[1], row[3]);
    _mm256_store_ps(v[0], _mm256_and_ps(live, _mm256_unpacklo_ps(xz, yw)));
    _mm256_store_ps(v[1], _mm256_and_ps(live, _mm256_unpackhi_ps(xz, yw)));
    _mm256_store_ps(v[2], _mm256_and_ps(live, _mm256_unpacklo_ps(zx, wy)));
}

/* Of zeros of either sign the first one is taken, as everywhere. */
HT_TARGET HT_INLINE __m128 fold_min(const __m256 a[4]) {
    const __m256 all = _mm256_min_ps(a[3], _mm256_min_ps(a[2], _mm256_min_ps(a[1], a[0])));
    return _mm_min_ps(_mm256_extractf128_ps(all, 1), _mm256_castps256_ps128(all));
}

HT_TARGET HT_INLINE __m128 fold_max(const __m256 a[4]) {
    const __m256 all = _mm256_max_ps(a[3], _mm256_max_ps(a[2], _mm256_max_ps(a[1], a[0])));
    return _mm_max_ps(_mm256_extractf128_ps(all, 1), _mm256_castps256_ps128(all));
}

HT_TARGET bool ht_wide_fill_avx2(const ht_source *source, uint32_t triangles, ht_wide_leaf *leaf,
                                 ht_box4 *box) {
    const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i live = _mm256_cmpgt_epi32(_mm256_set1_epi32((int)triangles), lanes);
    const __m256i prims = _mm256_load_si256((const __m256i *)(const void *)leaf->prim);
    const __m256i first = _mm256_broadcastd_epi32(_mm256_castsi256_si128(prims));
    HT_ALIGNED(32) uint32_t from[3][HT_LANES];
    __m256 lo[4], hi[4];
    if (source->vertex_count * source->stride > UINT32_MAX ||
        source->triangle_count > INT32_MAX / 3)
        return false;
    /* Idle lanes read the first triangle again, which adds nothing to the box. */
    if (!find_corners(source, _mm256_blendv_epi8(first, prims, live), from)) return false;
    for (uint32_t k = 0; k < 3; ++k) {
        __m256 rows[4];
        for (uint32_t i = 0; i < 4; ++i) {
            rows[i] = load_two(source->positions, &from[k][i]);
            lo[i] = k > 0 ? _mm256_min_ps(rows[i], lo[i]) : rows[i];
            hi[i] = k > 0 ? _mm256_max_ps(rows[i], hi[i]) : rows[i];
        }
        store_corner(rows, _mm256_castsi256_ps(live), leaf->v[k]);
    }
    box->lo = fold_min(lo);
    box->hi = fold_max(hi);
    return true;
}
#else
typedef int ht_no_avx2; /* a file is not empty */
#endif
