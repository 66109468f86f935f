/* refit.c: new positions into the leaves of a wide tree, and boxes around them from the leaves up.
 *
 * Builders write nodes and leaves in the order of a walk, so memory is read in its own order: tasks
 * take runs of nodes, fill the leaves below each, and then close nodes backwards, children before
 * parents. A node with a child outside of its task's run stays open; those few are closed in the
 * end. Boxes are as exact as those of a build; what suffers is their fit, which the areas tell.
 *
 * The survey of the mesh is made in the same parallel loop, before its first task: to start threads
 * twice costs more than to wait. */
#include "refit.h"
#include "survey.h"
#include "wide.h"

enum {
    BLOCK = 64,      /* nodes with flags in one word */
    TASK_BLOCKS = 2, /* fewer are not worth a task */
    MOST_TASKS = 256
};

typedef struct block {
    uint64_t open; /* a bit for every node with a lane that has no box yet */
    double areas;  /* of the closed nodes' boxes, which weigh what rays do there */
} block;

typedef struct refitting {
    htree *tree;
    ht_source source;
    ht_survey survey;
    block *blocks;
    uint32_t block_count, tasks;
} refitting;

/* Slots of nodes. */
typedef struct run {
    uint32_t first, end;
} run;

static ht_wide_node *node_at(const htree *tree, uint32_t slot) {
    return (ht_wide_node *)tree->nodes + slot;
}

static bool is_node(uint32_t child) {
    return !(child & HT_WIDE_LEAF);
}

static bool is_leaf(uint32_t child) {
    return child & HT_WIDE_LEAF && child != HT_WIDE_NONE;
}

/* ---- Planes --------------------------------------------------------------------------------- */

static void set_lane(ht_wide_node *node, uint32_t lane, const ht_box4 *box) {
    const htree_box b = ht_box4_box(box);
    for (uint32_t axis = 0; axis < 3; ++axis) {
        node->lo[axis][lane] = b.lo[axis];
        node->hi[axis][lane] = b.hi[axis];
    }
}

/* Planes become boxes again; idle lanes are empty boxes, which add nothing. */
static ht_box4 node_box(const ht_wide_node *node) {
    ht_f4 lo[4], hi[4];
    for (uint32_t axis = 0; axis < 3; ++axis) {
        lo[axis] = ht_f4_min(ht_f4_load(node->lo[axis]), ht_f4_load(&node->lo[axis][4]));
        hi[axis] = ht_f4_max(ht_f4_load(node->hi[axis]), ht_f4_load(&node->hi[axis][4]));
    }
    lo[3] = lo[0];
    hi[3] = hi[0];
    ht_f4_transpose(lo);
    ht_f4_transpose(hi);
    const ht_box4 box = {ht_f4_min(ht_f4_min(lo[0], lo[1]), ht_f4_min(lo[2], lo[3])),
                         ht_f4_max(ht_f4_max(hi[0], hi[1]), ht_f4_max(hi[2], hi[3]))};
    return box;
}

static ht_f4 extents(const ht_wide_node *node, uint32_t axis, uint32_t half) {
    const ht_f4 lo = ht_f4_load(&node->lo[axis][half]), hi = ht_f4_load(&node->hi[axis][half]);
    return ht_f4_max(ht_f4_all(0), ht_f4_sub(hi, lo));
}

/* Of the boxes of all lanes. Two are added as floats, which is finite: see ht_box_area. */
static double node_areas(const ht_wide_node *node) {
    float sums[4];
    ht_f4 sum = ht_f4_all(0);
    for (uint32_t half = 0; half < HT_LANES; half += 4) {
        const ht_f4 x = extents(node, 0, half), y = extents(node, 1, half);
        const ht_f4 z = extents(node, 2, half);
        sum = ht_f4_add(sum, ht_f4_add(ht_f4_mul(x, ht_f4_add(y, z)), ht_f4_mul(y, z)));
    }
    ht_f4_store(sums, sum);
    return ((double)sums[0] + (double)sums[1]) + ((double)sums[2] + (double)sums[3]);
}

