/* scan_avx512.c: triangles into cells, four to a vector, sixteen at a time; the bits are those of
 * wide_scan.c. What makes up the time there is not arithmetic: neighbours mostly fall into one cell,
 * whose box then goes from store to load to store. So neighbours' boxes are joined first. */
#include "base/isa.h"

#ifdef HT_X86
#include "rows_avx512.h"

enum { WIDTH = HT_WIDE_AT_ONCE, ROWS = 4 /* triangles of a vector */, BLOCK = 128 };

HT_TARGET HT_INLINE __m512i lanes16(void) {
    return _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}

HT_TARGET HT_INLINE __m512 each(const float xyz[4]) {
    return _mm512_broadcast_f32x4(_mm_loadu_ps(xyz));
}

/* Bytes from the first position to the 48 corners of sixteen triangles. False if one of them is the
 * last vertex, after which no fourth float may be read, or none at all. */
HT_TARGET HT_INLINE bool find_corners(const ht_source *source, uint32_t i, uint32_t from[48]) {
    const __m512i stride = _mm512_set1_epi32((int)source->stride);
    const __m512i last = _mm512_set1_epi32((int)(source->vertex_count - 1));
    __mmask16 good = 0xffff;
    for (uint32_t k = 0; k < 3; ++k) {
        const uint64_t at = 3 * (uint64_t)i + k * WIDTH;
        const __m512i vertex = source->indices
                                   ? _mm512_loadu_si512(source->indices + at)
                                   : _mm512_add_epi32(_mm512_set1_epi32((int)at), lanes16());
        good &= _mm512_cmplt_epu32_mask(vertex, last);
        _mm512_storeu_si512(from + k * WIDTH, _mm512_mullo_epi32(vertex, stride));
    }
    return good == 0xffff;
}

/* ht_corners_have_area: all lanes of triangles that may have none. */
HT_TARGET HT_INLINE __mmask16 doubt_area(const ht_rows v[3]) {
    const ht_rows a = _mm512_sub_ps(v[1], v[0]), b = _mm512_sub_ps(v[2], v[0]);
    const ht_rows p = _mm512_mul_ps(a, _mm512_permute_ps(b, 0xc9));
    const ht_rows q = _mm512_mul_ps(_mm512_permute_ps(a, 0xc9), b);
    const ht_rows sum = _mm512_add_ps(_mm512_abs_ps(p), _mm512_abs_ps(q));
    const ht_rows error =
        _mm512_add_ps(_mm512_mul_ps(sum, _mm512_set1_ps(1e-6f)), _mm512_set1_ps(1e-30f));
    const uint32_t above =
        _mm512_cmp_ps_mask(_mm512_abs_ps(_mm512_sub_ps(p, q)), error, _CMP_GT_OQ);
    const uint32_t sure = ((above & 0x7777) + 0x7777) >> 3 & 0x1111;
    return (__mmask16)(0xffff - 15 * sure);
}

/* All lanes of triangles two of whose corners are the same. */
HT_TARGET HT_INLINE uint32_t same_corners(ht_rows a, ht_rows b) {
    const uint32_t equal = _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ);
    return 15 * (((equal & 0x7777) + 0x1111) >> 3 & 0x1111);
}

/* Those lanes for which the doubt is true. Most triangles without area have a corner twice. */
HT_TARGET static __mmask16 find_degenerate(const ht_rows v[3], __mmask16 doubt) {
    HT_ALIGNED(64) float row[3][ROWS][4];
    uint32_t found = same_corners(v[0], v[1]) | same_corners(v[1], v[2]) | same_corners(v[2], v[0]);
    const uint32_t left = doubt & ~found;
    if (left == 0) return (__mmask16)found;
    for (uint32_t k = 0; k < 3; ++k) _mm512_store_ps(row[k][0], v[k]);
    for (uint32_t i = 0; i < ROWS; ++i) {
        const ht_corners corners = {
            {_mm_load_ps(row[0][i]), _mm_load_ps(row[1][i]), _mm_load_ps(row[2][i])}};
        if ((left >> 4 * i & 1) && ht_corners_are_degenerate(corners)) found |= 15u << 4 * i;
    }
    return (__mmask16)found;
}

/* The cell of each triangle, in all of its lanes. */
HT_TARGET HT_INLINE __m512i find_cells(const ht_wide_grid *grid, ht_rows lo, ht_rows hi) {
    const ht_rows c = _mm512_sub_ps(_mm512_add_ps(lo, hi), each(grid->origin));
    const ht_rows at = _mm512_min_ps(each(grid->last), _mm512_mul_ps(c, each(grid->scale)));
    const __m512i step = _mm512_broadcast_i32x4(
        _mm_setr_epi32(1, (int)grid->cells[0], (int)(grid->cells[0] * grid->cells[1]), 0));
    const __m512i part = _mm512_mullo_epi32(_mm512_cvttps_epi32(at), step);
    const __m512i two = _mm512_add_epi32(part, _mm512_shuffle_epi32(part, _MM_PERM_BADC));
    return _mm512_add_epi32(two, _mm512_shuffle_epi32(two, _MM_PERM_CDAB));
}

