#include "prims.h"

htree_box ht_prims_box(const ht_prim *prims, uint32_t count) {
    ht_box4 box = ht_box4_empty();
    for (uint32_t i = 0; i < count; ++i)
        ht_box4_add(&box, ht_f4_load(prims[i].lo), ht_f4_load(prims[i].hi));
    return ht_box4_box(&box);
}

htree_box ht_centroid_bounds(const ht_prim *prims, uint32_t count) {
    ht_box4 box = ht_box4_empty();
    for (uint32_t i = 0; i < count; ++i) {
        const ht_f4 c = ht_f4_add(ht_f4_load(prims[i].lo), ht_f4_load(prims[i].hi));
        ht_box4_add(&box, c, c);
    }
    return ht_box4_box(&box);
}

uint32_t ht_levels_needed(uint32_t count) {
    uint32_t levels = 0;
    while (levels < 32 && (uint64_t)1 << levels < count) ++levels;
    return levels;
}
