/* refit.c: new positions into the leaves of a wide tree, and boxes around them from the leaves up.
 *
 * The top is opened until there are subtrees enough for all threads. Each is refitted depth first,
 * and the top's nodes at last, children before parents. Boxes are as exact as those of a build;
 * what suffers is their fit, which the areas tell. */
#include "refit.h"
#include "wide.h"

/* ---- Before anything changes ---------------------------------------------------------------- */

enum { CHUNKS = 64, MOST_SUBTREES = 512 };

typedef struct survey {
    const htree *tree;
    ht_source source;
    uint32_t skipped[CHUNKS];
    uint32_t bad[CHUNKS]; /* the first prim that has no vertex */
    bool plain[CHUNKS];   /* every index is a vertex, and every vertex and box is in range */
} survey;

typedef struct range {
    uint64_t first, end;
} range;

static range chunk_of(uint64_t count, uint32_t index) {
    const range r = {count * index / CHUNKS, count * (index + 1) / CHUNKS};
    return r;
}

/* Arrays in their order, which is faster than triangle by triangle. */
static void survey_arrays(void *data, uint32_t index) {
    survey *s = (survey *)data;
    const ht_source source = s->source;
    const range indices = chunk_of(source.indices ? 3 * (uint64_t)source.triangle_count : 0, index);
    const range vertices = chunk_of(source.vertex_count, index);
    const range boxes = chunk_of(source.object_count, index);
    uint32_t largest = 0;
    bool plain = true;
    for (uint64_t i = indices.first; i < indices.end; ++i)
        largest = source.indices[i] > largest ? source.indices[i] : largest;
    for (uint64_t i = vertices.first; i < vertices.end; ++i) {
        const ht_f4 p = ht_source_position(&source, i);
        const uint32_t in = ht_f4_above(ht_f4_all(2 * HTREE_COORDINATE_MAX), ht_f4_magnitude(p));
        plain &= (~in & HT_XYZ) == 0;
    }
    for (uint64_t i = boxes.first; i < boxes.end; ++i) plain &= ht_box_is_valid(&source.boxes[i]);
    s->plain[index] = plain && (indices.first == indices.end || largest < source.vertex_count);
}

static bool is_skipped(const ht_source *source, uint32_t i) {
    if (i >= source->triangle_count)
        return !ht_box_is_valid(&source->boxes[i - source->triangle_count]);
    const ht_corners corners = ht_source_corners(source, i);
    return ht_corners_judge(&corners) != HT_HITTABLE;
}

static void survey_prims(void *data, uint32_t index) {
    survey *s = (survey *)data;
    const ht_source source = s->source;
    const range prims = chunk_of((uint64_t)source.triangle_count + source.object_count, index);
    uint32_t skipped = 0;
    for (uint32_t i = (uint32_t)prims.first; i < prims.end; ++i) {
        if (i < source.triangle_count && HT_UNLIKELY(!ht_source_has_corners(&source, i))) {
            s->bad[index] = i;
            return;
        }
        skipped += is_skipped(&source, i);
    }
    s->skipped[index] = skipped;
}

/* As many skipped prims as before are the same ones if the tree refers to none of them. */
static void survey_leaves(void *data, uint32_t index) {
    survey *s = (survey *)data;
    const range leaves = chunk_of(s->tree->leaf_count, index);
    uint32_t skipped = 0;
    for (uint64_t i = leaves.first; i < leaves.end; ++i) {
        const uint32_t *prims = s->tree->leaves[i].prim;
        for (uint32_t k = 0; k < HT_LANES && prims[k] != HT_WIDE_NONE; ++k)
            skipped += is_skipped(&s->source, prims[k]);
    }
    s->skipped[index] = skipped;
}

static void run_survey(survey *s, ht_task *task) {
    ht_parallel_for(&s->tree->tasks, s->tree->threads, CHUNKS, task, s);
}

static bool is_plain(survey *s) {
    bool plain = true;
    run_survey(s, survey_arrays);
    for (uint32_t i = 0; i < CHUNKS; ++i) plain &= s->plain[i];
    return plain;
}

