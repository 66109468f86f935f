#include "visit.h"

/* ---- How each kind reads its nodes ---------------------------------------------------------- */

static void add_child(ht_node_view *view, const ht_place *parent, uint32_t slot,
                      const htree_box *box) {
    ht_place *child = &view->child[view->child_count++];
    child->slot = slot;
    child->depth = parent->depth + 1;
    child->branches = parent->branches + (view->role == HT_SPLIT);
    child->box = *box;
}

/* The box of a child, as far as the nodes above it let rays through. */
static htree_box inside(const ht_place *place, const float *lo, const float *hi) {
    htree_box box;
    memcpy(box.lo, lo, sizeof box.lo);
    memcpy(box.hi, hi, sizeof box.hi);
    return ht_box_intersection(&place->box, &box);
}

static void view_leaf(ht_node_view *view, const uint32_t *prims, uint32_t count) {
    view->role = HT_LEAF;
    view->prims = prims;
    view->prim_count = count;
}

static bool view_bvh(const htree *tree, const ht_place *place, ht_node_view *view) {
    const ht_bvh_node *nodes = (const ht_bvh_node *)tree->nodes;
    const ht_bvh_node *node = &nodes[place->slot];
    view->slots = 1;
    if (node->tag == HT_BVH_LEAF) {
        view_leaf(view, &node->child, 1);
        return true;
    }
    if (node->tag > 2 || node->child >= tree->node_slots - 1) return false;
    view->role = HT_SPLIT;
    for (uint32_t i = 0; i < 2; ++i) {
        const ht_bvh_node *child = &nodes[node->child + i];
        const htree_box box = inside(place, child->lo, child->hi);
        add_child(view, place, node->child + i, &box);
    }
    return true;
}

static void view_h_bound(const ht_h_node *node, const ht_place *place, ht_node_view *view) {
    const uint32_t planes = ht_h_bound_planes(node);
    htree_box by = place->box, box = place->box;
    for (uint32_t i = 0, k = 0; i < 6; ++i) {
        if (!(planes >> i & 1)) continue;
        const float plane = ht_h_plane(node, k++);
        if (i < 3) by.lo[i] = plane;
        if (i >= 3) by.hi[i - 3] = plane;
    }
    ht_cut_by_planes(&box, planes, &by);
    add_child(view, place, place->slot + view->slots, &box);
}

static void view_h_skd(const ht_h_node *node, const ht_place *place, ht_node_view *view) {
    const uint32_t axis = (node->tag & HT_H_TYPE) - HT_H_SKD;
    const uint32_t shelf = node->tag >> HT_H_TAG_BITS;
    htree_box left = place->box, right = place->box;
    left.hi[axis] = ht_min(left.hi[axis], node->a);
    right.lo[axis] = ht_max(right.lo[axis], node->b);
    add_child(view, place, place->slot + 1, &left);
    add_child(view, place, node->child, &right);
    if (!shelf) return;
    add_child(view, place, shelf, &place->box);
    ++view->child[2].branches; /* both other children wait while a ray is in the shelf */
}

static bool view_h(const htree *tree, const ht_place *place, ht_node_view *view) {
    const ht_h_node *node = (const ht_h_node *)tree->nodes + place->slot;
    const uint32_t type = node->tag & HT_H_TYPE;
    view->slots = 1;
    if (type == HT_H_LEAF) {
        view_leaf(view, &node->child, 1);
    } else if (type < HT_H_BV2) {
        view->role = HT_SPLIT;
        view_h_skd(node, place, view);
    } else if (type == HT_H_LINK) {
        view->role = HT_LINK;
        add_child(view, place, node->child, &place->box);
    } else if (type <= HT_H_BVO) {
        const uint32_t planes = ht_h_bound_planes(node);
        view->role = type == HT_H_BV6 ? HT_BV6 : type == HT_H_BVO ? HT_BVO : HT_BV2;
        view->slots = ht_plane_count(planes) > 3 ? 2 : 1;
        if (planes == 0 || planes > HT_ALL_PLANES || view->slots > tree->node_slots - place->slot) {
            return false;
        }
        view_h_bound(node, place, view);
    } else {
        return false;
    }
    return true;
}

