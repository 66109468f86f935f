/* refit.h: new positions into the nodes of a finished tree. */
#ifndef HT_REFIT_H
#define HT_REFIT_H

#include "source.h"

/* Brings a wide tree to the mesh without building, if *done says so: then *ratio is the cost now
 * over that of the build. Else the tree is as it was, and so it is after an error: GEOMETRY, MEMORY. */
htree_status ht_refit(htree *tree, const htree_mesh *mesh, bool *done, double *ratio);

#endif
