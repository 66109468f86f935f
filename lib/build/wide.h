/* wide.h: what the files of the wide tree's builder share.
 *
 *     wide_scan.c     every triangle once: what can be hit, and its cell
 *     wide_cells.c    prims sorted by cell; crowded cells get a grid of their own
 *     wide_top.c      the top of the tree over cells, and errands below it
 *     wide_errand.c   the subtree of an errand, over prims
 *     wide_nodes.c    nodes and leaves as walks read them
 *     wide.c          all of it, in order, on all cores
 */
#ifndef HT_WIDE_H
#define HT_WIDE_H

#include "base/arena.h"
#include "source.h"
#include "split.h"

/* ---- Cells ---------------------------------------------------------------------------------- */

/* A grid over doubled centroids: cell(c) = (c - origin) * scale, x fastest. */
typedef struct ht_wide_grid {
    float origin[4], scale[4], last[4]; /* last: cells - 1; the last lane is 0 */
    uint32_t cells[3], total;
} ht_wide_grid;

/* Prims in a range of `order`, as weighted prims of the top (ht_cell_prims). */
typedef struct ht_wide_cells {
    ht_array cells; /* of ht_prim */
    uint32_t *order;
    uint32_t *leaf_order; /* scratch, then the prims in the order of leaves */
} ht_wide_cells;

/* At most `wanted` cells over the box of centroids. */
void ht_wide_grid_shape(ht_wide_grid *grid, const htree_box *centroids, double wanted);

HT_INLINE uint32_t ht_wide_grid_cell(const ht_wide_grid *grid, ht_f4 lo, ht_f4 hi) {
    const ht_f4 c = ht_f4_sub(ht_f4_add(lo, hi), ht_f4_load(grid->origin));
    int32_t at[4];
    ht_f4_store_int(at, ht_f4_min(ht_f4_mul(c, ht_f4_load(grid->scale)), ht_f4_load(grid->last)));
    return ((uint32_t)at[2] * grid->cells[1] + (uint32_t)at[1]) * grid->cells[0] + (uint32_t)at[0];
}

/* wide_scan.c: sets the tree's bounds and counts, and sorts what can be hit into cells. */
htree_status ht_wide_scan(ht_builder *builder, const ht_source *source, ht_wide_cells *cells);

/* wide_cells.c: replaces crowded cells by finer ones. */
htree_status ht_wide_refine(ht_builder *builder, const ht_source *source, ht_wide_cells *cells);

/* ---- Nodes ---------------------------------------------------------------------------------- */

/* Prims or cells in a row, and their box. */
typedef struct ht_wide_run {
    ht_prim *items;
    uint32_t count;
    uint32_t prims; /* count, or what the cells hold */
    htree_box box;
} ht_wide_run;

/* Splits a run into at most eight; returns how many. With `scarce` each split is in the middle, so
 * that no run keeps more than an eighth, rounded up. */
uint32_t ht_wide_split(const htree_options *options, ht_prim *spare, const ht_wide_run *all,
                       bool scarce, bool cells, ht_wide_run *runs);

/* Nodes and leaves of some errands, counted from the part's own start. */
typedef struct ht_wide_part {
    ht_array nodes;   /* of ht_wide_node */
    ht_array leaves;  /* of ht_wide_leaf_run */
    uint32_t deepest; /* entries that a traversal stack can need */
} ht_wide_part;

/* A leaf to be: a range of leaf_order. */
typedef struct ht_wide_leaf_run {
    uint32_t first, count;
} ht_wide_leaf_run;

void ht_wide_part_begin(ht_wide_part *part, ht_memory *memory);
void ht_wide_part_end(ht_wide_part *part);

/* wide_nodes.c: a node over runs, its children still to come: run i belongs into lane[i]. */
htree_status ht_wide_write_node(ht_wide_part *part, const ht_wide_run *runs, uint32_t count,
                                const htree_box *box, uint32_t lane[HT_LANES], uint32_t *slot);

HT_INLINE void ht_wide_set_child(ht_wide_part *part, uint32_t slot, uint32_t lane, uint32_t child) {
    ((ht_wide_node *)ht_array_at(&part->nodes, slot))->child[lane] = child;
}

/* A leaf of at most HT_LANES prims; user objects come last. */
void ht_wide_write_leaf(const ht_source *source, const uint32_t *prims, uint32_t count,
                        ht_wide_leaf *leaf);

/* ---- Errands -------------------------------------------------------------------------------- */

/* A subtree to be built over the prims of some cells. */
typedef struct ht_wide_errand {
    ht_wide_run cells;
    uint32_t first;          /* where its prims go in leaf_order */
    uint32_t level, waiting; /* nodes above it, and what can wait on a ray's stack there */
    uint32_t parent, lane;   /* in the top: what it is a child of; HT_WIDE_NONE: it is the tree */
    uint32_t child;          /* counted from the start of its group's part */
} ht_wide_errand;

/* wide_top.c: the top of the tree, and the errands below it. */
typedef struct ht_wide_top {
    ht_wide_part part;
    ht_array errands; /* of ht_wide_errand */
    uint32_t prims;   /* of the errands so far */
} ht_wide_top;

htree_status ht_wide_build_top(ht_builder *builder, const ht_wide_cells *cells, ht_wide_top *top);

/* wide_errand.c: builds the subtree of an errand; prims and spare hold as many prims as it has. */
htree_status ht_wide_run_errand(ht_builder *builder, const ht_source *source,
                                const ht_wide_cells *cells, ht_wide_errand *errand,
                                ht_wide_part *part, ht_prim *prims, ht_prim *spare);

#endif
