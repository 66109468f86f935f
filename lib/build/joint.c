/* joint.c: reads a binary hierarchy of any kind. Nodes of one child are left out, and one of
 * three is two of two. */
#include "joint.h"
#include "tree/visit.h"

enum { CHILDREN = 3 /* that a node of a hierarchy has at most, its shelf included */ };

static htree_box box_of_prim(const htree *tree, uint32_t prim) {
    htree_box box = ht_box_empty();
    if (prim >= tree->triangle_count) return tree->object_boxes[prim - tree->triangle_count];
    for (int k = 0; k < 3; ++k) ht_box_add_point(&box, tree->triangles[prim].v[k]);
    return box;
}

static htree_status add_joint(ht_joints *joints, uint32_t left, uint32_t right, uint32_t *index) {
    *index = (uint32_t)joints->all.count;
    ht_joint *joint = (ht_joint *)ht_array_add(&joints->all);
    if (!joint) return HTREE_ERROR_MEMORY;
    joint->left = left;
    joint->right = right;
    joint->parent = HTREE_NONE;
    return HTREE_OK;
}

static htree_status add_prim(ht_joints *joints, const htree *tree, uint32_t prim, uint32_t *index) {
    HT_TRY(add_joint(joints, prim, HTREE_NONE, index));
    ht_joint *joint = ht_joint_at(joints, *index);
    joint->box = box_of_prim(tree, prim);
    joint->prims = 1;
    return HTREE_OK;
}

/* Joins one more subtree to the one at *index, if there is one yet. */
static htree_status join(ht_joints *joints, uint32_t *index, uint32_t other) {
    const uint32_t left = *index;
    if (left == HTREE_NONE) {
        *index = other;
        return HTREE_OK;
    }
    HT_TRY(add_joint(joints, left, other, index));
    ht_joint_refit(ht_joint_at(joints, *index), ht_joint_at(joints, left),
                   ht_joint_at(joints, other));
    ht_joint_at(joints, left)->parent = ht_joint_at(joints, other)->parent = *index;
    return HTREE_OK;
}

/* Writes the children of a node, and joins what its own leaf holds; apart from the recursion, whose
 * frames are small so. */
static HT_NOINLINE htree_status read_node(ht_joints *joints, const htree *tree,
                                          const ht_place *place, ht_place *child, uint32_t *count,
                                          uint32_t *index) {
    ht_node_view view;
    (void)ht_view_node(tree, place, NULL, &view);
    *index = HTREE_NONE;
    for (uint32_t i = 0; i < view.prim_count; ++i) {
        uint32_t prim;
        HT_TRY(add_prim(joints, tree, view.prims[i], &prim));
        HT_TRY(join(joints, index, prim));
    }
    *count = view.child_count;
    memcpy(child, view.child, view.child_count * sizeof *child);
    return HTREE_OK;
}

static htree_status read_subtree(ht_joints *joints, const htree *tree, const ht_place *place,
                                 uint32_t *index) {
    ht_place child[CHILDREN];
    uint32_t count;
    HT_TRY(read_node(joints, tree, place, child, &count, index));
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t below;
        HT_TRY(read_subtree(joints, tree, &child[i], &below));
        HT_TRY(join(joints, index, below));
    }
    return HTREE_OK;
}

htree_status ht_joints_read(ht_joints *joints, const htree *tree) {
    const ht_place place = ht_root_place(tree);
    HT_TRY(ht_array_reserve(&joints->all, 2 * (uint64_t)tree->prim_count));
    return read_subtree(joints, tree, &place, &joints->root);
}
