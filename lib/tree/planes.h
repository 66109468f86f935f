/* planes.h: sets of bounding planes, and the planes of bounding nodes. */
#ifndef HT_PLANES_H
#define HT_PLANES_H

#include "base/vec.h"
#include "layout.h"

/* Bit i of a set is plane i of layout.h. */
HT_INLINE uint32_t ht_slab_planes(uint32_t axis) {
    return 9u << axis;
}

/* The axis of a set that is the two planes of one axis; 3 for any other set. */
HT_INLINE uint32_t ht_slab_axis(uint32_t planes) {
    return planes == 9 ? 0 : planes == 18 ? 1 : planes == 36 ? 2 : 3;
}

HT_INLINE uint32_t ht_plane_count(uint32_t planes) {
    uint32_t count = 0;
    for (; planes; planes &= planes - 1) ++count;
    return count;
}

/* Plane k of those that a bounding node holds. */
HT_INLINE float ht_h_plane(const ht_h_node *node, uint32_t k) {
    const ht_h_node *slot = &node[k / 3];
    float plane = k % 3 == 0 ? slot->a : slot->b;
    if (k % 3 == 2) memcpy(&plane, &slot->child, sizeof plane);
    return plane;
}

HT_INLINE void ht_h_set_plane(ht_h_node *node, uint32_t k, float plane) {
    ht_h_node *slot = &node[k / 3];
    if (k % 3 == 0) slot->a = plane;
    if (k % 3 == 1) slot->b = plane;
    if (k % 3 == 2) memcpy(&slot->child, &plane, sizeof plane);
}

/* The planes that a bounding node holds, and the slots that it takes. */
HT_INLINE uint32_t ht_h_bound_planes(const ht_h_node *node) {
    const uint32_t type = node->tag & HT_H_TYPE;
    return type == HT_H_BVO   ? node->tag >> HT_H_TAG_BITS
           : type == HT_H_BV6 ? HT_ALL_PLANES
                              : ht_slab_planes(type - HT_H_BV2);
}

/* *box cut by the planes of `set` in `by`. */
HT_INLINE void ht_cut_by_planes(htree_box *box, uint32_t set, const htree_box *by) {
    for (uint32_t i = 0; i < 3; ++i) {
        if (set >> i & 1) box->lo[i] = ht_max(box->lo[i], by->lo[i]);
        if (set >> (3 + i) & 1) box->hi[i] = ht_min(box->hi[i], by->hi[i]);
    }
}

#endif
