/* cells.h: 3D grids of cubic-like cells over a box, for the uniform grid and the AH-tree. */
#ifndef HT_CELLS_H
#define HT_CELLS_H

#include "base/vec.h"

/* Divides a box with some extent into the smallest near-cubes that number no more than
 * `wanted`, but at least one. Writes how many lie along each axis, and their size. */
void ht_cubic_cells(const htree_box *box, double wanted, uint32_t cells[3], float size[3]);

#endif
