/* grid.h: the AH-tree's view of a set of prims (section 7.1): a 3D grid of cubic-like cells,
 * the prims sorted by the cell of their centroid, and a 3D summed-area table of counts. */
#ifndef HT_GRID_H
#define HT_GRID_H

#include "base/arena.h"
#include "prims.h"

/* Cells first <= i < end along each axis. */
typedef struct ht_cells {
    uint32_t first[3], end[3];
} ht_cells;

typedef struct ht_grid {
    const ht_prim *prims; /* the set */
    float origin[3];      /* of the doubled centroids */
    float scale[3];       /* cell = (centroid - origin) * scale */
    float size[3];        /* of a cell, in single lengths */
    uint32_t cells[3];
    uint32_t *order;    /* indices of the small prims, by cell, x fastest */
    uint32_t *start;    /* of each cell in order; one more than cells */
    uint32_t *sums;     /* summed-area table, (cells + 1)^3: prims below and left and before */
    uint32_t *oversize; /* indices of the prims that are larger than a cell along some axis */
    uint32_t small_count, oversize_count;
} ht_grid;

/* Makes the grid of `count` prims with centroids in *centroids, which have some extent, about
 * `cells_per_prim` cells each. Its memory is pushed onto the stack. O(N). */
htree_status ht_grid_make(ht_grid *grid, ht_stack_memory *stack, const ht_prim *prims,
                          uint32_t count, const htree_box *centroids, float cells_per_prim);

/* Small prims with their centroid in these cells: eight look-ups. */
uint32_t ht_grid_count(const ht_grid *grid, const ht_cells *cells);

/* The box that holds every small prim of these cells: half a cell more on each side (figure 6). */
htree_box ht_grid_box(const ht_grid *grid, const ht_cells *cells);

/* Takes empty slabs off all six sides; the cells must not be empty. O(log M). */
void ht_grid_shrink(const ht_grid *grid, ht_cells *cells);

/* Copies the small prims of these cells to `out`. */
void ht_grid_gather(const ht_grid *grid, const ht_cells *cells, ht_prim *out);

/* The cell of a prim's centroid along an axis. */
HT_INLINE uint32_t ht_grid_cell(const ht_grid *grid, const ht_prim *prim, uint32_t axis) {
    const float at = (prim->lo[axis] + prim->hi[axis] - grid->origin[axis]) * grid->scale[axis];
    const uint32_t cell = (uint32_t)at;
    return cell < grid->cells[axis] ? cell : grid->cells[axis] - 1;
}

#endif
