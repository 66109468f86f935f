/* bvh.c: bounding volume hierarchies: tight boxes, one object a leaf, 2 N - 1 nodes, split by eq. 1
 * (section 5) or at the spatial median (section 9).
 *
 * A subtree over n prims takes 2 n - 1 slots wherever it is built, so the place of every node
 * follows from counts alone. O(N log N). */
#include "split.h"

typedef struct bvh_build {
    ht_builder *builder;
    bool median;
    ht_bvh_node *nodes;
    uint32_t deepest; /* levels of branching below the root */
} bvh_build;

/* Writes the subtree of prims first..first+count into nodes[slot] and, from `below` on, its 2 n - 2
 * other nodes. */
static htree_status subtree(bvh_build *build, uint32_t slot, uint32_t below, uint32_t first,
                            uint32_t count, const htree_box *box, uint32_t level) {
    ht_prim *prims = build->builder->prims + first;
    ht_bvh_node *node = &build->nodes[slot];
    memcpy(node->lo, box->lo, sizeof node->lo);
    memcpy(node->hi, box->hi, sizeof node->hi);
    if (count == 1) {
        node->child = ht_prim_id(prims);
        node->tag = HT_BVH_LEAF;
        if (level > build->deepest) build->deepest = level;
        if (!ht_progress_step(&build->builder->progress, 1)) return HTREE_ERROR_CANCELLED;
        return HTREE_OK;
    }
    ht_split split;
    if (build->median) {
        ht_split_find_median(prims, count, box, HT_MAX_DEPTH - level, &split);
    } else {
        const ht_split_rule rule = {HT_MAX_DEPTH - level, 0, false};
        ht_split_find(build->builder->options, prims, count, &rule, &split);
    }
    ht_split_apply(&split, prims, build->builder->spare, count);
    node->child = below;
    node->tag = split.axis;
    const uint32_t left = split.left_count;
    const htree_box left_box = ht_box4_box(&split.left), right_box = ht_box4_box(&split.right);
    HT_TRY(subtree(build, below, below + 2, first, left, &left_box, level + 1));
    return subtree(build, below + 1, below + 2 * left, first + left, count - left, &right_box,
                   level + 1);
}

static htree_status build_bvh(ht_builder *builder, bool median) {
    htree *tree = builder->tree;
    if (tree->prim_count > UINT32_MAX / 2) {
        return ht_fail(HTREE_ERROR_LIMIT, "a BVH holds at most 2^31 - 1 objects");
    }
    bvh_build build = {builder, median, NULL, 0};
    tree->node_slots = 2 * tree->prim_count - 1;
    tree->node_bytes = (uint64_t)tree->node_slots * sizeof(ht_bvh_node);
    tree->nodes = ht_allocate(&tree->memory, tree->node_bytes);
    if (!tree->nodes || !ht_builder_spare(builder)) return HTREE_ERROR_MEMORY;
    build.nodes = (ht_bvh_node *)tree->nodes;
    HT_TRY(subtree(&build, 0, 1, 0, tree->prim_count, &tree->bounds, 0));
    tree->stack = build.deepest;
    return HTREE_OK;
}

htree_status ht_build_bvh_median(ht_builder *builder) {
    return build_bvh(builder, true);
}

htree_status ht_build_bvh_sah(ht_builder *builder) {
    return build_bvh(builder, false);
}
