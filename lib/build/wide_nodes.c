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

/* Triangles to the front, objects behind them; returns how many triangles. */
static uint32_t order_prims(const ht_source *source, const uint32_t *prims, uint32_t count,
                            uint32_t *lanes) {
    uint32_t triangles = 0, end = count;
    for (uint32_t i = 0; i < HT_LANES; ++i) lanes[i] = HTREE_NONE;
    for (uint32_t i = 0; i < count; ++i) {
        const bool triangle = prims[i] < source->triangle_count;
        lanes[triangle ? triangles++ : --end] = prims[i];
    }
    return triangles;
}

/* Four triangles at a time, which come corner by corner and go coordinate by coordinate. */
ht_box4 ht_wide_write_leaf(const ht_source *from, const uint32_t *prims, uint32_t count,
                           ht_wide_leaf *leaf) {
    const ht_source source = *from; /* which no store can change */
    const uint32_t triangles = order_prims(from, prims, count, leaf->prim);
    ht_box4 box = ht_box4_empty();
    for (uint32_t half = 0; half < HT_LANES; half += 4) {
        ht_f4 rows[3][4];
        for (uint32_t i = 0; i < 4; ++i) {
            const ht_f4 zero = ht_f4_all(0);
            ht_corners c = {{zero, zero, zero}};
            if (half + i < triangles) {
                c = ht_source_corners(&source, leaf->prim[half + i]);
                const ht_box4 one = ht_corners_box(&c);
                ht_box4_add(&box, one.lo, one.hi);
            }
            for (uint32_t k = 0; k < 3; ++k) rows[k][i] = c.v[k];
        }
        for (uint32_t k = 0; k < 3; ++k) {
            ht_f4_transpose(rows[k]);
            for (uint32_t axis = 0; axis < 3; ++axis)
                ht_f4_store(&leaf->v[k][axis][half], rows[k][axis]);
        }
    }
    for (uint32_t i = triangles; i < count; ++i) {
        ht_prim object;
        ht_source_prim(&source, leaf->prim[i], &object);
        ht_box4_add(&box, ht_f4_load(object.lo), ht_f4_load(object.hi));
    }
    return box;
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

/* How far out a box lies in the direction of each lane: the corner of a cube that its number is. */
static void lane_worths(const htree_box *box, const htree_box *all, float worth[HT_LANES]) {
    float offset[3];
    for (int k = 0; k < 3; ++k) offset[k] = (box->lo[k] - all->lo[k]) - (all->hi[k] - box->hi[k]);
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        worth[lane] = (lane & 1 ? offset[0] : -offset[0]) + (lane & 2 ? offset[1] : -offset[1]) +
                      (lane & 4 ? offset[2] : -offset[2]);
    }
}

/* Gives every run in turn the free lane that suits it best. */
static void assign_lanes(const ht_wide_run *runs, uint32_t count, const htree_box *all,
                         uint32_t lane[HT_LANES]) {
    uint32_t taken = 0;
    for (uint32_t i = 0; i < count; ++i) {
        float worth[HT_LANES], best = -INFINITY;
        lane_worths(&runs[i].box, all, worth);
        for (uint32_t k = 0; k < HT_LANES; ++k) {
            const bool better = !(taken >> k & 1) && worth[k] >= best;
            best = better ? worth[k] : best;
            lane[i] = better ? k : lane[i];
        }
        taken |= 1u << lane[i];
    }
}

static void write_box(ht_wide_node *node, uint32_t lane, const htree_box *box) {
    for (uint32_t axis = 0; axis < 3; ++axis) {
        node->lo[axis][lane] = box->lo[axis];
        node->hi[axis][lane] = box->hi[axis];
    }
}

void ht_wide_fill_node(ht_wide_node *node, const ht_wide_run *runs, uint32_t count,
                       const htree_box *box, uint32_t lane[HT_LANES]) {
    const htree_box nothing = ht_box_empty();
    assign_lanes(runs, count, box, lane);
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        write_box(node, i, &nothing);
        node->child[i] = HT_WIDE_NONE;
        node->unused[i] = 0;
    }
    for (uint32_t i = 0; i < count; ++i) write_box(node, lane[i], &runs[i].box);
}

htree_status ht_wide_write_node(ht_wide_part *part, const ht_wide_run *runs, uint32_t count,
                                const htree_box *box, uint32_t lane[HT_LANES], uint32_t *slot) {
    *slot = (uint32_t)part->nodes.count;
    ht_wide_node *node = (ht_wide_node *)ht_array_add(&part->nodes);
    if (!node) return HTREE_ERROR_MEMORY;
    ht_wide_fill_node(node, runs, count, box, lane);
    return HTREE_OK;
}
