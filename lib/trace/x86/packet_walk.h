/* packet_walk.h: takes packets through a wide tree. A node is asked for all groups of a packet at
 * once, a lane each, by their beams; a leaf is asked group by group, first for the triangles whose
 * boxes the beam meets, then triangle by triangle for all rays of the group.
 *
 * Culling is conservative for every ray, and the rays' tests do what triangle.h does, in the same
 * order: hits are the same bits as those of rays that walk alone. */
#ifndef HT_PACKET_WALK_H
#define HT_PACKET_WALK_H

#include "packet_rays.h"
#include "trace/to_front.h"

/* Leaves that a group may see, until its rays are better off as streams. */
enum { PATIENCE = 64 };

/* Rows of groups that are asked for ahead at each step. */
enum { AHEAD = 4 };

/* The rays that are wanted next, and where their hits go: both come from far, and are asked for a few
 * at a time while others walk. */
typedef struct ahead {
    const htree_ray *rays;
    const htree_hit *hits; /* or NULL */
    uint64_t first[LANES]; /* of each group */
    uint64_t stride;       /* from a row of a group to the next */
    uint32_t rows;         /* still to be asked for, of all groups */
} ahead;

typedef struct packet {
    group groups[LANES];
    beams one;   /* of each group */
    beams whole; /* in lane 0: of all groups that walk */
    heading h;
    float eye[3]; /* the origin of all rays, if they have one */
    uint32_t child[HT_PACKET_STACK];
    VECTORS float from[HT_PACKET_STACK][LANES]; /* where beams meet the child; NaN: they do not */
} packet;

HT_TARGET HT_INLINE void prefetch(const void *from, uint32_t bytes) {
    for (uint32_t i = 0; i < bytes; i += 64) _mm_prefetch((const char *)from + i, _MM_HINT_T1);
}

HT_TARGET HT_INLINE void look_ahead(ahead *to, uint32_t rows) {
    for (; rows > 0 && to->rows > 0; --rows) {
        const uint32_t i = --to->rows;
        const uint64_t ray = to->first[i / ROWS] + i % ROWS * to->stride;
        prefetch(to->rays + ray, COLUMNS * (uint32_t)sizeof *to->rays);
        if (to->hits) prefetch(to->hits + ray, COLUMNS * (uint32_t)sizeof *to->hits);
    }
}

/* ---- Boxes ---------------------------------------------------------------------------------- */

/* A bit for each of eight boxes that beam `g` meets, and where. Distances grow with rdir if they are
 * positive, and no others count: rays of beams begin at 0 or later. */
HT_TARGET HT_INLINE uint32_t clip_boxes(const float *planes, const beams *b, uint32_t g,
                                        uint32_t negative, __m256 *enter) {
    __m256 leave = _mm256_broadcast_ss(&b->tfar[g]);
    *enter = _mm256_broadcast_ss(&b->tnear[g]);
    for (uint32_t i = 0; i < 3; ++i) {
        const uint32_t n = negative >> i & 1;
        const __m256 near = _mm256_load_ps(planes + 8 * i + 24 * n);
        const __m256 far = _mm256_load_ps(planes + 8 * i + 24 * (1 - n));
        const __m256 from = near - _mm256_broadcast_ss(&b->entry[i][g]);
        const __m256 to = far - _mm256_broadcast_ss(&b->exit[i][g]);
        *enter = _mm256_max_ps(from * _mm256_broadcast_ss(&b->least[i][g]), *enter);
        leave = _mm256_min_ps(to * _mm256_broadcast_ss(&b->most[i][g]), leave);
    }
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(*enter, leave, _CMP_LE_OQ));
}

/* Where beams meet box `lane` of a node; NaN for those that do not, as it was before for those that
 * do not come here. Returns a bit for each that does. */
HT_TARGET HT_INLINE uint32_t clip_beams(const ht_wide_node *node, uint32_t lane, const packet *p,
                                        lanes until, lanes *meets) {
    const float *planes = &node->lo[0][lane];
    lanes enter = *meets, leave = until;
    for (uint32_t i = 0; i < 3; ++i) {
        const uint32_t n = p->h.negative >> i & 1;
        const lanes from = spread(planes[8 * i + 24 * n]) - load(p->one.entry[i]);
        const lanes to = spread(planes[8 * i + 24 * (1 - n)]) - load(p->one.exit[i]);
        enter = greatest(from * load(p->one.least[i]), enter);
        leave = least(to * load(p->one.most[i]), leave);
    }
    const uint32_t mask = at_most(enter, leave);
    *meets = pick(mask, enter, spread(NAN));
    return mask;
}

