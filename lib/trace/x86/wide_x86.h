/* wide_x86.h: boxes and triangles of a wide tree by 256-bit vectors: included by one file per
 * instruction set, which defines HT_TARGET, store_met() and larger(). trace/streams.h does the rest. */
#ifndef HT_WIDE_X86_H
#define HT_WIDE_X86_H

#include "trace/streams.h"

#include "trace/x86/ready_x86.h"

#include <immintrin.h>

/* Moves the lanes where enter <= leave to the front of child, and with tnear, of that; returns how
 * many. */
HT_TARGET HT_INLINE uint32_t store_met(__m256 enter, __m256 leave, __m256i words, uint32_t *child,
                                       float *tnear);

/* The larger magnitude of each lane. */
HT_TARGET HT_INLINE __m256 larger(__m256 a, __m256 b);

/* ---- Boxes ---------------------------------------------------------------------------------- */

HT_TARGET HT_INLINE void clip_axis(const float *planes, const ready *r, int axis, __m256 *enter,
                                   __m256 *leave) {
    const __m256 near = _mm256_load_ps(planes + r->near[axis]);
    const __m256 far = _mm256_load_ps(planes + r->far[axis]);
    const __m256 rdir = _mm256_broadcast_ss(&r->rdir[axis]);
    const __m256 from = _mm256_broadcast_ss(&r->enter[axis]);
    const __m256 to = _mm256_broadcast_ss(&r->leave[axis]);
    *enter = _mm256_max_ps(_mm256_fmadd_ps(near, rdir, from), *enter);
    *leave = _mm256_min_ps(_mm256_fmadd_ps(far, rdir, to), *leave);
}

HT_TARGET HT_INLINE uint32_t step_node(const ht_wide_node *node, const stream *s, uint32_t *child,
                                       float *tnear, const bool any) {
    const float *planes = &node->lo[0][0];
    __m256 enter = _mm256_broadcast_ss(&s->r.tnear), leave = _mm256_broadcast_ss(&s->hit.t);
    clip_axis(planes, &s->r, 0, &enter, &leave);
    clip_axis(planes, &s->r, 1, &enter, &leave);
    clip_axis(planes, &s->r, 2, &enter, &leave);
    __m256i words = _mm256_load_si256((const __m256i *)(const void *)node->child);
    if (any) return store_met(enter, leave, words, child, NULL);
    const __m256i last = _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0);
    const __m256i order = _mm256_xor_si256(last, _mm256_set1_epi32((int)s->r.order));
    enter = _mm256_permutevar8x32_ps(enter, order);
    leave = _mm256_permutevar8x32_ps(leave, order);
    words = _mm256_permutevar8x32_epi32(words, order);
    return store_met(enter, leave, words, child, tnear);
}

/* Eight at a time: what is written has been read. */
HT_TARGET HT_INLINE uint32_t keep_near(uint32_t *child, float *tnear, uint32_t count, float t) {
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i += HT_LANES) {
        const __m256i left = _mm256_set1_epi32((int)(count - i));
        const __m256 waits = _mm256_castsi256_ps(_mm256_cmpgt_epi32(left, lane));
        const __m256 near = pick(waits, _mm256_loadu_ps(tnear + i), spread(NAN));
        const __m256i words = _mm256_loadu_si256((const __m256i *)(const void *)(child + i));
        kept += store_met(near, spread(t), words, child + kept, tnear + kept);
    }
    return kept;
}

/* ---- Compact trees -------------------------------------------------------------------------- */

HT_TARGET HT_INLINE __m256i words_of_bytes(const ht_byte bytes[8]) {
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)bytes));
}

HT_TARGET HT_INLINE __m256 planes_of(const ht_compact_node *node, uint32_t axis,
                                     const ht_byte bytes[8]) {
    const __m256 steps = _mm256_mul_ps(_mm256_cvtepi32_ps(words_of_bytes(bytes)),
                                       _mm256_broadcast_ss(&node->step[axis]));
    return _mm256_add_ps(_mm256_broadcast_ss(&node->origin[axis]), steps);
}

