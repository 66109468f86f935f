/* morton_avx512.c: an errand by Morton order, sixteen prims at a time; the bits are those of
 * wide_morton.c, which says what is done. Corners are kept coordinate by coordinate, as leaves want
 * them, and the leaves of a node get their boxes together. */
#include "base/isa.h"

#ifdef HT_X86
#include "corners_avx512.h"

enum {
    WIDTH = 16,
    ROOM = HT_WIDE_CELL_PRIMS + 2 * WIDTH, /* vectors may reach beyond the last prim */
    KEYS = 64,
    FULL = HT_LANES * HT_LANES, /* prims of a node of leaves */
    LEAVES_AHEAD = 12,          /* to be in the cache when they are written */
    NODES_AHEAD = 2
};

typedef struct building {
    ht_source source;
    ht_wide_node *nodes;
    ht_wide_leaf *leaves;
    uint32_t next_node, next_leaf, count;
    HT_ALIGNED(64) uint32_t id[ROOM];
    HT_ALIGNED(64) float corner[3][3][ROOM]; /* of the vertex, of the axis */
    HT_ALIGNED(64) float centroid[3][ROOM];  /* doubled */
    HT_ALIGNED(64) uint32_t key[ROOM];       /* four times, in the four bytes */
    HT_ALIGNED(64) uint32_t order[ROOM];
} building;

/* ---- Prims ---------------------------------------------------------------------------------- */

HT_TARGET HT_INLINE void gather_ids(building *b, const uint32_t *order, const ht_wide_run *cells) {
    uint32_t n = 0;
    for (uint32_t i = 0; i < cells->count; ++i) {
        const uint32_t *ids = order + ht_cell_first(&cells->items[i]);
        const uint32_t count = ht_cell_prims(&cells->items[i]);
        for (uint32_t k = 0; k < count; k += WIDTH) {
            const uint32_t rest = count - k;
            const __mmask16 live = (__mmask16)_bzhi_u32(0xffff, rest < WIDTH ? rest : WIDTH);
            _mm512_storeu_si512(&b->id[n + k], _mm512_maskz_loadu_epi32(live, ids + k));
        }
        n += count;
    }
    b->count = n;
    _mm512_storeu_si512(&b->id[n], _mm512_set1_epi32((int)b->id[n - 1]));
}

/* Corners, centroids and the box of centroids; beyond the last prim that prim comes again. */
HT_TARGET HT_INLINE bool gather_corners(building *b, __m512 lo[3], __m512 hi[3]) {
    const ht_source source = b->source; /* which no store can change */
    for (uint32_t axis = 0; axis < 3; ++axis) {
        lo[axis] = _mm512_set1_ps(INFINITY);
        hi[axis] = _mm512_set1_ps(-INFINITY);
    }
    for (uint32_t i = 0; i < b->count; i += WIDTH) {
        HT_ALIGNED(64) uint32_t from[3][WIDTH];
        __m512 v[3][3];
        if (HT_UNLIKELY(!ht_find_corners(&source, _mm512_load_si512(b->id + i), from)))
            return false;
        for (uint32_t k = 0; k < 3; ++k) ht_load_corner(source.positions, from[k], v[k]);
        for (uint32_t axis = 0; axis < 3; ++axis) {
            const __m512 p = v[0][axis], q = v[1][axis], r = v[2][axis];
            const __m512 c = _mm512_add_ps(_mm512_min_ps(_mm512_min_ps(p, q), r),
                                           _mm512_max_ps(_mm512_max_ps(p, q), r));
            for (uint32_t k = 0; k < 3; ++k) _mm512_store_ps(&b->corner[k][axis][i], v[k][axis]);
            _mm512_store_ps(&b->centroid[axis][i], c);
            lo[axis] = _mm512_min_ps(lo[axis], c);
            hi[axis] = _mm512_max_ps(hi[axis], c);
        }
    }
    return true;
}

/* ---- The order ------------------------------------------------------------------------------ */