/* ---- Leaves --------------------------------------------------------------------------------- */

/* How far ahead to ask for memory: nodes, what leaves say of their prims, and what these say of
 * theirs. What is asked for too early or too late costs a third more. */
enum { NODES_AHEAD = 8, PRIMS_AHEAD = 24, INDICES_AHEAD = 8 };

/* Inlined for sure: gcc drops calls of functions that do nothing but prefetch. */
HT_INLINE void prefetch_node(const htree *tree, uint32_t slot) {
    if (slot >= tree->node_slots) return;
    const ht_wide_node *node = node_at(tree, slot);
    HT_PREFETCH(&node->lo[0]);
    HT_PREFETCH(&node->lo[2]);
    HT_PREFETCH(&node->hi[1]);
    HT_PREFETCH(&node->child);
}

HT_INLINE void prefetch_prims(const htree *tree, uint32_t leaf) {
    if (leaf < tree->leaf_count) HT_PREFETCH(&tree->leaves[leaf].prim);
}

/* Where the corners go, and where they are found. */
HT_INLINE void prefetch_leaf(const refitting *r, uint32_t leaf) {
    if (leaf >= r->tree->leaf_count) return;
    const ht_wide_leaf *l = &r->tree->leaves[leaf];
    HT_PREFETCH(&l->v[0][0]);
    HT_PREFETCH(&l->v[1][0]);
    HT_PREFETCH(&l->v[1][1]);
    HT_PREFETCH(&l->v[2][0]);
    for (uint32_t i = 0; i < HT_LANES; ++i) ht_source_prefetch(&r->source, l->prim[i]);
}

static ht_box4 refit_leaf(const refitting *r, uint32_t leaf) {
    prefetch_prims(r->tree, leaf + PRIMS_AHEAD);
    prefetch_leaf(r, leaf + INDICES_AHEAD);
    return ht_wide_fill_leaf(r->tree->isa, &r->source, &r->tree->leaves[leaf]);
}

/* Lanes of nodes are empty until these are closed. */
static void refit_leaves(const refitting *r, ht_wide_node *node) {
    ht_box4 boxes[HT_LANES];
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        const uint32_t child = node->child[lane];
        boxes[lane] = is_leaf(child) ? refit_leaf(r, child & ~HT_WIDE_LEAF) : ht_box4_empty();
    }
    ht_wide_set_planes(node, boxes);
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

static bool is_open(const refitting *r, uint32_t slot) {
    return r->blocks[slot / BLOCK].open >> slot % BLOCK & 1;
}

/* Boxes around the nodes below, if all of them are closed and in the run. */
static void close_node(const refitting *r, uint32_t slot, run all) {
    ht_wide_node *node = node_at(r->tree, slot);
    bool closed = true;
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        const uint32_t child = node->child[lane];
        if (!is_node(child)) continue;
        if (child < all.first || child >= all.end || is_open(r, child)) {
            closed = false;
        } else {
            const ht_box4 box = node_box(node_at(r->tree, child));
            set_lane(node, lane, &box);
        }
    }
    if (!closed) return;
    block *b = &r->blocks[slot / BLOCK];
    b->open ^= (uint64_t)1 << slot % BLOCK;
    b->areas += node_areas(node);
}

static void refit_run(void *data, uint32_t index) {
    const refitting *r = (const refitting *)data;
    const uint64_t count = r->block_count;
    const uint32_t nodes = r->tree->node_slots;
    run own = {(uint32_t)(count * index / r->tasks) * BLOCK,
               (uint32_t)(count * (index + 1) / r->tasks) * BLOCK};
    if (own.end > nodes) own.end = nodes;
    for (uint32_t i = own.first; i < own.end; ++i) {
        prefetch_node(r->tree, i + NODES_AHEAD);
        r->blocks[i / BLOCK].open |= (uint64_t)1 << i % BLOCK;
        refit_leaves(r, node_at(r->tree, i));
    }
    for (uint32_t i = own.end; i-- > own.first;) close_node(r, i, own);
}