static bool view_kd(const htree *tree, const ht_place *place, ht_node_view *view) {
    const ht_kd_node *node = (const ht_kd_node *)tree->nodes + place->slot;
    view->slots = 1;
    if ((node->tag & 3) == HT_KD_LEAF) {
        uint32_t first;
        memcpy(&first, &node->plane, sizeof first);
        const uint32_t count = node->tag >> 2;
        if (first > tree->ref_count || count > tree->ref_count - first) return false;
        view_leaf(view, tree->refs + first, count);
        return true;
    }
    const uint32_t axis = node->tag & 3;
    htree_box left = place->box, right = place->box;
    left.hi[axis] = node->plane;
    right.lo[axis] = node->plane;
    view->role = HT_SPLIT;
    add_child(view, place, place->slot + 1, &left);
    add_child(view, place, node->tag >> 2, &right);
    return true;
}

ht_triangle ht_view_triangle(const htree *tree, const ht_node_view *view, uint32_t i) {
    ht_triangle triangle;
    if (!view->block) return tree->triangles[view->prims[i]];
    for (uint32_t k = 0; k < 9; ++k) triangle.v[k / 3][k % 3] = view->block->v[k / 3][k % 3][i];
    return triangle;
}

/* Walks rely on the order of lanes, and on zeros in those that hold no triangle. */
static bool view_wide_leaf(const htree *tree, const ht_wide_leaf *leaf, ht_node_view *view) {
    const uint32_t count = ht_wide_leaf_count(leaf);
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        const uint32_t prim = leaf->prim[i];
        if (i < count ? prim >= HT_WIDE_LEAF : prim != HT_WIDE_NONE) return false;
        if (i > 0 && i < count && prim < tree->triangle_count &&
            leaf->prim[i - 1] >= tree->triangle_count)
            return false;
        for (uint32_t k = 0; k < 9 && prim >= tree->triangle_count; ++k) {
            if (leaf->v[k / 3][k % 3][i] != 0) return false;
        }
    }
    view_leaf(view, leaf->prim, count);
    view->block = leaf;
    return count > 0;
}

/* Slots of nodes are followed by those of leaves, and these by subtrees of a lazy tree. HTREE_NONE for
 * what is none of them. */
static uint32_t wide_slot(const htree *tree, uint32_t child) {
    if (ht_wide_is_pending(child)) {
        const uint32_t subtree = child & ~HT_WIDE_PENDING;
        if (!tree->lazy || subtree >= tree->lazy->subtrees) return HTREE_NONE;
        child = tree->lazy->child(tree, subtree);
        if (child == HT_WIDE_NONE) return tree->node_slots + tree->leaf_count + subtree;
    }
    const uint32_t leaf = child & ~HT_WIDE_LEAF;
    if (child & HT_WIDE_LEAF) return leaf < tree->leaf_count ? tree->node_slots + leaf : HTREE_NONE;
    return child < tree->node_slots ? child : HTREE_NONE;
}

/* The box of an idle lane, which would be met were it merely inside out by less than a pad. */
static bool is_never_met(const float *lo, const float *hi) {
    const htree_box empty = ht_box_empty();
    return memcmp(lo, empty.lo, sizeof empty.lo) == 0 && memcmp(hi, empty.hi, sizeof empty.hi) == 0;
}

static bool view_wide(const htree *tree, const ht_place *place, ht_wide_leaf *leaf_room,
                      ht_node_view *view) {
    const uint32_t slots = tree->node_slots;
    view->slots = 1;
    if (place->slot >= slots + tree->leaf_count) {
        view->role = HT_PENDING;
        view->prim_count = tree->lazy->prims(tree, place->slot - slots - tree->leaf_count);
        return true;
    }
    if (place->slot >= slots) {
        const uint32_t index = place->slot - slots;
        if (!ht_has_vertices(tree, index)) return false;
        return view_wide_leaf(tree, ht_wide_leaf_at(tree, index, leaf_room), view);
    }
    ht_wide_node room;
    const ht_wide_node *node = ht_wide_node_at(tree, place->slot, &room);
    view->role = HT_SPLIT;
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        const uint32_t slot = wide_slot(tree, node->child[i]);
        const float lo[3] = {node->lo[0][i], node->lo[1][i], node->lo[2][i]};
        const float hi[3] = {node->hi[0][i], node->hi[1][i], node->hi[2][i]};
        const htree_box box = inside(place, lo, hi);
        if (node->child[i] == HT_WIDE_NONE) {
            if (!is_never_met(lo, hi)) return false;
            continue;
        }
        if (slot == HTREE_NONE) return false;
        add_child(view, place, slot, &box);
    }
    for (uint32_t i = 0; i < view->child_count; ++i)
        view->child[i].branches = place->branches + view->child_count - 1;
    return view->child_count > 0;
}

