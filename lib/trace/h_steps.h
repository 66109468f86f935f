/* h_steps.h: what a ray does at each node type of an H-tree (section 8): shared by the walk and
 * by the measurement of what it costs. */
#ifndef HT_H_STEPS_H
#define HT_H_STEPS_H

#include "trace.h"

/* Both children of an SKD node may be entered, and their intervals may overlap. */
HT_INLINE bool step_skd(const ht_h_node *node, uint32_t axis, const ht_ray *r, ht_stack_entry *here,
                        ht_stack_entry *stack, uint32_t *top) {
    const bool negative = r->negative[axis] != 0;
    const uint32_t left_slot = here->slot + 1;
    const uint32_t near_slot = negative ? node->child : left_slot;
    const uint32_t far_slot = negative ? left_slot : node->child;
    /* left ends at plane a, right begins at plane b: a ray against the axis meets right first. */
    const float near_exit = ht_min(here->tfar, ht_ray_exit(r, axis, negative ? node->b : node->a));
    const float far_entry =
        ht_max(here->tnear, ht_ray_entry(r, axis, negative ? node->a : node->b));
    if (here->tnear <= near_exit) {
        if (far_entry <= here->tfar) {
            const ht_stack_entry later = {far_slot, far_entry, here->tfar};
            stack[(*top)++] = later;
        }
        here->slot = near_slot;
        here->tfar = near_exit;
        return true;
    }
    here->slot = far_slot;
    here->tnear = far_entry;
    return far_entry <= here->tfar;
}

/* Clips by the planes of a BVO node one by one, and returns the slots that the node takes. */
static uint32_t clip_planes(const ht_ray *r, const ht_h_node *node, float *tnear, float *tfar) {
    const uint32_t planes = node->tag >> HT_H_TAG_BITS;
    uint32_t k = 0;
    for (uint32_t i = 0; i < 6; ++i) {
        if (!(planes >> i & 1)) continue;
        const uint32_t axis = i % 3;
        const float plane = ht_h_plane(node, k++);
        if ((i < 3) != (r->negative[axis] != 0)) {
            *tnear = ht_max(*tnear, ht_ray_entry(r, axis, plane));
        } else {
            *tfar = ht_min(*tfar, ht_ray_exit(r, axis, plane));
        }
    }
    return k > 3 ? 2 : 1;
}

/* Follows a bounding node to its child; false if the ray misses what it bounds. */
HT_INLINE bool step_bound(const ht_h_node *node, uint32_t type, const ht_ray *r,
                          ht_stack_entry *here) {
    if (type == HT_H_BV6) {
        float lo[3], hi[3];
        memcpy(lo, &node[0].a, sizeof lo);
        memcpy(hi, &node[1].a, sizeof hi);
        ht_ray_clip_box(r, lo, hi, &here->tnear, &here->tfar);
        here->slot += 2;
    } else if (type < HT_H_BV6) {
        ht_ray_clip(r, type - HT_H_BV2, node->a, node->b, &here->tnear, &here->tfar);
        here->slot += 1;
    } else {
        /* Copies: the address of the interval would keep it out of registers. */
        float tnear = here->tnear, tfar = here->tfar;
        here->slot += clip_planes(r, node, &tnear, &tfar);
        here->tnear = tnear;
        here->tfar = tfar;
    }
    return here->tnear <= here->tfar;
}

#endif
