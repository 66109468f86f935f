/* streams.h: walks a wide tree with several rays at a time: included once per instruction set, which
 * defines HT_TARGET before, and after it what is declared here.
 *
 * One ray waits for memory and mispredicts its branches. Here 32 are in flight, and each round takes
 * every one of them a step further: first those that are at a node, then those at a leaf, then those
 * that have candidates to judge, then those that are through. So a step is a short run of
 * instructions without a branch that data decide, and steps of several rays overlap in the core.
 * What each phase works on is known when the round begins, so leaves are asked for from memory
 * before their turn comes.
 *
 * Every lane does what trace/wide.c does, in the same order, so hits are the same bits; the order in
 * which rays and children are taken changes none of them. */
#ifndef HT_STREAMS_H
#define HT_STREAMS_H

#include "trace.h"

enum {
    STREAMS = 32,
    WAITING = 3072 /* children that may wait: a deep tree has fewer rays in flight */
};

#define HT_STREAM_LEAST 8.673617379884035e-19f /* 2^-60 */
#define HT_STREAM_FAR   1.099511627776e12f     /* 2^40 */

/* A ray on its way. */
typedef struct __attribute__((aligned(64))) stream {
    ht_ray r;
    htree_hit hit;
    uint32_t near[3], far[3]; /* floats from a node to the planes that are met first, and last */
    uint32_t order;           /* the lane that is met first: a bit for each negative axis */
    uint32_t bottom, top;     /* its stack: from the mark of the end to where it is */
    float main, first, slack; /* dz, tmin dz, and what that may be off by before it is scaled */
    const htree_ray *ray;
} stream;

/* The rays in flight. Sets of them are words, a bit for each. */
typedef struct streams {
    stream ray[STREAMS];
    uint32_t next[STREAMS];  /* where each is: child[top]; HT_WIDE_NONE: it has its answer */
    uint32_t lanes[STREAMS]; /* of the leaf that it is at: the candidates */
    uint32_t child[WAITING];
    float tnear[WAITING];
} streams;

/* Writes the children that the ray meets to child, the one that it is likely to meet first last, and
 * their distances to tnear; returns how many. Whole vectors are written. The first hit that comes
 * will do for `any`: no order, and no distances. */
HT_TARGET HT_INLINE uint32_t step_node(const ht_wide_node *node, const stream *s, uint32_t *child,
                                       float *tnear, const bool any);

/* A bit for every lane in use that the float signs do not reject: see triangle.h. Others that the
 * verdict would reject may be left out. */
HT_TARGET HT_INLINE uint32_t candidates(const ht_wide_leaf *leaf, const stream *s);

/* As ht_expand_node and ht_expand_leaf. */
HT_TARGET HT_INLINE void expand_node(const htree *tree, uint32_t slot, ht_wide_node *node);
HT_TARGET HT_INLINE void expand_leaf(const htree *tree, uint32_t index, ht_wide_leaf *leaf);

/* Returns the rays that are not at a node; those that have their answer go to *ended too. */
HT_TARGET HT_INLINE uint32_t sort_out(const uint32_t next[STREAMS], uint32_t *ended);

/* ---- Leaves --------------------------------------------------------------------------------- */