HT_TARGET HT_INLINE void prefetch_child(const htree *tree, uint32_t child) {
    const ht_wide_node *nodes = (const ht_wide_node *)tree->nodes;
    const bool leaf = child & HT_WIDE_LEAF;
    if (HT_UNLIKELY(ht_wide_is_pending(child))) return;
    const char *from =
        leaf ? (const char *)&tree->leaves[child & ~HT_WIDE_LEAF] : (const char *)&nodes[child];
    for (int i = 0; i < 5; ++i) _mm_prefetch(from + 64 * i, _MM_HINT_T0);
}

/* The lanes of a mask by where the whole beam meets their boxes, the farthest first. Returns how many
 * they are. Distances are sorted as words, whose lowest bits give way to the lane's number. */
HT_TARGET HT_INLINE uint32_t sort_lanes(uint32_t mask, __m256 enter, uint32_t sorted[HT_LANES]) {
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i high = _mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(enter));
    uint32_t words[HT_LANES], count = 0;
    _mm256_storeu_si256((__m256i *)(void *)words, _mm256_or_si256(high, lane));
    for (; mask; mask &= mask - 1) {
        const uint32_t word = words[__builtin_ctz(mask)];
        uint32_t i = count++;
        for (; i > 0 && sorted[i - 1] < word; --i) sorted[i] = sorted[i - 1];
        sorted[i] = word;
    }
    return count;
}

/* Pushes the children that a beam meets, the one that is met first on top. */
HT_TARGET HT_INLINE uint32_t meet_node(const htree *tree, const ht_wide_node *node, packet *p,
                                       lanes from, uint32_t top) {
    const lanes until = load(p->one.tfar);
    uint32_t sorted[HT_LANES];
    __m256 enter;
    const uint32_t boxes = clip_boxes(&node->lo[0][0], &p->whole, 0, p->h.negative, &enter);
    const uint32_t count = sort_lanes(boxes, enter, sorted);
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t lane = sorted[i] % HT_LANES;
        lanes meets = from;
        if (!clip_beams(node, lane, p, until, &meets)) continue;
        prefetch_child(tree, node->child[lane]);
        p->child[top] = node->child[lane];
        store(p->from[top++], meets);
    }
    return top;
}

/* ---- Triangles ------------------------------------------------------------------------------ */

/* The corners of a leaf's triangles along kx, ky, kz, and the triangles' boxes in the layout of a
 * node's. Rays of one origin see the corners from there. */
typedef struct corners {
    __m256 v[3][3];
    __m256 planes[2][3];
} corners;

HT_TARGET HT_INLINE void take_corners(const ht_wide_leaf *leaf, const packet *p, corners *out,
                                      const bool pinhole) {
    uint32_t axis = p->h.kz;
    for (int k = 2, i = 0; i < 3; ++i, k = i - 1) {
        const __m256 org = _mm256_set1_ps(pinhole ? p->eye[axis] : 0);
        const __m256 a = _mm256_load_ps(leaf->v[0][axis]), b = _mm256_load_ps(leaf->v[1][axis]);
        const __m256 c = _mm256_load_ps(leaf->v[2][axis]);
        out->planes[0][axis] = _mm256_min_ps(_mm256_min_ps(a, b), c);
        out->planes[1][axis] = _mm256_max_ps(_mm256_max_ps(a, b), c);
        out->v[0][k] = a - org;
        out->v[1][k] = b - org;
        out->v[2][k] = c - org;
        axis = axis == 2 ? 0 : axis + 1;
    }
}

typedef struct corner {
    lanes x, y, z;
} corner;

/* Corner `c` of triangle `i`, sheared for every ray. */
HT_TARGET HT_INLINE corner shear(const corners *from, uint32_t c, uint32_t i, const group *g,
                                 uint32_t kz, const bool pinhole) {
    const uint32_t kx = kz == 2 ? 0 : kz + 1, ky = kx == 2 ? 0 : kx + 1;
    const float *const v = (const float *)from->v[c] + i;
    lanes x = spread(v[0]), y = spread(v[HT_LANES]), z = spread(v[2 * HT_LANES]);
    if (!pinhole) {
        x = x - load(g->org[kx]);
        y = y - load(g->org[ky]);
        z = z - load(g->org[kz]);
    }
    const corner out = {x - load(g->sx) * z, y - load(g->sy) * z, z};
    return out;
}

HT_TARGET HT_INLINE lanes edge_of(corner a, corner b) {
    return a.x * b.y - a.y * b.x;
}

/* A triangle that has candidates in a group, sheared for each ray: where the verdict of triangle.h
 * reads. It goes through memory, which widens at no cost. */
typedef struct judged {
    VECTORS float x[3][LANES], y[3][LANES], z[3][LANES];
    uint32_t candidates, group, triangle;
} judged;

