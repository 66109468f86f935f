/* wide_cost.c: errands by cost: how many nodes and leaves they make is known when they are done. So
 * groups of errands write nodes of their own, which are joined at the end, and leaves are written
 * last. */
#include "wide.h"

enum { GROUPS = 64 /* of errands, each for one thread at a time */ };

typedef struct group {
    uint32_t first, end; /* errands */
    ht_wide_part part;
    uint32_t node_base, leaf_base; /* where the part's lie in the tree */
    htree_status status;
} group;

typedef struct joint {
    ht_wide_build *build;
    group groups[GROUPS];
    uint32_t group_count;
} joint;

/* ---- Errands, on all threads ---------------------------------------------------------------- */

/* Groups of neighbouring errands with about as many prims. */
static void group_errands(joint *j) {
    const ht_wide_build *build = j->build;
    const uint32_t count = (uint32_t)build->top.errands.count;
    const uint32_t share = build->builder->tree->prim_count / GROUPS + 1;
    for (uint32_t i = 0; i < count;) {
        group *g = &j->groups[j->group_count++];
        const bool last = j->group_count == GROUPS;
        const uint32_t start = ht_wide_errand_at(build, i)->first;
        g->first = i;
        while (i < count && (last || ht_wide_errand_at(build, i)->first - start < share)) ++i;
        g->end = i;
        ht_wide_part_begin(&g->part, &build->builder->tree->memory);
    }
}

/* Leaves hold six prims on average and nodes have nearly five children. */
static htree_status reserve(ht_wide_part *part, uint32_t prims) {
    HT_TRY(ht_array_reserve(&part->leaves, prims / 6 + 16));
    return ht_array_reserve(&part->nodes, prims / 24 + 16);
}

static htree_status run_errands(ht_wide_build *build, group *g, ht_prim *prims, ht_prim *spare) {
    for (uint32_t i = g->first; i < g->end; ++i) {
        ht_wide_errand *e = ht_wide_errand_at(build, i);
        HT_TRY(ht_wide_run_errand(build, e, &g->part, prims, spare));
        if (!ht_progress_step(&build->builder->progress, e->cells.prims))
            return HTREE_ERROR_CANCELLED;
    }
    return HTREE_OK;
}

static void run_group(void *data, uint32_t index) {
    joint *j = (joint *)data;
    group *g = &j->groups[index];
    ht_memory *memory = &j->build->builder->tree->memory;
    uint64_t most = 0;
    uint32_t prims = 0;
    for (uint32_t i = g->first; i < g->end; ++i) {
        const uint32_t count = ht_wide_errand_at(j->build, i)->cells.prims;
        if (count > most) most = count;
        prims += count;
    }
    ht_prim *room = (ht_prim *)ht_allocate(memory, 2 * most * sizeof *room);
    g->status = room ? reserve(&g->part, prims) : HTREE_ERROR_MEMORY;
    if (g->status == HTREE_OK) g->status = run_errands(j->build, g, room, room + most);
    ht_release(memory, room, 2 * most * sizeof *room);
}

/* A failure of another thread left its text there. */
static htree_status status_of_groups(const joint *j) {
    for (uint32_t i = 0; i < j->group_count; ++i) {
        const htree_status status = j->groups[i].status;
        if (status == HTREE_ERROR_MEMORY)
            return ht_fail(status, "out of memory while a thread built a part of the tree");
        if (status != HTREE_OK) return status;
    }
    return HTREE_OK;
}

/* ---- All parts as one tree ------------------------------------------------------------------ */

static void copy_nodes(const htree *tree, const ht_wide_part *part, uint32_t node_base,
                       uint32_t leaf_base) {
    const ht_wide_node *from = (const ht_wide_node *)part->nodes.items;
    ht_wide_node *to = (ht_wide_node *)tree->nodes + node_base;
    for (uint64_t i = 0; i < part->nodes.count; ++i) {
        to[i] = from[i];
        for (uint32_t k = 0; k < HT_LANES; ++k) {
            uint32_t *child = &to[i].child[k];
            if (*child != HT_WIDE_NONE) *child += *child & HT_WIDE_LEAF ? leaf_base : node_base;
        }
    }
}

/* Writes what can be written two at a time; returns how many leaves that are. */
static uint32_t write_many(const ht_wide_build *build, const ht_wide_leaf_run *runs, uint32_t count,
                           ht_wide_leaf *leaves) {
    const htree *tree = build->builder->tree;
#ifdef HT_X86
    if (tree->isa == HT_AVX512)
        return ht_wide_write_avx512(&build->source, build->cells.leaf_order, tree->prim_count, runs,
                                    count, leaves);
#endif
    (void)tree, (void)runs, (void)count, (void)leaves;
    return 0;
}

static void write_leaves(const ht_wide_build *build, const ht_wide_leaf_run *runs, uint32_t count,
                         ht_wide_leaf *leaves) {
    for (uint32_t i = 0; i < count; ++i) {
        i += write_many(build, runs + i, count - i, leaves + i);
        if (i < count)
            ht_wide_write_leaf(build->builder->tree->isa, &build->source,
                               build->cells.leaf_order + runs[i].first, runs[i].count, &leaves[i]);
    }
}

static void finish_group(void *data, uint32_t index) {
    const joint *j = (const joint *)data;
    const group *g = &j->groups[index];
    const ht_wide_build *build = j->build;
    const htree *tree = build->builder->tree;
    const ht_wide_leaf_run *runs = (const ht_wide_leaf_run *)g->part.leaves.items;
    copy_nodes(tree, &g->part, g->node_base, g->leaf_base);
    write_leaves(build, runs, (uint32_t)g->part.leaves.count, &tree->leaves[g->leaf_base]);
    for (uint32_t i = g->first; i < g->end; ++i) {
        const ht_wide_errand *e = ht_wide_errand_at(build, i);
        const uint32_t base = e->child & HT_WIDE_LEAF ? g->leaf_base : g->node_base;
        ht_wide_set_parent(tree, e, base + e->child);
    }
}

static htree_status join_groups(joint *j) {
    const ht_wide_part *top = &j->build->top.part;
    htree *tree = j->build->builder->tree;
    uint64_t nodes = top->nodes.count, leaves = 0;
    tree->stack = top->deepest;
    for (uint32_t i = 0; i < j->group_count; ++i) {
        group *g = &j->groups[i];
        g->node_base = (uint32_t)nodes;
        g->leaf_base = (uint32_t)leaves;
        nodes += g->part.nodes.count;
        leaves += g->part.leaves.count;
        if (g->part.deepest > tree->stack) tree->stack = g->part.deepest;
    }
    HT_TRY(ht_wide_allocate(tree, nodes, leaves));
    copy_nodes(tree, top, 0, 0);
    ht_builder_run(j->build->builder, j->group_count, finish_group, j);
    return HTREE_OK;
}

htree_status ht_wide_finish_by_cost(ht_wide_build *build) {
    joint j;
    memset(&j, 0, sizeof j);
    j.build = build;
    group_errands(&j);
    ht_builder_run(build->builder, j.group_count, run_group, &j);
    htree_status status = status_of_groups(&j);
    if (status == HTREE_OK) status = join_groups(&j);
    for (uint32_t i = 0; i < j.group_count; ++i) ht_wide_part_end(&j.groups[i].part);
    return status;
}