HT_TARGET HT_INLINE void find_keys(building *b, const __m512 lo[3], const __m512 hi[3]) {
    const __m512 half = _mm512_set1_ps(0.5f);
    __m512 middle[3], lower[3], upper[3];
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const __m512 l = _mm512_mul_ps(_mm512_set1_ps(_mm512_reduce_min_ps(lo[axis])), half);
        const __m512 h = _mm512_mul_ps(_mm512_set1_ps(_mm512_reduce_max_ps(hi[axis])), half);
        const __m512 quarter = _mm512_mul_ps(_mm512_sub_ps(h, l), half);
        middle[axis] = _mm512_add_ps(l, h);
        lower[axis] = _mm512_sub_ps(middle[axis], quarter);
        upper[axis] = _mm512_add_ps(middle[axis], quarter);
    }
    for (uint32_t i = 0; i < b->count; i += WIDTH) {
        __m512i key = _mm512_setzero_si512();
        for (uint32_t axis = 0; axis < 3; ++axis) {
            const __m512i bit = _mm512_set1_epi32(0x01010101 << axis);
            const __m512 c = _mm512_load_ps(&b->centroid[axis][i]);
            const __mmask16 high = _mm512_cmp_ps_mask(c, middle[axis], _CMP_GT_OQ);
            const __m512 quarter = _mm512_mask_blend_ps(high, lower[axis], upper[axis]);
            const __mmask16 above = _mm512_cmp_ps_mask(c, quarter, _CMP_GT_OQ);
            key = _mm512_mask_or_epi32(key, high, key, _mm512_slli_epi32(bit, 3));
            key = _mm512_mask_or_epi32(key, above, key, bit);
        }
        _mm512_store_si512(&b->key[i], key);
    }
}

/* At most 64 prims: the place of each is how many come before it. */
HT_TARGET HT_INLINE void sort_few(building *b) {
    __m128i part[4];
    for (uint32_t i = 0; i < 4; ++i)
        part[i] = _mm512_cvtepi32_epi8(_mm512_load_si512(&b->key[i * WIDTH]));
    __m512i key = _mm512_inserti32x4(_mm512_castsi128_si512(part[0]), part[1], 1);
    key = _mm512_inserti32x4(_mm512_inserti32x4(key, part[2], 2), part[3], 3);
    key = _mm512_mask_set1_epi8(key, ~_bzhi_u64(~UINT64_C(0), b->count), KEYS);
    for (uint32_t i = 0; i < b->count; ++i) {
        const __m512i mine = _mm512_set1_epi32((int)b->key[i]);
        const uint64_t less = _mm512_cmplt_epu8_mask(key, mine);
        const uint64_t same = _mm512_cmpeq_epu8_mask(key, mine);
        b->order[_mm_popcnt_u64(less | _bzhi_u64(same, i))] = i;
    }
}

static void sort_many(building *b) {
    uint16_t next[KEYS + 1] = {0};
    for (uint32_t i = 0; i < b->count; ++i) ++next[(b->key[i] & 63) + 1];
    for (uint32_t k = 0; k < KEYS; ++k) next[k + 1] = (uint16_t)(next[k + 1] + next[k]);
    for (uint32_t i = 0; i < b->count; ++i) b->order[next[b->key[i] & 63]++] = i;
}

/* ---- Leaves --------------------------------------------------------------------------------- */

/* Of zeros of either sign the first one is taken, as everywhere. */
HT_TARGET HT_INLINE __m512 first_min(__m512 a, __m512 b) {
    return _mm512_min_ps(b, a);
}

HT_TARGET HT_INLINE __m512 first_max(__m512 a, __m512 b) {
    return _mm512_max_ps(b, a);
}

/* Every other lane, from the first or the second on. */
HT_TARGET HT_INLINE __m512 even(__m512 a, __m512 b) {
    return _mm512_shuffle_ps(a, b, 0x88);
}

HT_TARGET HT_INLINE __m512 odd(__m512 a, __m512 b) {
    return _mm512_shuffle_ps(a, b, 0xdd);
}

/* The least of the lanes of each child; lanes 8 to 15 of vector i belong to child i + 4. */
HT_TARGET HT_INLINE __m256 fold_min(const __m512 v[4]) {
    const __m512 a = first_min(even(v[0], v[1]), odd(v[0], v[1]));
    const __m512 b = first_min(even(v[2], v[3]), odd(v[2], v[3]));
    const __m512 c = first_min(even(a, b), odd(a, b)), d = _mm512_shuffle_f32x4(c, c, 0xd8);
    return _mm256_min_ps(_mm512_extractf32x8_ps(d, 1), _mm512_castps512_ps256(d));
}

