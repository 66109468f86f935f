/* wide_x86.h: walks a wide tree with 256-bit vectors, several rays at a time: included by one file
 * per instruction set, which defines HT_TARGET and compress().
 *
 * One ray waits for memory and mispredicts its branches; four rays that take their steps in turn
 * keep the core busy meanwhile. Every lane does what trace/wide.c does, in the same order, so hits
 * are the same bits; the order in which rays and children are taken changes none of them. */
#ifndef HT_WIDE_X86_H
#define HT_WIDE_X86_H

#include "trace/trace.h"

#include <immintrin.h>

enum { STREAMS = 4 };

/* A ray on its way. */
typedef struct stream {
    ht_ray r;
    htree_hit hit;
    const htree_ray *ray;
    uint64_t index;
    uint32_t order; /* the lane that is met first: a bit for each negative axis */
    uint32_t top;
    uint32_t child[HT_WIDE_STACK + HT_LANES]; /* whole vectors are stored */
    float tnear[HT_WIDE_STACK + HT_LANES];
} stream;

/* Move the lanes of the mask to the front. */
HT_TARGET HT_INLINE __m256 compress(__m256 from, uint32_t mask);
HT_TARGET HT_INLINE __m256i compress_words(__m256i from, uint32_t mask);

/* ---- Boxes ---------------------------------------------------------------------------------- */

HT_TARGET HT_INLINE void clip_axis(const float *planes, const ht_ray *r, int axis, __m256 *enter,
                                   __m256 *leave) {
    const uint32_t negative = r->negative[axis];
    const __m256 near = _mm256_load_ps(planes + 8 * axis + 24 * negative);
    const __m256 far = _mm256_load_ps(planes + 8 * axis + 24 * (1 - negative));
    const __m256 rdir = _mm256_broadcast_ss(&r->rdir[axis]);
    const __m256 from = _mm256_broadcast_ss(&r->entry[axis]);
    const __m256 to = _mm256_broadcast_ss(&r->exit[axis]);
    *enter = _mm256_max_ps(_mm256_mul_ps(_mm256_sub_ps(near, from), rdir), *enter);
    *leave = _mm256_min_ps(_mm256_mul_ps(_mm256_sub_ps(far, to), rdir), *leave);
}

/* Pushes the children that the ray meets, the one that it is likely to meet first on top. The first
 * hit that comes will do for `any`: no order, and no distances. */
HT_TARGET HT_INLINE void step_node(const ht_wide_node *node, stream *s, const bool any) {
    const float *planes = &node->lo[0][0];
    __m256 enter = _mm256_broadcast_ss(&s->r.tnear), leave = _mm256_broadcast_ss(&s->hit.t);
    clip_axis(planes, &s->r, 0, &enter, &leave);
    clip_axis(planes, &s->r, 1, &enter, &leave);
    clip_axis(planes, &s->r, 2, &enter, &leave);
    __m256i child = _mm256_load_si256((const __m256i *)(const void *)node->child);
    if (!any) {
        const __m256i last = _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0);
        const __m256i order = _mm256_xor_si256(last, _mm256_set1_epi32((int)s->order));
        enter = _mm256_permutevar8x32_ps(enter, order);
        leave = _mm256_permutevar8x32_ps(leave, order);
        child = _mm256_permutevar8x32_epi32(child, order);
    }
    const uint32_t mask = (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(enter, leave, _CMP_LE_OQ));
    if (!any) _mm256_storeu_ps(s->tnear + s->top, compress(enter, mask));
    _mm256_storeu_si256((__m256i *)(void *)(s->child + s->top), compress_words(child, mask));
    s->top += (uint32_t)_mm_popcnt_u32(mask);
}

/* ---- Triangles ------------------------------------------------------------------------------ */

typedef struct corner_lanes {
    __m256 x, y, z;
} corner_lanes;

HT_TARGET HT_INLINE corner_lanes shear_corner(const float (*v)[HT_LANES], const ht_shear *s) {
    corner_lanes c;
    c.z = _mm256_sub_ps(_mm256_load_ps(v[s->kz]), _mm256_broadcast_ss(&s->org[s->kz]));
    c.x =
        _mm256_sub_ps(_mm256_sub_ps(_mm256_load_ps(v[s->kx]), _mm256_broadcast_ss(&s->org[s->kx])),
                      _mm256_mul_ps(_mm256_broadcast_ss(&s->sx), c.z));
    c.y =
        _mm256_sub_ps(_mm256_sub_ps(_mm256_load_ps(v[s->ky]), _mm256_broadcast_ss(&s->org[s->ky])),
                      _mm256_mul_ps(_mm256_broadcast_ss(&s->sy), c.z));
    return c;
}

HT_TARGET HT_INLINE __m256 edge(corner_lanes a, corner_lanes b) {
    return _mm256_sub_ps(_mm256_mul_ps(a.x, b.y), _mm256_mul_ps(a.y, b.x));
}

/* One lane of a corner, as the verdict wants it. */
HT_TARGET HT_INLINE void take_lane(const ht_wide_leaf *leaf, uint32_t corner, uint32_t lane,
                                   const ht_shear *s, float p[3]) {
    p[2] = leaf->v[corner][s->kz][lane] - s->org[s->kz];
    p[0] = (leaf->v[corner][s->kx][lane] - s->org[s->kx]) - s->sx * p[2];
    p[1] = (leaf->v[corner][s->ky][lane] - s->org[s->ky]) - s->sy * p[2];
}

