/* kd.c: the paper's reference: a kd-tree by the exact surface area heuristic, O(N log N).
 *
 * The boundaries of all boxes are sorted once per axis; a split hands each list on to both
 * children in order, so nothing is sorted again. After V. Havran, "Heuristic Ray Shooting
 * Algorithms", 2000, and I. Wald, V. Havran, "On building fast kd-trees for ray tracing", 2006,
 * without split clipping: boundaries that lie outside a voxel count as lying on its sides,
 * which keeps their order.
 *
 * Termination is automatic (Havran, section 4.5): a voxel is split while a plane lowers its
 * expected cost, down to a depth of 1.2 log2 N + 2. */
#include "event.h"
#include "prims.h"

typedef struct kd_lists {
    kd_event *events[3];
    uint32_t count[3];
    uint32_t prims;
} kd_lists;

typedef struct kd_plane {
    float cost;
    float position;
    uint32_t axis;    /* 3: no plane */
    bool planar_left; /* where boxes that lie in the plane go */
} kd_plane;

typedef struct kd_build {
    ht_builder *builder;
    ht_stack_memory lists;
    uint8_t *side; /* by prim: of the split that is being carried out */
    ht_array nodes, refs;
    uint32_t max_depth;
    uint32_t deepest;
} kd_build;

/* References per prim that a tree may hold; a split at worst doubles those of its voxel. */
static const double REFERENCE_BUDGET = 40;

enum { SIDE_BOTH = 0, SIDE_LEFT = 1, SIDE_RIGHT = 2 };

/* ---- The plane ------------------------------------------------------------------------------ */

static float clamp(float x, float lo, float hi) {
    return ht_max(lo, ht_min(hi, x));
}

/* Sweeps a plane over the boundaries of one axis and keeps the cheapest in *best. Costs are in
 * intersections times half the voxel's area. */
static void sweep_axis(const kd_event *events, uint32_t count, uint32_t prims,
                       const htree_box *voxel, uint32_t axis, kd_plane *best) {
    /* The cut-off of empty space is worth more than its cost says: nothing is ever tested there. */
    const float empty_bonus = 0.8f;
    const float lo = voxel->lo[axis], hi = voxel->hi[axis];
    const float y = voxel->hi[(axis + 1) % 3] - voxel->lo[(axis + 1) % 3];
    const float z = voxel->hi[(axis + 2) % 3] - voxel->lo[(axis + 2) % 3];
    const float cap = y * z, rim = y + z;
    uint32_t left = 0, right = prims;
    for (uint32_t i = 0; i < count;) {
        const float position = clamp(events[i].position, lo, hi);
        uint32_t by_type[3] = {0, 0, 0};
        for (; i < count && clamp(events[i].position, lo, hi) == position; ++i) {
            ++by_type[kd_event_type(&events[i])];
        }
        right -= by_type[KD_END] + by_type[KD_PLANAR];
        if (position > lo && position < hi) {
            const float area_left = cap + rim * (position - lo);
            const float area_right = cap + rim * (hi - position);
            for (uint32_t side = 0; side < (by_type[KD_PLANAR] ? 2u : 1u); ++side) {
                const uint32_t n_left = left + (side == 0 ? by_type[KD_PLANAR] : 0);
                const uint32_t n_right = right + (side == 1 ? by_type[KD_PLANAR] : 0);
                float cost = area_left * (float)n_left + area_right * (float)n_right;
                if (n_left == 0 || n_right == 0) cost *= empty_bonus;
                if (cost < best->cost) {
                    const kd_plane plane = {cost, position, axis, side == 0};
                    *best = plane;
                }
            }
        }
        left += by_type[KD_START] + by_type[KD_PLANAR];
    }
}

/* Whether a plane lowers the expected cost of the voxel. */
static bool pays(const kd_build *build, const kd_plane *plane, const kd_lists *lists,
                 const htree_box *voxel) {
    const htree_options *options = build->builder->options;
    const float before = options->cost_intersect * (float)lists->prims;
    const float after =
        options->cost_skd + options->cost_intersect * plane->cost / ht_box_area(voxel);
    return plane->axis < 3 && after < before;
}

