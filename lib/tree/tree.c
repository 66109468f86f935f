/* tree.c: the tree as an object: its end, its bounds, and the boxes of its prims. */
#include "tree.h"
#include "base/sized.h"

htree_status ht_tree_verify(const htree *tree) {
    return tree ? HTREE_OK : ht_fail(HTREE_ERROR_ARGUMENT, "tree is NULL");
}

uint64_t ht_slot_bytes(htree_kind kind) {
    switch (kind) {
    case HTREE_UG: return sizeof(ht_ug_node);
    case HTREE_KD: return sizeof(ht_kd_node);
    case HTREE_BVH_MEDIAN:
    case HTREE_BVH_SAH: return sizeof(ht_bvh_node);
    case HTREE_WIDE: return sizeof(ht_wide_node);
    default: return sizeof(ht_h_node);
    }
}

uint32_t ht_stack_limit(htree_kind kind) {
    /* A wide node's children are all pushed before one of them is taken. */
    return kind == HTREE_WIDE ? HT_WIDE_STACK - 1 : HT_MAX_DEPTH;
}

bool ht_triangle_is_valid(const ht_triangle *triangle) {
    return ht_point_is_valid(triangle->v[0]) && ht_point_is_valid(triangle->v[1]) &&
           ht_point_is_valid(triangle->v[2]);
}

void ht_tree_release(htree *tree) {
    ht_memory *memory = &tree->memory;
    if (tree->lazy) tree->lazy->end(tree);
    ht_release(memory, tree->skipped, tree->skipped_count * sizeof *tree->skipped);
    if (tree->borrowed) return;
    ht_release(memory, tree->nodes, tree->node_bytes);
    ht_release(memory, tree->refs, tree->ref_count * sizeof *tree->refs);
    ht_release(memory, tree->leaves, tree->leaf_count * sizeof *tree->leaves);
    ht_release(memory, tree->compact_leaves, tree->leaf_count * sizeof *tree->compact_leaves);
    ht_release(memory, tree->vertices, 3 * sizeof(float) * (uint64_t)tree->vertex_count);
    ht_release(memory, tree->object_boxes, tree->object_count * sizeof *tree->object_boxes);
    ht_release(memory, tree->triangles, tree->triangle_count * sizeof *tree->triangles);
}

void htree_free(htree *tree) {
    if (!tree) return;
    ht_tree_release(tree);
    ht_recycler_end(&tree->memory);
    ht_memory memory = tree->memory;
    ht_release(&memory, tree, sizeof *tree);
}

/* The struct as version 0.1 knew it. */
enum { FIRST_VIEW_SIZE = sizeof(htree_view) };

static htree_view view_tree(const htree *tree) {
    htree_view v;
    memset(&v, 0, sizeof v);
    v.kind = tree->kind;
    v.bounds = tree->bounds;
    v.prims = tree->prim_count;
    v.triangle_count = tree->triangle_count;
    v.object_count = tree->object_count;
    v.stack = tree->stack;
    v.triangles = (const float *)tree->triangles;
    v.nodes = tree->prim_count ? tree->nodes : NULL;
    v.node_bytes = v.nodes ? tree->node_slots * ht_slot_bytes(tree->kind) : 0;
    if (tree->refs) {
        v.leaves = tree->refs;
        v.leaf_bytes = tree->ref_count * sizeof *tree->refs;
    }
    if (tree->leaves) {
        v.leaves = tree->leaves;
        v.leaf_bytes = tree->leaf_count * sizeof *tree->leaves;
    }
    if (tree->kind == HTREE_UG && v.nodes) {
        v.grid = &tree->grid;
        v.grid_bytes = sizeof tree->grid;
    }
    return v;
}

htree_status htree_get_view(const htree *tree, htree_view *view) {
    HT_TRY(ht_tree_verify(tree));
    if (!view) return ht_fail(HTREE_ERROR_ARGUMENT, "view is NULL");
    HT_TRY(ht_sized_verify(view->size, FIRST_VIEW_SIZE, "view"));
    if (tree->lazy)
        return ht_fail(HTREE_ERROR_UNSUPPORTED, "the tree is lazy: call htree_complete first");
    if (ht_is_compact(tree))
        return ht_fail(HTREE_ERROR_UNSUPPORTED, "a compact tree has no arrays to show");
    const htree_view v = view_tree(tree);
    ht_sized_write(view, &v, sizeof v);
    return HTREE_OK;
}

htree_status htree_get_bounds(const htree *tree, htree_box *bounds) {
    HT_TRY(ht_tree_verify(tree));
    if (!bounds) return ht_fail(HTREE_ERROR_ARGUMENT, "bounds is NULL");
    *bounds = tree->bounds;
    return HTREE_OK;
}