HT_NOINLINE static bool step_objects(const htree *tree, const ht_wide_leaf *leaf, stream *s,
                                     bool any) {
    for (uint32_t i = ht_wide_leaf_count(leaf); i > 0; --i) {
        const uint32_t prim = leaf->prim[i - 1];
        if (prim < tree->triangle_count) break;
        if (!ht_meets_object(tree, prim, &s->r, s->hit.t)) continue;
        if (ht_intersect_prim(tree, prim, s->ray, &s->r, &s->hit) && any) return true;
    }
    return false;
}

/* Tests the prims of a leaf; with `any`, true at the first hit. */
HT_TARGET HT_INLINE bool step_leaf(const htree *tree, const ht_wide_leaf *leaf, stream *s,
                                   const bool any) {
    const ht_shear *shear = &s->r.shear;
    const corner_lanes a = shear_corner(leaf->v[0], shear);
    const corner_lanes b = shear_corner(leaf->v[1], shear);
    const corner_lanes c = shear_corner(leaf->v[2], shear);
    const __m256 u = edge(c, b), v = edge(a, c), w = edge(b, a), zero = _mm256_setzero_ps();
    const __m256 least = _mm256_min_ps(_mm256_min_ps(u, v), w);
    const __m256 most = _mm256_max_ps(_mm256_max_ps(u, v), w);
    const __m256 outside = _mm256_and_ps(_mm256_cmp_ps(least, zero, _CMP_LT_OQ),
                                         _mm256_cmp_ps(most, zero, _CMP_GT_OQ));
    const __m256 idle = _mm256_load_ps((const float *)(const void *)leaf->prim);
    uint32_t mask = 255 & ~(uint32_t)_mm256_movemask_ps(_mm256_or_ps(outside, idle));
    for (; mask; mask &= mask - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(mask);
        float p[3][3];
        htree_hit found;
        for (uint32_t k = 0; k < 3; ++k) take_lane(leaf, k, i, shear, p[k]);
        if (!ht_triangle_verdict(shear, p[0], p[1], p[2], s->r.tmin, s->hit.t, &found)) continue;
        ht_keep_nearer(&s->hit, &found, leaf->prim[i]);
        if (any) return true;
    }
    return HT_UNLIKELY(tree->object_count) && step_objects(tree, leaf, s, any);
}

/* ---- Rays in turn --------------------------------------------------------------------------- */

/* Takes one step; true when the ray has its answer. */
HT_TARGET HT_INLINE bool step(const htree *tree, stream *s, const bool any) {
    /* Strictly beyond the best hit: at equal t a lower prim may still win. */
    do {
        if (s->top == 0) return true;
        --s->top;
    } while (!any && s->tnear[s->top] > s->hit.t);
    uint32_t child = s->child[s->top];
    if (child & HT_WIDE_LEAF) {
        child = ht_wide_resolve(tree, child);
        if (child & HT_WIDE_LEAF)
            return step_leaf(tree, &tree->leaves[child & ~HT_WIDE_LEAF], s, any);
    }
    step_node((const ht_wide_node *)tree->nodes + child, s, any);
    return false;
}

HT_INLINE void give_answer(const ht_block *block, const stream *s) {
    if (block->hits)
        block->hits[s->index] = s->hit;
    else
        block->occluded[s->index] = s->hit.prim != HTREE_NONE;
}

/* The next ray that has a way to go; the others are answered at once. False after the last. */
HT_TARGET HT_INLINE bool next_ray(const htree *tree, const ht_block *block, uint64_t *next,
                                  stream *s) {
    while (*next < block->count) {
        s->index = (*next)++;
        s->ray = &block->rays[s->index];
        const htree_hit miss = {s->ray->tmax, 0, 0, HTREE_NONE};
        s->hit = miss;
        if (ht_ray_init(&s->r, s->ray, &tree->bounds)) {
            s->order = s->r.negative[0] | s->r.negative[1] << 1 | s->r.negative[2] << 2;
            s->child[0] = 0;
            s->tnear[0] = s->r.tnear;
            s->top = 1;
            return true;
        }
        give_answer(block, s);
    }
    return false;
}

HT_TARGET HT_INLINE void walk_block(const htree *tree, const ht_block *block, const bool any) {
    stream streams[STREAMS];
    stream *active[STREAMS];
    uint32_t count = 0;
    uint64_t next = 0;
    while (count < STREAMS && next_ray(tree, block, &next, &streams[count])) {
        active[count] = &streams[count];
        ++count;
    }
    while (count > 0) {
        for (uint32_t i = 0; i < count; ++i) {
            if (!step(tree, active[i], any)) continue;
            give_answer(block, active[i]);
            if (!next_ray(tree, block, &next, active[i])) active[i--] = active[--count];
        }
    }
}

#define HT_DEFINE_BLOCK_WALKS(name)                                                                \
    HT_TARGET static void closest_block(const htree *tree, const ht_block *block) {                \
        walk_block(tree, block, false);                                                            \
    }                                                                                              \
    HT_TARGET static void any_block(const htree *tree, const ht_block *block) {                    \
        walk_block(tree, block, true);                                                             \
    }                                                                                              \
    const ht_block_walks name = {closest_block, any_block}

#endif
