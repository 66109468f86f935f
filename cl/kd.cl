/* kd.cl: twin of lib/trace/kd.c. */

void walk_kd(__global const ht_scene *scene, __global const void *slots,
             __global const float *triangles, __global const void *leaves, const ht_ray *r,
             ht_hit *hit, const bool any) {
    __global const ht_kd_node *nodes = (__global const ht_kd_node *)slots;
    __global const uint *refs = (__global const uint *)leaves;
    ht_stack_entry stack[HT_STACK];
    ht_stack_entry here = {0, r->tnear, r->tfar};
    uint top = 0;
    for (;;) {
        __global const ht_kd_node *node = &nodes[here.slot];
        const uint axis = node->tag & 3;
        if (axis != HT_KD_LEAF) {
            const uint right = node->tag >> 2, left = here.slot + 1;
            const uint near_slot = r->negative[axis] ? right : left;
            const uint far_slot = r->negative[axis] ? left : right;
            const float near_exit = ht_ray_exit(r, axis, node->plane);
            const float far_entry = ht_ray_entry(r, axis, node->plane);
            if (far_entry > here.tfar) {
                here.slot = near_slot;
            } else if (near_exit < here.tnear) {
                here.slot = far_slot;
            } else {
                stack[top].slot = far_slot;
                stack[top].tnear = ht_max(here.tnear, far_entry);
                stack[top++].tfar = here.tfar;
                here.slot = near_slot;
                here.tfar = ht_min(here.tfar, near_exit);
            }
            continue;
        }
        const uint first = as_uint(node->plane), count = node->tag >> 2;
        for (uint i = 0; i < count; ++i) {
            if (ht_triangle_intersect(r, triangles, refs[first + i], hit) && any) return;
        }
        do {
            if (top == 0) return;
            here = stack[--top];
        } while (here.tnear > hit->t);
        here.tfar = ht_min(here.tfar, hit->t);
    }
}

HT_KERNELS(walk_kd)