/* Judges the prims that the tree does not refer to. */
static htree_status find_returning(const survey *s, bool *returns) {
    const htree *tree = s->tree;
    const uint32_t prims = tree->triangle_count + tree->object_count;
    const uint64_t bytes = prims / 8 + 1;
    ht_memory memory = {tree->memory.hook, 0, 0, NULL};
    uint8_t *known = (uint8_t *)ht_allocate(&memory, bytes);
    if (!known) return HTREE_ERROR_MEMORY;
    memset(known, 0, (size_t)bytes);
    for (uint32_t i = 0; i < tree->leaf_count; ++i) {
        const uint32_t *prim = tree->leaves[i].prim;
        for (uint32_t k = 0; k < HT_LANES && prim[k] != HT_WIDE_NONE; ++k)
            known[prim[k] >> 3] = (uint8_t)(known[prim[k] >> 3] | 1u << (prim[k] & 7));
    }
    *returns = false;
    for (uint32_t i = 0; i < prims && !*returns; ++i)
        *returns = !(known[i >> 3] >> (i & 7) & 1) && !is_skipped(&s->source, i);
    ht_release(&memory, known, bytes);
    return HTREE_OK;
}

static uint64_t sum_of_skipped(const survey *s) {
    uint64_t sum = 0;
    for (uint32_t i = 0; i < CHUNKS; ++i) sum += s->skipped[i];
    return sum;
}

htree_status ht_refit_verify(const htree *tree, const htree_mesh *mesh, bool *can) {
    survey s;
    memset(&s, 0, sizeof s);
    memset(s.bad, 0xff, sizeof s.bad);
    s.tree = tree;
    s.source = ht_source_of(mesh);
    *can = tree->kind == HTREE_WIDE && !tree->lazy && tree->leaves && !tree->borrowed &&
           s.source.triangle_count == tree->triangle_count &&
           s.source.object_count == tree->object_count;
    if (!*can) return HTREE_OK;
    /* Where everything is in range, triangles without area are all that could be new, and those do
     * no harm in a leaf. */
    if (is_plain(&s)) {
        bool returns = false;
        if (tree->invalid + tree->degenerate) HT_TRY(find_returning(&s, &returns));
        *can = !returns;
        return HTREE_OK;
    }
    run_survey(&s, survey_prims);
    for (uint32_t i = 0; i < CHUNKS; ++i) {
        if (s.bad[i] != HTREE_NONE) return ht_refuse_prim(&s.source, s.bad[i], true);
    }
    const uint64_t skipped = sum_of_skipped(&s);
    *can = skipped == tree->invalid + tree->degenerate;
    if (!*can || skipped == 0) return HTREE_OK;
    run_survey(&s, survey_leaves);
    *can = sum_of_skipped(&s) == 0;
    return HTREE_OK;
}

/* ---- Subtrees ------------------------------------------------------------------------------- */

typedef struct subtree {
    uint32_t parent, lane;
    double areas; /* of the boxes below, which weigh what rays do there */
} subtree;

typedef struct refitting {
    htree *tree;
    ht_source source;
    bool as_built; /* measures areas, and changes nothing */
    uint32_t top[MOST_SUBTREES];
    subtree subtrees[MOST_SUBTREES + HT_LANES];
    uint32_t top_count, subtree_count;
} refitting;

static ht_wide_node *node_at(const refitting *r, uint32_t slot) {
    return (ht_wide_node *)r->tree->nodes + slot;
}

static ht_box4 lane_box(const ht_wide_node *node, uint32_t lane) {
    ht_box4 box;
    box.lo = ht_f4_set(node->lo[0][lane], node->lo[1][lane], node->lo[2][lane], 0);
    box.hi = ht_f4_set(node->hi[0][lane], node->hi[1][lane], node->hi[2][lane], 0);
    return box;
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
    ht_box4 box = ht_box4_empty();
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        const ht_box4 one = lane_box(node, lane);
        ht_box4_add(&box, one.lo, one.hi);
    }
    return box;
}

static ht_box4 refit_leaf(const refitting *r, ht_wide_leaf *leaf) {
    uint32_t prims[HT_LANES];
    memcpy(prims, leaf->prim, sizeof prims);
    return ht_wide_write_leaf(&r->source, prims, ht_wide_leaf_count(leaf), leaf);
}

/* Leaves are read once each, and which comes next is known only here. */
static void prefetch_children(const refitting *r, const ht_wide_node *node) {
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        const uint32_t child = node->child[lane];
        if (child == HT_WIDE_NONE) continue;
        if (child & HT_WIDE_LEAF)
            HT_PREFETCH(r->tree->leaves[child & ~HT_WIDE_LEAF].prim);
        else
            HT_PREFETCH(node_at(r, child)->child);
    }
}

