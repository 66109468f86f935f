/* ah.c: the AH-tree of section 7: expected O(N log log N), because a split never touches the
 * prims.
 *
 * Prims are counted into a 3D grid once. A node is a range of cells; a summed-area table counts
 * any range in constant time, so the plane of least cost is found by interpolation-binary
 * search over the planes between cells. Ranges of few prims go to the algorithm of section 6,
 * crowded cells get a grid of their own. Prims larger than a cell wait on the shelf of the
 * deepest SKD node whose traversal box contains them, and a shelf is a tree again, the node's
 * ternary child (section 7.2).
 *
 * A grid knows boxes only to half a cell. The recursion returns the exact box of what it built,
 * and planes are set from that, at no cost; HTREE_LOOSE_PLANES keeps them as the paper has
 * them. */
#include "cost.h"
#include "h_nodes.h"
#include "search.h"

typedef struct ah_build {
    ht_h_writer writer;
    ht_stack_memory scratch;
} ah_build;

/* A set of prims being built through one grid. */
typedef struct ah_set {
    ah_build *build;
    const ht_grid *grid;
    uint32_t count;
} ah_set;

/* A node to be built: a range of cells with small prims, and a list of oversize ones that lie
 * in its traversal box. */
typedef struct ah_node {
    ht_cells cells;
    uint32_t small;
    uint32_t *oversize; /* indices of prims */
    uint32_t oversize_count;
    htree_box traversal;
    uint32_t level;
} ah_node;

static htree_status build_set(ah_build *build, ht_prim *prims, uint32_t count,
                              const htree_box *traversal, uint32_t level, htree_box *exact);

/* The search may cut off one slab at a time, and a shelf takes two levels: both need some to spare
 * over what the prims need, which section 6 then keeps to. */
static bool levels_run_out(uint32_t level, uint32_t count) {
    enum { SPARE_LEVELS = 8 };
    return level + ht_levels_needed(count) + SPARE_LEVELS > HT_MAX_DEPTH;
}

/* ---- Leaving the grid ----------------------------------------------------------------------- */

/* Section 6 for a set of prims, which may be permuted. */
static htree_status build_h_tree(ah_build *build, ht_prim *prims, uint32_t count,
                                 const htree_box *traversal, uint32_t level, htree_box *exact) {
    const ht_box4 tight = ht_prims_box(prims, count);
    *exact = ht_box4_box(&tight);
    const ht_stack_mark mark = ht_stack_top(&build->scratch);
    ht_prim *spare = (ht_prim *)ht_stack_push(&build->scratch, count * sizeof(ht_prim));
    if (!spare) return HTREE_ERROR_MEMORY;
    htree_box box = *traversal;
    uint32_t bound;
    if (count > 1) {
        /* The root of a subtree has no split yet to compare a bounding node with: not bounding
         * costs N. */
        const htree_options *options = build->writer.builder->options;
        HT_TRY(ht_h_maybe_bound(&build->writer, options->cost_intersect * (float)count, exact,
                                count, &box, &bound));
    }
    HT_TRY(ht_h_subtree(&build->writer, prims, spare, count, exact, &box, level));
    ht_stack_pop(&build->scratch, mark);
    return HTREE_OK;
}

/* Gathers all prims of a node and builds them as a set of their own. */
static htree_status build_gathered(const ah_set *set, const ah_node *node, bool grid_again,
                                   htree_box *exact) {
    ah_build *build = set->build;
    const uint32_t count = node->small + node->oversize_count;
    const ht_stack_mark mark = ht_stack_top(&build->scratch);
    ht_prim *prims = (ht_prim *)ht_stack_push(&build->scratch, count * sizeof(ht_prim));
    if (!prims) return HTREE_ERROR_MEMORY;
    if (node->small) ht_grid_gather(set->grid, &node->cells, prims);
    for (uint32_t i = 0; i < node->oversize_count; ++i) {
        prims[node->small + i] = set->grid->prims[node->oversize[i]];
    }
    if (grid_again) {
        HT_TRY(build_set(build, prims, count, &node->traversal, node->level, exact));
    } else {
        HT_TRY(build_h_tree(build, prims, count, &node->traversal, node->level, exact));
    }
    ht_stack_pop(&build->scratch, mark);
    return HTREE_OK;
}

/* ---- Oversize prims ------------------------------------------------------------------------- */

/* Deals the oversize prims of a node to the child in whose traversal box they lie whole, on the
 * side of their centroid; the rest is the node's shelf. Brings left to the front, then right,
 * then the shelf. */
