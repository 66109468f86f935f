/* prims.h: what builders ask of a run of prims. */
#ifndef HT_PRIMS_H
#define HT_PRIMS_H

#include "build.h"

/* B^E: the box of the prims; and that of their centroids, doubled as in ht_prim. */
ht_box4 ht_prims_box(const ht_prim *prims, uint32_t count);
htree_box ht_centroid_bounds(const ht_prim *prims, uint32_t count);

/* The levels that a binary tree over so many prims has at least. */
uint32_t ht_levels_needed(uint32_t count);

#endif
