/* cost.h: equations 2 to 4 of the paper: what a node of each type is expected to cost a random ray
 * that meets its traversal box B^T. */
#ifndef HT_COST_H
#define HT_COST_H

#include "split.h"

/* Eq. 2: an SKD node, its children's traversal boxes cut by the two planes only. */
float ht_cost_skd(const htree_options *options, const htree_box *traversal, const ht_split *split,
                  uint32_t count);

/* Eqs. 3 and 4: a node that bounds all `count` objects by `bounded`, a part of the traversal box.
 */
float ht_cost_bound(float traverse_cost, const htree_options *options, const htree_box *traversal,
                    const htree_box *bounded, uint32_t count);

/* B^T cut by a plane of `axis`: everything up to `hi`, or everything from `lo`. */
htree_box ht_cut_above(const htree_box *box, uint32_t axis, float hi);
htree_box ht_cut_below(const htree_box *box, uint32_t axis, float lo);

#endif