HT_TARGET HT_INLINE void expand_node(const htree *tree, uint32_t slot, ht_wide_node *node) {
    const ht_compact_node *from = (const ht_compact_node *)tree->nodes + slot;
    const __m256i child = _mm256_loadu_si256((const __m256i *)(const void *)from->child);
    const __m256 idle = _mm256_castsi256_ps(_mm256_cmpeq_epi32(child, _mm256_set1_epi32(-1)));
    const __m256 lo = _mm256_set1_ps(INFINITY), hi = _mm256_set1_ps(-INFINITY);
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const __m256 from_lo = planes_of(from, axis, from->lo[axis]);
        const __m256 from_hi = planes_of(from, axis, from->hi[axis]);
        _mm256_store_ps(node->lo[axis], _mm256_blendv_ps(from_lo, lo, idle));
        _mm256_store_ps(node->hi[axis], _mm256_blendv_ps(from_hi, hi, idle));
    }
    _mm256_store_si256((__m256i *)(void *)node->child, child);
}

/* Gathers coordinates by numbers of 32 bits, so it is not for the largest trees. */
HT_TARGET HT_INLINE void expand_leaf(const htree *tree, uint32_t index, ht_wide_leaf *leaf) {
    const ht_compact_leaf *from = &tree->compact_leaves[index];
    if (HT_UNLIKELY(tree->vertex_count > INT32_MAX / 3)) {
        ht_expand_leaf(tree, index, leaf);
        return;
    }
    const __m256i prim = _mm256_loadu_si256((const __m256i *)(const void *)from->prim);
    const __m256i count = _mm256_set1_epi32((int)tree->triangle_count);
    const __m256 others =
        _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_max_epu32(prim, count), prim));
    const __m256i first = _mm256_set1_epi32((int)from->first);
    for (uint32_t k = 0; k < 3; ++k) {
        const __m256i vertex = _mm256_add_epi32(first, words_of_bytes(from->corner[k]));
        const __m256i at = _mm256_add_epi32(vertex, _mm256_add_epi32(vertex, vertex));
        for (uint32_t axis = 0; axis < 3; ++axis) {
            const __m256 all = _mm256_i32gather_ps(tree->vertices + axis, at, 4);
            _mm256_store_ps(leaf->v[k][axis], _mm256_andnot_ps(others, all));
        }
    }
    _mm256_store_si256((__m256i *)(void *)leaf->prim, prim);
}

/* ---- Triangles ------------------------------------------------------------------------------ */

typedef struct corner_lanes {
    __m256 x, y, z;
} corner_lanes;

/* With x, y and z negated, which rounds the same way and changes no edge function: so corners are
 * subtracted where they lie in memory. */
HT_TARGET HT_INLINE corner_lanes shear_corner(const float (*v)[HT_LANES], const ready *r) {
    const float *const lanes = v[0];
    const __m256 x = _mm256_broadcast_ss(&r->org[0]), y = _mm256_broadcast_ss(&r->org[1]);
    const __m256 z =
        _mm256_sub_ps(_mm256_broadcast_ss(&r->org[2]), _mm256_load_ps(lanes + r->row[2]));
    corner_lanes c;
    c.z = z;
    c.x = _mm256_sub_ps(_mm256_sub_ps(x, _mm256_load_ps(lanes + r->row[0])),
                        _mm256_mul_ps(_mm256_broadcast_ss(&r->sx), z));
    c.y = _mm256_sub_ps(_mm256_sub_ps(y, _mm256_load_ps(lanes + r->row[1])),
                        _mm256_mul_ps(_mm256_broadcast_ss(&r->sy), z));
    return c;
}

HT_TARGET HT_INLINE __m256 edge(corner_lanes a, corner_lanes b) {
    return _mm256_sub_ps(_mm256_mul_ps(a.x, b.y), _mm256_mul_ps(a.y, b.x));
}

