/* packet_tile.h: a tile of rays from the caller's bytes into packets, and the answers back. Groups
 * that go together walk together; rays that agree with no neighbours walk as streams. */
#ifndef HT_PACKET_TILE_H
#define HT_PACKET_TILE_H

#include "packet_walk.h"

/* A group's place in its tile. */
typedef struct place {
    uint64_t first;         /* its first ray among those of the tile */
    uint32_t columns, rows; /* fewer than a group has at the edges of the tile */
} place;

/* What a walk of packets makes of a tile. */
typedef struct plan {
    packet *p; /* while it walks */
    place places[LANES];
    heading headings[LANES];
    spans all;
    uint32_t count;     /* groups */
    uint32_t ready;     /* groups that want to walk */
    uint32_t scattered; /* groups whose rays do not go together */
    bool gave_up;
} plan;

/* From a ray of a group to the one below it. */
HT_INLINE uint64_t stride_of(const ht_tile *tile) {
    return tile->cell ? (uint64_t)1 << tile->cell : tile->row;
}

HT_INLINE bool is_whole(const place *at) {
    return at->columns == COLUMNS && at->rows == ROWS;
}

/* A group at the edge of a tile: its first ray takes the place of those that it lacks. */
HT_TARGET HT_INLINE uint32_t fill_some(group *g, const ht_tile *tile, const place *at) {
    const htree_ray *rays = tile->rays + at->first;
    const uint64_t stride = stride_of(tile);
    htree_ray some[LANES];
    for (uint32_t k = 0; k < ROWS; ++k) {
        for (uint32_t j = 0; j < COLUMNS; ++j) {
            const bool in = k < at->rows && j < at->columns;
            some[k * COLUMNS + j] = in ? rays[k * stride + j] : *rays;
        }
    }
    return fill_group(g, some, COLUMNS);
}

/* Finds `across` groups of the tile beside each other, from column x and row y on, and as many below
 * each other as there is room for: LANES in all, or fewer at the edges of the tile. */
HT_INLINE void find_places(const ht_tile *tile, uint32_t x, uint32_t y, uint32_t across, plan *s) {
    s->count = 0;
    for (uint32_t i = 0; i < LANES; ++i) {
        const uint32_t left = x + i % across * COLUMNS, top = y + i / across * ROWS;
        if (left >= tile->width || top >= tile->height) continue;
        const place at = {ht_ray_at(tile->row, tile->cell, left, top),
                          tile->width - left < COLUMNS ? tile->width - left : COLUMNS,
                          tile->height - top < ROWS ? tile->height - top : ROWS};
        s->places[s->count++] = at;
    }
}

/* Fills the groups and makes their beams. */
HT_TARGET HT_INLINE void take_groups(const htree *tree, const ht_tile *tile, plan *s) {
    const uint64_t stride = stride_of(tile);
    uint32_t wanting = 0;
    for (uint32_t i = 0; i < s->count; ++i) {
        const place *at = &s->places[i];
        group *g = &s->p->groups[i];
        const uint32_t mask =
            is_whole(at) ? fill_group(g, tile->rays + at->first, stride) : fill_some(g, tile, at);
        wanting |= (uint32_t)(mask != 0) << i;
    }
    for (uint32_t i = s->count; i < LANES; ++i) memset(&s->p->groups[i], 0, sizeof(group));
    uint32_t together = find_spans(s->p->groups, &tree->bounds, tree->prim_count, &s->all);
    together &= find_headings(&s->all, s->headings);
    s->ready = wanting & together & make_beams(s->p->groups, &tree->bounds, &s->all, &s->p->one);
    s->scattered = wanting & ~together;
}

/* ---- Answers -------------------------------------------------------------------------------- */

HT_TARGET HT_INLINE void answer_closest(const ht_tile *tile, const place *at, const group *g) {
    htree_hit *const hits = tile->hits + at->first;
    const uint64_t stride = stride_of(tile);
    htree_hit some[LANES];
    if (is_whole(at)) {
        give_hits(g, hits, stride);
        return;
    }
    give_hits(g, some, COLUMNS);
    for (uint32_t k = 0; k < at->rows; ++k)
        memcpy(hits + k * stride, some + k * COLUMNS, at->columns * sizeof *hits);
}

HT_TARGET HT_INLINE void answer_any(const ht_tile *tile, const place *at, const group *g) {
    uint8_t *const occluded = tile->occluded + at->first;
    const uint64_t stride = stride_of(tile);
    const uint32_t hit = prims_hit(g->prim);
    for (uint32_t k = 0; k < at->rows; ++k) {
        for (uint32_t j = 0; j < at->columns; ++j)
            occluded[k * stride + j] = hit >> (ROWS * j + k) & 1;
    }
}

enum { LONERS = 8 }; /* more would fill streams better, but take too much of a small stack */

/* Groups whose rays walk as streams, together with those of other packets: a few would not fill them. */
typedef struct loners {
    place places[LONERS];
    uint32_t count;
} loners;

