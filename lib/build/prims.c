#include "prims.h"

htree_box ht_prims_box(const ht_prim *prims, uint32_t count) {
    htree_box box = ht_box_empty();
    for (uint32_t i = 0; i < count; ++i) {
        ht_box_add_point(&box, prims[i].lo);
        ht_box_add_point(&box, prims[i].hi);
    }
    return box;
}

htree_box ht_centroid_bounds(const ht_prim *prims, uint32_t count) {
    htree_box box = ht_box_empty();
    for (uint32_t i = 0; i < count; ++i) {
        const float c[3] = {prims[i].lo[0] + prims[i].hi[0], prims[i].lo[1] + prims[i].hi[1],
                            prims[i].lo[2] + prims[i].hi[2]};
        ht_box_add_point(&box, c);
    }
    return box;
}

uint32_t ht_levels_needed(uint32_t count) {
    uint32_t levels = 0;
    while (levels < 32 && (uint64_t)1 << levels < count) ++levels;
    return levels;
}
