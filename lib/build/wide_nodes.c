/* wide_nodes.c: writes the leaves and nodes of wide trees. */
#include "wide.h"

void ht_wide_part_begin(ht_wide_part *part, ht_memory *memory) {
    part->deepest = 0;
    ht_array_begin(&part->nodes, memory, sizeof(ht_wide_node));
    ht_array_begin(&part->leaves, memory, sizeof(ht_wide_leaf_run));
}

void ht_wide_part_end(ht_wide_part *part) {
    ht_array_end(&part->leaves);
    ht_array_end(&part->nodes);
}

/* ---- Leaves --------------------------------------------------------------------------------- */

htree_status ht_wide_add_leaf(ht_wide_part *part, uint32_t first, uint32_t count, uint32_t *child) {
    *child = HT_WIDE_LEAF | (uint32_t)part->leaves.count;
    ht_wide_leaf_run *leaf = (ht_wide_leaf_run *)ht_array_add(&part->leaves);
    if (!leaf) return HTREE_ERROR_MEMORY;
    leaf->first = first;
    leaf->count = count;
    return HTREE_OK;
}

/* Triangles to the front, objects behind them. */
static void order_prims(const ht_source *source, const uint32_t *prims, uint32_t count,
                        uint32_t *lanes) {
    uint32_t triangles = 0, end = count;
    for (uint32_t i = 0; i < HT_LANES; ++i) lanes[i] = HT_WIDE_NONE;
    for (uint32_t i = 0; i < count; ++i) {
        const bool triangle = prims[i] < source->triangle_count;
        lanes[triangle ? triangles++ : --end] = prims[i];
    }
}

/* Four triangles at a time, which come corner by corner and go coordinate by coordinate. */
void ht_wide_write_corners(const ht_corners corners[HT_LANES], ht_wide_leaf *leaf) {
    for (uint32_t half = 0; half < HT_LANES; half += 4) {
        for (uint32_t k = 0; k < 3; ++k) {
            ht_f4 rows[4];
            for (uint32_t i = 0; i < 4; ++i) rows[i] = corners[half + i].v[k];
            ht_f4_transpose(rows);
            for (uint32_t axis = 0; axis < 3; ++axis)
                ht_f4_store(&leaf->v[k][axis][half], rows[axis]);
        }
    }
}

/* Four triangles at a time, which come corner by corner and go coordinate by coordinate. Idle lanes
 * read the first triangle again, which adds nothing to the box. */
static ht_box4 fill_with_triangles(const ht_source *source, uint32_t triangles,
                                   ht_wide_leaf *leaf) {
    static const float busy[2 * HT_LANES] = {-1, -1, -1, -1, -1, -1, -1, -1};
    const uint32_t first = leaf->prim[0];
    ht_box4 box = ht_box4_empty();
    for (uint32_t half = 0; half < HT_LANES; half += 4) {
        const ht_f4 live = ht_f4_load(&busy[HT_LANES - triangles + half]);
        ht_f4 rows[3][4];
        for (uint32_t i = 0; i < 4; ++i) {
            const uint32_t prim = half + i < triangles ? leaf->prim[half + i] : first;
            const ht_corners c = ht_source_corners(source, prim);
            const ht_box4 one = ht_corners_box(&c);
            ht_box4_add(&box, one.lo, one.hi);
            for (uint32_t k = 0; k < 3; ++k) rows[k][i] = c.v[k];
        }
        for (uint32_t k = 0; k < 3; ++k) {
            ht_f4_transpose(rows[k]);
            for (uint32_t axis = 0; axis < 3; ++axis)
                ht_f4_store(&leaf->v[k][axis][half],
                            ht_f4_by_sign(live, rows[k][axis], ht_f4_all(0)));
        }
    }
    return box;
}

static bool fill_eight(ht_isa isa, const ht_source *source, uint32_t triangles, ht_wide_leaf *leaf,
                       ht_box4 *box) {
#ifdef HT_X86
    return isa >= HT_AVX2 && ht_wide_fill_avx2(source, triangles, leaf, box);
#else
    (void)isa, (void)source, (void)triangles, (void)leaf, (void)box;
    return false;
#endif
}

