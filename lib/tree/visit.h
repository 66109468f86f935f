/* visit.h: one way to see the nodes of any kind, for statistics and for proofs, not for rays. */
#ifndef HT_VISIT_H
#define HT_VISIT_H

#include "tree.h"

/* A node, and the traversal box that the nodes above it leave: B^T of the paper's section 6.1. */
typedef struct ht_place {
    uint32_t slot;
    uint32_t depth;    /* nodes on the way from the root, this one included */
    uint32_t branches; /* entries that wait on a ray's stack when it gets here */
    htree_box box;
} ht_place;

typedef enum ht_node_role {
    HT_LEAF,
    HT_SPLIT,
    HT_BV2,
    HT_BV6,
    HT_BVO,
    HT_LINK,
    HT_PENDING, /* a subtree of a lazy tree that is not built */
    HT_ROLES
} ht_node_role;

/* What a node is: for a leaf its prims, if it is built, else its children with their traversal boxes. */
typedef struct ht_node_view {
    ht_node_role role;
    uint32_t slots;        /* that the node takes */
    const uint32_t *prims; /* of a leaf */
    uint32_t prim_count;
    const ht_wide_leaf *block; /* of a wide leaf: the triangles themselves */
    uint32_t child_count;
    ht_place child[8];
} ht_node_view;

/* Corners of triangle i of a viewed leaf. */
ht_triangle ht_view_triangle(const htree *tree, const ht_node_view *view, uint32_t i);

/* Slots that places may have. */
uint64_t ht_slot_count(const htree *tree);

ht_place ht_root_place(const htree *tree);

/* Views the node at *place; false if it is no node of the tree's kind or reaches outside its slots.
 * Leaves of a compact tree are expanded into *room, which only those need. */
bool ht_view_node(const htree *tree, const ht_place *place, ht_wide_leaf *room, ht_node_view *view);

/* Calls see(data, place, view) for every node, parents first, until it fails. CORRUPT if a node
 * cannot be viewed or lies deeper than a walk's stack; cycles go on until `see` fails. */
typedef htree_status ht_see_node(void *data, const ht_place *place, const ht_node_view *view);
htree_status ht_visit_nodes(const htree *tree, ht_see_node *see, void *data);

#endif
