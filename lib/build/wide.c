/* wide.c: the wide tree: eight children a node, eight prims a leaf.
 *
 * All prims are sorted into cells once; the top is built over the cells as weighted prims; what hangs
 * below it is cut into errands for all threads; leaves are written last, when it is known how many
 * there are. Errands and their order follow from the input alone, and so do the bytes of the tree.
 * O(N log log N) where prims are spread evenly, else O(N log N). */
#include "wide.h"

enum { GROUPS = 64 /* of errands, each for one thread at a time */ };

typedef struct group {
    uint32_t first, end; /* errands */
    ht_wide_part part;
    uint32_t node_base, leaf_base; /* where the part's lie in the tree */
    htree_status status;
} group;

typedef struct wide_build {
    ht_builder *builder;
    ht_source source;
    ht_wide_cells cells;
    ht_wide_top top;
    group groups[GROUPS];
    uint32_t group_count;
    ht_wide_node *nodes;
    ht_wide_leaf *leaves;
} wide_build;

static ht_wide_errand *errand_at(const wide_build *build, uint32_t i) {
    return (ht_wide_errand *)ht_array_at(&build->top.errands, i);
}

/* ---- Errands, on all threads ---------------------------------------------------------------- */

/* Groups of neighbouring errands with about as many prims. */
static void group_errands(wide_build *build) {
    const uint32_t count = (uint32_t)build->top.errands.count;
    const uint32_t share = build->top.prims / GROUPS + 1;
    for (uint32_t i = 0; i < count;) {
        group *g = &build->groups[build->group_count++];
        const bool last = build->group_count == GROUPS;
        const uint32_t start = errand_at(build, i)->first;
        g->first = i;
        while (i < count && (last || errand_at(build, i)->first - start < share)) ++i;
        g->end = i;
        ht_wide_part_begin(&g->part, &build->builder->tree->memory);
    }
}

/* Leaves hold six prims on average and nodes have nearly five children. */
static htree_status reserve(ht_wide_part *part, uint32_t prims) {
    HT_TRY(ht_array_reserve(&part->leaves, prims / 6 + 16));
    return ht_array_reserve(&part->nodes, prims / 24 + 16);
}

static htree_status run_errands(wide_build *build, group *g, ht_prim *prims, ht_prim *spare) {
    ht_builder *builder = build->builder;
    for (uint32_t i = g->first; i < g->end; ++i) {
        ht_wide_errand *e = errand_at(build, i);
        HT_TRY(
            ht_wide_run_errand(builder, &build->source, &build->cells, e, &g->part, prims, spare));
        if (!ht_progress_step(&builder->progress, e->cells.prims)) return HTREE_ERROR_CANCELLED;
    }
    return HTREE_OK;
}

static void run_group(void *data, uint32_t index) {
    wide_build *build = (wide_build *)data;
    group *g = &build->groups[index];
    ht_memory *memory = &build->builder->tree->memory;
    uint64_t most = 0;
    uint32_t prims = 0;
    for (uint32_t i = g->first; i < g->end; ++i) {
        const uint32_t count = errand_at(build, i)->cells.prims;
        if (count > most) most = count;
        prims += count;
    }
    ht_prim *room = (ht_prim *)ht_allocate(memory, 2 * most * sizeof *room);
    g->status = room ? reserve(&g->part, prims) : HTREE_ERROR_MEMORY;
    if (g->status == HTREE_OK) g->status = run_errands(build, g, room, room + most);
    ht_release(memory, room, 2 * most * sizeof *room);
}

/* A failure of another thread left its text there. */
static htree_status status_of_groups(const wide_build *build) {
    for (uint32_t i = 0; i < build->group_count; ++i) {
        const htree_status status = build->groups[i].status;
        if (status == HTREE_ERROR_MEMORY)
            return ht_fail(status, "out of memory while a thread built a part of the tree");
        if (status != HTREE_OK) return status;
    }
    return HTREE_OK;
}

/* ---- All parts as one tree ------------------------------------------------------------------ */

