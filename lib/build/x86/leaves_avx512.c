/* leaves_avx512.c: leaves of triangles, two at a time; the bits are those of wide_nodes.c. */
#include "base/isa.h"

#ifdef HT_X86
#include "corners_avx512.h"

/* How far ahead to ask for the memory of leaves, and for the indices of prims. */
enum { LEAVES_AHEAD = 8, PRIMS_AHEAD = 32 };

/* The prims of a leaf, idle lanes HT_WIDE_NONE. */
HT_TARGET HT_INLINE __m256i load_prims(const uint32_t *order, const ht_wide_leaf_run *run) {
    const __mmask8 live = (__mmask8)_bzhi_u32(0xff, run->count);
    return _mm256_mask_loadu_epi32(_mm256_set1_epi32(-1), live, order + run->first);
}

/* False, and nothing done, if the last vertex is among their corners. */
HT_TARGET HT_INLINE bool write_two(const ht_source *source, const uint32_t *order,
                                   const ht_wide_leaf_run *runs, ht_wide_leaf *leaves) {
    HT_ALIGNED(64) uint32_t from[3][16];
    const __m256i low = load_prims(order, &runs[0]), high = load_prims(order, &runs[1]);
    const __m512i prims = _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
    const __mmask16 live = _mm512_cmpneq_epi32_mask(prims, _mm512_set1_epi32((int)HT_WIDE_NONE));
    const __m512i any = _mm512_broadcastd_epi32(_mm256_castsi256_si128(low));
    if (HT_UNLIKELY(!ht_find_corners(source, _mm512_mask_mov_epi32(any, live, prims), from)))
        return false;
    for (uint32_t k = 0; k < 3; ++k) {
        __m512 v[3];
        ht_load_corner(source->positions, from[k], v);
        for (uint32_t axis = 0; axis < 3; ++axis) {
            const __m512 row = _mm512_maskz_mov_ps(live, v[axis]);
            _mm256_store_ps(leaves[0].v[k][axis], _mm512_castps512_ps256(row));
            _mm256_store_ps(leaves[1].v[k][axis], _mm512_extractf32x8_ps(row, 1));
        }
    }
    _mm256_store_si256((__m256i *)(void *)leaves[0].prim, low);
    _mm256_store_si256((__m256i *)(void *)leaves[1].prim, high);
    return true;
}

HT_TARGET uint32_t ht_wide_write_avx512(const ht_source *from, const uint32_t *order, uint32_t end,
                                        const ht_wide_leaf_run *runs, uint32_t count,
                                        ht_wide_leaf *leaves) {
    const ht_source source = *from; /* which no store can change */
    uint32_t i = 0;
    if (source.object_count > 0 || !ht_source_is_narrow(&source)) return 0;
    for (; i + 2 <= count && write_two(&source, order, runs + i, leaves + i); i += 2) {
        ht_ask_for(leaves + i, LEAVES_AHEAD * sizeof *leaves, 2 * sizeof *leaves);
        for (uint32_t k = runs[i].first + PRIMS_AHEAD; k < runs[i].first + PRIMS_AHEAD + 16; ++k)
            if (k < end) ht_source_prefetch(&source, order[k]);
    }
    return i;
}
#else
typedef int ht_no_avx512; /* a file is not empty */
#endif
