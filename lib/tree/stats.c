/* stats.c: htree_get_stats: the paper's columns of a finished tree, and its expected cost. */
#include "visit.h"
#include "base/float_env.h"
#include "base/sized.h"

typedef struct census {
    uint64_t roles[HT_ROLES];
    uint64_t references, ternary;
    uint32_t depth;
    double cost; /* of the nodes, weighted by the chance that a ray through the bounds meets them */
    double bounds_area;
    double role_cost[HT_ROLES];
} census;

static htree_status count_node(void *data, const ht_place *place, const ht_node_view *view) {
    census *c = (census *)data;
    ++c->roles[view->role];
    c->references += view->role == HT_LEAF ? view->prim_count : 0;
    c->ternary += view->child_count == 3;
    if (place->depth > c->depth) c->depth = place->depth;
    const double chance =
        c->bounds_area > 0 ? (double)ht_box_area(&place->box) / c->bounds_area : 1;
    c->cost += chance * (view->role == HT_LEAF ? view->prim_count * c->role_cost[HT_LEAF]
                                               : c->role_cost[view->role]);
    return HTREE_OK;
}

/* A node of boxes bounds and branches at once. */
static bool is_of_boxes(const htree *tree) {
    return tree->kind == HTREE_BVH_SAH || tree->kind == HTREE_BVH_MEDIAN ||
           tree->kind == HTREE_WIDE;
}

static htree_status take_census(const htree *tree, census *c) {
    memset(c, 0, sizeof *c);
    c->bounds_area = (double)ht_box_area(&tree->bounds);
    c->role_cost[HT_LEAF] = (double)tree->cost_intersect;
    c->role_cost[HT_SPLIT] = (double)(is_of_boxes(tree) ? tree->cost_bv6 : tree->cost_skd);
    c->role_cost[HT_BV2] = (double)tree->cost_bv2;
    c->role_cost[HT_BV6] = (double)tree->cost_bv6;
    c->role_cost[HT_BVO] = (double)tree->cost_bv6;
    return ht_visit_nodes(tree, count_node, c);
}

/* The struct as version 0.1 knew it. */
enum { FIRST_STATS_SIZE = sizeof(htree_stats) };

static htree_status get_stats(const htree *tree, htree_stats *stats) {
    census c;
    HT_TRY(ht_tree_verify(tree));
    if (!stats) return ht_fail(HTREE_ERROR_ARGUMENT, "stats is NULL");
    HT_TRY(ht_sized_verify(stats->size, FIRST_STATS_SIZE, "stats"));
    HT_TRY(take_census(tree, &c));
    htree_stats s;
    memset(&s, 0, sizeof s);
    s.kind = tree->kind;
    s.triangles = tree->triangle_count;
    s.objects = tree->object_count;
    s.invalid = tree->invalid;
    s.degenerate = tree->degenerate;
    for (int role = 0; role < HT_PENDING; ++role) s.nodes += c.roles[role];
    s.leaves = c.roles[HT_LEAF];
    s.references = c.references;
    s.skd_nodes = is_of_boxes(tree) ? 0 : c.roles[HT_SPLIT];
    s.bv2_nodes = c.roles[HT_BV2];
    s.bv6_nodes = is_of_boxes(tree) ? c.roles[HT_SPLIT] : c.roles[HT_BV6];
    s.bvo_nodes = c.roles[HT_BVO];
    s.ternary_nodes = is_of_boxes(tree) ? 0 : c.ternary;
    s.link_nodes = c.roles[HT_LINK];
    s.depth = c.depth;
    s.stack = tree->stack;
    s.bytes = tree->memory.held;
    s.peak_bytes = tree->memory.peak;
    s.build_seconds = tree->build_seconds;
    s.sah_cost = c.cost;
    s.subtrees = tree->lazy ? tree->lazy->subtrees : 0;
    s.subtrees_built = tree->lazy ? tree->lazy->built(tree) : 0;
    ht_sized_write(stats, &s, sizeof s);
    return HTREE_OK;
}

htree_status htree_get_stats(const htree *tree, htree_stats *stats) {
    HT_RETURN_IN_DEFAULT_ENV(get_stats(tree, stats));
}
