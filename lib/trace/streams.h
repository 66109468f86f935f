/* streams.h: walks a wide tree with several rays at a time: included once per instruction set, which
 * defines HT_TARGET before, and after it what is declared here.
 *
 * One ray waits for memory and mispredicts its branches. Here 64 are in flight, and each round takes
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
    FEW = 2,       /* rays that are not worth rounds */
    STREAMS = 64,  /* bits of a ray_set */
    WAITING = 3072 /* children that may wait; twice as many for `any`, which asks for no distance */
};

#define HT_STREAM_LEAST 8.673617379884035e-19f /* 2^-60 */
#define HT_STREAM_FAR   1.099511627776e12f     /* 2^40 */

/* What steps read of a ray: 32 words, so that vectors can write eight rays at a time. */
typedef struct HT_ALIGNED(64) ready {
    float rdir[3], enter[3], tnear, tmax; /* enter, leave: what step_node makes distances with */
    float leave[3], tmin;
    float first, slack;       /* tmin dz, and what that may be off by before it is scaled */
    float dz, sx, sy, org[3]; /* as in ht_shear; org by kx, ky, kz */
    uint32_t row[3];          /* floats from a corner's lanes to those of kx, ky, kz */
    uint32_t order;           /* the lane that is met first: a bit for each negative axis */
    uint32_t near[3], far[3]; /* floats from a node to the planes that are met first, and last */
    uint32_t unused[2];
} ready;

/* A ray on its way. */
typedef struct HT_ALIGNED(64) stream {
    ready r;
    htree_hit hit;
    uint32_t bottom, top; /* its stack: from the mark of the end to where it is */
    uint64_t index;       /* in the block */
} stream;

/* Rays that are ready to go. */
typedef struct supply {
    ready ray[HT_LANES];
    uint32_t left;        /* a bit for each */
    uint64_t first, next; /* in the block: the ray of bit 0, and the first that is not ready */
} supply;

/* Some of the rays in flight: a bit for each. */
typedef uint64_t ray_set;

/* The rays in flight. */
typedef struct streams {
    stream ray[STREAMS];
    uint32_t next[STREAMS];  /* where each is: child[top]; HT_WIDE_NONE: it has its answer */
    uint32_t lanes[STREAMS]; /* of the leaf that it is at: the candidates */
    union {
        uint32_t child[2 * WAITING];
        struct {
            uint32_t child[WAITING];
            float tnear[WAITING];
        } closest;
    } on; /* the stacks of all */
} streams;

/* Writes the children that the ray meets to child, the one that it is likely to meet first last, and
 * their distances to tnear; returns how many. Whole vectors are written. The first hit that comes
 * will do for `any`: no order, and no distances. */
HT_TARGET HT_INLINE uint32_t step_node(const ht_wide_node *node, const stream *s, uint32_t *child,
                                       float *tnear, const bool any);

/* Moves the children that are not beyond t to the front; returns how many. Whole vectors are written. */
HT_TARGET HT_INLINE uint32_t keep_near(uint32_t *child, float *tnear, uint32_t count, float t);

/* A bit for every lane in use that the float signs do not reject: see triangle.h. Others that the
 * verdict would reject may be left out. */
HT_TARGET HT_INLINE uint32_t candidates(const ht_wide_leaf *leaf, const ready *r);

/* As ht_expand_node and ht_expand_leaf. */
HT_TARGET HT_INLINE void expand_node(const htree *tree, uint32_t slot, ht_wide_node *node);
HT_TARGET HT_INLINE void expand_leaf(const htree *tree, uint32_t index, ht_wide_leaf *leaf);

/* Makes eight rays ready; returns those that have a way to go, by ht_ray_init. Those whose numbers are
 * too large to be made ready go to *apart. */
HT_TARGET HT_INLINE uint32_t make_ready(const htree_box *bounds, const htree_ray *rays, ready *out,
                                        uint32_t *apart);

/* Returns the rays that are not at a node; those that have their answer go to *ended too. */
HT_TARGET HT_INLINE ray_set sort_out(const uint32_t next[STREAMS], ray_set *ended);

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
                                   const ready *r, float p[3]) {
    const float *const v = &leaf->v[corner][0][lane];
    p[2] = v[r->row[2]] - r->org[2];
    p[0] = (v[r->row[0]] - r->org[0]) - r->sx * p[2];
    p[1] = (v[r->row[1]] - r->org[1]) - r->sy * p[2];
}

HT_NOINLINE static bool step_objects(const htree *tree, const ht_wide_leaf *leaf,
                                     const htree_ray *ray, htree_hit *hit, bool any) {
    ht_ray r;
    if (!ht_ray_init(&r, ray, &tree->bounds)) return false;
    for (uint32_t i = ht_wide_leaf_count(leaf); i > 0; --i) {
        const uint32_t prim = leaf->prim[i - 1];
        if (prim < tree->triangle_count) break;
        if (!ht_meets_object(tree, prim, &r, hit->t)) continue;
        if (ht_intersect_prim(tree, prim, ray, &r, hit) && any) return true;
    }
    return false;
}

