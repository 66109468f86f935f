/* wide.h: what the files of the wide tree's builder share: runs of prims, and the nodes and leaves
 * that they become. */
#ifndef HT_WIDE_H
#define HT_WIDE_H

#include "base/arena.h"
#include "split.h"

/* Prims in a row, or cells of prims (ht_cell_prims), and their box. */
typedef struct ht_wide_run {
    ht_prim *items;
    uint32_t count;
    uint32_t prims; /* count, or what the cells hold */
    htree_box box;
} ht_wide_run;

/* Nodes and leaves that one thread writes; slots and indices count from the part's own start. */
typedef struct ht_wide_part {
    ht_builder *builder;
    ht_array nodes, leaves;
    uint32_t deepest; /* entries that a traversal stack can need */
} ht_wide_part;

void ht_wide_part_begin(ht_wide_part *part, ht_builder *builder);
void ht_wide_part_end(ht_wide_part *part);

/* wide_nodes.c: a leaf of at most HT_LANES prims; *child is what a node says of it. */
htree_status ht_wide_write_leaf(ht_wide_part *part, const ht_wide_run *run, uint32_t *child);

/* A node over runs, its children still to come: run i belongs into lane[i]. */
htree_status ht_wide_write_node(ht_wide_part *part, const ht_wide_run *runs, uint32_t count,
                                const htree_box *box, uint32_t lane[HT_LANES], uint32_t *slot);

/* wide_cells.c: sorts all prims into the cells of a grid over their centroids, in builder->spare,
 * and lists the cells that hold any: a box each, and a range of the sorted prims. */
typedef struct ht_wide_cells {
    ht_prim *cells; /* in memory of `capacity` */
    uint32_t count, capacity;
} ht_wide_cells;

htree_status ht_wide_cells_begin(ht_wide_cells *cells, ht_builder *builder);
void ht_wide_cells_end(ht_wide_cells *cells, ht_builder *builder);

#endif
