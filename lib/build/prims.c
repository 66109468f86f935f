#include "prims.h"

ht_box4 ht_prims_box(const ht_prim *prims, uint32_t count) {
    ht_box4 box = ht_box4_empty();
    for (uint32_t i = 0; i < count; ++i)
        ht_box4_add(&box, ht_f4_load(prims[i].lo), ht_f4_load(prims[i].hi));
    return box;
}

HT_INLINE ht_f4 centroid(const ht_prim *prim) {
    return ht_f4_add(ht_f4_load(prim->lo), ht_f4_load(prim->hi));
}

/* Two boxes, which do not wait for each other. */
htree_box ht_centroid_bounds(const ht_prim *prims, uint32_t count) {
    ht_box4 even = ht_box4_empty(), odd = even;
    uint32_t i = 0;
    for (; i + 2 <= count; i += 2) {
        const ht_f4 a = centroid(&prims[i]), b = centroid(&prims[i + 1]);
        ht_box4_add(&even, a, a);
        ht_box4_add(&odd, b, b);
    }
    if (i < count) {
        const ht_f4 last = centroid(&prims[i]);
        ht_box4_add(&even, last, last);
    }
    ht_box4_add(&even, odd.lo, odd.hi);
    return ht_box4_box(&even);
}

uint32_t ht_levels_needed(uint32_t count) {
    uint32_t levels = 0;
    while (levels < 32 && (uint64_t)1 << levels < count) ++levels;
    return levels;
}
