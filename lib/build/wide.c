/* wide.c: the wide tree: eight children a node, eight prims a leaf, by the split of section 5.
 *
 * A node begins as one run of prims and splits the run with the largest box, until it has eight
 * or all are leaves. A leaf tests its prims at once, so eq. 1 counts leaves where it has counted
 * prims (`block_bits` of split.h): that fills leaves, and measured faster to build and to trace.
 *
 * The top of a large tree is built over the cells of a grid instead of prims; what hangs below it
 * is cut into errands for all threads. Errands and their order follow from the input alone, and so
 * do the bytes of the tree. O(N log log N) where prims are spread evenly, else O(N log N). */
#include "prims.h"
#include "wide.h"

enum {
    CELLS_PAY = 4096,   /* prims from which on a grid is worth its while */
    ERRAND_PRIMS = 512, /* where the top over cells ends */
    TOP_LEVELS = 12,
    GROUPS = 32 /* of errands, each for one thread at a time */
};

/* ---- Runs ----------------------------------------------------------------------------------- */

/* Levels of nodes that so many prims need at least, every node full. */
static uint32_t levels_needed(uint32_t count) {
    uint32_t levels = 1;
    for (uint64_t room = HT_LANES * HT_LANES; room < count; room *= HT_LANES) ++levels;
    return levels;
}

/* The run to split next: the largest box, or where levels are scarce the most prims; `count` if
 * every run fits into a leaf, or is a single cell. */
static uint32_t choose_run(const ht_wide_run *runs, uint32_t count, bool scarce) {
    uint32_t best = count;
    float most = -1;
    for (uint32_t i = 0; i < count; ++i) {
        const float worth = scarce ? (float)runs[i].prims : ht_box_area(&runs[i].box);
        if (runs[i].prims > HT_LANES && runs[i].count > 1 && worth > most) {
            most = worth;
            best = i;
        }
    }
    return best;
}

/* Splits a run into at most eight; returns how many. With `scarce` each split is in the middle, so
 * that no run keeps more than an eighth, rounded up. */
static uint32_t split_runs(const htree_options *options, ht_prim *spare, const ht_wide_run *all,
                           bool scarce, bool cells, ht_wide_run *runs) {
    uint32_t count = 1;
    runs[0] = *all;
    while (count < HT_LANES) {
        const uint32_t chosen = choose_run(runs, count, scarce);
        if (chosen == count) break;
        ht_wide_run *left = &runs[chosen], *right = &runs[count++];
        const ht_split_rule rule = {scarce ? ht_levels_needed(left->count) : HT_MAX_DEPTH,
                                    HT_LANE_BITS, cells};
        ht_split split;
        ht_split_find(options, left->items, left->count, &rule, &split);
        ht_split_apply(&split, left->items, spare, left->count);
        right->items = left->items + split.left_count;
        right->count = left->count - split.left_count;
        right->prims = left->prims - split.left_prims;
        right->box = split.right;
        left->count = split.left_count;
        left->prims = split.left_prims;
        left->box = split.left;
    }
    return count;
}

static void set_child(ht_wide_part *part, uint32_t slot, uint32_t lane, uint32_t child) {
    ((ht_wide_node *)ht_array_at(&part->nodes, slot))->child[lane] = child;
}

/* Writes the subtree over a run of prims, `level` nodes below the root, where `waiting` entries
 * stand on a ray's stack already. */
static htree_status subtree(ht_wide_part *part, ht_prim *spare, const ht_wide_run *all,
                            uint32_t level, uint32_t waiting, uint32_t *child) {
    ht_wide_run runs[HT_LANES];
    uint32_t lane[HT_LANES], slot;
    const bool scarce = level + levels_needed(all->count) >= HT_WIDE_LEVELS;
    const uint32_t count = split_runs(part->builder->options, spare, all, scarce, false, runs);
    HT_TRY(ht_wide_write_node(part, runs, count, &all->box, lane, &slot));
    waiting += count - 1;
    if (waiting > part->deepest) part->deepest = waiting;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t below;
        HT_TRY(runs[i].count > HT_LANES ? subtree(part, spare, &runs[i], level + 1, waiting, &below)
                                        : ht_wide_write_leaf(part, &runs[i], &below));
        set_child(part, slot, lane[i], below);
    }
    *child = slot;
    return HTREE_OK;
}

