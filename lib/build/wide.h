/* wide.h: what the files of the wide tree's builder share, in the order of the work.
 *
 *     wide.c          all of it
 *     wide_scan.c     every prim once: what can be hit, and its cell
 *     wide_cells.c    finer grids in crowded cells
 *     wide_top.c      the top of the tree over cells, and errands below it
 *     wide_cost.c     errands by cost, joined into a tree;  wide_errand.c: one of them
 *     wide_order.c    errands by Morton order, at once or lazily;  wide_morton.c: one of them
 *     wide_nodes.c    nodes and leaves as walks read them;  x86/leaf_avx2.c: leaves by AVX2
 *     x86/            the scan, errands by Morton order and leaves by cost by AVX-512
 *     wide_compact.c  the finished tree in less memory
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

/* At most `wanted` near-cubes over the box of centroids. */
void ht_wide_grid_shape(ht_wide_grid *grid, const htree_box *centroids, double wanted);

HT_INLINE void ht_wide_grid_at(const ht_wide_grid *grid, ht_f4 lo, ht_f4 hi, int32_t at[4]) {
    const ht_f4 c = ht_f4_sub(ht_f4_add(lo, hi), ht_f4_load(grid->origin));
    ht_f4_store_int(at, ht_f4_min(ht_f4_mul(c, ht_f4_load(grid->scale)), ht_f4_load(grid->last)));
}

HT_INLINE uint32_t ht_wide_grid_cell(const ht_wide_grid *grid, ht_f4 lo, ht_f4 hi) {
    int32_t at[4];
    ht_wide_grid_at(grid, lo, hi, at);
    return ((uint32_t)at[2] * grid->cells[1] + (uint32_t)at[1]) * grid->cells[0] + (uint32_t)at[0];
}

/* The most prims of a cell, unless it is the only one. */
#define HT_WIDE_CELL_PRIMS 384u

/* What the loop over triangles works with: a copy, which no store through a pointer can change. */
typedef struct ht_wide_scanner {
    ht_source source;
    ht_wide_grid grid;
    uint32_t *cell_of, *next; /* by prim; by cell: how many */
    ht_box4 *boxes;           /* by cell */
} ht_wide_scanner;

enum { HT_WIDE_AT_ONCE = 16 };

/* x86/scan_avx512.c: triangles from i on, all vertices in range, up to where they are to be read in
 * another way; returns where that is, and adds to those without area. */
uint32_t ht_wide_scan_avx512(const ht_wide_scanner *given, uint32_t i, uint32_t end,
                             uint64_t *degenerate);

/* ---- Nodes ---------------------------------------------------------------------------------- */