ht_box4 ht_wide_fill_leaf(ht_isa isa, const ht_source *from, ht_wide_leaf *leaf) {
    const ht_source source = *from; /* which no store can change */
    ht_box4 box = ht_box4_empty();
    uint32_t triangles = 0;
    for (uint32_t i = 0; i < HT_LANES; ++i) triangles += leaf->prim[i] < source.triangle_count;
    if (triangles == 0)
        memset(leaf->v, 0, sizeof leaf->v);
    else if (!fill_eight(isa, &source, triangles, leaf, &box))
        box = fill_with_triangles(&source, triangles, leaf);
    for (uint32_t i = triangles; i < HT_LANES && leaf->prim[i] != HT_WIDE_NONE; ++i) {
        const ht_box4 object = ht_source_box(&source, leaf->prim[i]);
        ht_box4_add(&box, object.lo, object.hi);
    }
    return box;
}

ht_box4 ht_wide_write_leaf(ht_isa isa, const ht_source *source, const uint32_t *prims,
                           uint32_t count, ht_wide_leaf *leaf) {
    order_prims(source, prims, count, leaf->prim);
    return ht_wide_fill_leaf(isa, source, leaf);
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

/* The free lane that suits a box best: the farther out it lies towards a corner of the cube that the
 * lanes are, the more that corner is worth. */
static uint32_t best_lane(ht_f4 outward, uint32_t taken) {
    float far[4], most = -INFINITY;
    uint32_t best = HT_LANES;
    ht_f4_store(far, outward);
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        const float worth = (lane & 1 ? far[0] : -far[0]) + (lane & 2 ? far[1] : -far[1]) +
                            (lane & 4 ? far[2] : -far[2]);
        const bool better = !(taken >> lane & 1) && worth >= most;
        most = better ? worth : most;
        best = better ? lane : best;
    }
    return best;
}

/* Gives every run in turn the lane of the octant that it lies in, or else the best that is free. */
static void assign_lanes(const ht_wide_run *runs, uint32_t count, const ht_box4 *all,
                         uint32_t lane[HT_LANES]) {
    const ht_f4 middle = ht_f4_add(all->lo, all->hi);
    uint32_t taken = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const ht_f4 outward = ht_f4_sub(ht_f4_add(runs[i].box.lo, runs[i].box.hi), middle);
        const uint32_t octant = ~ht_f4_above(ht_f4_all(0), outward) & (HT_LANES - 1);
        lane[i] = HT_UNLIKELY(taken >> octant & 1) ? best_lane(outward, taken) : octant;
        taken |= 1u << lane[i];
    }
}

void ht_wide_fill_in_order(ht_wide_node *node, const ht_box4 *parts, const uint32_t *child,
                           uint32_t count) {
    ht_box4 boxes[HT_LANES];
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        boxes[i] = i < count ? parts[i] : ht_box4_empty();
        node->child[i] = i < count ? child[i] : HT_WIDE_NONE;
        node->unused[i] = 0;
    }
    ht_wide_set_planes(node, boxes);
}

void ht_wide_fill_node(ht_wide_node *node, const ht_wide_run *runs, uint32_t count,
                       const ht_box4 *box, uint32_t lane[HT_LANES]) {
    ht_box4 boxes[HT_LANES];
    assign_lanes(runs, count, box, lane);
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        boxes[i] = ht_box4_empty();
        node->child[i] = HT_WIDE_NONE;
        node->unused[i] = 0;
    }
    for (uint32_t i = 0; i < count; ++i) boxes[lane[i]] = runs[i].box;
    ht_wide_set_planes(node, boxes);
}

htree_status ht_wide_write_node(ht_wide_part *part, const ht_wide_run *runs, uint32_t count,
                                const ht_box4 *box, uint32_t lane[HT_LANES], uint32_t *slot) {
    *slot = (uint32_t)part->nodes.count;
    ht_wide_node *node = (ht_wide_node *)ht_array_add(&part->nodes);
    if (!node) return HTREE_ERROR_MEMORY;
    ht_wide_fill_node(node, runs, count, box, lane);
    return HTREE_OK;
}
