/* kd.c: walks a kd-tree by intervals (Havran 2000, recursive ray traversal). A plane ends the near
 * child's interval a pad late and begins the far child's a pad early, so that a hit in the plane is
 * found from both sides; the walk ends when everything left lies strictly beyond the best hit. */
#include "trace.h"

/* Tests the prims of a leaf; with `any`, true at the first hit. */
HT_INLINE bool intersect_leaf(const htree *tree, const ht_kd_node *node, const htree_ray *ray,
                              const ht_ray *r, htree_hit *hit, htree_counters *counters,
                              const bool any, const bool counted) {
    uint32_t first;
    memcpy(&first, &node->plane, sizeof first);
    const uint32_t count = node->tag >> 2;
    if (counted) {
        ++counters->leaf_steps;
        counters->intersections += count;
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (ht_intersect_prim(tree, tree->refs[first + i], ray, r, hit) && any) return true;
    }
    return false;
}

HT_INLINE void walk_kd(const htree *tree, const htree_ray *ray, const ht_ray *r, htree_hit *hit,
                       htree_counters *counters, const bool any, const bool counted) {
    const ht_kd_node *nodes = (const ht_kd_node *)tree->nodes;
    ht_stack_entry stack[HT_MAX_DEPTH];
    ht_stack_entry here = {0, r->tnear, r->tfar};
    uint32_t top = 0;
    for (;;) {
        const ht_kd_node *node = &nodes[here.slot];
        const uint32_t axis = node->tag & 3;
        if (counted) ++counters->traversal_steps;
        if (axis != HT_KD_LEAF) {
            const uint32_t right = node->tag >> 2, left = here.slot + 1;
            const uint32_t near_slot = r->negative[axis] ? right : left;
            const uint32_t far_slot = r->negative[axis] ? left : right;
            const float near_exit = ht_ray_exit(r, axis, node->plane);
            const float far_entry = ht_ray_entry(r, axis, node->plane);
            if (far_entry > here.tfar) {
                here.slot = near_slot;
            } else if (near_exit < here.tnear) {
                here.slot = far_slot;
            } else {
                const ht_stack_entry later = {far_slot, ht_max(here.tnear, far_entry), here.tfar};
                stack[top++] = later;
                here.slot = near_slot;
                here.tfar = ht_min(here.tfar, near_exit);
            }
            continue;
        }
        if (intersect_leaf(tree, node, ray, r, hit, counters, any, counted)) return;
        /* Strictly beyond the best hit: at equal t a lower prim may still win. */
        do {
            if (top == 0) return;
            here = stack[--top];
        } while (here.tnear > hit->t);
        here.tfar = ht_min(here.tfar, hit->t);
    }
}

HT_DEFINE_WALKS(ht_kd_walks, walk_kd);
