/* refit.h: new positions into the nodes of a finished tree. */
#ifndef HT_REFIT_H
#define HT_REFIT_H

#include "source.h"

/* Whether refitting can bring the tree to the mesh; GEOMETRY if the mesh is to be refused. On all
 * cores. */
htree_status ht_refit_verify(const htree *tree, const htree_mesh *mesh, bool *can);

/* Refits a wide tree to a mesh that was verified. Returns the cost now over that of the build. */
double ht_refit(htree *tree, const htree_mesh *mesh);

#endif
