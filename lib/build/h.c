/* h.c: the H-tree of section 6: SKD nodes, and bounding nodes where the cost model wants them;
 * without bounding nodes it is the SKD-tree of section 5.
 *
 * At every node the split is found once by eq. 1 (tight boxes), then the cheapest of eqs. 2, 3
 * and 4 decides which node is written: the SKD node itself, or first a bounding node that
 * narrows the traversal box. Two bounding nodes never follow each other. O(N log N). */
#include "h_nodes.h"
#include "cost.h"
#include "split.h"

/* The sets of planes that a bounding node may have: BV2 and BV6, or with HTREE_ANY_PLANES all
 * 63. */
static const uint8_t paper_sets[] = {9, 18, 36, HT_ALL_PLANES};

/* C^T of a node with so many planes: given for two and six, a straight line through both. */
static float bound_traverse_cost(const htree_options *options, uint32_t planes) {
    if (planes == HT_ALL_PLANES) return options->cost_bv6;
    if (ht_slab_axis(planes) < 3) return options->cost_bv2;
    const float beyond_two = (float)ht_plane_count(planes) - 2;
    return options->cost_bv2 + beyond_two * (options->cost_bv6 - options->cost_bv2) / 4;
}

/* The extents of *traversal along each axis when it is cut by no plane, the lower, the upper or
 * both. */
static void cut_extents(const htree_box *traversal, const htree_box *tight, float extent[3][4]) {
    for (int i = 0; i < 3; ++i) {
        const float lo = traversal->lo[i], hi = traversal->hi[i];
        const float cut_lo = ht_max(lo, tight->lo[i]), cut_hi = ht_min(hi, tight->hi[i]);
        extent[i][0] = hi - lo;
        extent[i][1] = hi - cut_lo;
        extent[i][2] = cut_hi - lo;
        extent[i][3] = cut_hi - cut_lo;
    }
}

HT_INLINE float cut_area(float (*extent)[4], uint32_t planes) {
    const float x = extent[0][(planes & 1) | (planes >> 2 & 2)];
    const float y = extent[1][(planes >> 1 & 1) | (planes >> 3 & 2)];
    const float z = extent[2][(planes >> 2 & 1) | (planes >> 4 & 2)];
    return x * (y + z) + y * z;
}

htree_status ht_h_maybe_bound(ht_h_writer *writer, float skd_cost, const htree_box *tight,
                              uint32_t count, htree_box *traversal, uint32_t *slot) {
    const htree_options *options = writer->builder->options;
    const bool any = (options->flags & HTREE_ANY_PLANES) != 0;
    const uint32_t sets = any ? HT_ALL_PLANES : sizeof paper_sets;
    const float scale = ht_chance_scale(traversal);
    float extent[3][4];
    float cheapest = skd_cost;
    uint32_t chosen = 0;
    *slot = HT_H_NO_SLOT;
    cut_extents(traversal, tight, extent);
    for (uint32_t i = 0; i < sets; ++i) {
        const uint32_t planes = any ? i + 1 : paper_sets[i];
        const float chance = scale * cut_area(extent, planes);
        const float cost =
            ht_cost_bound(options, bound_traverse_cost(options, planes), chance, count);
        if (cost < cheapest && chance < 1) {
            cheapest = cost;
            chosen = planes;
        }
    }
    if (!chosen) return HTREE_OK;
    ht_cut_by_planes(traversal, chosen, tight);
    return ht_h_write_bound(writer, chosen, tight, slot);
}

htree_status ht_h_subtree(ht_h_writer *writer, ht_prim *prims, ht_prim *spare, uint32_t count,
                          const htree_box *tight, const htree_box *traversal, uint32_t level) {
    if (count == 1) return ht_h_write_leaf(writer, ht_prim_id(prims), level);
    const htree_options *options = writer->builder->options;
    ht_split split;
    uint32_t bound, slot;
    htree_box box = *traversal;
    const ht_split_rule rule = {HT_MAX_DEPTH - level, 0, false};
    ht_split_find(options, prims, count, &rule, &split);
    ht_split_apply(&split, prims, spare, count);
    const uint32_t axis = split.axis, left = split.left_count;
    const htree_box left_tight = ht_box4_box(&split.left), right_tight = ht_box4_box(&split.right);
    if (writer->bounding) {
        const float skd_cost = ht_cost_skd(options, &box, axis, left_tight.hi[axis],
                                           right_tight.lo[axis], left, count - left);
        HT_TRY(ht_h_maybe_bound(writer, skd_cost, tight, count, &box, &bound));
    }
    HT_TRY(ht_h_write_skd(writer, axis, &slot));
    ht_h_node *node = ht_h_node_at(writer, slot);
    node->a = left_tight.hi[axis];
    node->b = right_tight.lo[axis];
    const htree_box left_box = ht_cut_above(&box, axis, left_tight.hi[axis]);
    HT_TRY(ht_h_subtree(writer, prims, spare, left, &left_tight, &left_box, level + 1));
    ht_h_node_at(writer, slot)->child = writer->used;
    const htree_box right_box = ht_cut_below(&box, axis, right_tight.lo[axis]);
    return ht_h_subtree(writer, prims + left, spare, count - left, &right_tight, &right_box,
                        level + 1);
}

/* A BV6 node at the root (section 6.3), then the SKD node: below a box that is tight already, no
 * bounding node is cheaper. */
static htree_status build_nodes(ht_h_writer *writer, ht_prim *spare) {
    const ht_builder *builder = writer->builder;
    const htree *tree = builder->tree;
    uint32_t root;
    if (writer->bounding) HT_TRY(ht_h_write_bound(writer, HT_ALL_PLANES, &tree->bounds, &root));
    HT_TRY(ht_h_subtree(writer, builder->prims, spare, tree->prim_count, &tree->bounds,
                        &tree->bounds, 0));
    ht_h_writer_finish(writer);
    return HTREE_OK;
}

static htree_status build_h(ht_builder *builder, bool bounding) {
    ht_h_writer writer;
    ht_prim *spare = ht_builder_spare(builder);
    htree_status status =
        spare ? ht_h_writer_begin(&writer, builder, bounding) : HTREE_ERROR_MEMORY;
    if (!spare) return status;
    if (status == HTREE_OK) status = build_nodes(&writer, spare);
    ht_h_writer_end(&writer);
    return status;
}

htree_status ht_build_skd(ht_builder *builder) {
    return build_h(builder, false);
}

htree_status ht_build_h(ht_builder *builder) {
    return build_h(builder, true);
}
