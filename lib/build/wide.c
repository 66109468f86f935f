/* wide.c: the wide tree: eight children a node, eight prims a leaf.
 *
 * All prims are sorted into cells once; the top is built over the cells as weighted prims; what
 * hangs below it is cut into errands for all threads, or for the rays that come there first.
 * Errands and their order follow from the input alone, and so do the bytes of the tree. O(N log log
 * N) where prims are spread evenly, else O(N log N). */
#include "wide.h"

htree_status ht_wide_allocate(htree *tree, uint64_t nodes, uint64_t leaves) {
    tree->node_slots = (uint32_t)nodes;
    tree->node_bytes = nodes * sizeof(ht_wide_node);
    tree->nodes = ht_allocate(&tree->memory, tree->node_bytes);
    tree->leaf_count = (uint32_t)leaves;
    tree->leaves = (ht_wide_leaf *)ht_allocate(&tree->memory, leaves * sizeof(ht_wide_leaf));
    return tree->nodes && tree->leaves ? HTREE_OK : HTREE_ERROR_MEMORY;
}

/* A tree of one errand has its root in it, which Morton order does not put first. */
static bool is_by_order(const ht_wide_build *build) {
    return (build->builder->options->flags & (HTREE_MORTON | HTREE_LAZY)) != 0 &&
           build->top.errands.count > 1;
}

static htree_status run_build(ht_wide_build *build) {
    ht_builder *builder = build->builder;
    const htree *tree = builder->tree;
    if (!build->cells.order || !build->cells.leaf_order) return HTREE_ERROR_MEMORY;
    HT_TRY(ht_wide_scan(build));
    if (tree->prim_count == 0) return HTREE_OK;
    if (!ht_progress_step(&builder->progress, build->prims)) return HTREE_ERROR_CANCELLED;
    HT_TRY(ht_wide_refine(build));
    HT_TRY(ht_wide_build_top(build));
    HT_TRY(is_by_order(build) ? ht_wide_finish_by_order(build) : ht_wide_finish_by_cost(build));
    if (builder->options->flags & HTREE_COMPACT) HT_TRY(ht_wide_compact(builder));
    const uint64_t skipped = tree->invalid + tree->degenerate;
    return ht_progress_step(&builder->progress, skipped) ? HTREE_OK : HTREE_ERROR_CANCELLED;
}

htree_status ht_build_wide(ht_builder *builder) {
    htree *tree = builder->tree;
    ht_memory *memory = &tree->memory;
    const uint64_t prims = (uint64_t)tree->triangle_count + tree->object_count;
    ht_wide_build build;
    memset(&build, 0, sizeof build);
    build.builder = builder;
    build.prims = (uint32_t)prims;
    build.source = ht_source_of(builder->mesh);
    build.cells.order = (uint32_t *)ht_allocate(memory, prims * sizeof *build.cells.order);
    build.cells.leaf_order = (uint32_t *)ht_allocate(memory, prims * sizeof *build.cells.order);
    ht_array_begin(&build.cells.cells, memory, sizeof(ht_prim));
    ht_wide_top_begin(&build.top, memory);
    /* Half of the time for the scan and the sort, half for errands. */
    ht_progress_begin(&builder->progress, &builder->options->progress, 2 * prims);
    const htree_status status = run_build(&build);
    ht_wide_top_end(&build.top);
    ht_array_end(&build.cells.cells);
    ht_release(memory, build.cells.leaf_order, prims * sizeof *build.cells.order);
    ht_release(memory, build.cells.order, prims * sizeof *build.cells.order);
    return status;
}
