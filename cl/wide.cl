/* wide.cl: twin of lib/trace/wide.c; eight lanes are one vector. */

float8 max8(float8 a, float8 b) {
    return b > a ? b : a;
}

float8 min8(float8 a, float8 b) {
    return b < a ? b : a;
}

/* A bit for every lane that is true: OpenCL C has no word for the instruction that CPUs have for it,
 * which is worth a sixth of the time. */
uint lanes_of(int8 lanes) {
#ifdef __AVX__
    typedef __attribute__((__vector_size__(32))) float ymm;
    return (uint)__builtin_ia32_movmskps256(__builtin_astype(lanes, ymm));
#else
    const int8 bits = lanes & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
    const int4 four = bits.lo | bits.hi;
    const int2 two = four.lo | four.hi;
    return (uint)(two.x | two.y);
#endif
}

uint lowest_lane(uint mask) {
    return 31 - clz(mask & (0 - mask));
}

/* Children that the ray meets before tfar, as a mask, and where it enters them. */
uint meet_children(__global const ht_wide_node *node, const ht_ray *r, float tfar, float *entry) {
    __global const float8 *planes = (__global const float8 *)node;
    float8 enter = (float8)(r->tnear), leave = (float8)(tfar);
    for (uint axis = 0; axis < 3; ++axis) {
        const uint far = r->negative[axis] ? 0 : 3;
        enter = max8(enter, (planes[axis + 3 - far] - r->entry[axis]) * r->rdir[axis]);
        leave = min8(leave, (planes[axis + far] - r->exit[axis]) * r->rdir[axis]);
    }
    *(float8 *)entry = enter;
    return lanes_of(enter <= leave);
}

typedef struct corners {
    float8 x, y, z;
} corners;

corners shear_lanes(__global const ht_wide_leaf *leaf, uint corner, const ht_ray *r) {
    __global const float8 *v = (__global const float8 *)leaf + 3 * corner;
    corners c;
    c.z = v[r->kz] - r->oz;
    c.x = (v[r->kx] - r->ox) - r->sx * c.z;
    c.y = (v[r->ky] - r->oy) - r->sy * c.z;
    return c;
}

/* A corner of one lane, once more: cheaper than to keep 72 floats for the few that need them. */
ht_corner shear_lane(__global const ht_wide_leaf *leaf, uint corner, uint lane, const ht_ray *r) {
    return ht_ray_corner(r, leaf->v[corner][r->kx][lane], leaf->v[corner][r->ky][lane],
                         leaf->v[corner][r->kz][lane]);
}

/* Tests the triangles of a leaf; with `any`, true at the first hit. */
bool intersect_leaf(__global const ht_wide_leaf *leaf, const ht_ray *r, ht_hit *hit,
                    const bool any) {
    const corners a = shear_lanes(leaf, 0, r);
    const corners b = shear_lanes(leaf, 1, r);
    const corners c = shear_lanes(leaf, 2, r);
    const float8 u = c.x * b.y - c.y * b.x;
    const float8 v = a.x * c.y - a.y * c.x;
    const float8 w = b.x * a.y - b.y * a.x;
    const int8 outside = (u < 0 | v < 0 | w < 0) & (u > 0 | v > 0 | w > 0);
    const int8 idle = ((__global const int8 *)leaf->prim)[0] < 0;
    uint mask = 255 & ~lanes_of(outside | idle);
    for (; mask; mask &= mask - 1) {
        const uint i = lowest_lane(mask);
        const ht_corner p = shear_lane(leaf, 0, i, r), q = shear_lane(leaf, 1, i, r);
        if (ht_triangle_verdict(r, p, q, shear_lane(leaf, 2, i, r), leaf->prim[i], hit) && any)
            return true;
    }
    return false;
}

typedef struct wide_entry {
    uint child;
    float tnear;
} wide_entry;

/* Follows the nearest child in *here and leaves the others on the stack, the farthest at the
 * bottom; the first hit that comes will do for `any`, so there the order is as it is. */
uint push_children(__global const ht_wide_node *node, uint mask, const float *entry,
                   wide_entry *here, wide_entry *stack, uint top, const bool any) {
    const uint bottom = top, first = lowest_lane(mask);
    here->child = node->child[first];
    here->tnear = entry[first];
    for (mask &= mask - 1; mask; mask &= mask - 1) {
        const uint i = lowest_lane(mask);
        wide_entry later = {node->child[i], entry[i]};
        if (!any && later.tnear < here->tnear) {
            const wide_entry nearer = later;
            later = *here;
            *here = nearer;
        }
        uint k = top++;
        for (; !any && k > bottom && stack[k - 1].tnear < later.tnear; --k) stack[k] = stack[k - 1];
        stack[k] = later;
    }
    return top;
}

void walk_wide(__global const ht_scene *scene, __global const void *slots,
               __global const float *triangles, __global const void *blocks, const ht_ray *r,
               ht_hit *hit, const bool any) {
    __global const ht_wide_node *nodes = (__global const ht_wide_node *)slots;
    __global const ht_wide_leaf *leaves = (__global const ht_wide_leaf *)blocks;
    wide_entry stack[HT_STACK];
    wide_entry here = {0, r->tnear};
    float entry[8] __attribute__((aligned(32)));
    uint top = 0;
    for (;;) {
        if (here.child & HT_WIDE_LEAF) {
            if (intersect_leaf(&leaves[here.child & ~HT_WIDE_LEAF], r, hit, any)) return;
        } else {
            __global const ht_wide_node *node = &nodes[here.child];
            const uint mask = meet_children(node, r, hit->t, entry);
            if (mask) {
                top = push_children(node, mask, entry, &here, stack, top, any);
                continue;
            }
        }
        do {
            if (top == 0) return;
            here = stack[--top];
        } while (here.tnear > hit->t);
    }
}

HT_KERNELS(walk_wide)
