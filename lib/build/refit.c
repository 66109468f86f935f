/* refit.c: new positions into the leaves of a wide tree, and boxes around them from the leaves up.
 *
 * The top is opened until there are subtrees enough for all threads. Each is refitted depth first,
 * and the top's nodes at last, children before parents. Boxes are as exact as those of a build;
 * what suffers is their fit, which the areas tell. The survey of the mesh is made in the same
 * parallel loop, before its first subtree: to start threads twice costs more than to wait. */
#include "refit.h"
#include "survey.h"
#include "wide.h"

enum { MOST_SUBTREES = 512 };

/* A node of the top, or a subtree: where it hangs. */
typedef struct place {
    uint32_t parent, lane;
    uint32_t child;
    double areas; /* of a subtree: of the boxes below, which weigh what rays do there */
} place;

typedef struct refitting {
    htree *tree;
    ht_source source;
    ht_survey survey;
    place top[MOST_SUBTREES], subtrees[MOST_SUBTREES + HT_LANES];
    uint32_t top_count, subtree_count;
} refitting;

static ht_wide_node *node_at(const htree *tree, uint32_t slot) {
    return (ht_wide_node *)tree->nodes + slot;
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

/* Boxes become planes, four at a time. */
static void set_planes(ht_wide_node *node, const ht_box4 boxes[HT_LANES]) {
    for (uint32_t half = 0; half < HT_LANES; half += 4) {
        ht_f4 lo[4], hi[4];
        for (uint32_t i = 0; i < 4; ++i) {
            lo[i] = boxes[half + i].lo;
            hi[i] = boxes[half + i].hi;
        }
        ht_f4_transpose(lo);
        ht_f4_transpose(hi);
        for (uint32_t axis = 0; axis < 3; ++axis) {
            ht_f4_store(&node->lo[axis][half], lo[axis]);
            ht_f4_store(&node->hi[axis][half], hi[axis]);
        }
    }
}

static void set_lane(ht_wide_node *node, uint32_t lane, const ht_box4 *box) {
    const htree_box b = ht_box4_box(box);
    for (uint32_t axis = 0; axis < 3; ++axis) {
        node->lo[axis][lane] = b.lo[axis];
        node->hi[axis][lane] = b.hi[axis];
    }
}

/* Idle lanes are empty boxes, which add nothing. */
static ht_box4 node_box(const ht_wide_node *node) {
    htree_box box;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        box.lo[axis] = node->lo[axis][0];
        box.hi[axis] = node->hi[axis][0];
        for (uint32_t lane = 1; lane < HT_LANES; ++lane) {
            box.lo[axis] = ht_min(box.lo[axis], node->lo[axis][lane]);
            box.hi[axis] = ht_max(box.hi[axis], node->hi[axis][lane]);
        }
    }
    const ht_box4 out = {ht_f4_set(box.lo[0], box.lo[1], box.lo[2], 0),
                         ht_f4_set(box.hi[0], box.hi[1], box.hi[2], 0)};
    return out;
}

static ht_f4 extent(const ht_wide_node *node, uint32_t axis, uint32_t half) {
    const ht_f4 lo = ht_f4_load(&node->lo[axis][half]), hi = ht_f4_load(&node->hi[axis][half]);
    return ht_f4_max(ht_f4_all(0), ht_f4_sub(hi, lo));
}

/* Of its lanes' boxes; four of them at most are finite in a float (ht_box_area). */
static double node_areas(const ht_wide_node *node) {
    float sums[4];
    ht_f4 sum = ht_f4_all(0);
    for (uint32_t half = 0; half < HT_LANES; half += 4) {
        const ht_f4 x = extent(node, 0, half), y = extent(node, 1, half), z = extent(node, 2, half);
        sum = ht_f4_add(sum, ht_f4_add(ht_f4_mul(x, ht_f4_add(y, z)), ht_f4_mul(y, z)));
    }
    ht_f4_store(sums, sum);
    return (double)sums[0] + (double)sums[1] + ((double)sums[2] + (double)sums[3]);
}

/* ---- Subtrees ------------------------------------------------------------------------------- */

/* Leaves are read once each, and which comes next is known only here. */
static void prefetch_children(const htree *tree, const ht_wide_node *node) {
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        const uint32_t child = node->child[lane];
        if (child == HT_WIDE_NONE) continue;
        if (child & HT_WIDE_LEAF)
            HT_PREFETCH(tree->leaves[child & ~HT_WIDE_LEAF].prim);
        else
            HT_PREFETCH(node_at(tree, child)->child);
    }
}