enum { VERDICTS = 8 }; /* that wait for each other */

/* The verdict of triangle.h for half of the rays, from lane `first` on. Returns a bit for each that
 * the triangle meets. */
HT_TARGET HT_INLINE uint32_t judge(const group *g, const judged *p, uint32_t kz, uint32_t first,
                                   half *t, half bary[3]) {
    const half ax = widen(p->x[0] + first), ay = widen(p->y[0] + first);
    const half bx = widen(p->x[1] + first), by = widen(p->y[1] + first);
    const half cx = widen(p->x[2] + first), cy = widen(p->y[2] + first);
    const half u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
    const half det = u + v + w;
    const half z =
        u * widen(p->z[0] + first) + v * widen(p->z[1] + first) + w * widen(p->z[2] + first);
    *t = z / (det * widen(g->dir[kz] + first));
    bary[0] = det;
    bary[1] = v;
    bary[2] = w;
    return meets_triangle(u, v, w, det);
}

/* The rays that triangle `i` of a leaf does not reject by the signs of floats; their corners. */
HT_TARGET HT_INLINE uint32_t find_candidates(const corners *from, uint32_t i, const group *g,
                                             uint32_t kz, const bool pinhole, judged *out) {
    corner p[3];
    for (uint32_t k = 0; k < 3; ++k) {
        p[k] = shear(from, k, i, g, kz, pinhole);
        store(out->x[k], p[k].x);
        store(out->y[k], p[k].y);
        store(out->z[k], p[k].z);
    }
    const lanes u = edge_of(p[2], p[1]), v = edge_of(p[0], p[2]), w = edge_of(p[1], p[0]);
    const lanes low = least(least(u, v), w), high = greatest(greatest(u, v), w);
    return ~(below(low, spread(0)) & below(spread(0), high)) & ALL_LANES;
}

/* Returns whether the triangle is a better answer for any ray. */
HT_TARGET HT_INLINE bool meet_triangle(group *g, const judged *p, uint32_t prim, uint32_t kz,
                                       const bool any) {
    half t[2], bary[2][3];
    uint32_t met = judge(g, p, kz, 0, &t[0], bary[0]);
    met |= judge(g, p, kz, LANES / 2, &t[1], bary[1]) << LANES / 2;
    const lanes found = narrow(t[0], t[1]), limit = load(g->limit);
    const uint32_t nearer =
        any ? at_most(found, limit)
            : below(found, limit) | (at_most(found, limit) & prims_above(g->prim, prim));
    const uint32_t better = p->candidates & met & nearer & at_most(load(g->tmin), found);
    if (!better) return false;
    store(g->limit, pick(better, any ? spread(-INFINITY) : found, limit));
    store_prim(g->prim, better, prim);
    for (int side = 0; !any && side < 2; ++side) {
        const uint32_t some = better >> side * LANES / 2;
        store_some(g->det + side * LANES / 2, some, bary[side][0]);
        store_some(g->v + side * LANES / 2, some, bary[side][1]);
        store_some(g->w + side * LANES / 2, some, bary[side][2]);
    }
    return true;
}

/* Idle lanes have the sign of HT_WIDE_NONE. */
HT_TARGET HT_INLINE uint32_t used_lanes(const ht_wide_leaf *leaf) {
    const __m256 prims = _mm256_load_ps((const float *)(const void *)leaf->prim);
    return ~(uint32_t)_mm256_movemask_ps(prims) & 255;
}

/* Groups and triangles whose boxes their beams meet. */
typedef struct pairs {
    uint8_t group[LANES * HT_LANES], triangle[LANES * HT_LANES];
    uint32_t count;
} pairs;

HT_TARGET HT_INLINE void find_pairs(const ht_wide_leaf *leaf, const corners *from, const packet *p,
                                    uint32_t groups, pairs *out) {
    const uint32_t all = used_lanes(leaf);
    out->count = 0;
    for (; groups; groups &= groups - 1) {
        const uint32_t g = (uint32_t)__builtin_ctz(groups);
        const uint64_t eight = g * 0x0101010101010101u;
        __m256 enter;
        const uint32_t triangles =
            all & clip_boxes((const float *)from->planes, &p->one, g, p->h.negative, &enter);
        memcpy(out->group + out->count, &eight, sizeof eight);
        memcpy(out->triangle + out->count, &ht_to_front[triangles], sizeof *ht_to_front);
        out->count += (uint32_t)_mm_popcnt_u32(triangles);
    }
}