/* After a hit: with `any` nothing waits any more, else what is not strictly beyond the best hit: at
 * equal t a lower prim may still win. The ray stays where it is. */
HT_TARGET HT_INLINE void leave_behind(streams *all, stream *s, const bool any) {
    const uint32_t first = s->bottom + 1, here = all->on.child[s->top];
    uint32_t *child = all->on.child + first, kept = 0;
    if (!any) kept = keep_near(child, all->on.closest.tnear + first, s->top - first, s->hit.t);
    child[kept] = here;
    s->top = first + kept;
}

/* ---- A step of each ray of a set ------------------------------------------------------------- */

HT_INLINE uint32_t first_of(ray_set set) {
    return (uint32_t)__builtin_ctzll(set);
}

HT_TARGET HT_INLINE void visit_nodes(const htree *tree, streams *all, ray_set set, const bool any,
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
        top +=
            step_node(node, s, all->on.child + top, all->on.closest.tnear + (any ? 0 : top), any) -
            1;
        all->next[i] = all->on.child[top];
        s->top = top;
    }
}

HT_INLINE void fetch_leaves(const htree *tree, const streams *all, ray_set set) {
    for (; set; set &= set - 1) {
        const uint32_t index = all->next[first_of(set)] & ~HT_WIDE_LEAF;
        const char *leaf = (const char *)tree->leaves + index * sizeof(ht_wide_leaf);
        for (uint32_t k = 0; k < sizeof(ht_wide_leaf); k += 64) HT_PREFETCH(leaf + k);
    }
}

/* Returns the rays that have candidates: these stay where they are. */
HT_TARGET HT_INLINE ray_set visit_leaves(const htree *tree, const ht_block *block, streams *all,
                                         ray_set set, const bool any, const bool compact) {
    HT_ALIGNED(64) ht_wide_leaf room;
    ray_set judged = 0;
    for (; set; set &= set - 1) {
        const uint32_t i = first_of(set), child = all->next[i];
        stream *s = &all->ray[i];
        if (HT_UNLIKELY(ht_wide_is_pending(child))) {
            all->next[i] = all->on.child[s->top] = ht_wide_resolve(tree, child);
            continue;
        }
        const ht_wide_leaf *leaf = leaf_of(tree, child, &room, compact);
        uint32_t lanes = candidates(leaf, &s->r);
        if (HT_UNLIKELY(tree->object_count) &&
            step_objects(tree, leaf, block->rays + s->index, &s->hit, any)) {
            if (any) lanes = 0;
            leave_behind(all, s, any);
        }
        all->lanes[i] = lanes;
        judged |= (ray_set)(lanes != 0) << i;
        s->top -= lanes == 0;
        all->next[i] = all->on.child[s->top];
    }
    return judged;
}

HT_TARGET HT_INLINE void judge(const htree *tree, streams *all, ray_set set, const bool any,
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
            for (uint32_t k = 0; k < 3; ++k) take_lane(leaf, k, lane, &s->r, p[k]);
            if (ht_triangle_verdict((double)s->r.dz, p[0], p[1], p[2], s->r.tmin, s->hit.t, &found))
                met = ht_keep_nearer(&s->hit, &found, leaf->prim[lane]);
        }
        if (met) leave_behind(all, s, any);
        all->next[i] = all->on.child[--s->top];
    }
}

/* ---- From ray to answer --------------------------------------------------------------------- */

HT_INLINE void give_answer(const ht_block *block, uint64_t index, const htree_hit *hit) {
    if (block->hits)
        block->hits[index] = *hit;
    else
        block->occluded[index] = hit->prim != HTREE_NONE;
}

/* Answers a ray that has no way to go, or whose numbers are too large for streams. */
static HT_NOINLINE void answer_apart(const htree *tree, const ht_block *block, uint64_t index) {
    const htree_ray *ray = &block->rays[index];
    htree_hit hit = {ray->tmax, 0, 0, HTREE_NONE};
    ht_ray r;
    if (ht_ray_init(&r, ray, &tree->bounds))
        (block->hits ? ht_wide_walks.closest : ht_wide_walks.any)(tree, ray, &r, &hit, NULL);
    give_answer(block, index, &hit);
}

