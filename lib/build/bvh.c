/* bvh.c: bounding volume hierarchies: tight boxes, one object a leaf, 2 N - 1 nodes, split by eq. 1
 * (section 5) or at the spatial median (section 9).
 *
 * A subtree over n prims takes 2 n - 1 slots wherever it is built, so the place of every node
 * follows from counts alone. O(N log N). */
#include "base/arena.h"
#include "split.h"

enum {
    TASKS = 64,       /* that there are at least, more or less */
    TASK_PRIMS = 2048 /* but none is smaller without need */
};

/* Prims first..first+count: their root goes to nodes[slot], its 2 n - 2 other nodes from `below` on. */
typedef struct bvh_range {
    uint32_t slot, below, first, count, level;
    htree_box box;
} bvh_range;

/* A subtree that is built apart from the others. */
typedef struct bvh_task {
    bvh_range range;
    uint32_t deepest;
    htree_status status;
} bvh_task;

typedef struct bvh_build {
    ht_builder *builder;
    bool median;
    ht_bvh_node *nodes;
    ht_array tasks;     /* of bvh_task */
    uint32_t task_size; /* prims of the largest */
} bvh_build;

static ht_bvh_node *write_node(const bvh_build *build, const bvh_range *at) {
    ht_bvh_node *node = &build->nodes[at->slot];
    memcpy(node->lo, at->box.lo, sizeof node->lo);
    memcpy(node->hi, at->box.hi, sizeof node->hi);
    return node;
}

/* Writes the root of at least two prims and says what hangs below it. */
static void split_range(const bvh_build *build, const bvh_range *at, bvh_range *left,
                        bvh_range *right) {
    const ht_builder *builder = build->builder;
    ht_prim *prims = builder->prims + at->first;
    ht_bvh_node *node = write_node(build, at);
    ht_split split;
    if (build->median) {
        ht_split_find_median(prims, at->count, &at->box, HT_MAX_DEPTH - at->level, &split);
    } else {
        const ht_split_rule rule = {HT_MAX_DEPTH - at->level, 0, false};
        ht_split_find(builder->options, prims, at->count, &rule, &split);
    }
    ht_split_apply(&split, prims, builder->spare + at->first, at->count);
    node->child = at->below;
    node->tag = split.axis;
    const uint32_t count = split.left_count, rest = at->count - count, next = at->level + 1;
    const bvh_range l = {at->below, at->below + 2, at->first,
                         count,     next,          ht_box4_box(&split.left)};
    const bvh_range r = {at->below + 1, at->below + 2 * count,    at->first + count, rest,
                         next,          ht_box4_box(&split.right)};
    *left = l;
    *right = r;
}

static htree_status build_range(const bvh_build *build, const bvh_range *at, uint32_t *deepest) {
    bvh_range left, right;
    if (at->count > 1) {
        split_range(build, at, &left, &right);
        HT_TRY(build_range(build, &left, deepest));
        return build_range(build, &right, deepest);
    }
    ht_bvh_node *node = write_node(build, at);
    node->child = ht_prim_id(build->builder->prims + at->first);
    node->tag = HT_BVH_LEAF;
    if (at->level > *deepest) *deepest = at->level;
    return ht_progress_step(&build->builder->progress, 1) ? HTREE_OK : HTREE_ERROR_CANCELLED;
}

/* Builds the top, whose leaves are tasks. */
static htree_status build_top(bvh_build *build, const bvh_range *at) {
    bvh_range left, right;
    if (at->count > build->task_size) {
        split_range(build, at, &left, &right);
        HT_TRY(build_top(build, &left));
        return build_top(build, &right);
    }
    bvh_task *task = (bvh_task *)ht_array_add(&build->tasks);
    if (!task) return HTREE_ERROR_MEMORY;
    task->range = *at;
    return HTREE_OK;
}

static void run_task(void *data, uint32_t index) {
    const bvh_build *build = (const bvh_build *)data;
    bvh_task *task = (bvh_task *)ht_array_at(&build->tasks, index);
    task->status = build_range(build, &task->range, &task->deepest);
}

static htree_status run_tasks(bvh_build *build) {
    htree *tree = build->builder->tree;
    const bvh_range root = {0, 1, 0, tree->prim_count, 0, tree->bounds};
    build->task_size =
        tree->prim_count / TASKS > TASK_PRIMS ? tree->prim_count / TASKS : TASK_PRIMS;
    HT_TRY(build_top(build, &root));
    const uint32_t count = (uint32_t)build->tasks.count;
    ht_builder_run(build->builder, count, run_task, build);
    for (uint32_t i = 0; i < count; ++i) {
        const bvh_task *task = (const bvh_task *)ht_array_at(&build->tasks, i);
        HT_TRY(task->status);
        if (task->deepest > tree->stack) tree->stack = task->deepest;
    }
    return HTREE_OK;
}

static htree_status build_bvh(ht_builder *builder, bool median) {
    htree *tree = builder->tree;
    bvh_build build;
    memset(&build, 0, sizeof build);
    build.builder = builder;
    build.median = median;
    tree->node_slots = 2 * tree->prim_count - 1;
    tree->node_bytes = (uint64_t)tree->node_slots * sizeof(ht_bvh_node);
    tree->nodes = ht_allocate(&tree->memory, tree->node_bytes);
    if (!tree->nodes || !ht_builder_spare(builder)) return HTREE_ERROR_MEMORY;
    build.nodes = (ht_bvh_node *)tree->nodes;
    ht_array_begin(&build.tasks, &tree->memory, sizeof(bvh_task));
    const htree_status status = run_tasks(&build);
    ht_array_end(&build.tasks);
    return status;
}

htree_status ht_build_bvh_median(ht_builder *builder) {
    return build_bvh(builder, true);
}

htree_status ht_build_bvh_sah(ht_builder *builder) {
    return build_bvh(builder, false);
}