static ht_box4 refit_node(const refitting *r, uint32_t slot, double *areas);

static ht_box4 refit_child(const refitting *r, uint32_t child, double *areas) {
    if (child == HT_WIDE_NONE) return ht_box4_empty();
    if (!(child & HT_WIDE_LEAF)) return refit_node(r, child, areas);
    return ht_wide_fill_leaf(&r->source, &r->tree->leaves[child & ~HT_WIDE_LEAF]);
}

static ht_box4 refit_node(const refitting *r, uint32_t slot, double *areas) {
    ht_wide_node *node = node_at(r->tree, slot);
    ht_box4 boxes[HT_LANES], all = ht_box4_empty();
    prefetch_children(r->tree, node);
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        boxes[lane] = refit_child(r, node->child[lane], areas);
        ht_box4_add(&all, boxes[lane].lo, boxes[lane].hi);
    }
    set_planes(node, boxes);
    *areas += node_areas(node);
    return all;
}

static void refit_subtree(void *data, uint32_t index) {
    refitting *r = (refitting *)data;
    place *p = &r->subtrees[index];
    const ht_box4 box = refit_child(r, p->child, &p->areas);
    set_lane(node_at(r->tree, p->parent), p->lane, &box);
}

static void survey_and_refit(void *data, uint32_t index) {
    refitting *r = (refitting *)data;
    if (ht_survey_help(&r->survey)) refit_subtree(data, index);
}

/* ---- The top -------------------------------------------------------------------------------- */

/* Opens nodes in order until their children are enough. */
static void open_top(refitting *r) {
    const place root = {0, 0, 0, 0};
    r->top[0] = root;
    r->top_count = 1;
    r->subtree_count = 0;
    for (uint32_t i = 0; i < r->top_count; ++i) {
        const uint32_t slot = r->top[i].child;
        for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
            const place p = {slot, lane, node_at(r->tree, slot)->child[lane], 0};
            const uint32_t waiting = r->top_count - i - 1;
            if (p.child == HT_WIDE_NONE) continue;
            if (!(p.child & HT_WIDE_LEAF) &&
                r->subtree_count + HT_LANES * (waiting + 2) <= MOST_SUBTREES)
                r->top[r->top_count++] = p;
            else
                r->subtrees[r->subtree_count++] = p;
        }
    }
}

/* Children come after their parents in the list. Returns the areas of all boxes. */
static double close_top(const refitting *r) {
    double areas = 0;
    for (uint32_t i = 0; i < r->subtree_count; ++i) areas += r->subtrees[i].areas;
    for (uint32_t i = r->top_count; i-- > 0;) {
        const place *p = &r->top[i];
        const ht_wide_node *node = node_at(r->tree, p->child);
        const ht_box4 box = node_box(node);
        areas += node_areas(node);
        if (i > 0) set_lane(node_at(r->tree, p->parent), p->lane, &box);
    }
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

/* Refits all subtrees, unless that cannot do. */
static htree_status refit_below(refitting *r, bool *done) {
    const htree *tree = r->tree;
    ht_parallel_for(&tree->tasks, tree->threads, r->subtree_count, survey_and_refit, r);
    *done = !r->survey.returning;
    if (!r->survey.odd) return HTREE_OK;
    HT_TRY(ht_survey_closely(&r->survey, done));
    if (*done) ht_parallel_for(&tree->tasks, tree->threads, r->subtree_count, refit_subtree, r);
    return HTREE_OK;
}

htree_status ht_refit(htree *tree, const htree_mesh *mesh, bool *done, double *ratio) {
    refitting r;
    r.tree = tree;
    r.source = ht_source_of(mesh);
    *done = false;
    if (!can_refit(tree, &r.source)) return HTREE_OK;
    if (tree->area == 0) tree->area = cost_as_built(tree);
    HT_TRY(ht_survey_begin(&r.survey, tree, &r.source));
    open_top(&r);
    HT_TRY(refit_below(&r, done));
    if (!*done) return HTREE_OK;
    const double areas = close_top(&r);
    const ht_box4 root = node_box(node_at(tree, 0));
    tree->bounds = ht_box4_box(&root);
    for (uint32_t i = 0; i < tree->object_count; ++i) {
        const htree_box *box = &r.source.boxes[i];
        tree->object_boxes[i] = ht_box_is_valid(box) ? *box : ht_box_empty();
    }
    *ratio = cost_of(areas, &tree->bounds) / tree->area;
    return HTREE_OK;
}
