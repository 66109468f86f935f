/* h.c: the H-tree of section 6: SKD nodes, and bounding nodes where the cost model wants them; without
 * bounding nodes it is the SKD-tree of section 5.
 *
 * At every node the split is found once by eq. 1 (tight boxes), then the cheapest of eqs. 2, 3 and
 * 4 decides which node is written: the SKD node itself, or first a BV2 or BV6 that narrows the
 * traversal box. Two bounding nodes never follow each other. Nodes leave in depth-first order into
 * chunks of 16 KiB, joined by link nodes (section 6.2). O(N log N). */
#include "cost.h"

typedef struct h_build {
    ht_builder *builder;
    bool bounding;
    ht_h_node **chunks;
    uint32_t chunk_capacity, chunk_count;
    uint32_t used;    /* slots taken in the last chunk */
    uint32_t deepest; /* levels of branching below the root */
} h_build;

/* ---- Nodes in chunks ---------------------------------------------------------------------- */

static htree_status chunk_begin(h_build *build) {
    assert(build->chunk_count < build->chunk_capacity);
    const uint64_t bytes = HT_H_CHUNK_SLOTS * sizeof(ht_h_node);
    ht_h_node *chunk = (ht_h_node *)ht_allocate(&build->builder->tree->memory, bytes);
    if (!chunk) return HTREE_ERROR_MEMORY;
    build->chunks[build->chunk_count++] = chunk;
    build->used = 0;
    return HTREE_OK;
}

static uint32_t next_slot(const h_build *build) {
    return (build->chunk_count - 1) * HT_H_CHUNK_SLOTS + build->used;
}

/* Takes `slots` slots in a row; the last slot of a chunk is kept for the link to the next one. */
static htree_status node_begin(h_build *build, uint32_t slots, ht_h_node **node) {
    if (build->used + slots >= HT_H_CHUNK_SLOTS) {
        ht_h_node *link = &build->chunks[build->chunk_count - 1][build->used];
        const uint32_t unused = HT_H_CHUNK_SLOTS - build->used - 1;
        memset(link, 0, (unused + 1) * sizeof *link);
        HT_TRY(chunk_begin(build));
        link->child = next_slot(build);
        link->tag = HT_H_LINK;
    }
    *node = &build->chunks[build->chunk_count - 1][build->used];
    memset(*node, 0, slots * sizeof **node);
    build->used += slots;
    return HTREE_OK;
}

static htree_status emit_bv2(h_build *build, uint32_t axis, const htree_box *box) {
    ht_h_node *node;
    HT_TRY(node_begin(build, 1, &node));
    node->a = box->lo[axis];
    node->b = box->hi[axis];
    node->tag = HT_H_BV2 + axis;
    return HTREE_OK;
}

static htree_status emit_bv6(h_build *build, const htree_box *box) {
    ht_h_node *node;
    ht_h_bv6 bv6 = {{0, 0, 0}, HT_H_BV6, {0, 0, 0}, 0};
    memcpy(bv6.lo, box->lo, sizeof bv6.lo);
    memcpy(bv6.hi, box->hi, sizeof bv6.hi);
    HT_TRY(node_begin(build, 2, &node));
    memcpy(node, &bv6, sizeof bv6);
    return HTREE_OK;
}

static htree_status emit_leaf(h_build *build, uint32_t prim) {
    ht_h_node *node;
    HT_TRY(node_begin(build, 1, &node));
    node->child = prim;
    node->tag = HT_H_LEAF;
    return HTREE_OK;
}

/* ---- Choice of the node type -------------------------------------------------------------- */

/* Writes a bounding node before the SKD node of `split` if that is the cheapest of eqs. 2, 3, 4,
 * and narrows *traversal by it. tight is B^E, the box of the objects. */
static htree_status maybe_bound(h_build *build, const ht_split *split, const htree_box *tight,
                                uint32_t count, htree_box *traversal) {
    const htree_options *options = build->builder->options;
    float cheapest = ht_cost_skd(options, traversal, split, count);
    uint32_t bv2_axis = 3;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        htree_box slab = *traversal;
        slab.lo[axis] = tight->lo[axis];
        slab.hi[axis] = tight->hi[axis];
        const float cost = ht_cost_bound(options->cost_bv2, options, traversal, &slab, count);
        if (cost < cheapest) {
            cheapest = cost;
            bv2_axis = axis;
        }
    }
    if (ht_cost_bound(options->cost_bv6, options, traversal, tight, count) < cheapest) {
        HT_TRY(emit_bv6(build, tight));
        *traversal = *tight;
    } else if (bv2_axis < 3) {
        HT_TRY(emit_bv2(build, bv2_axis, tight));
        traversal->lo[bv2_axis] = tight->lo[bv2_axis];
        traversal->hi[bv2_axis] = tight->hi[bv2_axis];
    }
    return HTREE_OK;
}