/* ---- The top, over cells -------------------------------------------------------------------- */

/* A subtree to be built over the prims of some cells; first, where they are gathered. */
typedef struct errand {
    ht_wide_run cells;
    uint32_t first, level, waiting;
    uint32_t parent, lane; /* in the top: what it is a child of */
    uint32_t child;        /* counted from the start of its group's part */
} errand;

typedef struct group {
    uint32_t first, end; /* errands */
    ht_wide_part part;
    uint32_t node_base, leaf_base; /* where the part's lie in the tree */
    htree_status status;
} group;

typedef struct wide_build {
    ht_builder *builder;
    ht_wide_part top;
    ht_array errands;
    uint32_t gathered; /* prims of the errands so far */
    group groups[GROUPS];
    uint32_t group_count;
    ht_wide_node *nodes;
    ht_wide_leaf *leaves;
} wide_build;

static void gather(const ht_builder *builder, const ht_wide_run *cells, ht_prim *out) {
    for (uint32_t i = 0; i < cells->count; ++i) {
        const uint32_t count = ht_cell_prims(&cells->items[i]);
        memcpy(out, builder->spare + ht_cell_first(&cells->items[i]), count * sizeof *out);
        out += count;
    }
}

static htree_status top_leaf(wide_build *build, const ht_wide_run *cells, uint32_t *child) {
    ht_prim prims[HT_LANES];
    const ht_wide_run run = {prims, cells->prims, cells->prims, cells->box};
    gather(build->builder, cells, prims);
    return ht_wide_write_leaf(&build->top, &run, child);
}

static htree_status add_errand(wide_build *build, const ht_wide_run *cells, uint32_t level,
                               uint32_t waiting, uint32_t parent, uint32_t lane) {
    errand *e = (errand *)ht_array_add(&build->errands);
    if (!e) return HTREE_ERROR_MEMORY;
    e->cells = *cells;
    e->first = build->gathered;
    e->level = level;
    e->waiting = waiting;
    e->parent = parent;
    e->lane = lane;
    build->gathered += cells->prims;
    return HTREE_OK;
}

static htree_status top_subtree(wide_build *build, ht_prim *spare, const ht_wide_run *all,
                                uint32_t level, uint32_t waiting, uint32_t *child) {
    ht_wide_part *top = &build->top;
    ht_wide_run runs[HT_LANES];
    uint32_t lane[HT_LANES], slot;
    const uint32_t count = split_runs(build->builder->options, spare, all, false, true, runs);
    HT_TRY(ht_wide_write_node(top, runs, count, &all->box, lane, &slot));
    waiting += count - 1;
    if (waiting > top->deepest) top->deepest = waiting;
    for (uint32_t i = 0; i < count; ++i) {
        const ht_wide_run *run = &runs[i];
        uint32_t below = HT_WIDE_NONE;
        if (run->prims <= HT_LANES) {
            HT_TRY(top_leaf(build, run, &below));
        } else if (run->count == 1 || run->prims <= ERRAND_PRIMS || level == TOP_LEVELS) {
            HT_TRY(add_errand(build, run, level + 1, waiting, slot, lane[i]));
        } else {
            HT_TRY(top_subtree(build, spare, run, level + 1, waiting, &below));
        }
        set_child(top, slot, lane[i], below);
    }
    *child = slot;
    return HTREE_OK;
}