HT_TARGET HT_INLINE __m256 fold_max(const __m512 v[4]) {
    const __m512 a = first_max(even(v[0], v[1]), odd(v[0], v[1]));
    const __m512 b = first_max(even(v[2], v[3]), odd(v[2], v[3]));
    const __m512 c = first_max(even(a, b), odd(a, b)), d = _mm512_shuffle_f32x4(c, c, 0xd8);
    return _mm256_max_ps(_mm512_extractf32x8_ps(d, 1), _mm512_castps512_ps256(d));
}

/* Prims of leaf `i` of a node and of leaf i + 4, a half each; idle lanes hold the first of their
 * leaf. Returns the lanes that are not idle. */
HT_TARGET HT_INLINE __mmask16 find_prims(const building *b, uint32_t start, uint32_t count,
                                         uint32_t i, __m512i *which) {
    __m256i half[2];
    uint32_t live = 0;
    for (uint32_t k = 0; k < 2; ++k) {
        const uint32_t at = (i + 4 * k) * HT_LANES, from = at < count ? at : 0;
        const uint32_t *order = &b->order[start + from];
        const uint32_t busy = _bzhi_u32(0xff, at < count ? count - at : 0);
        half[k] = _mm256_mask_loadu_epi32(_mm256_set1_epi32((int)*order), (__mmask8)busy, order);
        live |= busy << 8 * k;
    }
    *which = _mm512_inserti64x4(_mm512_castsi256_si512(half[0]), half[1], 1);
    return (__mmask16)live;
}

/* Those of a row of at most 64, or of more. */
HT_TARGET HT_INLINE __m512 pick(const float *row, __m512i which, bool few) {
    if (!few) return _mm512_i32gather_ps(which, row, 4);
    const __mmask16 high = _mm512_test_epi32_mask(which, _mm512_set1_epi32(2 * WIDTH));
    const __m512 a =
        _mm512_permutex2var_ps(_mm512_load_ps(row), which, _mm512_load_ps(row + WIDTH));
    const __m512 b = _mm512_permutex2var_ps(_mm512_load_ps(row + 2 * WIDTH), which,
                                            _mm512_load_ps(row + 3 * WIDTH));
    return _mm512_mask_mov_ps(a, high, b);
}

/* Boxes by axis, and by the pair of leaves whose they are. */
typedef struct boxes {
    __m512 lo[3][4], hi[3][4];
} boxes;

