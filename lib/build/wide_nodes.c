/* wide_nodes.c: writes the leaves and nodes of wide trees. */
#include "wide.h"

void ht_wide_part_begin(ht_wide_part *part, ht_builder *builder) {
    part->builder = builder;
    part->deepest = 0;
    ht_array_begin(&part->nodes, &builder->tree->memory, sizeof(ht_wide_node));
    ht_array_begin(&part->leaves, &builder->tree->memory, sizeof(ht_wide_leaf));
}

void ht_wide_part_end(ht_wide_part *part) {
    ht_array_end(&part->leaves);
    ht_array_end(&part->nodes);
}

/* ---- Leaves --------------------------------------------------------------------------------- */

static void write_lane(const htree *tree, ht_wide_leaf *leaf, uint32_t prim) {
    const uint32_t lane = leaf->count++;
    leaf->prim[lane] = prim;
    if (prim >= tree->triangle_count) {
        ++leaf->objects;
        return;
    }
    const ht_triangle *triangle = &tree->triangles[prim];
    for (uint32_t corner = 0; corner < 3; ++corner) {
        for (uint32_t axis = 0; axis < 3; ++axis)
            leaf->v[corner][axis][lane] = triangle->v[corner][axis];
    }
}

/* User objects come last, so that the lanes of triangles are the first ones. */
htree_status ht_wide_write_leaf(ht_wide_part *part, const ht_wide_run *run, uint32_t *child) {
    const htree *tree = part->builder->tree;
    *child = HT_WIDE_LEAF | (uint32_t)part->leaves.count;
    ht_wide_leaf *leaf = (ht_wide_leaf *)ht_array_add(&part->leaves);
    if (!leaf) return HTREE_ERROR_MEMORY;
    for (uint32_t i = 0; i < run->count; ++i) {
        const uint32_t prim = ht_prim_id(&run->items[i]);
        if (prim < tree->triangle_count) write_lane(tree, leaf, prim);
    }
    for (uint32_t i = 0; i < run->count && leaf->count < run->count; ++i) {
        const uint32_t prim = ht_prim_id(&run->items[i]);
        if (prim >= tree->triangle_count) write_lane(tree, leaf, prim);
    }
    return ht_progress_step(&part->builder->progress, run->count) ? HTREE_OK
                                                                  : HTREE_ERROR_CANCELLED;
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

/* Gives every run a lane, the pairs that suit each other best first. */
static void assign_lanes(const ht_wide_run *runs, uint32_t count, const htree_box *all,
                         uint32_t lane[HT_LANES]) {
    float worth[HT_LANES][HT_LANES];
    uint32_t free_lanes = (1u << HT_LANES) - 1, free_runs = (1u << count) - 1;
    for (uint32_t i = 0; i < count; ++i) lane_worths(&runs[i].box, all, worth[i]);
    while (free_runs) {
        uint32_t best_run = 0, best_lane = 0;
        float best = -INFINITY;
        for (uint32_t i = 0; i < count; ++i) {
            if (!(free_runs >> i & 1)) continue;
            for (uint32_t k = 0; k < HT_LANES; ++k) {
                if (!(free_lanes >> k & 1) || !(worth[i][k] >= best)) continue;
                best = worth[i][k];
                best_run = i;
                best_lane = k;
            }
        }
        lane[best_run] = best_lane;
        free_runs &= ~(1u << best_run);
        free_lanes &= ~(1u << best_lane);
    }
}

static void write_box(ht_wide_node *node, uint32_t lane, const htree_box *box) {
    for (uint32_t axis = 0; axis < 3; ++axis) {
        node->lo[axis][lane] = box->lo[axis];
        node->hi[axis][lane] = box->hi[axis];
    }
}

htree_status ht_wide_write_node(ht_wide_part *part, const ht_wide_run *runs, uint32_t count,
                                const htree_box *box, uint32_t lane[HT_LANES], uint32_t *slot) {
    const htree_box nothing = ht_box_empty();
    *slot = (uint32_t)part->nodes.count;
    ht_wide_node *node = (ht_wide_node *)ht_array_add(&part->nodes);
    if (!node) return HTREE_ERROR_MEMORY;
    assign_lanes(runs, count, box, lane);
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        write_box(node, i, &nothing);
        node->child[i] = HT_WIDE_NONE;
    }
    for (uint32_t i = 0; i < count; ++i) write_box(node, lane[i], &runs[i].box);
    return HTREE_OK;
}
