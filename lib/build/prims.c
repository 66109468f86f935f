#include "prims.h"

/* A box of four lanes, as ht_prim has them: the last means nothing. */
typedef struct lanes {
    float lo[4], hi[4];
} lanes;

static const lanes nothing = {{INFINITY, INFINITY, INFINITY, INFINITY},
                              {-INFINITY, -INFINITY, -INFINITY, -INFINITY}};

static htree_box box_of(const lanes *b) {
    const htree_box box = {{b->lo[0], b->lo[1], b->lo[2]}, {b->hi[0], b->hi[1], b->hi[2]}};
    return box;
}

htree_box ht_prims_box(const ht_prim *prims, uint32_t count) {
    lanes box = nothing;
    for (uint32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 4; ++k) box.lo[k] = ht_min(box.lo[k], prims[i].lo[k]);
        for (int k = 0; k < 4; ++k) box.hi[k] = ht_max(box.hi[k], prims[i].hi[k]);
    }
    return box_of(&box);
}

htree_box ht_centroid_bounds(const ht_prim *prims, uint32_t count) {
    lanes box = nothing;
    for (uint32_t i = 0; i < count; ++i) {
        float c[4];
        for (int k = 0; k < 4; ++k) c[k] = prims[i].lo[k] + prims[i].hi[k];
        for (int k = 0; k < 4; ++k) box.lo[k] = ht_min(box.lo[k], c[k]);
        for (int k = 0; k < 4; ++k) box.hi[k] = ht_max(box.hi[k], c[k]);
    }
    return box_of(&box);
}

uint32_t ht_levels_needed(uint32_t count) {
    uint32_t levels = 0;
    while (levels < 32 && (uint64_t)1 << levels < count) ++levels;
    return levels;
}