/* The leaf to read: in the tree, or expanded into *room. */
HT_TARGET HT_INLINE const ht_wide_leaf *leaf_of(const htree *tree, uint32_t child,
                                                ht_wide_leaf *room, const bool compact) {
    if (!compact) return &tree->leaves[child & ~HT_WIDE_LEAF];
    expand_leaf(tree, child & ~HT_WIDE_LEAF, room);
    return room;
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

/* After a hit: with `any` nothing waits any more, else what is not strictly beyond the best hit: at
 * equal t a lower prim may still win. The ray stays where it is. */
HT_INLINE void leave_behind(streams *all, stream *s, const bool any) {
    uint32_t kept = s->bottom + 1;
    for (uint32_t i = kept; !any && i < s->top; ++i) {
        all->child[kept] = all->child[i];
        all->tnear[kept] = all->tnear[i];
        kept += all->tnear[kept] <= s->hit.t;
    }
    all->child[kept] = all->child[s->top];
    s->top = kept;
}

/* ---- A step of each ray of a set ------------------------------------------------------------- */

HT_INLINE uint32_t first_of(uint32_t set) {
    return (uint32_t)__builtin_ctz(set);
}

HT_TARGET HT_INLINE void visit_nodes(const htree *tree, streams *all, uint32_t set, const bool any,
                                     const bool compact) {
    HT_ALIGNED(64) ht_wide_node room;
    for (; set; set &= set - 1) {
        const uint32_t i = first_of(set);
        const ht_wide_node *node = (const ht_wide_node *)tree->nodes + all->next[i];
        stream *s = &all->ray[i];
        uint32_t top = s->top;
        if (compact) {
            expand_node(tree, all->next[i], &room);
            node = &room;
        }
        top += step_node(node, s, all->child + top, all->tnear + top, any) - 1;
        all->next[i] = all->child[top];
        s->top = top;
    }
}

HT_INLINE void fetch_leaves(const htree *tree, const streams *all, uint32_t set) {
    for (; set; set &= set - 1) {
        const uint32_t index = all->next[first_of(set)] & ~HT_WIDE_LEAF;
        const char *leaf = (const char *)tree->leaves + index * sizeof(ht_wide_leaf);
        for (uint32_t k = 0; k < sizeof(ht_wide_leaf); k += 64) HT_PREFETCH(leaf + k);
    }
}

/* Returns the rays that have candidates: these stay where they are. */
HT_TARGET HT_INLINE uint32_t visit_leaves(const htree *tree, streams *all, uint32_t set,
                                          const bool any, const bool compact) {
    HT_ALIGNED(64) ht_wide_leaf room;
    uint32_t judged = 0;
    for (; set; set &= set - 1) {
        const uint32_t i = first_of(set), child = all->next[i];
        stream *s = &all->ray[i];
        if (HT_UNLIKELY(ht_wide_is_pending(child))) {
            all->next[i] = all->child[s->top] = ht_wide_resolve(tree, child);
            continue;
        }
        const ht_wide_leaf *leaf = leaf_of(tree, child, &room, compact);
        uint32_t lanes = candidates(leaf, s);
        if (HT_UNLIKELY(tree->object_count) && step_objects(tree, leaf, s, any)) {
            if (any) lanes = 0;
            leave_behind(all, s, any);
        }
        all->lanes[i] = lanes;
        judged |= (uint32_t)(lanes != 0) << i;
        s->top -= lanes == 0;
        all->next[i] = all->child[s->top];
    }
    return judged;
}

HT_TARGET HT_INLINE void judge(const htree *tree, streams *all, uint32_t set, const bool any,
                               const bool compact) {
    HT_ALIGNED(64) ht_wide_leaf room;
    for (; set; set &= set - 1) {
        const uint32_t i = first_of(set);
        stream *s = &all->ray[i];
        const ht_wide_leaf *leaf = leaf_of(tree, all->next[i], &room, compact);
        bool met = false;
        for (uint32_t lanes = all->lanes[i]; lanes && !(any && met); lanes &= lanes - 1) {
            const uint32_t lane = first_of(lanes);
            float p[3][3];
            htree_hit found;
            for (uint32_t k = 0; k < 3; ++k) take_lane(leaf, k, lane, &s->r.shear, p[k]);
            if (ht_triangle_verdict(&s->r.shear, p[0], p[1], p[2], s->r.tmin, s->hit.t, &found))
                met = ht_keep_nearer(&s->hit, &found, leaf->prim[lane]);
        }
        if (met) leave_behind(all, s, any);
        all->next[i] = all->child[--s->top];
    }
}

/* ---- From ray to answer --------------------------------------------------------------------- */

HT_INLINE void give_answer(const ht_block *block, const stream *s) {
    const uint64_t index = (uint64_t)(s->ray - block->rays);
    if (block->hits)
        block->hits[index] = s->hit;
    else
        block->occluded[index] = s->hit.prim != HTREE_NONE;
}

/* Puts a ray that is ready at the root. */
HT_INLINE void set_out(stream *s) {
    s->order = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        s->order |= s->r.negative[axis] << axis;
        s->near[axis] = 8 * axis + 24 * s->r.negative[axis];
        s->far[axis] = 16 * axis + 24 - s->near[axis];
    }
    s->main = (float)s->r.shear.dz;
    s->first = s->r.tmin * s->main;
    s->slack = s->r.reach <= HT_STREAM_FAR ? ht_magnitude(s->first) + HT_STREAM_LEAST : INFINITY;
    s->top = s->bottom + 1;
}