HT_NOINLINE static void walk_alone(const htree *tree, const ht_tile *tile, loners *s,
                                   ht_block_walk *walk) {
    htree_ray rays[LONERS * LANES];
    htree_hit hits[LONERS * LANES];
    uint8_t occluded[LONERS * LANES];
    const uint64_t stride = stride_of(tile);
    uint64_t count = 0, from = 0;
    for (const place *at = s->places; at < s->places + s->count; ++at) {
        for (uint32_t k = 0; k < at->rows; ++k, count += at->columns)
            memcpy(rays + count, tile->rays + at->first + k * stride, at->columns * sizeof *rays);
    }
    const ht_block block = {rays, count, tile->hits ? hits : NULL, tile->hits ? NULL : occluded};
    walk(tree, &block);
    for (const place *at = s->places; at < s->places + s->count; ++at) {
        for (uint32_t k = 0; k < at->rows; ++k, from += at->columns) {
            const uint64_t to = at->first + k * stride;
            if (tile->hits)
                memcpy(tile->hits + to, hits + from, at->columns * sizeof *hits);
            else
                memcpy(tile->occluded + to, occluded + from, at->columns);
        }
    }
    s->count = 0;
}

/* ---- Tiles ---------------------------------------------------------------------------------- */

/* Walks the groups that are ready, those that head the same way together. */
HT_TARGET HT_INLINE void walk_ready(const htree *tree, plan *s, ahead *next, const bool any) {
    s->gave_up = false;
    while (s->ready) {
        const heading h = s->headings[__builtin_ctz(s->ready)];
        uint32_t groups = 0;
        for (uint32_t rest = s->ready; rest; rest &= rest - 1) {
            const uint32_t i = (uint32_t)__builtin_ctz(rest);
            if (s->headings[i].negative != h.negative || s->headings[i].kz != h.kz) continue;
            shear_group(&s->p->groups[i], h.kz);
            groups |= 1u << i;
        }
        s->p->h = h;
        s->ready &= ~groups;
        const uint32_t lost = make_whole(s->p, &s->all, groups)
                                  ? walk_packet(tree, s->p, groups, next, any, true)
                                  : walk_packet(tree, s->p, groups, next, any, false);
        s->scattered |= lost;
        s->gave_up |= 2 * _mm_popcnt_u32(lost) > _mm_popcnt_u32(groups);
    }
}

/* The packet is on the stack no longer than its walk: stacks may be small. */
HT_TARGET HT_NOINLINE static void walk_together(const htree *tree, const ht_tile *tile, plan *s,
                                                ahead *next, const bool any) {
    packet p;
    s->p = &p;
    take_groups(tree, tile, s);
    walk_ready(tree, s, next, any);
    look_ahead(next, LANES * ROWS);
    for (uint32_t i = 0; i < s->count; ++i) {
        if (s->scattered >> i & 1) continue;
        if (any)
            answer_any(tile, &s->places[i], &s->p->groups[i]);
        else
            answer_closest(tile, &s->places[i], &s->p->groups[i]);
    }
}

/* What the packet of a plan wants of memory. */
HT_INLINE ahead ahead_of(const ht_tile *tile, const plan *s) {
    ahead to;
    to.rays = tile->rays;
    to.hits = tile->hits;
    to.stride = stride_of(tile);
    to.rows = s->count * ROWS;
    for (uint32_t i = 0; i < s->count; ++i) to.first[i] = s->places[i].first;
    return to;
}

/* Packet by packet. Where one had to give up, those that follow are not tried: one at first, then
 * more. */
HT_TARGET HT_INLINE void walk_tile(const htree *tree, const ht_tile *tile, ht_block_walk *alone,
                                   const bool any) {
    const uint32_t fit = (tile->width + COLUMNS - 1) / COLUMNS;
    const uint32_t across = fit >= 4 ? 4 : fit >= 2 ? 2 : 1, down = LANES / across;
    const uint32_t columns = (fit + across - 1) / across;
    const uint32_t rows = (tile->height + down * ROWS - 1) / (down * ROWS);
    uint32_t penalty = 0, skip = 0;
    loners scattered;
    plan plans[2];
    scattered.count = 0;
    find_places(tile, 0, 0, across, &plans[0]);
    for (uint32_t i = 0; i < columns * rows; ++i) {
        plan *s = &plans[i % 2], *following = &plans[1 - i % 2];
        find_places(tile, (i + 1) % columns * across * COLUMNS, (i + 1) / columns * down * ROWS,
                    across, following);
        ahead next = ahead_of(tile, following);
        s->scattered = ALL_LANES >> (LANES - s->count);
        if (skip > 0) {
            --skip;
        } else {
            walk_together(tree, tile, s, &next, any);
            penalty = s->gave_up ? 2 * penalty + 1 : 0;
            skip = penalty / 2;
        }
        for (uint32_t rest = s->scattered; rest; rest &= rest - 1) {
            scattered.places[scattered.count++] = s->places[__builtin_ctz(rest)];
            if (scattered.count == LONERS) walk_alone(tree, tile, &scattered, alone);
        }
    }
    if (scattered.count) walk_alone(tree, tile, &scattered, alone);
}

#define HT_DEFINE_TILE_WALKS(name, alone)                                                          \
    HT_TARGET static void closest_tile(const htree *tree, const ht_tile *tile) {                   \
        walk_tile(tree, tile, alone.closest, false);                                               \
    }                                                                                              \
    HT_TARGET static void any_tile(const htree *tree, const ht_tile *tile) {                       \
        walk_tile(tree, tile, alone.any, true);                                                    \
    }                                                                                              \
    const ht_tile_walks name = {closest_tile, any_tile}

#endif
