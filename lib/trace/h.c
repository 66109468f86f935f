/* h.c: walks an H-tree (section 8): the ray's interval is clipped by two planes at an SKD node, and
 * by two or six at a bounding node; the nearer child goes first, the other waits with its interval.
 */
#include "trace.h"

/* Both children of an SKD node may be entered, and their intervals may overlap. */
HT_INLINE bool step_skd(const ht_h_node *node, uint32_t at, const ht_ray *r, ht_stack_entry *here,
                        ht_stack_entry *stack, uint32_t *top) {
    const uint32_t axis = node->tag - HT_H_SKD;
    const bool negative = r->negative[axis] != 0;
    const uint32_t near_slot = negative ? node->child : at + 1;
    const uint32_t far_slot = negative ? at + 1 : node->child;
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

/* Follows a bounding node to its child; false if the ray misses what it bounds. */
HT_INLINE bool step_bound(const ht_h_node *node, uint32_t at, const ht_ray *r,
                          ht_stack_entry *here) {
    if (node->tag == HT_H_BV6) {
        ht_h_bv6 bv6;
        memcpy(&bv6, node, sizeof bv6);
        ht_ray_clip_box(r, bv6.lo, bv6.hi, &here->tnear, &here->tfar);
        here->slot = at + 2;
    } else {
        ht_ray_clip(r, node->tag - HT_H_BV2, node->a, node->b, &here->tnear, &here->tfar);
        here->slot = at + 1;
    }
    return here->tnear <= here->tfar;
}

HT_INLINE void walk_h(const htree *tree, const htree_ray *ray, const ht_ray *r, htree_hit *hit,
                      htree_counters *counters, const bool any, const bool counted) {
    const ht_h_node *nodes = (const ht_h_node *)tree->nodes;
    ht_stack_entry stack[HT_MAX_DEPTH];
    ht_stack_entry here = {0, r->tnear, r->tfar};
    uint32_t top = 0;
    for (;;) {
        const ht_h_node *node = &nodes[here.slot];
        bool inside;
        if (counted) ++counters->traversal_steps;
        if (node->tag >= HT_H_SKD && node->tag < HT_H_BV2) {
            inside = step_skd(node, here.slot, r, &here, stack, &top);
        } else if (node->tag == HT_H_LEAF) {
            if (counted) {
                ++counters->leaf_steps;
                ++counters->intersections;
            }
            if (ht_intersect_prim(tree, node->child, ray, r, hit) && any) return;
            inside = false;
        } else if (node->tag == HT_H_LINK) {
            here.slot = node->child;
            inside = true;
        } else {
            inside = step_bound(node, here.slot, r, &here);
        }
        if (inside) continue;
        /* Strictly beyond the best hit: at equal t a lower prim may still win. */
        do {
            if (top == 0) return;
            here = stack[--top];
        } while (here.tnear > hit->t);
        here.tfar = ht_min(here.tfar, hit->t);
    }
}

HT_DEFINE_WALKS(ht_h_walks, walk_h);