/* The next ray that has a way to go; the others are answered at once. False after the last. */
HT_TARGET HT_INLINE bool next_ray(const htree *tree, const ht_block *block, uint64_t *next,
                                  stream *s) {
    while (*next < block->count) {
        s->ray = &block->rays[(*next)++];
        const htree_hit miss = {s->ray->tmax, 0, 0, HTREE_NONE};
        s->hit = miss;
        if (ht_ray_init(&s->r, s->ray, &tree->bounds)) {
            set_out(s);
            return true;
        }
        give_answer(block, s);
    }
    return false;
}

/* Gives each ray its part of the stacks, and returns how many there are. */
HT_INLINE uint32_t share_stacks(const htree *tree, streams *all) {
    const uint32_t part = tree->stack + 2 + HT_LANES;
    uint32_t count = 0;
    for (; count < STREAMS && (count + 1) * part <= WAITING; ++count) {
        all->ray[count].bottom = count * part;
        all->child[count * part] = HT_WIDE_NONE;
    }
    return count;
}

/* Answers the rays of a set and puts new ones in their places; returns those that stay empty. */
HT_TARGET HT_INLINE uint32_t answer(const htree *tree, const ht_block *block, uint64_t *next,
                                    streams *all, uint32_t set) {
    uint32_t empty = 0;
    for (; set; set &= set - 1) {
        const uint32_t i = first_of(set);
        give_answer(block, &all->ray[i]);
        if (next_ray(tree, block, next, &all->ray[i]))
            all->next[i] = 0;
        else
            empty |= (uint32_t)1 << i;
    }
    return empty;
}

HT_TARGET HT_INLINE void walk_block(const htree *tree, const ht_block *block, const bool any,
                                    const bool compact) {
    streams all;
    const uint32_t count = share_stacks(tree, &all);
    uint64_t next = 0;
    uint32_t flying = 0, judged = 0;
    for (uint32_t i = 0; i < STREAMS; ++i) {
        const bool used = i < count && next_ray(tree, block, &next, &all.ray[i]);
        all.next[i] = used ? 0 : HT_WIDE_NONE;
        flying |= (uint32_t)used << i;
    }
    while (flying) {
        uint32_t ended;
        const uint32_t elsewhere = sort_out(all.next, &ended);
        const uint32_t leaves = elsewhere & ~ended & ~judged, verdicts = judged;
        if (!compact) fetch_leaves(tree, &all, leaves);
        visit_nodes(tree, &all, ~elsewhere, any, compact);
        judged = visit_leaves(tree, &all, leaves, any, compact);
        judge(tree, &all, verdicts, any, compact);
        flying &= ~answer(tree, block, &next, &all, ended & flying);
    }
}

#define HT_DEFINE_BLOCK_WALKS(name)                                                                \
    HT_TARGET static HT_NOINLINE void closest_compact(const htree *tree, const ht_block *block) {  \
        walk_block(tree, block, false, true);                                                      \
    }                                                                                              \
    HT_TARGET static HT_NOINLINE void any_compact(const htree *tree, const ht_block *block) {      \
        walk_block(tree, block, true, true);                                                       \
    }                                                                                              \
    HT_TARGET static void closest_block(const htree *tree, const ht_block *block) {                \
        if (ht_is_compact(tree))                                                                   \
            closest_compact(tree, block);                                                          \
        else                                                                                       \
            walk_block(tree, block, false, false);                                                 \
    }                                                                                              \
    HT_TARGET static void any_block(const htree *tree, const ht_block *block) {                    \
        if (ht_is_compact(tree))                                                                   \
            any_compact(tree, block);                                                              \
        else                                                                                       \
            walk_block(tree, block, true, false);                                                  \
    }                                                                                              \
    const ht_block_walks name = {closest_block, any_block}

#endif
