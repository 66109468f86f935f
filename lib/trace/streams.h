/* streams.h: walks a wide tree with several rays at a time: included once per instruction set,
 * which defines HT_TARGET before, and after it what is declared here.
 *
 * One ray waits for memory and mispredicts its branches; four rays that take their steps in turn
 * keep the core busy meanwhile. Every lane does what trace/wide.c does, in the same order, so hits
 * are the same bits; the order in which rays and children are taken changes none of them. */
#ifndef HT_STREAMS_H
#define HT_STREAMS_H

#include "trace.h"

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

/* Pushes the children that the ray meets, the one that it is likely to meet first on top. The first
 * hit that comes will do for `any`: no order, and no distances. */
HT_TARGET HT_INLINE void step_node(const ht_wide_node *node, stream *s, const bool any);

/* A bit for every lane in use that the float signs do not reject: see triangle.h. */
HT_TARGET HT_INLINE uint32_t candidates(const ht_wide_leaf *leaf, const ht_shear *s);

/* As ht_expand_node and ht_expand_leaf. */
HT_TARGET HT_INLINE void expand_node(const htree *tree, uint32_t slot, ht_wide_node *node);
HT_TARGET HT_INLINE void expand_leaf(const htree *tree, uint32_t index, ht_wide_leaf *leaf);

/* ---- Leaves --------------------------------------------------------------------------------- */

/* A leaf, or a subtree of a lazy tree before ht_wide_resolve. */
HT_INLINE bool is_leaf(uint32_t child) {
    return child & HT_WIDE_LEAF;
}

HT_INLINE const ht_wide_leaf *leaf_of(const htree *tree, uint32_t child) {
    return &tree->leaves[child & ~HT_WIDE_LEAF];
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
    uint32_t mask = candidates(leaf, shear);
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

/* The step into a child of a compact tree: apart from the others, which it would slow down. */
HT_TARGET HT_NOINLINE static bool step_compact(const htree *tree, stream *s, uint32_t child,
                                               bool any) {
    HT_ALIGNED(64) ht_wide_node node;
    HT_ALIGNED(64) ht_wide_leaf leaf;
    if (is_leaf(child)) {
        expand_leaf(tree, child & ~HT_WIDE_LEAF, &leaf);
        return step_leaf(tree, &leaf, s, any);
    }
    expand_node(tree, child, &node);
    if (any)
        step_node(&node, s, true);
    else
        step_node(&node, s, false);
    return false;
}

/* Takes one step; true when the ray has its answer. */
HT_TARGET HT_INLINE bool step(const htree *tree, stream *s, const bool any) {
    /* Strictly beyond the best hit: at equal t a lower prim may still win. */
    do {
        if (s->top == 0) return true;
        --s->top;
    } while (!any && s->tnear[s->top] > s->hit.t);
    uint32_t child = s->child[s->top];
    if (HT_UNLIKELY(ht_is_compact(tree))) return step_compact(tree, s, child, any);
    if (is_leaf(child)) {
        child = ht_wide_resolve(tree, child);
        if (is_leaf(child)) return step_leaf(tree, leaf_of(tree, child), s, any);
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