/* The whole tree over the grid's cells; a single cell is an errand that has no parent. */
static htree_status build_top(wide_build *build, const ht_wide_cells *cells) {
    ht_builder *builder = build->builder;
    const htree *tree = builder->tree;
    const ht_wide_run all = {cells->cells, cells->count, tree->prim_count, tree->bounds};
    uint32_t root;
    if (cells->count == 1) return add_errand(build, &all, 0, 0, HT_WIDE_NONE, 0);
    const uint64_t bytes = cells->count * sizeof(ht_prim);
    ht_prim *spare = (ht_prim *)ht_allocate(&builder->tree->memory, bytes);
    if (!spare) return HTREE_ERROR_MEMORY;
    const htree_status status = top_subtree(build, spare, &all, 0, 0, &root);
    ht_release(&builder->tree->memory, spare, bytes);
    return status;
}

/* ---- Errands, on all threads ---------------------------------------------------------------- */

/* Groups of neighbouring errands with about as many prims. */
static void group_errands(wide_build *build) {
    const errand *errands = (const errand *)build->errands.items;
    const uint32_t count = (uint32_t)build->errands.count;
    const uint32_t share = build->gathered / GROUPS + 1;
    for (uint32_t i = 0; i < count;) {
        group *g = &build->groups[build->group_count++];
        const bool last = build->group_count == GROUPS;
        const uint32_t start = errands[i].first;
        g->first = i;
        while (i < count && (last || errands[i].first - start < share)) ++i;
        g->end = i;
        ht_wide_part_begin(&g->part, build->builder);
    }
}

/* Leaves hold six prims on average and nodes have nearly five children. */
static htree_status reserve(ht_wide_part *part, uint32_t prims) {
    HT_TRY(ht_array_reserve(&part->leaves, prims / 6 + 16));
    return ht_array_reserve(&part->nodes, prims / 20 + 16);
}

static htree_status run_errands(wide_build *build, group *g, ht_prim *spare, uint32_t prims) {
    const ht_builder *builder = build->builder;
    HT_TRY(reserve(&g->part, prims));
    for (uint32_t i = g->first; i < g->end; ++i) {
        errand *e = (errand *)ht_array_at(&build->errands, i);
        const ht_wide_run run = {builder->prims + e->first, e->cells.prims, e->cells.prims,
                                 e->cells.box};
        gather(builder, &e->cells, run.items);
        HT_TRY(subtree(&g->part, spare, &run, e->level, e->waiting, &e->child));
    }
    return HTREE_OK;
}

static void run_group(void *data, uint32_t index) {
    wide_build *build = (wide_build *)data;
    group *g = &build->groups[index];
    uint64_t most = 0;
    uint32_t prims = 0;
    for (uint32_t i = g->first; i < g->end; ++i) {
        const errand *e = (const errand *)ht_array_at(&build->errands, i);
        if (e->cells.prims > most) most = e->cells.prims;
        prims += e->cells.prims;
    }
    ht_memory *memory = &build->builder->tree->memory;
    ht_prim *spare = (ht_prim *)ht_allocate(memory, most * sizeof *spare);
    g->status = spare ? run_errands(build, g, spare, prims) : HTREE_ERROR_MEMORY;
    ht_release(memory, spare, most * sizeof *spare);
}

/* ---- All parts as one tree ------------------------------------------------------------------ */

static void copy_part(const wide_build *build, const ht_wide_part *part, uint32_t node_base,
                      uint32_t leaf_base) {
    ht_wide_node *nodes = build->nodes + node_base;
    /* A part of one leaf has no nodes: memcpy takes no NULL, not even for no bytes. */
    if (part->nodes.count) memcpy(nodes, part->nodes.items, part->nodes.count * sizeof *nodes);
    if (part->leaves.count) {
        memcpy(build->leaves + leaf_base, part->leaves.items,
               part->leaves.count * sizeof *build->leaves);
    }
    for (uint64_t i = 0; i < part->nodes.count; ++i) {
        for (uint32_t k = 0; k < HT_LANES; ++k) {
            uint32_t *child = &nodes[i].child[k];
            if (*child != HT_WIDE_NONE) *child += *child & HT_WIDE_LEAF ? leaf_base : node_base;
        }
    }
}