/* The cheapest plane of all axes; or, by default, of the widest axis whose cheapest plane pays. */
static kd_plane find_plane(const kd_build *build, const kd_lists *lists, const htree_box *voxel) {
    kd_plane best = {INFINITY, 0, 3, false};
    const uint32_t widest = (uint32_t)ht_widest_axis(voxel);
    for (uint32_t i = 0; i < 3; ++i) {
        const uint32_t axis = (widest + i) % 3;
        sweep_axis(lists->events[axis], lists->count[axis], lists->prims, voxel, axis, &best);
        if (build->builder->options->axes == 1 && pays(build, &best, lists, voxel)) break;
    }
    return best;
}

/* ---- The split ------------------------------------------------------------------------------ */

static void classify(const kd_build *build, const kd_lists *lists, const kd_plane *plane,
                     uint32_t *left, uint32_t *right) {
    const kd_event *events = lists->events[plane->axis];
    const uint32_t count = lists->count[plane->axis];
    uint32_t only_left = 0, only_right = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const float position = events[i].position;
        const uint32_t type = kd_event_type(&events[i]);
        uint8_t *side = &build->side[kd_event_prim(&events[i])];
        if (type == KD_START) {
            *side = position >= plane->position ? SIDE_RIGHT : SIDE_BOTH;
            only_right += *side == SIDE_RIGHT;
        } else if (type == KD_END) {
            /* A start comes before its end, so this has the last word. */
            if (position <= plane->position) {
                *side = SIDE_LEFT;
                ++only_left;
            }
        } else {
            const bool goes_left =
                position < plane->position || (position == plane->position && plane->planar_left);
            *side = goes_left ? SIDE_LEFT : SIDE_RIGHT;
            only_left += goes_left;
            only_right += !goes_left;
        }
    }
    *left = lists->prims - only_right;
    *right = lists->prims - only_left;
}

/* Splits the three lists: the left one stays in place, the right one goes to the lists' stack. */
static htree_status split_lists(kd_build *build, const kd_plane *plane, kd_lists *lists,
                                kd_lists *right_lists) {
    uint32_t n_left, n_right;
    classify(build, lists, plane, &n_left, &n_right);
    for (int axis = 0; axis < 3; ++axis) {
        kd_event *events = lists->events[axis];
        const uint32_t count = lists->count[axis];
        /* One more: the branch-free loop stores an event before it knows whether it stays. */
        const uint64_t bytes = ((uint64_t)count + 1) * sizeof(kd_event);
        kd_event *apart = (kd_event *)ht_stack_push(&build->lists, bytes);
        if (!apart) return HTREE_ERROR_MEMORY;
        uint32_t left = 0, right = 0;
        for (uint32_t i = 0; i < count; ++i) {
            const kd_event event = events[i];
            const uint8_t side = build->side[kd_event_prim(&event)];
            events[left] = event;
            apart[right] = event;
            left += side != SIDE_RIGHT;
            right += side != SIDE_LEFT;
        }
        ht_stack_trim(&build->lists, apart, (uint64_t)right * sizeof(kd_event));
        lists->count[axis] = left;
        right_lists->events[axis] = apart;
        right_lists->count[axis] = right;
    }
    lists->prims = n_left;
    right_lists->prims = n_right;
    return HTREE_OK;
}

/* ---- The tree ------------------------------------------------------------------------------- */

static htree_status emit_leaf(kd_build *build, uint32_t slot, const kd_lists *lists) {
    const uint64_t first = build->refs.count;
    for (uint32_t i = 0; i < lists->count[0]; ++i) {
        const kd_event *event = &lists->events[0][i];
        if (kd_event_type(event) == KD_END) continue;
        const uint32_t id = ht_prim_id(&build->builder->prims[kd_event_prim(event)]);
        uint32_t *ref = (uint32_t *)ht_array_add(&build->refs);
        if (!ref) return HTREE_ERROR_MEMORY;
        *ref = id;
    }
    ht_kd_node *node = (ht_kd_node *)ht_array_at(&build->nodes, slot);
    const uint32_t first_word = (uint32_t)first;
    memcpy(&node->plane, &first_word, sizeof first_word);
    node->tag = (uint32_t)(build->refs.count - first) << 2 | HT_KD_LEAF;
    return HTREE_OK;
}