static void copy_nodes(const wide_build *build, const ht_wide_part *part, uint32_t node_base,
                       uint32_t leaf_base) {
    const ht_wide_node *from = (const ht_wide_node *)part->nodes.items;
    ht_wide_node *to = build->nodes + node_base;
    for (uint64_t i = 0; i < part->nodes.count; ++i) {
        to[i] = from[i];
        for (uint32_t k = 0; k < HT_LANES; ++k) {
            uint32_t *child = &to[i].child[k];
            if (*child != HT_WIDE_NONE) *child += *child & HT_WIDE_LEAF ? leaf_base : node_base;
        }
    }
}

static void finish_group(void *data, uint32_t index) {
    const wide_build *build = (const wide_build *)data;
    const group *g = &build->groups[index];
    const ht_wide_leaf_run *runs = (const ht_wide_leaf_run *)g->part.leaves.items;
    copy_nodes(build, &g->part, g->node_base, g->leaf_base);
    for (uint64_t i = 0; i < g->part.leaves.count; ++i) {
        ht_wide_write_leaf(&build->source, build->cells.leaf_order + runs[i].first, runs[i].count,
                           &build->leaves[g->leaf_base + i]);
    }
    for (uint32_t i = g->first; i < g->end; ++i) {
        const ht_wide_errand *e = errand_at(build, i);
        const uint32_t base = e->child & HT_WIDE_LEAF ? g->leaf_base : g->node_base;
        if (e->parent != HT_WIDE_NONE) build->nodes[e->parent].child[e->lane] = base + e->child;
    }
}

static htree_status join_groups(wide_build *build) {
    htree *tree = build->builder->tree;
    uint64_t nodes = build->top.part.nodes.count, leaves = 0;
    tree->stack = build->top.part.deepest;
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
    copy_nodes(build, &build->top.part, 0, 0);
    ht_builder_run(build->builder, build->group_count, finish_group, build);
    return HTREE_OK;
}

/* ---- Build ---------------------------------------------------------------------------------- */

static htree_status run_build(wide_build *build) {
    ht_builder *builder = build->builder;
    htree *tree = builder->tree;
    if (!build->cells.order || !build->cells.leaf_order) return HTREE_ERROR_MEMORY;
    HT_TRY(ht_wide_scan(builder, &build->source, &build->cells));
    if (tree->prim_count == 0) return HTREE_OK;
    ht_progress_begin(&builder->progress, &builder->options->progress, tree->prim_count);
    HT_TRY(ht_wide_refine(builder, &build->source, &build->cells));
    HT_TRY(ht_wide_build_top(builder, &build->cells, &build->top));
    group_errands(build);
    ht_builder_run(builder, build->group_count, run_group, build);
    HT_TRY(status_of_groups(build));
    return join_groups(build);
}

htree_status ht_build_wide(ht_builder *builder) {
    htree *tree = builder->tree;
    ht_memory *memory = &tree->memory;
    const uint64_t prims = (uint64_t)tree->triangle_count + tree->object_count;
    wide_build build;
    if (prims >= HT_WIDE_LEAF)
        return ht_fail(HTREE_ERROR_LIMIT, "a wide tree holds fewer than 2^31 objects");
    memset(&build, 0, sizeof build);
    build.builder = builder;
    build.source = ht_source_of(builder->mesh);
    build.cells.order = (uint32_t *)ht_allocate(memory, prims * sizeof *build.cells.order);
    build.cells.leaf_order = (uint32_t *)ht_allocate(memory, prims * sizeof *build.cells.order);
    ht_array_begin(&build.cells.cells, memory, sizeof(ht_prim));
    ht_array_begin(&build.top.errands, memory, sizeof(ht_wide_errand));
    ht_wide_part_begin(&build.top.part, memory);
    const htree_status status = run_build(&build);
    for (uint32_t i = 0; i < build.group_count; ++i) ht_wide_part_end(&build.groups[i].part);
    ht_wide_part_end(&build.top.part);
    ht_array_end(&build.top.errands);
    ht_array_end(&build.cells.cells);
    ht_release(memory, build.cells.leaf_order, prims * sizeof *build.cells.order);
    ht_release(memory, build.cells.order, prims * sizeof *build.cells.order);
    return status;
}