static htree_status subtree(h_build *build, uint32_t first, uint32_t count, const htree_box *tight,
                            htree_box traversal, uint32_t level) {
    ht_prim *prims = build->builder->prims + first;
    if (count == 1) {
        if (level > build->deepest) build->deepest = level;
        if (!ht_progress_step(&build->builder->progress, 1)) return HTREE_ERROR_CANCELLED;
        return emit_leaf(build, ht_prim_id(prims));
    }
    ht_split split;
    ht_split_find(build->builder->options, prims, count, HT_MAX_DEPTH - level, &split);
    ht_split_apply(&split, prims, build->builder->spare, count);
    if (build->bounding && level > 0) HT_TRY(maybe_bound(build, &split, tight, count, &traversal));

    const uint32_t axis = split.axis;
    ht_h_node *node;
    HT_TRY(node_begin(build, 1, &node));
    node->a = split.left.hi[axis];
    node->b = split.right.lo[axis];
    node->tag = HT_H_SKD + axis;
    HT_TRY(subtree(build, first, split.left_count, &split.left,
                   ht_cut_above(&traversal, axis, split.left.hi[axis]), level + 1));
    node->child = next_slot(build);
    return subtree(build, first + split.left_count, count - split.left_count, &split.right,
                   ht_cut_below(&traversal, axis, split.right.lo[axis]), level + 1);
}

/* ---- The tree ----------------------------------------------------------------------------- */

/* Moves the chunks into the tree's one array: slots stay as they are. */
static htree_status collect(h_build *build) {
    htree *tree = build->builder->tree;
    tree->node_slots = next_slot(build);
    tree->node_slot_bytes = sizeof(ht_h_node);
    tree->stack = build->deepest;
    tree->nodes = ht_allocate(&tree->memory, (uint64_t)tree->node_slots * sizeof(ht_h_node));
    if (!tree->nodes) return HTREE_ERROR_MEMORY;
    for (uint32_t i = 0; i < build->chunk_count; ++i) {
        const uint32_t slots = i + 1 < build->chunk_count ? HT_H_CHUNK_SLOTS : build->used;
        memcpy((ht_h_node *)tree->nodes + (size_t)i * HT_H_CHUNK_SLOTS, build->chunks[i],
               slots * sizeof(ht_h_node));
    }
    return HTREE_OK;
}

static htree_status build_nodes(h_build *build) {
    const htree *tree = build->builder->tree;
    HT_TRY(chunk_begin(build));
    if (build->bounding) HT_TRY(emit_bv6(build, &tree->bounds));
    HT_TRY(subtree(build, 0, tree->prim_count, &tree->bounds, tree->bounds, 0));
    return collect(build);
}

static htree_status build_h(ht_builder *builder, bool bounding) {
    htree *tree = builder->tree;
    /* At most 4 slots an object (section 6.2); slots are 32 bits. */
    const uint64_t most_slots = 4 * (uint64_t)tree->prim_count + 2;
    const uint64_t most_chunks = most_slots / (HT_H_CHUNK_SLOTS - 2) + 1;
    if (most_chunks * HT_H_CHUNK_SLOTS > UINT32_MAX) {
        return ht_fail(HTREE_ERROR_LIMIT, "an H-tree holds at most 2^30 objects");
    }
    h_build build = {builder, bounding, NULL, (uint32_t)most_chunks, 0, 0, 0};
    build.chunks = (ht_h_node **)ht_allocate(&tree->memory, most_chunks * sizeof *build.chunks);
    if (!build.chunks) return HTREE_ERROR_MEMORY;

    const htree_status status = build_nodes(&build);
    for (uint32_t i = 0; i < build.chunk_count; ++i) {
        ht_release(&tree->memory, build.chunks[i], HT_H_CHUNK_SLOTS * sizeof(ht_h_node));
    }
    ht_release(&tree->memory, build.chunks, most_chunks * sizeof *build.chunks);
    return status;
}

htree_status ht_build_skd(ht_builder *builder) {
    return build_h(builder, false);
}

htree_status ht_build_h(ht_builder *builder) {
    return build_h(builder, true);
}
