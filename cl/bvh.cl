/* bvh.cl: twin of lib/trace/bvh.c. */

bool box_interval(__global const ht_bvh_node *node, const ht_ray *r, float tfar, float *tnear) {
    *tnear = r->tnear;
    for (uint axis = 0; axis < 3; ++axis)
        ht_ray_clip(r, axis, node->lo[axis], node->hi[axis], tnear, &tfar);
    return *tnear <= tfar;
}

void walk_bvh(__global const ht_scene *scene, __global const void *slots,
              __global const float *triangles, __global const void *leaves, const ht_ray *r,
              ht_hit *hit, const bool any) {
    __global const ht_bvh_node *nodes = (__global const ht_bvh_node *)slots;
    uint waiting[HT_STACK];
    float waiting_tnear[HT_STACK];
    uint top = 0, slot = 0;
    float tnear;
    if (!box_interval(&nodes[0], r, hit->t, &tnear)) return;
    for (;;) {
        __global const ht_bvh_node *node = &nodes[slot];
        if (node->tag == HT_BVH_LEAF) {
            if (ht_triangle_intersect(r, triangles, node->child, hit) && any) return;
        } else {
            const uint first = node->child + r->negative[node->tag];
            const uint second = node->child + 1 - r->negative[node->tag];
            float t_first, t_second;
            const bool hits_first = box_interval(&nodes[first], r, hit->t, &t_first);
            const bool hits_second = box_interval(&nodes[second], r, hit->t, &t_second);
            if (hits_first && hits_second) {
                waiting[top] = second;
                waiting_tnear[top++] = t_second;
            }
            if (hits_first || hits_second) {
                slot = hits_first ? first : second;
                continue;
            }
        }
        do {
            if (top == 0) return;
            --top;
        } while (waiting_tnear[top] > hit->t);
        slot = waiting[top];
    }
}

HT_KERNELS(walk_bvh)
