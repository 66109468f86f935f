/* build_tree.h: the tree of a program that needs one, with a progress bar while it is built. */
#ifndef EXAMPLES_BUILD_TREE_H
#define EXAMPLES_BUILD_TREE_H

#include "shape_mesh.h"

#include <stdbool.h>

/* The defaults of `kind`; the caller frees *tree. On failure htree_error_text() says why. */
htree_status build_tree(htree **tree, const shape *s, htree_kind kind, uint32_t threads,
                        bool quiet);

#endif
