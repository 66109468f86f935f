/* h.cl: twin of lib/trace/h.c and h_steps.h; walks SKD-, H- and AH-trees. */

/* Both children of an SKD node may be entered, and their intervals may overlap. */
bool step_skd(__global const ht_h_node *node, uint axis, const ht_ray *r, ht_stack_entry *here,
              ht_stack_entry *stack, uint *top) {
    const bool negative = r->negative[axis] != 0;
    const uint left_slot = here->slot + 1;
    const uint near_slot = negative ? node->child : left_slot;
    const uint far_slot = negative ? left_slot : node->child;
    const float near_exit = ht_min(here->tfar, ht_ray_exit(r, axis, negative ? node->b : node->a));
    const float far_entry =
        ht_max(here->tnear, ht_ray_entry(r, axis, negative ? node->a : node->b));
    if (here->tnear <= near_exit) {
        if (far_entry <= here->tfar) {
            stack[*top].slot = far_slot;
            stack[*top].tnear = far_entry;
            stack[*top].tfar = here->tfar;
            ++*top;
        }
        here->slot = near_slot;
        here->tfar = near_exit;
        return true;
    }
    here->slot = far_slot;
    here->tnear = far_entry;
    return far_entry <= here->tfar;
}

/* Plane k of those that a bounding node holds. */
float h_plane(__global const ht_h_node *node, uint k) {
    __global const ht_h_node *slot = &node[k / 3];
    return k % 3 == 0 ? slot->a : k % 3 == 1 ? slot->b : as_float(slot->child);
}

void clip_planes(__global const ht_h_node *node, const ht_ray *r, ht_stack_entry *here) {
    const uint planes = node->tag >> HT_H_TAG_BITS;
    uint k = 0;
    for (uint i = 0; i < 6; ++i) {
        if (!(planes >> i & 1)) continue;
        const uint axis = i % 3;
        const float plane = h_plane(node, k++);
        if ((i < 3) != (r->negative[axis] != 0)) {
            here->tnear = ht_max(here->tnear, ht_ray_entry(r, axis, plane));
        } else {
            here->tfar = ht_min(here->tfar, ht_ray_exit(r, axis, plane));
        }
    }
    here->slot += k > 3 ? 2 : 1;
}

/* Follows a bounding node to its child; false if the ray misses what it bounds. */
bool step_bound(__global const ht_h_node *node, uint type, const ht_ray *r, ht_stack_entry *here) {
    if (type == HT_H_BV6) {
        ht_ray_clip(r, 0, node[0].a, node[1].a, &here->tnear, &here->tfar);
        ht_ray_clip(r, 1, node[0].b, node[1].b, &here->tnear, &here->tfar);
        ht_ray_clip(r, 2, as_float(node[0].child), as_float(node[1].child), &here->tnear,
                    &here->tfar);
        here->slot += 2;
    } else if (type < HT_H_BV6) {
        ht_ray_clip(r, type - HT_H_BV2, node->a, node->b, &here->tnear, &here->tfar);
        here->slot += 1;
    } else {
        clip_planes(node, r, here);
    }
    return here->tnear <= here->tfar;
}

void walk_h(__global const ht_scene *scene, __global const void *slots,
            __global const float *triangles, __global const void *leaves, const ht_ray *r,
            ht_hit *hit, const bool any) {
    __global const ht_h_node *nodes = (__global const ht_h_node *)slots;
    ht_stack_entry stack[HT_STACK];
    ht_stack_entry here = {0, r->tnear, r->tfar};
    uint top = 0;
    for (;;) {
        __global const ht_h_node *node = &nodes[here.slot];
        const uint type = node->tag & HT_H_TYPE;
        bool inside = false;
        if (type == HT_H_LEAF) {
            if (ht_triangle_intersect(r, triangles, node->child, hit) && any) return;
        } else if (type < HT_H_BV2) {
            const uint shelf = node->tag >> HT_H_TAG_BITS;
            if (shelf) {
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
        do {
            if (top == 0) return;
            here = stack[--top];
        } while (here.tnear > hit->t);
        here.tfar = ht_min(here.tfar, hit->t);
    }
}

HT_KERNELS(walk_h)
