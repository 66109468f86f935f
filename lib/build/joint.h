/* joint.h: any binary hierarchy as nodes of two children, to be improved and then collapsed. */
#ifndef HT_JOINT_H
#define HT_JOINT_H

#include "base/arena.h"
#include "build.h"

/* Two subtrees, or one prim: left is its number then, and right is HTREE_NONE. */
typedef struct ht_joint {
    htree_box box; /* tight, whatever the planes of the hierarchy had left of it */
    uint32_t prims;
    uint32_t left, right;
    uint32_t parent; /* HTREE_NONE: none */
    uint32_t height; /* joints below it on the longest way */
} ht_joint;

typedef struct ht_joints {
    ht_array all; /* of ht_joint */
    uint32_t root;
} ht_joints;

HT_INLINE ht_joint *ht_joint_at(const ht_joints *joints, uint32_t i) {
    return (ht_joint *)ht_array_at(&joints->all, i);
}

HT_INLINE bool ht_joint_is_prim(const ht_joint *joint) {
    return joint->right == HTREE_NONE;
}

/* Makes box, prims and height of a joint anew from those of its children. */
HT_INLINE void ht_joint_refit(ht_joint *joint, const ht_joint *left, const ht_joint *right) {
    joint->box = left->box;
    ht_box_add(&joint->box, &right->box);
    joint->prims = left->prims + right->prims;
    joint->height = 1 + (left->height > right->height ? left->height : right->height);
}

/* Reads the finished tree, which holds at least one prim and is no UG, KD or WIDE. */
htree_status ht_joints_read(ht_joints *joints, const htree *tree);

/* reinsert.c: moves subtrees to where a ray is expected to meet fewer boxes. */
htree_status ht_reinsert(const ht_builder *builder, ht_joints *joints);

#endif
