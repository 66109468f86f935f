/* h.c: walks an H-tree (section 8): the ray's interval is clipped by two planes at an SKD node, and
 * by two or six at a bounding node; the nearer child goes first, the other waits with its interval.
 */
#include "h_steps.h"

HT_INLINE void walk_h(const htree *tree, const htree_ray *ray, const ht_ray *r, htree_hit *hit,
                      htree_counters *counters, const bool any, const bool counted) {
    const ht_h_node *nodes = (const ht_h_node *)tree->nodes;
    ht_stack_entry stack[HT_MAX_DEPTH];
    ht_stack_entry here = {0, r->tnear, r->tfar};
    uint32_t top = 0;
    for (;;) {
        const ht_h_node *node = &nodes[here.slot];
        const uint32_t type = node->tag & HT_H_TYPE;
        bool inside = false;
        if (counted) ++counters->traversal_steps;
        if (type == HT_H_LEAF) {
            if (counted) {
                ++counters->leaf_steps;
                ++counters->intersections;
            }
            if (ht_intersect_prim(tree, node->child, ray, r, hit) && any) return;
        } else if (type < HT_H_BV2) {
            const uint32_t shelf = node->tag >> HT_H_TAG_BITS;
            /* A shelf goes first: large objects are likely hits (section 8). */
            if (HT_UNLIKELY(shelf)) {
                const ht_stack_entry whole = {shelf, here.tnear, here.tfar};
                if (step_skd(node, type - HT_H_SKD, r, &here, stack, &top)) stack[top++] = here;
                here = whole;
                inside = true;
            } else {
                inside = step_skd(node, type - HT_H_SKD, r, &here, stack, &top);
            }
        } else if (type != HT_H_LINK) {
            inside = step_bound(node, type, r, &here);
        } else {
            here.slot = node->child;
            inside = true;
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
