/* split.h: the discretised surface area heuristic of section 5, shared by all object hierarchies.
 */
#ifndef HT_SPLIT_H
#define HT_SPLIT_H

#include "build.h"

/* Prims with bucket(centroid) < plane on `axis` go left; where plane is 0, the first left_count
 * do. Both sides are never empty. */
typedef struct ht_split {
    uint32_t axis;
    uint32_t plane;
    float origin, scale;             /* bucket(c) = (c - origin) * scale */
    uint32_t buckets;                /* M */
    uint32_t left_count, left_prims; /* the same, but for cells */
    ht_box4 left, right;             /* tight boxes A_L and A_R of both sides */
} ht_split;

/* How to split. */
typedef struct ht_split_rule {
    uint32_t levels;     /* of branching that may still follow: where they get scarce the split is
                            in the middle, which keeps any tree within its depth */
    uint32_t block_bits; /* 2^block_bits prims are tested at once and cost as one */
    bool cells;          /* cells of prims, of which eq. 1 counts the prims */
} ht_split_rule;

/* Finds the cheapest split of count >= 2 prims by eq. 1. May reorder the prims. */
void ht_split_find(const htree_options *options, ht_prim *prims, uint32_t count,
                   const ht_split_rule *rule, ht_split *split);

/* The spatial median: the middle of `box` along its widest axis, or of the centroids where that
 * separates nothing. */
void ht_split_find_median(const ht_prim *prims, uint32_t count, const htree_box *box,
                          uint32_t levels, ht_split *split);

/* Brings the left side to the front, keeping the order within both sides. */
void ht_split_apply(const ht_split *split, ht_prim *prims, ht_prim *spare, uint32_t count);

/* After that: moves the plane within a bucket where a block less is needed then and eq. 1 falls. */
void ht_split_fill_blocks(ht_split *split, ht_prim *prims, uint32_t count, uint32_t block_bits);

#endif