/* Splits a voxel while that pays. `budget` is how many references it may come to: its share of
 * REFERENCE_BUDGET, so that a region where everything overlaps cannot starve the others. */
static htree_status subtree(kd_build *build, kd_lists *lists, const htree_box *voxel,
                            uint32_t depth, double budget) {
    const uint32_t slot = (uint32_t)build->nodes.count;
    if (!ht_array_add(&build->nodes)) return HTREE_ERROR_MEMORY;
    if (slot >= HT_KD_SLOTS)
        return ht_fail(HTREE_ERROR_LIMIT, "a kd-tree holds at most 2^30 nodes");
    if (depth > build->deepest) build->deepest = depth;
    const bool may_split = depth < build->max_depth && 2 * (double)lists->prims <= budget;
    kd_plane plane = {0, 0, 3, false};
    if (may_split && lists->prims > 0) plane = find_plane(build, lists, voxel);
    if (!pays(build, &plane, lists, voxel)) {
        if (!ht_progress_step(&build->builder->progress, lists->prims))
            return HTREE_ERROR_CANCELLED;
        return emit_leaf(build, slot, lists);
    }
    kd_lists right;
    const ht_stack_mark mark = ht_stack_top(&build->lists);
    HT_TRY(split_lists(build, &plane, lists, &right));
    const double share = budget / ((double)lists->prims + (double)right.prims);

    htree_box half = *voxel;
    half.hi[plane.axis] = plane.position;
    HT_TRY(subtree(build, lists, &half, depth + 1, share * (double)lists->prims));
    ht_kd_node *node = (ht_kd_node *)ht_array_at(&build->nodes, slot);
    node->plane = plane.position;
    node->tag = (uint32_t)build->nodes.count << 2 | plane.axis;
    half.hi[plane.axis] = voxel->hi[plane.axis];
    half.lo[plane.axis] = plane.position;
    HT_TRY(subtree(build, &right, &half, depth + 1, share * (double)right.prims));
    ht_stack_pop(&build->lists, mark);
    return HTREE_OK;
}

static htree_status build_nodes(kd_build *build) {
    htree *tree = build->builder->tree;
    kd_lists lists;
    lists.prims = tree->prim_count;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        HT_TRY(kd_sorted_events(build->builder, axis, &build->lists, &lists.events[axis],
                                &lists.count[axis]));
    }
    HT_TRY(subtree(build, &lists, &tree->bounds, 0, REFERENCE_BUDGET * (double)tree->prim_count));
    HT_TRY(ht_array_finish(&build->nodes, &tree->nodes));
    tree->node_slots = (uint32_t)build->nodes.count;
    tree->node_bytes = (uint64_t)tree->node_slots * sizeof(ht_kd_node);
    void *refs;
    HT_TRY(ht_array_finish(&build->refs, &refs));
    tree->refs = (uint32_t *)refs;
    tree->ref_count = (uint32_t)build->refs.count;
    tree->stack = build->deepest;
    return HTREE_OK;
}

htree_status ht_build_kd(ht_builder *builder) {
    htree *tree = builder->tree;
    const uint32_t n = tree->prim_count;
    kd_build build;
    memset(&build, 0, sizeof build);
    build.builder = builder;
    build.max_depth = 2 + (6 * ht_levels_needed(n) + 4) / 5;
    ht_stack_begin(&build.lists, &tree->memory);
    ht_array_begin(&build.nodes, &tree->memory, sizeof(ht_kd_node));
    ht_array_begin(&build.refs, &tree->memory, sizeof(uint32_t));
    build.side = (uint8_t *)ht_allocate(&tree->memory, n);
    const htree_status status = build.side ? build_nodes(&build) : HTREE_ERROR_MEMORY;
    ht_release(&tree->memory, build.side, n);
    ht_array_end(&build.refs);
    ht_array_end(&build.nodes);
    ht_stack_end(&build.lists);
    return status;
}
