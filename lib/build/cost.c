#include "cost.h"

/* SA(part) / SA(whole): the chance that a ray through `whole` meets `part`. A whole without area is
 * met by no random ray; 1 keeps such costs comparable. */
static float area_ratio(const htree_box *part, const htree_box *whole) {
    const float area = ht_box_area(whole);
    return area > 0 ? ht_box_area(part) / area : 1;
}

htree_box ht_cut_above(const htree_box *box, uint32_t axis, float hi) {
    htree_box cut = *box;
    cut.hi[axis] = ht_min(cut.hi[axis], hi);
    return cut;
}

htree_box ht_cut_below(const htree_box *box, uint32_t axis, float lo) {
    htree_box cut = *box;
    cut.lo[axis] = ht_max(cut.lo[axis], lo);
    return cut;
}

float ht_cost_skd(const htree_options *options, const htree_box *traversal, const ht_split *split,
                  uint32_t count) {
    const htree_box left = ht_cut_above(traversal, split->axis, split->left.hi[split->axis]);
    const htree_box right = ht_cut_below(traversal, split->axis, split->right.lo[split->axis]);
    return options->cost_skd +
           options->cost_intersect *
               ((float)split->left_count * area_ratio(&left, traversal) +
                (float)(count - split->left_count) * area_ratio(&right, traversal));
}

float ht_cost_bound(float traverse_cost, const htree_options *options, const htree_box *traversal,
                    const htree_box *bounded, uint32_t count) {
    return traverse_cost + options->cost_intersect * area_ratio(bounded, traversal) * (float)count;
}
