/* build.h: what builders are given and what they give back. A builder turns `prims` into nodes. */
#ifndef HT_BUILD_H
#define HT_BUILD_H

#include "base/lanes.h"
#include "tree/tree.h"

/* A prim as builders see it: its box. Centroids are kept doubled, lo + hi: one rounding, no
 * division. */
typedef struct ht_prim {
    float lo[4]; /* the last lane holds the bits of the id: four lanes are one instruction */
    float hi[4]; /* the last lane is idle, or a cell's count */
} ht_prim;

HT_INLINE uint32_t ht_prim_id(const ht_prim *prim) {
    uint32_t id;
    memcpy(&id, &prim->lo[3], sizeof id);
    return id;
}

HT_INLINE ht_box4 ht_prim_box4(const ht_prim *prim) {
    const ht_box4 box = {ht_f4_load(prim->lo), ht_f4_load(prim->hi)};
    return box;
}

/* Whole lanes are stored at once: who reads them back at once would wait for a word of them. */
HT_INLINE void ht_prim_set(ht_prim *prim, const ht_box4 *box, uint32_t id) {
    ht_f4_store(prim->lo, ht_f4_with_bits(box->lo, id));
    ht_f4_store(prim->hi, ht_f4_with_bits(box->hi, 0));
}

/* A cell of prims is a prim to those who split: its box, where its prims begin, and how many. */
HT_INLINE void ht_cell_set(ht_prim *cell, const ht_box4 *box, uint32_t first, uint32_t prims) {
    ht_f4_store(cell->lo, ht_f4_with_bits(box->lo, first));
    ht_f4_store(cell->hi, ht_f4_with_bits(box->hi, prims));
}

HT_INLINE uint32_t ht_cell_first(const ht_prim *cell) {
    return ht_prim_id(cell);
}

HT_INLINE uint32_t ht_cell_prims(const ht_prim *cell) {
    uint32_t prims;
    memcpy(&prims, &cell->hi[3], sizeof prims);
    return prims;
}

typedef struct ht_builder {
    const htree_options *options;
    const htree_mesh *mesh;
    htree *tree; /* geometry, bounds and counts are set; the builder sets nodes and stack */
    ht_prim
        *prims; /* tree->prim_count of them, at least 1, in order of id; the builder may permute */
    ht_prim *spare; /* see ht_builder_spare */
    ht_team *team;
    ht_progress progress;
} ht_builder;

/* Scratch for partitions, as many prims again; freed with the builder. NULL: the failure is
 * recorded. */
ht_prim *ht_builder_spare(ht_builder *builder);

/* Runs the tasks on the threads of the build. */
HT_INLINE void ht_builder_run(const ht_builder *builder, uint32_t count, ht_task *task,
                              void *data) {
    ht_team_run(builder->team, count, task, data);
}

typedef htree_status ht_build(ht_builder *builder);

/* One function per kind: the rows of the table in build.c. */
ht_build ht_build_ug;                           /* ug.c */
ht_build ht_build_kd;                           /* kd.c */
ht_build ht_build_bvh_median, ht_build_bvh_sah; /* bvh.c */
ht_build ht_build_skd, ht_build_h;              /* h.c */
ht_build ht_build_ah;                           /* ah.c */
ht_build ht_build_wide;                         /* wide.c: straight from the mesh */

#endif
