/* h_nodes.h: writing the nodes of H-trees in depth-first order, in chunks of 16 KiB (section
 * 6.2), and the two steps that the H-tree and the AH-tree share. */
#ifndef HT_H_NODES_H
#define HT_H_NODES_H

#include "build.h"

/* Nodes are named by their slot: they move when the array grows. */
typedef struct ht_h_writer {
    ht_builder *builder;
    bool bounding; /* false: SKD nodes and leaves only */
    ht_h_node *nodes;
    uint32_t capacity, used; /* slots */
    uint32_t deepest;        /* entries that a traversal stack needs */
} ht_h_writer;

HT_INLINE ht_h_node *ht_h_node_at(const ht_h_writer *writer, uint32_t slot) {
    return &writer->nodes[slot];
}

/* Fails with MEMORY; ht_h_writer_end is due either way. */
htree_status ht_h_writer_begin(ht_h_writer *writer, ht_builder *builder, bool bounding);
void ht_h_writer_end(ht_h_writer *writer);

/* Hands the nodes to the tree. */
void ht_h_writer_finish(ht_h_writer *writer);

/* Each takes the next slots and tells the first, *slot; what the node lacks is completed later. */
htree_status ht_h_write_skd(ht_h_writer *writer, uint32_t axis, uint32_t *slot);
htree_status ht_h_write_leaf(ht_h_writer *writer, uint32_t prim, uint32_t level);

/* A bounding node of the planes of `box` in the set `planes` (tree/planes.h). */
htree_status ht_h_write_bound(ht_h_writer *writer, uint32_t planes, const htree_box *box,
                              uint32_t *slot);

/* Overwrites the planes of a bounding node by those of another box. */
void ht_h_rebound(ht_h_node *node, const htree_box *box);

#define HT_H_NO_SLOT UINT32_MAX

/* Writes a bounding node before the SKD node of cost `skd_cost` if that is the cheapest of eqs.
 * 2, 3 and 4, and narrows *traversal by it. tight bounds the `count` objects. *slot: the
 * node's, or none. */
htree_status ht_h_maybe_bound(ht_h_writer *writer, float skd_cost, const htree_box *tight,
                              uint32_t count, htree_box *traversal, uint32_t *slot);

/* Writes the H-tree over `count` prims, by the algorithm of section 6, in h.c. `level` is how
 * many stack entries wait when a ray gets there; tight is B^E and traversal B^T. The prims are
 * permuted. */
htree_status ht_h_subtree(ht_h_writer *writer, ht_prim *prims, ht_prim *spare, uint32_t count,
                          const htree_box *tight, const htree_box *traversal, uint32_t level);

#endif