/* Returns a bit for each group that has a better answer. */
HT_TARGET HT_INLINE uint32_t meet_triangles(const ht_wide_leaf *leaf, packet *p, const judged *from,
                                            uint32_t count, const bool any) {
    uint32_t better = 0;
    for (const judged *end = from + count; from < end; ++from) {
        const uint32_t prim = leaf->prim[from->triangle];
        better |= (uint32_t)meet_triangle(&p->groups[from->group], from, prim, p->h.kz, any)
                  << from->group;
    }
    return better;
}

/* Stage by stage for all groups, rather than group by group: loops over the few triangles of a group
 * end unforeseen. */
HT_TARGET HT_INLINE void meet_leaf(const ht_wide_leaf *leaf, packet *p, uint32_t groups,
                                   const bool any, const bool pinhole) {
    uint32_t waiting = 0, better = 0;
    judged some[VERDICTS];
    pairs met;
    corners c;
    take_corners(leaf, p, &c, pinhole);
    find_pairs(leaf, &c, p, groups, &met);
    for (uint32_t i = 0; i < met.count; ++i) {
        judged *to = &some[waiting];
        to->group = met.group[i];
        to->triangle = met.triangle[i];
        to->candidates =
            find_candidates(&c, to->triangle, &p->groups[to->group], p->h.kz, pinhole, to);
        waiting += to->candidates != 0;
        if (waiting < VERDICTS && i + 1 < met.count) continue;
        better |= meet_triangles(leaf, p, some, waiting, any);
        waiting = 0;
    }
    for (; better; better &= better - 1) {
        const uint32_t g = (uint32_t)__builtin_ctz(better);
        p->one.tfar[g] = highest(load(p->groups[g].limit), ALL_LANES);
    }
}

/* ---- Packets -------------------------------------------------------------------------------- */

/* Bounds the beams of the groups that walk; whether their rays have one origin, the eye. */
HT_TARGET HT_INLINE bool make_whole(packet *p, const spans *s, uint32_t groups) {
    bool pinhole = true;
    for (int i = 0; i < 3; ++i) {
        const bool negative = p->h.negative >> i & 1;
        const lanes entry = load(p->one.entry[i]), exit = load(p->one.exit[i]);
        const lanes slow = load(p->one.least[i]), fast = load(p->one.most[i]);
        p->whole.entry[i][0] = negative ? lowest(entry, groups) : highest(entry, groups);
        p->whole.exit[i][0] = negative ? highest(exit, groups) : lowest(exit, groups);
        p->whole.least[i][0] = negative ? highest(slow, groups) : lowest(slow, groups);
        p->whole.most[i][0] = negative ? lowest(fast, groups) : highest(fast, groups);
        p->eye[i] = lowest(s->org_lo[i], groups);
        pinhole = pinhole && p->eye[i] == highest(s->org_hi[i], groups);
    }
    p->whole.tnear[0] = lowest(load(p->one.tnear), groups);
    p->whole.tfar[0] = highest(load(p->one.tfar), groups);
    return pinhole;
}

/* Counts what the groups of a mask see at a child; returns those that have seen too much. */
HT_TARGET HT_INLINE uint32_t count_seen(lanes *seen, uint32_t mask, const bool leaf) {
    *seen = *seen + pick(mask, spread(leaf ? 1 : 1.0f / LANES), spread(0));
    return mask & below(spread(PATIENCE), *seen);
}

/* Returns the groups that gave up: what their beams meet is too much for the rays in them. */
HT_TARGET HT_INLINE uint32_t walk_packet(const htree *tree, packet *p, uint32_t groups, ahead *next,
                                         const bool any, const bool pinhole) {
    const ht_wide_node *nodes = (const ht_wide_node *)tree->nodes;
    lanes seen = spread(0);
    uint32_t lost = 0;
    p->child[0] = 0;
    store(p->from[0], pick(groups, load(p->one.tnear), spread(NAN)));
    for (uint32_t top = 1; top > 0;) {
        const lanes from = load(p->from[--top]);
        const uint32_t mask = at_most(from, load(p->one.tfar));
        if (!mask) continue;
        look_ahead(next, AHEAD);
        const uint32_t child = ht_wide_resolve(tree, p->child[top]);
        const uint32_t tired = count_seen(&seen, mask, child & HT_WIDE_LEAF);
        if (HT_UNLIKELY(tired)) {
            store(p->one.tfar, pick(tired, spread(-INFINITY), load(p->one.tfar)));
            lost |= tired;
        }
        if (child & HT_WIDE_LEAF) {
            meet_leaf(&tree->leaves[child & ~HT_WIDE_LEAF], p, mask & ~tired, any, pinhole);
            p->whole.tfar[0] = highest(load(p->one.tfar), groups);
        } else {
            top = meet_node(tree, &nodes[child], p, from, top);
        }
    }
    return lost;
}

#endif
