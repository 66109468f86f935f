/* search.h: the plane of least cost between the cells of a range, in expected O(log log M)
 * steps. */
#ifndef HT_SEARCH_H
#define HT_SEARCH_H

#include "grid.h"

/* A cut of a range of cells: cells below `plane` go left. Both sides hold small prims. */
typedef struct ht_cut {
    uint32_t axis;
    uint32_t plane;
    uint32_t left_count;
    float left_hi, right_lo; /* the SKD planes: half a cell beyond, and before, the cut */
} ht_cut;

/* Finds the cut of a range of more than one cell, shrunk by ht_grid_shrink, that holds `count`
 * small prims within *box. */
void ht_find_cut(const ht_grid *grid, const ht_cells *cells, uint32_t count, const htree_box *box,
                 ht_cut *cut);

#endif