static void deal_oversize(const ah_set *set, const ah_node *node, uint32_t axis, uint32_t plane,
                          const htree_box *left, const htree_box *right, uint32_t *left_count,
                          uint32_t *right_count) {
    uint32_t *list = node->oversize;
    uint32_t dealt = 0;
    /* Two passes of exchange: lists are short, and their order does not matter but must be
     * fixed. */
    for (uint32_t side = 0; side < 2; ++side) {
        uint32_t kept = dealt;
        for (uint32_t i = dealt; i < node->oversize_count; ++i) {
            const ht_prim *prim = &set->grid->prims[list[i]];
            const htree_box box = {{prim->lo[0], prim->lo[1], prim->lo[2]},
                                   {prim->hi[0], prim->hi[1], prim->hi[2]}};
            const bool is_left = ht_grid_cell(set->grid, prim, axis) < plane;
            if (is_left != (side == 0) || !ht_box_contains(side == 0 ? left : right, &box))
                continue;
            const uint32_t index = list[i];
            list[i] = list[kept];
            list[kept++] = index;
        }
        *(side == 0 ? left_count : right_count) = kept - dealt;
        dealt = kept;
    }
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

static htree_status build_node(const ah_set *set, ah_node *node, htree_box *exact);

/* Whether so many prims of a set deserve a grid of their own. One that did not separate its
 * prims is not tried again: equal centroids would never end. */
static bool is_crowded(const ah_set *set, uint32_t count) {
    return count > set->build->writer.builder->options->few_prims &&
           count < set->count - set->count / 20;
}

/* Few prims, a single cell, or too few levels left. */
static bool leaves_grid(const ah_set *set, const ah_node *node) {
    const htree_options *options = set->build->writer.builder->options;
    const uint32_t count = node->small + node->oversize_count;
    const ht_cells *c = &node->cells;
    const bool one_cell = c->end[0] - c->first[0] == 1 && c->end[1] - c->first[1] == 1 &&
                          c->end[2] - c->first[2] == 1;
    return node->small == 0 || count <= options->few_prims || one_cell ||
           levels_run_out(node->level, count);
}

static htree_status build_shelf(const ah_set *set, const ah_node *node, uint32_t *oversize,
                                uint32_t count, uint32_t skd, htree_box *exact) {
    if (count == 0) return HTREE_OK;
    ah_node shelf = *node;
    htree_box box;
    shelf.small = 0;
    shelf.oversize = oversize;
    shelf.oversize_count = count;
    shelf.level = node->level + 2; /* both other children wait meanwhile */
    ht_h_node_at(&set->build->writer, skd)->tag |= set->build->writer.used << HT_H_TAG_BITS;
    HT_TRY(build_gathered(set, &shelf, is_crowded(set, count), &box));
    ht_box_add(exact, &box);
    return HTREE_OK;
}

/* Sets the planes of an SKD node: exact ones, or those of the grid as long as they hold. */
static void set_planes(const ah_set *set, uint32_t skd, uint32_t axis, float loose_left,
                       float loose_right, const htree_box *left, const htree_box *right) {
    const bool loose = (set->build->writer.builder->options->flags & HTREE_LOOSE_PLANES) != 0;
    ht_h_node *node = ht_h_node_at(&set->build->writer, skd);
    node->a = loose ? ht_max(loose_left, left->hi[axis]) : left->hi[axis];
    node->b = loose ? ht_min(loose_right, right->lo[axis]) : right->lo[axis];
}

static htree_status build_split(const ah_set *set, ah_node *node, const ht_cut *cut,
                                htree_box *exact) {
    ht_h_writer *writer = &set->build->writer;
    const uint32_t axis = cut->axis;
    ah_node left = *node, right = *node;
    htree_box left_exact, right_exact;
    uint32_t skd;
    HT_TRY(ht_h_write_skd(writer, axis, &skd));
    left.cells.end[axis] = cut->plane;
    right.cells.first[axis] = cut->plane;
    left.small = cut->left_count;
    right.small = node->small - cut->left_count;
    left.traversal = ht_cut_above(&node->traversal, axis, cut->left_hi);
    right.traversal = ht_cut_below(&node->traversal, axis, cut->right_lo);
    left.level = right.level = node->level + 1;
    deal_oversize(set, node, axis, cut->plane, &left.traversal, &right.traversal,
                  &left.oversize_count, &right.oversize_count);
    right.oversize = left.oversize + left.oversize_count;
    uint32_t *shelf = right.oversize + right.oversize_count;
    const uint32_t shelf_count = node->oversize_count - left.oversize_count - right.oversize_count;

    HT_TRY(build_node(set, &left, &left_exact));
    ht_h_node_at(writer, skd)->child = writer->used;
    HT_TRY(build_node(set, &right, &right_exact));
    set_planes(set, skd, axis, cut->left_hi, cut->right_lo, &left_exact, &right_exact);
    *exact = left_exact;
    ht_box_add(exact, &right_exact);
    return build_shelf(set, node, shelf, shelf_count, skd, exact);
}

/* The box that a bounding node may have: that of the cells, and of the oversize prims in it. */
static htree_box node_box(const ah_set *set, const ah_node *node) {
    htree_box box = ht_grid_box(set->grid, &node->cells);
    for (uint32_t i = 0; i < node->oversize_count; ++i) {
        const ht_prim *prim = &set->grid->prims[node->oversize[i]];
        ht_box_add_point(&box, prim->lo);
        ht_box_add_point(&box, prim->hi);
    }
    return ht_box_intersection(&box, &node->traversal);
}

static htree_status build_node(const ah_set *set, ah_node *node, htree_box *exact) {
    ht_h_writer *writer = &set->build->writer;
    if (node->small) ht_grid_shrink(set->grid, &node->cells);
    if (leaves_grid(set, node)) {
        const bool crowded = is_crowded(set, node->small + node->oversize_count);
        return build_gathered(set, node, crowded, exact);
    }
    const htree_box tight = node_box(set, node);
    const htree_options *options = writer->builder->options;
    ht_cut cut;
    uint32_t bound;
    ht_find_cut(set->grid, &node->cells, node->small, &tight, &cut);
    const float skd_cost = ht_cost_skd(options, &node->traversal, cut.axis, cut.left_hi,
                                       cut.right_lo, cut.left_count, node->small - cut.left_count);
    HT_TRY(ht_h_maybe_bound(writer, skd_cost, &tight, node->small + node->oversize_count,
                            &node->traversal, &bound));
    HT_TRY(build_split(set, node, &cut, exact));
    if (bound != HT_H_NO_SLOT) {
        /* Even loose planes must hold every prim: the grid's are rounded. */
        htree_box planes = *exact;
        if (options->flags & HTREE_LOOSE_PLANES) ht_box_add(&planes, &tight);
        ht_h_rebound(ht_h_node_at(writer, bound), &planes);
    }
    return HTREE_OK;
}

/* ---- Sets ----------------------------------------------------------------------------------- */

/* One grid over a set of prims. Where all centroids coincide no grid separates them: O(N log N). */
static htree_status build_set(ah_build *build, ht_prim *prims, uint32_t count,
                              const htree_box *traversal, uint32_t level, htree_box *exact) {
    const htree_options *options = build->writer.builder->options;
    const htree_box centroids = ht_centroid_bounds(prims, count);
    const int axis = ht_widest_axis(&centroids);
    const bool separable = centroids.hi[axis] - centroids.lo[axis] > 0;
    if (!separable || count <= options->few_prims || levels_run_out(level, count)) {
        return build_h_tree(build, prims, count, traversal, level, exact);
    }
    ht_grid grid;
    const ht_stack_mark mark = ht_stack_top(&build->scratch);
    HT_TRY(ht_grid_make(&grid, &build->scratch, prims, count, &centroids, options->cells_per_prim));
    const ah_set set = {build, &grid, count};
    ah_node root = {{{0, 0, 0}, {grid.cells[0], grid.cells[1], grid.cells[2]}},
                    grid.small_count,
                    grid.oversize,
                    grid.oversize_count,
                    *traversal,
                    level};
    HT_TRY(build_node(&set, &root, exact));
    ht_stack_pop(&build->scratch, mark);
    return HTREE_OK;
}

static htree_status build_nodes(ah_build *build) {
    const ht_builder *builder = build->writer.builder;
    const htree *tree = builder->tree;
    htree_box exact;
    uint32_t root;
    HT_TRY(ht_h_write_bound(&build->writer, HT_ALL_PLANES, &tree->bounds, &root));
    HT_TRY(build_set(build, builder->prims, tree->prim_count, &tree->bounds, 0, &exact));
    ht_h_writer_finish(&build->writer);
    return HTREE_OK;
}

htree_status ht_build_ah(ht_builder *builder) {
    ah_build build;
    ht_stack_begin(&build.scratch, &builder->tree->memory);
    htree_status status = ht_h_writer_begin(&build.writer, builder, true);
    if (status == HTREE_OK) status = build_nodes(&build);
    ht_h_writer_end(&build.writer);
    ht_stack_end(&build.scratch);
    return status;
}
