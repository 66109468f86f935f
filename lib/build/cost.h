/* cost.h: equations 2 to 4 of the paper: what a node of each type is expected to cost a random ray
 * that meets its traversal box B^T. */
#ifndef HT_COST_H
#define HT_COST_H

#include "base/vec.h"

/* 1 / SA(B^T), so that SA(part) * scale is the chance that a ray through B^T meets the part. A box
 * without area is met by no random ray: any scale will do. */
HT_INLINE float ht_chance_scale(const htree_box *traversal) {
    const float area = ht_box_area(traversal);
    return area > 0 ? 1 / area : 0;
}

/* B^T cut by a plane of `axis`: everything up to `hi`, or everything from `lo`. */
HT_INLINE htree_box ht_cut_above(const htree_box *box, uint32_t axis, float hi) {
    htree_box cut = *box;
    cut.hi[axis] = ht_min(cut.hi[axis], hi);
    return cut;
}

HT_INLINE htree_box ht_cut_below(const htree_box *box, uint32_t axis, float lo) {
    htree_box cut = *box;
    cut.lo[axis] = ht_max(cut.lo[axis], lo);
    return cut;
}

/* Eq. 2: an SKD node, whose children's traversal boxes are cut by its two planes only. */
HT_INLINE float ht_cost_skd(const htree_options *options, const htree_box *traversal, uint32_t axis,
                            float left_hi, float right_lo, uint32_t left_count,
                            uint32_t right_count) {
    const htree_box left = ht_cut_above(traversal, axis, left_hi);
    const htree_box right = ht_cut_below(traversal, axis, right_lo);
    return options->cost_skd +
           options->cost_intersect * ht_chance_scale(traversal) *
               ((float)left_count * ht_box_area(&left) + (float)right_count * ht_box_area(&right));
}

/* Eqs. 3 and 4: a node of C^T = traverse_cost that bounds all `count` objects by a box which a ray
 * through B^T meets with this chance. */
HT_INLINE float ht_cost_bound(const htree_options *options, float traverse_cost, float chance,
                              uint32_t count) {
    return traverse_cost + options->cost_intersect * chance * (float)count;
}

#endif
