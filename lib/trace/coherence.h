/* coherence.h: whether the rays of a batch agree with their neighbours, and in what rows they lie:
 * what packets are made from. A few rays are looked at, and nothing else, so that the answer is the
 * same on every machine; hits do not depend on it. */
#ifndef HT_COHERENCE_H
#define HT_COHERENCE_H

#include "base/vec.h"

#include <float.h>

/* A batch as a picture: `count` whole rows, to be taken `height` at once. It comes row by row, or in
 * square cells, row by row of them, and within each row by row. */
typedef struct ht_rows {
    uint64_t row; /* rays in a row; 0: neighbours do not agree */
    uint64_t count;
    uint32_t height;
    uint32_t cell; /* a cell is 1 << this rays wide; 0: no cells */
} ht_rows;

/* Which ray is at column x of row y. */
HT_INLINE uint64_t ht_ray_at(uint64_t row, uint32_t cell, uint64_t x, uint64_t y) {
    const uint64_t within = (1u << cell) - 1;
    return (y & ~within) * row + ((x & ~within) << cell) + ((y & within) << cell) + (x & within);
}

/* The largest side of a box, never 0. */
HT_INLINE float ht_extent(const htree_box *box) {
    float extent = FLT_MIN;
    for (int i = 0; i < 3; ++i) extent = ht_max(extent, box->hi[i] - box->lo[i]);
    return extent;
}

/* How far apart two neighbours may be, at the far end of the bounds, as a part of their extent; its
 * square. A few of its triangles side by side are as wide. */
HT_INLINE float ht_near_square(uint32_t triangles) {
    return ht_min(0.00390625f, 16 / (float)triangles);
}

/* The bounds are the tree's, and over so many triangles. */
ht_rows ht_find_rows(const htree_ray *rays, uint64_t count, const htree_box *bounds,
                     uint32_t triangles);

#endif