/* Prims or cells in a row, and their box. */
typedef struct ht_wide_run {
    ht_prim *items;
    uint32_t count;
    uint32_t prims; /* count, or what the cells hold */
    ht_box4 box;
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

/* Boxes become planes: eight come row by row and go coordinate by coordinate. */
HT_INLINE void ht_wide_set_planes(ht_wide_node *node, const ht_box4 boxes[HT_LANES]) {
    for (uint32_t half = 0; half < HT_LANES; half += 4) {
        ht_f4 lo[4], hi[4];
        for (uint32_t i = 0; i < 4; ++i) {
            lo[i] = boxes[half + i].lo;
            hi[i] = boxes[half + i].hi;
        }
        ht_f4_transpose(lo);
        ht_f4_transpose(hi);
        for (uint32_t axis = 0; axis < 3; ++axis) {
            ht_f4_store(&node->lo[axis][half], lo[axis]);
            ht_f4_store(&node->hi[axis][half], hi[axis]);
        }
    }
}

/* wide_nodes.c: a node over runs, its children still to come: run i belongs into lane[i]. */
void ht_wide_fill_node(ht_wide_node *node, const ht_wide_run *runs, uint32_t count,
                       const ht_box4 *box, uint32_t lane[HT_LANES]);
/* The same with child i in lane i. */
void ht_wide_fill_in_order(ht_wide_node *node, const ht_box4 *parts, const uint32_t *child,
                           uint32_t count);
htree_status ht_wide_write_node(ht_wide_part *part, const ht_wide_run *runs, uint32_t count,
                                const ht_box4 *box, uint32_t lane[HT_LANES], uint32_t *slot);

HT_INLINE void ht_wide_set_child(ht_wide_part *part, uint32_t slot, uint32_t lane, uint32_t child) {
    ((ht_wide_node *)ht_array_at(&part->nodes, slot))->child[lane] = child;
}

/* A leaf over a range of leaf_order. */
htree_status ht_wide_add_leaf(ht_wide_part *part, uint32_t first, uint32_t count, uint32_t *child);

/* A leaf of at most HT_LANES prims; user objects come last. Returns their box. */
ht_box4 ht_wide_write_leaf(ht_isa isa, const ht_source *source, const uint32_t *prims,
                           uint32_t count, ht_wide_leaf *leaf);

/* The corners of a leaf's triangles, zero where a lane is idle. */
void ht_wide_write_corners(const ht_corners corners[HT_LANES], ht_wide_leaf *leaf);
/* The same of a leaf that has its prims. */
ht_box4 ht_wide_fill_leaf(ht_isa isa, const ht_source *source, ht_wide_leaf *leaf);

/* x86/leaf_avx2.c: the triangles of a leaf that has some, and their box; false, and nothing done,
 * if they are not to be read this way. */
bool ht_wide_fill_avx2(const ht_source *source, uint32_t triangles, ht_wide_leaf *leaf,
                       ht_box4 *box);

/* x86/leaves_avx512.c: the first of some leaves over order[0 .. end); returns how many, which ends
 * where one is to be written in another way. */
uint32_t ht_wide_write_avx512(const ht_source *from, const uint32_t *order, uint32_t end,
                              const ht_wide_leaf_run *runs, uint32_t count, ht_wide_leaf *leaves);

/* ---- Errands -------------------------------------------------------------------------------- */

/* A subtree to be built over the prims of some cells. */
typedef struct ht_wide_errand {
    ht_wide_run cells;
    uint32_t first;          /* where its prims go in leaf_order */
    uint32_t level, waiting; /* nodes above it, and what can wait on a ray's stack there */
    uint32_t parent, lane;   /* in the top: what it is a child of; HT_WIDE_NONE: it is the tree */
    uint32_t child;          /* by cost: counted from the start of its group's part */
    uint32_t node, leaf;     /* by order: where its nodes and leaves begin */
} ht_wide_errand;

typedef struct ht_wide_top {
    ht_wide_part part;
    ht_array errands; /* of ht_wide_errand */
} ht_wide_top;

/* wide_top.c */
void ht_wide_top_begin(ht_wide_top *top, ht_memory *memory);
void ht_wide_top_end(ht_wide_top *top);

/* ---- The build ------------------------------------------------------------------------------ */

typedef struct ht_wide_build {
    ht_builder *builder;
    ht_source source;
    uint32_t prims; /* of the mesh, skipped ones included */
    ht_wide_cells cells;
    ht_wide_top top;
} ht_wide_build;

HT_INLINE ht_wide_errand *ht_wide_errand_at(const ht_wide_build *build, uint32_t i) {
    return (ht_wide_errand *)ht_array_at(&build->top.errands, i);
}

HT_INLINE void ht_wide_set_parent(const htree *tree, const ht_wide_errand *errand, uint32_t child) {
    if (errand->parent != HT_WIDE_NONE)
        ((ht_wide_node *)tree->nodes)[errand->parent].child[errand->lane] = child;
}

/* wide.c: memory for the finished tree. */
htree_status ht_wide_allocate(htree *tree, uint64_t nodes, uint64_t leaves);

/* wide_scan.c: sets the tree's bounds and counts, and sorts what can be hit into cells. */
htree_status ht_wide_scan(ht_wide_build *build);

/* wide_cells.c: replaces crowded cells by finer ones. */
htree_status ht_wide_refine(ht_wide_build *build);

/* wide_top.c */
htree_status ht_wide_build_top(ht_wide_build *build);

/* wide_cost.c and wide_errand.c: prims and spare hold as many prims as the errand has. */
htree_status ht_wide_finish_by_cost(ht_wide_build *build);
htree_status ht_wide_run_errand(const ht_wide_build *build, ht_wide_errand *errand,
                                ht_wide_part *part, ht_prim *prims, ht_prim *spare);
void ht_wide_gather(const ht_source *source, const uint32_t *order, const ht_wide_run *cells,
                    ht_prim *out);

/* wide_order.c and wide_morton.c: nodes, leaves and stack entries that a subtree takes; and the
 * subtree of an errand of at most HT_WIDE_CELL_PRIMS, into its place. `room` has
 * ht_wide_morton_room() bytes, and is aligned as whatever the library allocates. */
htree_status ht_wide_finish_by_order(ht_wide_build *build);
uint32_t ht_wide_morton_nodes(uint32_t prims);
uint32_t ht_wide_morton_leaves(uint32_t prims);
uint32_t ht_wide_morton_stack(uint32_t prims);
uint64_t ht_wide_morton_room(void);
void ht_wide_run_morton(const htree *tree, const ht_source *source, const uint32_t *order,
                        const ht_wide_errand *errand, void *room);

/* x86/morton_avx512.c: the same of triangles alone; false, and nothing done, if they are not to be
 * read this way. */
uint64_t ht_wide_morton_avx512_room(void);
bool ht_wide_run_morton_avx512(const htree *tree, const ht_source *source, const uint32_t *order,
                               const ht_wide_errand *errand, void *room);

/* wide_compact.c: takes the place of the tree's nodes and leaves. */
htree_status ht_wide_compact(const ht_builder *builder);

#endif
