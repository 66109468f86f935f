/* tree_nodes.h: the nodes of a finished tree as boxes with a type and a level: what a viewer draws. */
#ifndef EXAMPLES_TREE_NODES_H
#define EXAMPLES_TREE_NODES_H

#include "htree.h"

#include <stdbool.h>

typedef enum node_type {
    NODE_SKD,   /* two planes: where the left child ends, and where the right one starts */
    NODE_SHELF, /* the same, and a third child for objects that are too large for either */
    NODE_BV2,   /* bounding node of two planes */
    NODE_BV6,   /* of six */
    NODE_SPLIT, /* one plane, kd */
    NODE_BOX,   /* with children, bvh and wide */
    NODE_CELL,  /* of a grid */
    NODE_LEAF,
    NODE_EMPTY, /* leaf or cell without a triangle */
    NODE_TYPES
} node_type;

/* "skd", "bv6", ...: static. */
const char *node_type_name(node_type type);

/* The box is the space that a ray can still be in when it gets to the node. A bounding node has the
 * level of the node that it stands before. */
typedef struct tree_node {
    node_type type;
    uint32_t level;
    htree_box box;
} tree_node;

typedef struct tree_nodes {
    tree_node *node; /* parents before children */
    uint64_t count, room;
    bool full; /* there was no memory for all of them */
} tree_nodes;

/* All nodes of a tree of default options. The caller frees the list, also after a failure. */
htree_status tree_nodes_list(tree_nodes *out, const htree *tree);
void tree_nodes_free(tree_nodes *list);

/* Levels that there are: 1 + the last node's greatest. */
uint32_t tree_nodes_levels(const tree_nodes *list);

#endif