/* Joins the boxes of neighbours in a cell; returns a bit for every triangle that those before it do
 * not speak for. Of zeros of either sign the first one is taken, as everywhere. */
HT_TARGET HT_INLINE uint32_t join_boxes(__m512i cell, ht_rows *lo, ht_rows *hi) {
    const __mmask16 next =
        _mm512_cmpeq_epi32_mask(cell, _mm512_shuffle_i32x4(cell, cell, 0x39)) & 0x0fff;
    const __mmask16 second =
        _mm512_cmpeq_epi32_mask(cell, _mm512_shuffle_i32x4(cell, cell, 0x4e)) & 0x00ff;
    *lo = _mm512_mask_min_ps(*lo, next, _mm512_shuffle_f32x4(*lo, *lo, 0x39), *lo);
    *hi = _mm512_mask_max_ps(*hi, next, _mm512_shuffle_f32x4(*hi, *hi, 0x39), *hi);
    *lo = _mm512_mask_min_ps(*lo, second, _mm512_shuffle_f32x4(*lo, *lo, 0x4e), *lo);
    *hi = _mm512_mask_max_ps(*hi, second, _mm512_shuffle_f32x4(*hi, *hi, 0x4e), *hi);
    return ~((uint32_t)next << 4) & 0x1111;
}

/* What some triangles add to their cells. */
typedef struct block {
    HT_ALIGNED(64) float lo[BLOCK][4], hi[BLOCK][4];
    uint32_t cell[BLOCK], count;         /* HTREE_NONE: a degenerate one */
    uint32_t head[BLOCK + WIDTH], heads; /* who speak for themselves and those up to the next */
    uint64_t degenerate;
} block;

/* Adds sixteen triangles; false if one of them is to be read in another way. */
HT_TARGET HT_INLINE bool look(const ht_wide_scanner *s, uint32_t first, block *b) {
    HT_ALIGNED(64) uint32_t from[3 * WIDTH];
    const uint32_t at = b->count;
    uint32_t heads = 0;
    if (HT_UNLIKELY(!find_corners(&s->source, first + at, from))) return false;
    for (uint32_t k = 0; k < WIDTH; k += ROWS) {
        ht_rows v[3];
        for (uint32_t corner = 0; corner < 3; ++corner)
            v[corner] = ht_load_rows(s->source.positions, from + 3 * k + corner, 3);
        const __mmask16 doubt = doubt_area(v);
        ht_rows lo = _mm512_min_ps(v[2], _mm512_min_ps(v[1], v[0]));
        ht_rows hi = _mm512_max_ps(v[2], _mm512_max_ps(v[1], v[0]));
        __m512i cell = find_cells(&s->grid, lo, hi);
        if (HT_UNLIKELY(doubt))
            cell = _mm512_mask_set1_epi32(cell, find_degenerate(v, doubt), (int)HTREE_NONE);
        heads |= _pext_u32(join_boxes(cell, &lo, &hi), 0x1111) << k;
        _mm512_store_ps(b->lo[at + k], lo);
        _mm512_store_ps(b->hi[at + k], hi);
        _mm_storeu_si128((__m128i *)(void *)&b->cell[at + k],
                         _mm512_castsi512_si128(_mm512_maskz_compress_epi32(0x1111, cell)));
    }
    const __m512i which = _mm512_add_epi32(_mm512_set1_epi32((int)at), lanes16());
    _mm512_storeu_si512(&b->head[b->heads], _mm512_maskz_compress_epi32((__mmask16)heads, which));
    b->heads += (uint32_t)_mm_popcnt_u32(heads);
    b->count += WIDTH;
    return true;
}

HT_TARGET HT_INLINE void add(const ht_wide_scanner *s, uint32_t first, block *b) {
    memcpy(&s->cell_of[first], b->cell, b->count * sizeof *b->cell);
    b->head[b->heads] = b->count;
    for (uint32_t k = 0; k < b->heads; ++k) {
        const uint32_t i = b->head[k], cell = b->cell[i], count = b->head[k + 1] - i;
        if (HT_UNLIKELY(cell == HTREE_NONE)) {
            b->degenerate += count;
            continue;
        }
        s->next[cell] += count;
        ht_box4_add(&s->boxes[cell], _mm_load_ps(b->lo[i]), _mm_load_ps(b->hi[i]));
    }
}

HT_TARGET uint32_t ht_wide_scan_avx512(const ht_wide_scanner *given, uint32_t i, uint32_t end,
                                       uint64_t *degenerate) {
    const ht_wide_scanner s = *given; /* which no store can change */
    block b;
    if (!ht_source_is_narrow(&s.source)) return i;
    b.degenerate = 0;
    do {
        b.count = b.heads = 0;
        while (b.count < BLOCK && end - i - b.count >= WIDTH && look(&s, i, &b)) continue;
        add(&s, i, &b);
        i += b.count;
    } while (b.count == BLOCK);
    *degenerate += b.degenerate;
    return i;
}
#else
typedef int ht_no_avx512; /* a file is not empty */
#endif