/* Where a triangle that the signs u, v, w do not reject lies before tmin without doubt: most often the
 * one that the ray starts on, whose verdict would be a division and a mispredicted branch.
 *
 * In exact numbers t dz is z / det, with z = u az + v bz + w cz and det = u + v + w, so with first =
 * tmin dz the triangle is before tmin if n = (z - first det) sign(det dz) < 0. Let X, Y and Z be the
 * largest magnitudes of coordinates and e = 2^-24. An edge function is at most 2 X Y and its error
 * 4.1 e X Y. Summing the errors of three of them, of the products with corners and of the sums gives
 * 29 e X Y Z for z and 35 e X Y |first| for first det, and 6.1 e X Y (Z + |first|) for their
 * difference: less than 42 e X Y (Z + |first|). Where the float n is below -64 e X Y (Z + |first|),
 * n is below -21 e X Y (Z + |first|), as is the n of the verdict, exact to 2^-50. |det| being at most
 * 6 X Y, t is below tmin by 3 e |tmin| then, more than the float next to tmin.
 *
 * The sign of the float det is that of the verdict's, if it accepts: a float edge function has the
 * exact sign or is 0, and the others may not have the opposite one. If all are 0, so is n. Smaller
 * terms than 2^-60 are taken for as much, in X Y here and in `slack`, which has |first| too: so
 * products that underflow, by 2^-150, stay below the bound, and t cannot be rounded up to 0. Where
 * products might overflow, `slack` is infinite and nothing is rejected. */
HT_TARGET HT_INLINE __m256 before_start(corner_lanes a, corner_lanes b, corner_lanes c, __m256 u,
                                        __m256 v, __m256 w, const ready *r) {
    const __m256 first = _mm256_broadcast_ss(&r->first), slack = _mm256_broadcast_ss(&r->slack);
    const __m256 det = _mm256_add_ps(_mm256_add_ps(u, v), w);
    const __m256 z = /* negated, as the corners are */
        _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(u, a.z), _mm256_mul_ps(v, b.z)),
                      _mm256_mul_ps(w, c.z));
    const __m256 below = _mm256_add_ps(z, _mm256_mul_ps(first, det));
    const __m256 flip = _mm256_xor_ps(det, _mm256_broadcast_ss(&r->dz));
    const __m256 n = _mm256_xor_ps(below, _mm256_and_ps(flip, _mm256_set1_ps(-0.0f)));
    const __m256 xy = _mm256_mul_ps(larger(larger(a.x, b.x), c.x), larger(larger(a.y, b.y), c.y));
    const __m256 zs = _mm256_add_ps(larger(larger(a.z, b.z), c.z), slack);
    const __m256 bound = _mm256_mul_ps(_mm256_add_ps(xy, _mm256_set1_ps(HT_STREAM_LEAST)), zs);
    return _mm256_cmp_ps(n, _mm256_mul_ps(bound, _mm256_set1_ps(3.814697265625e-6f)), _CMP_GT_OQ);
}

HT_TARGET HT_INLINE uint32_t candidates(const ht_wide_leaf *leaf, const ready *r) {
    const corner_lanes a = shear_corner(leaf->v[0], r);
    const corner_lanes b = shear_corner(leaf->v[1], r);
    const corner_lanes c = shear_corner(leaf->v[2], r);
    const __m256 u = edge(c, b), v = edge(a, c), w = edge(b, a), zero = _mm256_setzero_ps();
    const __m256 least = _mm256_min_ps(_mm256_min_ps(u, v), w);
    const __m256 most = _mm256_max_ps(_mm256_max_ps(u, v), w);
    const __m256 outside = _mm256_and_ps(_mm256_cmp_ps(least, zero, _CMP_LT_OQ),
                                         _mm256_cmp_ps(most, zero, _CMP_GT_OQ));
    const __m256 idle = _mm256_load_ps((const float *)(const void *)leaf->prim);
    const __m256 before = before_start(a, b, c, u, v, w, r);
    const __m256 rejected = _mm256_or_ps(_mm256_or_ps(outside, idle), before);
    return 255 & ~(uint32_t)_mm256_movemask_ps(rejected);
}

#endif
