/* trace.h: what walks share. A walk takes a prepared ray through the nodes of its kind.
 *
 * Each walk is written once, as a forced-inline function of two constants (any: stop at the first
 * hit; counted: count steps), and instantiated by HT_DEFINE_WALKS. */
#ifndef HT_TRACE_H
#define HT_TRACE_H

#include "ray.h"
#include "tree/tree.h"

/* Walks the tree, which holds at least one prim. *hit holds the best answer so far, at first
 * {tmax, 0, 0, HTREE_NONE}. With `any` the walk returns at the first hit. */
typedef void ht_walk(const htree *tree, const htree_ray *ray, const ht_ray *r, htree_hit *hit,
                     htree_counters *counters);

typedef struct ht_walks {
    ht_walk *closest, *any, *closest_counted, *any_counted;
} ht_walks;

/* Rays of a batch that a thread takes at once; the answers go to hits, or else to occluded. */
typedef struct ht_block {
    const htree_ray *rays;
    uint64_t count;
    htree_hit *hits;
    uint8_t *occluded;
} ht_block;

/* Walks that take several rays at once. The tree holds at least one prim. */
typedef void ht_block_walk(const htree *tree, const ht_block *block);

typedef struct ht_block_walks {
    ht_block_walk *closest, *any;
} ht_block_walks;

extern const ht_block_walks ht_wide_avx2_walks, ht_wide_avx512_walks; /* x86/ */
extern const ht_block_walks ht_wide_neon_walks;                       /* arm/ */

/* Rays of a picture that a thread takes at once: `height` rows of `width`, out of rows of `row`, in
 * cells or not, as coherence.h has it; so are the answers, which go to hits, or else to occluded. */
typedef struct ht_tile {
    const htree_ray *rays;
    uint64_t row;
    uint32_t cell, width, height;
    htree_hit *hits;
    uint8_t *occluded;
} ht_tile;

/* Walks that take rays which agree with their neighbours. The tree holds triangles only, and at least
 * one. */
typedef void ht_tile_walk(const htree *tree, const ht_tile *tile);

/* The stack of a packet: deeper trees know none. */
#define HT_PACKET_STACK 128u

typedef struct ht_tile_walks {
    ht_tile_walk *closest, *any;
} ht_tile_walks;

extern const ht_tile_walks ht_packet_avx2_walks, ht_packet_avx512_walks; /* x86/ */

extern const ht_walks ht_ug_walks;   /* ug.c */
extern const ht_walks ht_kd_walks;   /* kd.c */
extern const ht_walks ht_bvh_walks;  /* bvh.c */
extern const ht_walks ht_h_walks;    /* h.c */
extern const ht_walks ht_wide_walks; /* wide.c */

#define HT_DEFINE_WALKS(name, walk)                                                                \
    static void closest(const htree *t, const htree_ray *ray, const ht_ray *r, htree_hit *h,       \
                        htree_counters *c) {                                                       \
        walk(t, ray, r, h, c, false, false);                                                       \
    }                                                                                              \
    static void any(const htree *t, const htree_ray *ray, const ht_ray *r, htree_hit *h,           \
                    htree_counters *c) {                                                           \
        walk(t, ray, r, h, c, true, false);                                                        \
    }                                                                                              \
    static void closest_counted(const htree *t, const htree_ray *ray, const ht_ray *r,             \
                                htree_hit *h, htree_counters *c) {                                 \
        walk(t, ray, r, h, c, false, true);                                                        \
    }                                                                                              \
    static void any_counted(const htree *t, const htree_ray *ray, const ht_ray *r, htree_hit *h,   \
                            htree_counters *c) {                                                   \
        walk(t, ray, r, h, c, true, true);                                                         \
    }                                                                                              \
    const ht_walks name = {closest, any, closest_counted, any_counted}

/* An entry of a traversal stack: a node and the interval of the ray inside its traversal box. */
typedef struct ht_stack_entry {
    uint32_t slot;
    float tnear, tfar;
} ht_stack_entry;

/* Asks the caller's own object. What comes back is not trusted: it must lie in [tmin, tmax]. */
HT_NOINLINE bool ht_intersect_object(const htree *tree, uint32_t prim, const htree_ray *ray,
                                     htree_hit *hit);

/* Puts a hit of `prim` into *hit if it is the minimum of (t, prim). Returns true. */
HT_INLINE bool ht_keep_nearer(htree_hit *hit, const htree_hit *found, uint32_t prim) {
    if (found->t < hit->t || (found->t == hit->t && prim < hit->prim)) {
        *hit = *found;
        hit->prim = prim;
    }
    return true;
}

/* Whether the ray meets the box of an object: leaves of several ask before they call. */
HT_INLINE bool ht_meets_object(const htree *tree, uint32_t prim, const ht_ray *r, float tfar) {
    const htree_box *box = &tree->object_boxes[prim - tree->triangle_count];
    float tnear = r->tnear;
    ht_ray_clip_box(r, box->lo, box->hi, &tnear, &tfar);
    return tnear <= tfar;
}

/* Tests one prim and keeps the minimum of (t, prim) in *hit; returns whether the prim was hit at
 * all. */
HT_INLINE bool ht_intersect_prim(const htree *tree, uint32_t prim, const htree_ray *ray,
                                 const ht_ray *r, htree_hit *hit) {
    htree_hit found;
    if (prim < tree->triangle_count) {
        const ht_triangle *triangle = &tree->triangles[prim];
        if (!ht_triangle_intersect(&r->shear, triangle->v[0], triangle->v[1], triangle->v[2],
                                   r->tmin, hit->t, &found)) {
            return false;
        }
    } else if (!ht_intersect_object(tree, prim, ray, &found)) {
        return false;
    }
    return ht_keep_nearer(hit, &found, prim);
}

#endif
