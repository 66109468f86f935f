/* tree.c: the tree as an object: its end, its bounds, and the boxes of its prims. */
#include "tree.h"

htree_status ht_tree_verify(const htree *tree) {
    return tree ? HTREE_OK : ht_fail(HTREE_ERROR_ARGUMENT, "tree is NULL");
}

htree_box ht_prim_box(const htree *tree, uint32_t prim) {
    if (prim >= tree->triangle_count) return tree->object_boxes[prim - tree->triangle_count];
    htree_box box = ht_box_empty();
    for (int k = 0; k < 3; ++k) ht_box_add_point(&box, tree->triangles[prim].v[k]);
    return box;
}

bool ht_prim_is_hittable(const htree *tree, uint32_t prim) {
    if (prim >= tree->triangle_count) {
        const htree_box *box = &tree->object_boxes[prim - tree->triangle_count];
        return box->lo[0] <= box->hi[0];
    }
    /* A skipped triangle was zeroed, and a triangle of zeros has no area. */
    const ht_triangle *triangle = &tree->triangles[prim];
    return !ht_triangle_is_degenerate(triangle->v[0], triangle->v[1], triangle->v[2]);
}

void htree_free(htree *tree) {
    if (!tree) return;
    ht_memory memory = tree->memory;
    ht_release(&memory, tree->nodes, tree->node_bytes);
    ht_release(&memory, tree->refs, tree->ref_count * sizeof *tree->refs);
    ht_release(&memory, tree->object_boxes, tree->object_count * sizeof *tree->object_boxes);
    ht_release(&memory, tree->triangles, tree->triangle_count * sizeof *tree->triangles);
    ht_release(&memory, tree, sizeof *tree);
}

htree_status htree_get_bounds(const htree *tree, htree_box *bounds) {
    HT_TRY(ht_tree_verify(tree));
    if (!bounds) return ht_fail(HTREE_ERROR_ARGUMENT, "bounds is NULL");
    *bounds = tree->bounds;
    return HTREE_OK;
}
