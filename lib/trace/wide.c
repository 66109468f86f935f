/* wide.c: walks a wide tree: eight boxes at a step, nearest first, and eight triangles a leaf. The
 * loops over lanes are what compilers turn into vector instructions; every lane does what
 * ht_ray_clip_box and ht_triangle_intersect do, in the same order, so the bits are the same. */
#include "trace.h"

typedef struct wide_entry {
    uint32_t child;
    float tnear;
} wide_entry;

/* Pushes the children that the ray meets before tfar, the farthest first. */
HT_INLINE uint32_t push_children(const ht_wide_node *node, const ht_ray *r, float tfar,
                                 wide_entry *stack, uint32_t top) {
    float entry[HT_LANES], leave[HT_LANES];
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        entry[i] = r->tnear;
        leave[i] = tfar;
    }
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const float *const from = r->negative[axis] ? node->hi[axis] : node->lo[axis];
        const float *const to = r->negative[axis] ? node->lo[axis] : node->hi[axis];
        for (uint32_t i = 0; i < HT_LANES; ++i) {
            entry[i] = ht_max(entry[i], ht_ray_entry(r, axis, from[i]));
            leave[i] = ht_min(leave[i], ht_ray_exit(r, axis, to[i]));
        }
    }
    const uint32_t bottom = top;
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        if (!(entry[i] <= leave[i])) continue;
        uint32_t k = top++;
        for (; k > bottom && stack[k - 1].tnear < entry[i]; --k) stack[k] = stack[k - 1];
        stack[k].child = node->child[i];
        stack[k].tnear = entry[i];
    }
    return top;
}

/* A bit for every lane that the float signs do not reject: see triangle.h. The sheared corners
 * go to p, for the verdict. */
HT_INLINE uint32_t leaf_candidates(const ht_wide_leaf *leaf, const ht_shear *s,
                                   float p[3][3][HT_LANES]) {
    for (uint32_t c = 0; c < 3; ++c) {
        const float *const x = leaf->v[c][s->kx], *const y = leaf->v[c][s->ky];
        const float *const z = leaf->v[c][s->kz];
        for (uint32_t i = 0; i < HT_LANES; ++i) {
            p[c][2][i] = z[i] - s->org[s->kz];
            p[c][0][i] = (x[i] - s->org[s->kx]) - s->sx * p[c][2][i];
            p[c][1][i] = (y[i] - s->org[s->ky]) - s->sy * p[c][2][i];
        }
    }
    uint32_t kept[HT_LANES], mask = 0;
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        const float u = p[2][0][i] * p[1][1][i] - p[2][1][i] * p[1][0][i];
        const float v = p[0][0][i] * p[2][1][i] - p[0][1][i] * p[2][0][i];
        const float w = p[1][0][i] * p[0][1][i] - p[1][1][i] * p[0][0][i];
        kept[i] = !(((u < 0) | (v < 0) | (w < 0)) & ((u > 0) | (v > 0) | (w > 0)));
    }
    for (uint32_t i = 0; i < HT_LANES; ++i) mask |= kept[i] << i;
    return mask;
}

/* Tests the prims of a leaf; with `any`, true at the first hit. */
HT_INLINE bool intersect_leaf(const htree *tree, const ht_wide_leaf *leaf, const htree_ray *ray,
                              const ht_ray *r, htree_hit *hit, const bool any) {
    const uint32_t count = ht_wide_leaf_count(leaf);
    float p[3][3][HT_LANES];
    uint32_t mask = leaf_candidates(leaf, &r->shear, p) & ((1u << count) - 1);
    for (uint32_t i = 0; mask; mask >>= 1, ++i) {
        if (!(mask & 1)) continue;
        const float a[3] = {p[0][0][i], p[0][1][i], p[0][2][i]};
        const float b[3] = {p[1][0][i], p[1][1][i], p[1][2][i]};
        const float c[3] = {p[2][0][i], p[2][1][i], p[2][2][i]};
        htree_hit found;
        if (!ht_triangle_verdict(r->shear.dz, a, b, c, r->tmin, hit->t, &found)) continue;
        if (any) return ht_keep_nearer(hit, &found, leaf->prim[i]);
        ht_keep_nearer(hit, &found, leaf->prim[i]);
    }
    for (uint32_t i = count; i > 0 && leaf->prim[i - 1] >= tree->triangle_count; --i) {
        if (!ht_meets_object(tree, leaf->prim[i - 1], r, hit->t)) continue;
        if (ht_intersect_prim(tree, leaf->prim[i - 1], ray, r, hit) && any) return true;
    }
    return false;
}

HT_INLINE void walk_wide(const htree *tree, const htree_ray *ray, const ht_ray *r, htree_hit *hit,
                         htree_counters *counters, const bool any, const bool counted) {
    wide_entry stack[HT_WIDE_STACK];
    ht_wide_node node_room;
    ht_wide_leaf leaf_room;
    uint32_t top = 0, child = 0;
    for (;;) {
        if (counted) ++counters->traversal_steps;
        child = ht_wide_resolve(tree, child);
        if (child & HT_WIDE_LEAF) {
            const uint32_t index = child & ~HT_WIDE_LEAF;
            const ht_wide_leaf *leaf = ht_wide_leaf_at(tree, index, &leaf_room);
            if (counted) {
                ++counters->leaf_steps;
                counters->intersections += ht_wide_leaf_count(leaf);
            }
            if (intersect_leaf(tree, leaf, ray, r, hit, any)) return;
        } else {
            const ht_wide_node *node = ht_wide_node_at(tree, child, &node_room);
            top = push_children(node, r, hit->t, stack, top);
        }
        /* Strictly beyond the best hit: at equal t a lower prim may still win. */
        do {
            if (top == 0) return;
            --top;
        } while (stack[top].tnear > hit->t);
        child = stack[top].child;
    }
}

HT_DEFINE_WALKS(ht_wide_walks, walk_wide);