static void copy_group(void *data, uint32_t index) {
    const wide_build *build = (const wide_build *)data;
    const group *g = &build->groups[index];
    copy_part(build, &g->part, g->node_base, g->leaf_base);
    for (uint32_t i = g->first; i < g->end; ++i) {
        const errand *e = (const errand *)ht_array_at(&build->errands, i);
        if (e->parent != HT_WIDE_NONE)
            build->nodes[e->parent].child[e->lane] = g->node_base + e->child;
    }
}

static htree_status join_parts(wide_build *build) {
    htree *tree = build->builder->tree;
    uint64_t nodes = build->top.nodes.count, leaves = build->top.leaves.count;
    tree->stack = build->top.deepest;
    for (uint32_t i = 0; i < build->group_count; ++i) {
        group *g = &build->groups[i];
        g->node_base = (uint32_t)nodes;
        g->leaf_base = (uint32_t)leaves;
        nodes += g->part.nodes.count;
        leaves += g->part.leaves.count;
        if (g->part.deepest > tree->stack) tree->stack = g->part.deepest;
    }
    tree->node_slots = (uint32_t)nodes;
    tree->node_bytes = nodes * sizeof *build->nodes;
    tree->nodes = build->nodes = (ht_wide_node *)ht_allocate(&tree->memory, tree->node_bytes);
    tree->leaf_count = (uint32_t)leaves;
    tree->leaves = build->leaves =
        (ht_wide_leaf *)ht_allocate(&tree->memory, leaves * sizeof *build->leaves);
    if (!build->nodes || !build->leaves) return HTREE_ERROR_MEMORY;
    if (build->top.nodes.count) copy_part(build, &build->top, 0, 0);
    ht_builder_run(build->builder, build->group_count, copy_group, build);
    return HTREE_OK;
}

/* ---- Build ---------------------------------------------------------------------------------- */

/* A failure of another thread left its text there. */
static htree_status status_of_groups(const wide_build *build) {
    for (uint32_t i = 0; i < build->group_count; ++i) {
        const htree_status status = build->groups[i].status;
        if (status == HTREE_ERROR_MEMORY) return ht_fail(status, "out of memory");
        if (status != HTREE_OK) return status;
    }
    return HTREE_OK;
}

static htree_status build_from_cells(wide_build *build) {
    ht_builder *builder = build->builder;
    ht_wide_cells cells;
    HT_TRY(ht_wide_cells_begin(&cells, builder));
    htree_status status = build_top(build, &cells);
    if (status == HTREE_OK) {
        group_errands(build);
        ht_builder_run(builder, build->group_count, run_group, build);
        status = status_of_groups(build);
    }
    ht_wide_cells_end(&cells, builder);
    return status == HTREE_OK ? join_parts(build) : status;
}

static htree_status build_from_prims(wide_build *build) {
    ht_builder *builder = build->builder;
    const uint32_t count = builder->tree->prim_count;
    const ht_wide_run all = {builder->prims, count, count, builder->tree->bounds};
    uint32_t root;
    HT_TRY(subtree(&build->top, builder->spare, &all, 0, 0, &root));
    return join_parts(build);
}

htree_status ht_build_wide(ht_builder *builder) {
    const uint32_t count = builder->tree->prim_count;
    wide_build build;
    if (count >= HT_WIDE_LEAF)
        return ht_fail(HTREE_ERROR_LIMIT, "a wide tree holds fewer than 2^31 objects");
    if (!ht_builder_spare(builder)) return HTREE_ERROR_MEMORY;
    memset(&build, 0, sizeof build);
    build.builder = builder;
    ht_wide_part_begin(&build.top, builder);
    ht_array_begin(&build.errands, &builder->tree->memory, sizeof(errand));
    const htree_status status =
        count < CELLS_PAY ? build_from_prims(&build) : build_from_cells(&build);
    for (uint32_t i = 0; i < build.group_count; ++i) ht_wide_part_end(&build.groups[i].part);
    ht_array_end(&build.errands);
    ht_wide_part_end(&build.top);
    return status;
}