uint64_t ht_slot_count(const htree *tree) {
    const uint32_t subtrees = tree->lazy ? tree->lazy->subtrees : 0;
    return (uint64_t)tree->node_slots + tree->leaf_count + subtrees;
}

bool ht_view_node(const htree *tree, const ht_place *place, ht_wide_leaf *room,
                  ht_node_view *view) {
    if (place->slot >= ht_slot_count(tree)) return false;
    memset(view, 0, sizeof *view);
    switch (tree->kind) {
    case HTREE_KD: return view_kd(tree, place, view);
    case HTREE_BVH_MEDIAN:
    case HTREE_BVH_SAH: return view_bvh(tree, place, view);
    case HTREE_SKD:
    case HTREE_H:
    case HTREE_AH: return view_h(tree, place, view);
    default: return view_wide(tree, place, room, view);
    }
}

/* The root of a BVH has a box as well, which rays must pass. */
ht_place ht_root_place(const htree *tree) {
    ht_place root = {0, 1, 0, tree->bounds};
    if (tree->kind == HTREE_BVH_MEDIAN || tree->kind == HTREE_BVH_SAH) {
        const ht_bvh_node *node = (const ht_bvh_node *)tree->nodes;
        root.box = inside(&root, node->lo, node->hi);
    }
    return root;
}

/* ---- All nodes ------------------------------------------------------------------------------ */

/* Depth first by recursion, which the check of `branches` bounds: chains of bounding and link nodes
 * are followed in the loop. */
static htree_status visit_below(const htree *tree, const ht_place *top, ht_wide_leaf *room,
                                ht_see_node *see, void *data) {
    ht_place place = *top;
    for (;;) {
        ht_node_view view;
        if (!ht_view_node(tree, &place, room, &view)) {
            return ht_fail(HTREE_ERROR_CORRUPT, "slot %lu holds no node",
                           (unsigned long)place.slot);
        }
        if (place.branches > ht_stack_limit(tree->kind)) {
            return ht_fail(HTREE_ERROR_CORRUPT, "the nodes do not form a tree at slot %lu",
                           (unsigned long)place.slot);
        }
        HT_TRY(see(data, &place, &view));
        if (view.child_count == 0) return HTREE_OK;
        for (uint32_t i = 1; i < view.child_count; ++i) {
            HT_TRY(visit_below(tree, &view.child[i], room, see, data));
        }
        place = view.child[0];
    }
}

/* The cells of a grid are leaves side by side. */
static htree_status visit_cells(const htree *tree, ht_see_node *see, void *data) {
    const ht_ug_node *starts = (const ht_ug_node *)tree->nodes;
    const ht_ug_grid *grid = &tree->grid;
    for (uint32_t cell = 0; cell + 1 < tree->node_slots; ++cell) {
        const uint32_t at[3] = {cell % grid->cells[0], cell / grid->cells[0] % grid->cells[1],
                                cell / grid->cells[0] / grid->cells[1]};
        ht_place place = {cell, 1, 0, {{0, 0, 0}, {0, 0, 0}}};
        for (int i = 0; i < 3; ++i) {
            /* Boxes enter cells with the margin by which the grid is larger than the bounds. */
            const float slack = 4 * (tree->bounds.lo[i] - grid->lo[i]);
            place.box.lo[i] = grid->lo[i] + (float)at[i] * grid->size[i] - slack;
            place.box.hi[i] = grid->lo[i] + (float)(at[i] + 1) * grid->size[i] + slack;
        }
        if (starts[cell] > starts[cell + 1] || starts[cell + 1] > tree->ref_count) {
            return ht_fail(HTREE_ERROR_CORRUPT, "cell %lu has no range of references",
                           (unsigned long)cell);
        }
        ht_node_view view;
        memset(&view, 0, sizeof view);
        view.slots = 1;
        view_leaf(&view, tree->refs + starts[cell], starts[cell + 1] - starts[cell]);
        HT_TRY(see(data, &place, &view));
    }
    return HTREE_OK;
}

htree_status ht_visit_nodes(const htree *tree, ht_see_node *see, void *data) {
    if (tree->prim_count == 0) return HTREE_OK;
    if (tree->kind == HTREE_UG) return visit_cells(tree, see, data);
    const ht_place root = ht_root_place(tree);
    ht_wide_leaf room;
    return visit_below(tree, &root, &room, see, data);
}
