/* wide.c: the wide tree: eight children a node, eight prims a leaf, by the split of section 5.
 *
 * A node begins as one run of prims and splits the run with the largest box, until it has eight
 * or all are leaves. A leaf tests its prims at once, so eq. 1 counts leaves where it has counted
 * prims (`block_bits` of split.h): that fills leaves, and measured faster to build and to trace.
 * O(N log N). */
#include "base/arena.h"
#include "prims.h"
#include "split.h"

typedef struct wide_build {
    ht_builder *builder;
    ht_array nodes, leaves;
    uint32_t deepest; /* entries that a traversal stack can need */
} wide_build;

/* Prims first, first + 1, ... and their box. */
typedef struct run {
    ht_prim *prims;
    uint32_t count;
    htree_box box;
} run;

/* ---- Leaves --------------------------------------------------------------------------------- */

static void write_lane(const htree *tree, ht_wide_leaf *leaf, uint32_t prim) {
    const uint32_t lane = leaf->count++;
    leaf->prim[lane] = prim;
    if (prim >= tree->triangle_count) {
        ++leaf->objects;
        return;
    }
    for (uint32_t corner = 0; corner < 3; ++corner) {
        for (uint32_t axis = 0; axis < 3; ++axis)
            leaf->v[corner][axis][lane] = tree->triangles[prim].v[corner][axis];
    }
}

/* User objects come last, so that the lanes of triangles are the first ones. */
static htree_status write_leaf(wide_build *build, const run *prims, uint32_t *child) {
    const htree *tree = build->builder->tree;
    *child = HT_WIDE_LEAF | (uint32_t)build->leaves.count;
    ht_wide_leaf *leaf = (ht_wide_leaf *)ht_array_add(&build->leaves);
    if (!leaf) return HTREE_ERROR_MEMORY;
    for (uint32_t i = 0; i < prims->count; ++i) {
        const uint32_t prim = ht_prim_id(&prims->prims[i]);
        if (prim < tree->triangle_count) write_lane(tree, leaf, prim);
    }
    for (uint32_t i = 0; i < prims->count; ++i) {
        const uint32_t prim = ht_prim_id(&prims->prims[i]);
        if (prim >= tree->triangle_count) write_lane(tree, leaf, prim);
    }
    return ht_progress_step(&build->builder->progress, prims->count) ? HTREE_OK
                                                                     : HTREE_ERROR_CANCELLED;
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

/* Levels of nodes that so many prims need at least, every node full. */
static uint32_t levels_needed(uint32_t count) {
    uint32_t levels = 1;
    for (uint64_t room = HT_LANES * HT_LANES; room < count; room *= HT_LANES) ++levels;
    return levels;
}

/* The run to split next: the largest box, or where levels are scarce the most prims; `count` if
 * every run fits into a leaf. */
static uint32_t choose_run(const run *runs, uint32_t count, bool scarce) {
    uint32_t best = count;
    float most = -1;
    for (uint32_t i = 0; i < count; ++i) {
        const float worth = scarce ? (float)runs[i].count : ht_box_area(&runs[i].box);
        if (runs[i].count > HT_LANES && worth > most) {
            most = worth;
            best = i;
        }
    }
    return best;
}

/* Splits prims into at most eight runs; returns how many. With `scarce` each split is in the
 * middle, so that no run keeps more than an eighth, rounded up. */
static uint32_t split_runs(const ht_builder *builder, const run *all, bool scarce, run *runs) {
    uint32_t count = 1;
    runs[0] = *all;
    while (count < HT_LANES) {
        const uint32_t chosen = choose_run(runs, count, scarce);
        if (chosen == count) break;
        run *left = &runs[chosen], *right = &runs[count++];
        ht_split split;
        ht_split_find(builder->options, left->prims, left->count,
                      scarce ? ht_levels_needed(left->count) : HT_MAX_DEPTH, HT_LANE_BITS, &split);
        ht_split_apply(&split, left->prims, builder->spare, left->count);
        right->prims = left->prims + split.left_count;
        right->count = left->count - split.left_count;
        right->box = split.right;
        left->count = split.left_count;
        left->box = split.left;
    }
    return count;
}

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
static void assign_lanes(const run *runs, uint32_t count, const htree_box *all,
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

static htree_status write_node(wide_build *build, const run *runs, uint32_t count,
                               const uint32_t *lane, uint32_t *slot) {
    const htree_box nothing = ht_box_empty();
    *slot = (uint32_t)build->nodes.count;
    ht_wide_node *node = (ht_wide_node *)ht_array_add(&build->nodes);
    if (!node) return HTREE_ERROR_MEMORY;
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        write_box(node, i, &nothing);
        node->child[i] = HT_WIDE_NONE;
    }
    for (uint32_t i = 0; i < count; ++i) write_box(node, lane[i], &runs[i].box);
    return HTREE_OK;
}

/* Writes the subtree of `all`, `level` nodes below the root, where `waiting` entries stand on a
 * ray's stack already. */
static htree_status subtree(wide_build *build, const run *all, uint32_t level, uint32_t waiting,
                            uint32_t *slot) {
    run runs[HT_LANES];
    const bool scarce = level + levels_needed(all->count) >= HT_WIDE_LEVELS;
    const uint32_t count = split_runs(build->builder, all, scarce, runs);
    uint32_t lane[HT_LANES];
    assign_lanes(runs, count, &all->box, lane);
    HT_TRY(write_node(build, runs, count, lane, slot));
    waiting += count - 1;
    if (waiting > build->deepest) build->deepest = waiting;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t child;
        HT_TRY(runs[i].count > HT_LANES ? subtree(build, &runs[i], level + 1, waiting, &child)
                                        : write_leaf(build, &runs[i], &child));
        ((ht_wide_node *)ht_array_at(&build->nodes, *slot))->child[lane[i]] = child;
    }
    return HTREE_OK;
}

static htree_status build_nodes(wide_build *build) {
    const ht_builder *builder = build->builder;
    htree *tree = builder->tree;
    const run all = {builder->prims, tree->prim_count, tree->bounds};
    uint32_t root;
    void *leaves;
    HT_TRY(subtree(build, &all, 0, 0, &root));
    HT_TRY(ht_array_finish(&build->nodes, &tree->nodes));
    tree->node_slots = (uint32_t)build->nodes.count;
    tree->node_bytes = tree->node_slots * sizeof(ht_wide_node);
    HT_TRY(ht_array_finish(&build->leaves, &leaves));
    tree->leaves = (ht_wide_leaf *)leaves;
    tree->leaf_count = (uint32_t)build->leaves.count;
    tree->stack = build->deepest;
    return HTREE_OK;
}

htree_status ht_build_wide(ht_builder *builder) {
    htree *tree = builder->tree;
    if (tree->prim_count >= HT_WIDE_LEAF) {
        return ht_fail(HTREE_ERROR_LIMIT, "a wide tree holds fewer than 2^31 objects");
    }
    wide_build build = {builder, {NULL, NULL, 0, 0, 0}, {NULL, NULL, 0, 0, 0}, 0};
    if (!ht_builder_spare(builder)) return HTREE_ERROR_MEMORY;
    ht_array_begin(&build.nodes, &tree->memory, sizeof(ht_wide_node));
    ht_array_begin(&build.leaves, &tree->memory, sizeof(ht_wide_leaf));
    const htree_status status = build_nodes(&build);
    ht_array_end(&build.leaves);
    ht_array_end(&build.nodes);
    return status;
}