static ht_box4 refit_node(const refitting *r, uint32_t slot, double *areas);

/* What hangs in a lane, and the lane's own box around it, which is returned. */
static ht_box4 refit_lane(const refitting *r, ht_wide_node *node, uint32_t lane, double *areas) {
    const uint32_t child = node->child[lane];
    ht_box4 box = lane_box(node, lane);
    if (!(child & HT_WIDE_LEAF)) {
        box = refit_node(r, child, areas);
    } else if (!r->as_built) {
        box = refit_leaf(r, &r->tree->leaves[child & ~HT_WIDE_LEAF]);
    }
    if (!r->as_built) set_lane(node, lane, &box);
    return box;
}

static ht_box4 refit_node(const refitting *r, uint32_t slot, double *areas) {
    ht_wide_node *node = node_at(r, slot);
    prefetch_children(r, node);
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        if (node->child[lane] == HT_WIDE_NONE) continue;
        const ht_box4 box = refit_lane(r, node, lane, areas);
        const htree_box b = ht_box4_box(&box);
        *areas += (double)ht_box_area(&b);
    }
    return node_box(node);
}

static void refit_subtree(void *data, uint32_t index) {
    refitting *r = (refitting *)data;
    subtree *s = &r->subtrees[index];
    (void)refit_lane(r, node_at(r, s->parent), s->lane, &s->areas);
}

/* ---- The top -------------------------------------------------------------------------------- */

/* Opens nodes in order until their children are enough. */
static void open_top(refitting *r) {
    r->top[0] = 0;
    r->top_count = 1;
    r->subtree_count = 0;
    for (uint32_t i = 0; i < r->top_count; ++i) {
        const ht_wide_node *node = node_at(r, r->top[i]);
        for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
            const uint32_t child = node->child[lane];
            const uint32_t waiting = r->top_count - i - 1;
            if (child == HT_WIDE_NONE) continue;
            if (!(child & HT_WIDE_LEAF) &&
                r->subtree_count + HT_LANES * (waiting + 2) <= MOST_SUBTREES) {
                r->top[r->top_count++] = child;
            } else {
                const subtree s = {r->top[i], lane, 0};
                r->subtrees[r->subtree_count++] = s;
            }
        }
    }
}

/* Children come after their parents in the list. */
static void close_top(const refitting *r) {
    for (uint32_t i = r->top_count; i-- > 0;) {
        ht_wide_node *node = node_at(r, r->top[i]);
        for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
            const uint32_t child = node->child[lane];
            bool opened = false;
            for (uint32_t k = i + 1; k < r->top_count && !opened; ++k) opened = r->top[k] == child;
            if (!opened || child & HT_WIDE_LEAF) continue;
            const ht_box4 box = node_box(node_at(r, child));
            set_lane(node, lane, &box);
        }
    }
}

/* Areas of all boxes over that of the bounds: what a ray that meets these is expected to meet. */
static double run(refitting *r, bool as_built) {
    double areas = 0;
    htree *tree = r->tree;
    r->as_built = as_built;
    open_top(r);
    ht_parallel_for(&tree->tasks, tree->threads, r->subtree_count, refit_subtree, r);
    if (!as_built) close_top(r);
    for (uint32_t i = 0; i < r->subtree_count; ++i) areas += r->subtrees[i].areas;
    for (uint32_t i = 0; i < r->top_count; ++i) {
        const ht_wide_node *node = node_at(r, r->top[i]);
        for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
            const ht_box4 box = lane_box(node, lane);
            const htree_box b = ht_box4_box(&box);
            areas += (double)ht_box_area(&b);
        }
    }
    const ht_box4 root = node_box(node_at(r, 0));
    tree->bounds = ht_box4_box(&root);
    const double area = (double)ht_box_area(&tree->bounds);
    return area > 0 ? areas / area : 1;
}

double ht_refit(htree *tree, const htree_mesh *mesh) {
    refitting r;
    r.tree = tree;
    r.source = ht_source_of(mesh);
    if (tree->area == 0) tree->area = run(&r, true);
    for (uint32_t i = 0; i < tree->object_count; ++i) {
        const htree_box *box = &r.source.boxes[i];
        tree->object_boxes[i] = ht_box_is_valid(box) ? *box : ht_box_empty();
    }
    return run(&r, false) / tree->area;
}
