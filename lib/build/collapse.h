/* collapse.h: binary hierarchies as wide trees. */
#ifndef HT_COLLAPSE_H
#define HT_COLLAPSE_H

#include "build.h"

/* Replaces a finished BVH, SKD-tree or H-tree of at least one prim by a wide tree. */
htree_status ht_collapse(const ht_builder *builder);

#endif
