/* bvh.c: walks a bounding volume hierarchy: both children's boxes at once, the nearer one first. */
#include "trace.h"

HT_INLINE bool box_interval(const ht_bvh_node *node, const ht_ray *r, float tfar, float *tnear) {
    *tnear = r->tnear;
    ht_ray_clip_box(r, node->lo, node->hi, tnear, &tfar);
    return *tnear <= tfar;
}

HT_INLINE void walk_bvh(const htree *tree, const htree_ray *ray, const ht_ray *r, htree_hit *hit,
                        htree_counters *counters, const bool any, const bool counted) {
    const ht_bvh_node *nodes = (const ht_bvh_node *)tree->nodes;
    ht_stack_entry stack[HT_MAX_DEPTH];
    uint32_t top = 0, slot = 0;
    float tnear;
    if (counted) ++counters->traversal_steps;
    if (!box_interval(&nodes[0], r, hit->t, &tnear)) return;
    for (;;) {
        const ht_bvh_node *node = &nodes[slot];
        if (node->tag == HT_BVH_LEAF) {
            if (counted) {
                ++counters->leaf_steps;
                ++counters->intersections;
            }
            if (ht_intersect_prim(tree, node->child, ray, r, hit) && any) return;
        } else {
            const uint32_t first = node->child + r->negative[node->tag];
            const uint32_t second = node->child + 1 - r->negative[node->tag];
            float t_first, t_second;
            const bool hits_first = box_interval(&nodes[first], r, hit->t, &t_first);
            const bool hits_second = box_interval(&nodes[second], r, hit->t, &t_second);
            if (counted) counters->traversal_steps += 2;
            if (hits_first && hits_second) {
                const ht_stack_entry later = {second, t_second, 0};
                stack[top++] = later;
            }
            if (hits_first || hits_second) {
                slot = hits_first ? first : second;
                continue;
            }
        }
        /* Strictly beyond the best hit: at equal t a lower prim may still win. */
        do {
            if (top == 0) return;
            --top;
        } while (stack[top].tnear > hit->t);
        slot = stack[top].slot;
    }
}

HT_DEFINE_WALKS(ht_bvh_walks, walk_bvh);