/* Makes the next rays of the block ready; those without a way to go are answered at once. */
HT_TARGET static HT_NOINLINE void refill(const htree *tree, const ht_block *block, supply *from) {
    htree_ray last[HT_LANES];
    const htree_ray *rays = &block->rays[from->next];
    uint32_t all = (1u << HT_LANES) - 1, apart;
    if (block->count - from->next < HT_LANES) {
        const uint64_t count = block->count - from->next;
        memset(last, 0, sizeof last);
        memcpy(last, rays, count * sizeof *last);
        rays = last;
        all = (1u << count) - 1;
    }
    from->left = make_ready(&tree->bounds, rays, from->ray, &apart) & all;
    for (ray_set set = all & ~from->left; set; set &= set - 1) {
        const uint32_t i = first_of(set);
        const htree_hit miss = {rays[i].tmax, 0, 0, HTREE_NONE};
        if (HT_UNLIKELY(apart >> i & 1))
            answer_apart(tree, block, from->next + i);
        else
            give_answer(block, from->next + i, &miss);
    }
    from->first = from->next;
    from->next += HT_LANES;
}

/* The next ray that has a way to go. False after the last. */
HT_TARGET HT_INLINE bool next_ray(const htree *tree, const ht_block *block, supply *from,
                                  stream *s) {
    while (!from->left) {
        if (from->next >= block->count) return false;
        refill(tree, block, from);
    }
    const uint32_t i = first_of(from->left);
    const htree_hit miss = {from->ray[i].tmax, 0, 0, HTREE_NONE};
    from->left &= from->left - 1;
    s->r = from->ray[i];
    s->hit = miss;
    s->index = from->first + i;
    s->top = s->bottom + 1;
    return true;
}

/* Gives at most `most` rays their parts of the stacks, and returns how many there are: a deep tree has
 * fewer rays in flight, and for a ray alone to touch all parts takes as long as its first steps. */
HT_INLINE uint32_t share_stacks(const htree *tree, streams *all, uint64_t most, const bool any) {
    const uint32_t part = tree->stack + 2 + HT_LANES, room = any ? 2 * WAITING : WAITING;
    uint32_t count = 0;
    for (; count < STREAMS && count < most && (count + 1) * part <= room; ++count) {
        all->ray[count].bottom = count * part;
        all->on.child[count * part] = HT_WIDE_NONE;
    }
    return count;
}

/* Answers the rays of a set and puts new ones in their places; returns those that stay empty. */
HT_TARGET HT_INLINE ray_set answer(const htree *tree, const ht_block *block, supply *from,
                                   streams *all, ray_set set) {
    ray_set empty = 0;
    for (; set; set &= set - 1) {
        const uint32_t i = first_of(set);
        give_answer(block, all->ray[i].index, &all->ray[i].hit);
        if (next_ray(tree, block, from, &all->ray[i]))
            all->next[i] = 0;
        else
            empty |= (ray_set)1 << i;
    }
    return empty;
}

/* One ray after the other: with few in flight there is nothing to overlap, and rounds cost more than
 * they bring. */
HT_TARGET HT_INLINE void walk_few(const htree *tree, const ht_block *block, supply *from,
                                  streams *all, const bool any, const bool compact) {
    while (next_ray(tree, block, from, &all->ray[0])) {
        for (all->next[0] = 0; all->next[0] != HT_WIDE_NONE;) {
            if (!(all->next[0] & HT_WIDE_LEAF))
                visit_nodes(tree, all, 1, any, compact);
            else if (visit_leaves(tree, block, all, 1, any, compact))
                judge(tree, all, 1, any, compact);
        }
        give_answer(block, all->ray[0].index, &all->ray[0].hit);
    }
}

HT_TARGET HT_INLINE void walk_many(const htree *tree, const ht_block *block, supply *from,
                                   streams *all, uint32_t count, const bool any,
                                   const bool compact) {
    ray_set flying = 0, judged = 0;
    memset(all->next, 0xff, sizeof all->next); /* HT_WIDE_NONE */
    for (uint32_t i = 0; i < count && next_ray(tree, block, from, &all->ray[i]); ++i) {
        all->next[i] = 0;
        flying |= (ray_set)1 << i;
    }
    while (flying) {
        ray_set ended;
        const ray_set elsewhere = sort_out(all->next, &ended);
        const ray_set leaves = elsewhere & ~ended & ~judged, verdicts = judged;
        if (!compact) fetch_leaves(tree, all, leaves);
        visit_nodes(tree, all, ~elsewhere, any, compact);
        judged = visit_leaves(tree, block, all, leaves, any, compact);
        judge(tree, all, verdicts, any, compact);
        flying &= ~answer(tree, block, from, all, ended & flying);
    }
}

HT_TARGET HT_INLINE void walk_block(const htree *tree, const ht_block *block, const bool any,
                                    const bool compact) {
    streams all;
    supply from;
    const uint32_t count = share_stacks(tree, &all, block->count, any);
    from.left = 0;
    from.next = 0;
    if (count <= FEW)
        walk_few(tree, block, &from, &all, any, compact);
    else
        walk_many(tree, block, &from, &all, count, any, compact);
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
