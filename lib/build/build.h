/* build.h: what builders are given and what they give back. A builder turns `prims` into nodes. */
#ifndef HT_BUILD_H
#define HT_BUILD_H

#include "tree/tree.h"

/* A prim as builders see it: its box. Centroids are kept doubled, lo + hi: one rounding, no
 * division. */
typedef struct ht_prim {
    float lo[3];
    uint32_t id;
    float hi[3];
    uint32_t unused;
} ht_prim;

typedef struct ht_builder {
    const htree_options *options;
    htree *tree; /* geometry, bounds and counts are set; the builder sets nodes and stack */
    ht_prim
        *prims; /* tree->prim_count of them, at least 1, in order of id; the builder may permute */
    ht_prim *spare; /* as many again, scratch for partitions */
    ht_progress progress;
} ht_builder;

typedef htree_status ht_build(ht_builder *builder);

/* One function per kind: the rows of the table in build.c. */
ht_build ht_build_bvh_sah; /* bvh.c */
ht_build ht_build_h;       /* h.c */

#endif