/* Leaf i of a node, and leaf i + 4 if there is one. */
HT_TARGET HT_INLINE void write_leaves(const building *b, uint32_t start, uint32_t count, uint32_t i,
                                      boxes *all, bool few) {
    ht_wide_leaf *leaf = &b->leaves[b->next_leaf + i];
    const bool two = (i + 4) * HT_LANES < count;
    ht_ask_for(leaf, LEAVES_AHEAD * sizeof *leaf, sizeof *leaf);
    if (two) ht_ask_for(leaf, (4 + LEAVES_AHEAD) * sizeof *leaf, sizeof *leaf);
    const __mmask16 there = two ? 0xffff : 0x00ff;
    __m512i which;
    const __mmask16 live = find_prims(b, start, count, i, &which);
    const __m512i id = _mm512_mask_i32gather_epi32(_mm512_set1_epi32(-1), live, which, b->id, 4);
    _mm256_store_si256((__m256i *)(void *)leaf[0].prim, _mm512_castsi512_si256(id));
    if (two) _mm256_store_si256((__m256i *)(void *)leaf[4].prim, _mm512_extracti64x4_epi64(id, 1));
    for (uint32_t axis = 0; axis < 3; ++axis) {
        __m512 v[3];
        for (uint32_t k = 0; k < 3; ++k) {
            v[k] = pick(b->corner[k][axis], which, few);
            const __m512 stored = _mm512_maskz_mov_ps(live, v[k]);
            _mm256_store_ps(leaf[0].v[k][axis], _mm512_castps512_ps256(stored));
            if (two) _mm256_store_ps(leaf[4].v[k][axis], _mm512_extractf32x8_ps(stored, 1));
        }
        all->lo[axis][i] = _mm512_mask_mov_ps(_mm512_set1_ps(INFINITY), there,
                                              first_min(first_min(v[0], v[1]), v[2]));
        all->hi[axis][i] = _mm512_mask_mov_ps(_mm512_set1_ps(-INFINITY), there,
                                              first_max(first_max(v[0], v[1]), v[2]));
    }
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

/* Leaves, and the node that they would be children of. */
HT_TARGET HT_INLINE void add_leaves(building *b, uint32_t start, uint32_t count, bool few,
                                    ht_wide_node *node) {
    const uint32_t leaves = ht_wide_morton_leaves(count);
    const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i first = _mm256_set1_epi32((int)(HT_WIDE_LEAF | b->next_leaf));
    const __mmask8 live = (__mmask8)_bzhi_u32(0xff, leaves);
    boxes all;
    ht_ask_for(node, NODES_AHEAD * sizeof *node, sizeof *node);
    for (uint32_t i = 0; i < 4; ++i) {
        if (i < leaves) {
            write_leaves(b, start, count, i, &all, few);
            continue;
        }
        for (uint32_t axis = 0; axis < 3; ++axis) {
            all.lo[axis][i] = _mm512_set1_ps(INFINITY);
            all.hi[axis][i] = _mm512_set1_ps(-INFINITY);
        }
    }
    /* From register to node: boxes kept in between would be read back two at a time, which has to
     * wait until all stores so far have reached the cache. */
    for (uint32_t axis = 0; axis < 3; ++axis) {
        _mm256_store_ps(node->lo[axis], fold_min(all.lo[axis]));
        _mm256_store_ps(node->hi[axis], fold_max(all.hi[axis]));
    }
    _mm256_store_si256((__m256i *)(void *)node->child,
                       _mm256_mask_add_epi32(_mm256_set1_epi32(-1), live, first, lanes));
    _mm256_store_si256((__m256i *)(void *)node->unused, _mm256_setzero_si256());
    b->next_leaf += leaves;
}

/* The box of all children. */
static ht_box4 box_of(const ht_wide_node *node) {
    ht_box4 box = ht_box4_empty();
    for (uint32_t i = 0; i < HT_LANES; ++i)
        ht_box4_add(&box, ht_f4_set(node->lo[0][i], node->lo[1][i], node->lo[2][i], 0),
                    ht_f4_set(node->hi[0][i], node->hi[1][i], node->hi[2][i], 0));
    return box;
}

/* A node of nodes of leaves, the last of which may be a leaf. */
HT_TARGET HT_NOINLINE static void add_two_levels(building *b) {
    ht_box4 parts[HT_LANES];
    uint32_t child[HT_LANES], children = 0;
    ht_wide_node *node = &b->nodes[b->next_node++];
    HT_ALIGNED(64) ht_wide_node of_one_leaf;
    sort_many(b);
    for (uint32_t done = 0; done < b->count; done += FULL) {
        const uint32_t here = b->count - done < FULL ? b->count - done : FULL;
        const bool is_leaf = here <= HT_LANES;
        ht_wide_node *below = is_leaf ? &of_one_leaf : &b->nodes[b->next_node];
        child[children] = is_leaf ? HT_WIDE_LEAF | b->next_leaf : b->next_node++;
        add_leaves(b, done, here, false, below);
        parts[children++] = box_of(below);
    }
    ht_wide_fill_in_order(node, parts, child, children);
}

uint64_t ht_wide_morton_avx512_room(void) {
    return sizeof(building);
}

HT_TARGET bool ht_wide_run_morton_avx512(const htree *tree, const ht_source *source,
                                         const uint32_t *order, const ht_wide_errand *errand,
                                         void *room) {
    building *b = (building *)room;
    HT_ALIGNED(64) ht_wide_node of_one_leaf;
    __m512 lo[3], hi[3];
    if (source->object_count > 0 || !ht_source_is_narrow(source)) return false;
    b->source = *source;
    b->nodes = (ht_wide_node *)tree->nodes;
    b->leaves = tree->leaves;
    b->next_node = errand->node;
    b->next_leaf = errand->leaf;
    gather_ids(b, order, &errand->cells);
    if (!gather_corners(b, lo, hi)) return false;
    find_keys(b, lo, hi);
    if (b->count > FULL) {
        add_two_levels(b);
    } else {
        sort_few(b);
        add_leaves(b, 0, b->count, true,
                   b->count > HT_LANES ? &b->nodes[b->next_node] : &of_one_leaf);
    }
    return true;
}
#else
typedef int ht_no_avx512; /* a file is not empty */
#endif