static void survey_and_refit(void *data, uint32_t index) {
    refitting *r = (refitting *)data;
    if (ht_survey_help(&r->survey)) refit_run(data, index);
}

/* Returns the areas of all boxes. One round will do, unless a file had its nodes in
 * another order. */
static double close_all(const refitting *r) {
    const run all = {0, r->tree->node_slots};
    double areas = 0;
    while (is_open(r, 0)) {
        for (uint32_t b = r->block_count; b-- > 0;) {
            for (uint32_t i = BLOCK; i-- > 0 && r->blocks[b].open;) {
                if (is_open(r, b * BLOCK + i)) close_node(r, b * BLOCK + i, all);
            }
        }
    }
    for (uint32_t b = 0; b < r->block_count; ++b) areas += r->blocks[b].areas;
    return areas;
}

/* ---- All of it ------------------------------------------------------------------------------ */

/* Areas of all boxes over that of the bounds: what a ray that meets these is expected to meet. */
static double cost_of(double areas, const htree_box *bounds) {
    const double area = (double)ht_box_area(bounds);
    return area > 0 ? areas / area : 1;
}

static double cost_as_built(const htree *tree) {
    double areas = 0;
    for (uint32_t i = 0; i < tree->node_slots; ++i) areas += node_areas(node_at(tree, i));
    return cost_of(areas, &tree->bounds);
}

static bool can_refit(const htree *tree, const ht_source *source) {
    return tree->kind == HTREE_WIDE && !tree->lazy && tree->leaves && !tree->borrowed &&
           source->triangle_count == tree->triangle_count &&
           source->object_count == tree->object_count;
}

/* All nodes but those that stay open, unless other prims than before can be hit. */
static htree_status refit_runs(refitting *r, bool *done) {
    const htree *tree = r->tree;
    ht_parallel_for(&tree->tasks, tree->threads, r->tasks, survey_and_refit, r);
    *done = !r->survey.returning;
    if (!r->survey.odd) return HTREE_OK;
    HT_TRY(ht_survey_closely(&r->survey, done));
    if (*done) ht_parallel_for(&tree->tasks, tree->threads, r->tasks, refit_run, r);
    return HTREE_OK;
}

static void finish(const refitting *r, double *ratio) {
    htree *tree = r->tree;
    const double areas = close_all(r);
    const ht_box4 root = node_box(node_at(tree, 0));
    tree->bounds = ht_box4_box(&root);
    for (uint32_t i = 0; i < tree->object_count; ++i) {
        const htree_box *box = &r->source.boxes[i];
        tree->object_boxes[i] = ht_box_is_valid(box) ? *box : ht_box_empty();
    }
    *ratio = cost_of(areas, &tree->bounds) / tree->area;
}

htree_status ht_refit(htree *tree, const htree_mesh *mesh, bool *done, double *ratio) {
    refitting r;
    r.tree = tree;
    r.source = ht_source_of(mesh);
    *done = false;
    if (!can_refit(tree, &r.source)) return HTREE_OK;
    if (tree->area == 0) tree->area = cost_as_built(tree);
    HT_TRY(ht_survey_begin(&r.survey, tree, &r.source));
    r.block_count = (tree->node_slots + BLOCK - 1) / BLOCK;
    r.tasks = (r.block_count + TASK_BLOCKS - 1) / TASK_BLOCKS;
    if (r.tasks > MOST_TASKS) r.tasks = MOST_TASKS;
    r.blocks = (block *)ht_allocate(&tree->memory, r.block_count * sizeof *r.blocks);
    if (!r.blocks) return HTREE_ERROR_MEMORY;
    memset(r.blocks, 0, r.block_count * sizeof *r.blocks);
    const htree_status status = refit_runs(&r, done);
    if (*done) finish(&r, ratio);
    ht_release(&tree->memory, r.blocks, r.block_count * sizeof *r.blocks);
    return status;
}
