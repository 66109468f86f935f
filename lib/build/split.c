/* split.c: buckets over the centroids of one axis, tight boxes by two sweeps, the minimum of eq. 1.
 *
 * The axis is the widest extent of the *centroids*: a few large objects widen a box on axes where
 * nothing can be separated, and interiors then cost several times the steps. O(n + M) per split. */
#include "split.h"
#include "prims.h"

enum { MAX_BUCKETS = 64 };
enum { FEW_PRIMS = 8 }; /* so few are sorted: cheaper than buckets, and exact */

typedef struct bucket {
    ht_box4 box;
    uint32_t count; /* prims or cells */
    uint32_t prims; /* what the cells hold, or count */
} bucket;

static void bucket_clear(bucket *b) {
    b->box = ht_box4_empty();
    b->count = b->prims = 0;
}

HT_INLINE float centroid(const ht_prim *prim, uint32_t axis) {
    return prim->lo[axis] + prim->hi[axis];
}

HT_INLINE uint32_t bucket_index(const ht_split *split, float c) {
    const uint32_t index = (uint32_t)((c - split->origin) * split->scale);
    return index < split->buckets ? index : split->buckets - 1;
}

/* Few objects need few planes: the cost function has only n - 1 steps. */
static uint32_t bucket_count(const htree_options *options, uint32_t count) {
    const uint32_t wanted = 4 + count / 8;
    return wanted < options->buckets ? wanted : options->buckets;
}

/* False if the centroids have no extent on the axis. */
static bool split_scale(ht_split *split, uint32_t axis, const htree_box *centroids) {
    const float extent = centroids->hi[axis] - centroids->lo[axis];
    split->axis = axis;
    split->origin = centroids->lo[axis];
    split->scale = (float)split->buckets / extent;
    /* A denormal extent makes the scale infinite; such centroids count as equal. */
    return extent > 0 && split->scale <= 1e37f;
}

HT_INLINE void fill_buckets(const ht_split *split, const ht_prim *prims, uint32_t count,
                            bucket *buckets, const bool cells) {
    for (uint32_t b = 0; b < split->buckets; ++b) bucket_clear(&buckets[b]);
    for (uint32_t i = 0; i < count; ++i) {
        const ht_prim *prim = &prims[i];
        bucket *b = &buckets[bucket_index(split, centroid(prim, split->axis))];
        ht_box4_add(&b->box, ht_f4_load(prim->lo), ht_f4_load(prim->hi));
        ++b->count;
        if (cells) b->prims += ht_cell_prims(prim);
    }
    for (uint32_t b = 0; b < split->buckets && !cells; ++b) buckets[b].prims = buckets[b].count;
}

static HT_NOINLINE void fill_with_prims(const ht_split *split, const ht_prim *prims, uint32_t count,
                                        bucket *buckets) {
    fill_buckets(split, prims, count, buckets, false);
}

static HT_NOINLINE void fill_with_cells(const ht_split *split, const ht_prim *cells, uint32_t count,
                                        bucket *buckets) {
    fill_buckets(split, cells, count, buckets, true);
}

static void bucket_merge(bucket *b, const bucket *other) {
    ht_box4_add(&b->box, other->box.lo, other->box.hi);
    b->count += other->count;
    b->prims += other->prims;
}

static ht_box4 merged_box(const bucket *buckets, uint32_t count) {
    ht_box4 all = buckets[0].box;
    for (uint32_t b = 1; b < count; ++b) ht_box4_add(&all, buckets[b].box.lo, buckets[b].box.hi);
    return all;
}

static double bucket_area(const bucket *b) {
    return (double)ht_box4_area(&b->box);
}

/* Leaves that so many prims fill: what eq. 1 counts. */
static double blocks(uint32_t count, uint32_t block_bits) {
    return (double)((count + (1u << block_bits) - 1) >> block_bits);
}

/* The two sweeps: areas of everything right of each plane, then of everything left of it. Sets
 * plane, left_count and both boxes to the minimum of eq. 1 and returns its cost, undivided by
 * SA, which all planes and axes share. */
static double sweep(const bucket *buckets, uint32_t block_bits, ht_split *split) {
    double right_cost[MAX_BUCKETS];
    bucket side;
    bucket_clear(&side);
    for (uint32_t b = split->buckets - 1; b > 0; --b) {
        bucket_merge(&side, &buckets[b]);
        right_cost[b] = blocks(side.prims, block_bits) * bucket_area(&side);
    }
    bucket_clear(&side);
    double cheapest = INFINITY;
    for (uint32_t plane = 1; plane < split->buckets; ++plane) {
        bucket_merge(&side, &buckets[plane - 1]);
        const double cost = blocks(side.prims, block_bits) * bucket_area(&side) + right_cost[plane];
        if (cost < cheapest) {
            cheapest = cost;
            split->plane = plane;
            split->left_count = side.count;
            split->left_prims = side.prims;
        }
    }
    if (cheapest == INFINITY) return cheapest;
    split->left = merged_box(buckets, split->plane);
    split->right = merged_box(buckets + split->plane, split->buckets - split->plane);
    return cheapest;
}

static uint32_t prims_of(const ht_prim *items, uint32_t count, bool cells) {
    uint32_t prims = cells ? 0 : count;
    for (uint32_t i = 0; i < count && cells; ++i) prims += ht_cell_prims(&items[i]);
    return prims;
}

static void split_in_the_middle(const ht_prim *prims, uint32_t count, uint32_t axis, bool cells,
                                ht_split *split) {
    split->axis = axis;
    split->plane = 0;
    split->left_count = count / 2;
    split->left_prims = prims_of(prims, split->left_count, cells);
    split->left = ht_prims_box(prims, split->left_count);
    split->right = ht_prims_box(prims + split->left_count, count - split->left_count);
}

/* ---- Few prims: every plane between two centroids ------------------------------------------- */

/* A total order, so that sorting by one axis, another, and the first again ends where it began. */
HT_INLINE bool comes_before(const ht_prim *a, const ht_prim *b, uint32_t axis) {
    const float ca = centroid(a, axis), cb = centroid(b, axis);
    return ca < cb || (ca == cb && ht_prim_id(a) < ht_prim_id(b));
}

static void sort_by_centroid(ht_prim *prims, uint32_t count, uint32_t axis) {
    for (uint32_t i = 1; i < count; ++i) {
        const ht_prim prim = prims[i];
        uint32_t k = i;
        for (; k > 0 && comes_before(&prim, &prims[k - 1], axis); --k) prims[k] = prims[k - 1];
        prims[k] = prim;
    }
}

/* Half of all splits are of two prims, and there is nothing to choose. */
static void split_two(ht_prim *prims, uint32_t axis, bool cells, ht_split *split) {
    sort_by_centroid(prims, 2, axis);
    split->axis = axis;
    split->plane = 0;
    split->left_count = 1;
    split->left_prims = prims_of(prims, 1, cells);
    split->left = ht_prims_box(prims, 1);
    split->right = ht_prims_box(prims + 1, 1);
}

/* A bucket for every prim, in order of the centroids. */
static void split_exactly(ht_prim *prims, uint32_t count, uint32_t widest, uint32_t axes,
                          const ht_split_rule *rule, ht_split *split) {
    bucket buckets[FEW_PRIMS];
    double cheapest = INFINITY;
    for (uint32_t i = 0; i < axes; ++i) {
        ht_split candidate = {0};
        candidate.axis = (widest + i) % 3;
        candidate.buckets = count;
        sort_by_centroid(prims, count, candidate.axis);
        for (uint32_t k = 0; k < count; ++k) {
            buckets[k].box = ht_prim_box4(&prims[k]);
            buckets[k].count = 1;
            buckets[k].prims = prims_of(&prims[k], 1, rule->cells);
        }
        const double cost = sweep(buckets, rule->block_bits, &candidate);
        if (cost < cheapest) {
            cheapest = cost;
            *split = candidate;
        }
    }
    if (axes > 1) sort_by_centroid(prims, count, split->axis);
    split->plane = 0; /* the prims stand in order already */
}

static bool levels_are_scarce(uint32_t count, uint32_t levels) {
    return levels < 32 && (uint64_t)count > (uint64_t)1 << (levels - 1);
}

HT_NOINLINE void ht_split_find(const htree_options *options, ht_prim *prims, uint32_t count,
                               const ht_split_rule *rule, ht_split *split) {
    assert(count >= 2 && rule->levels >= 1);
    bucket buckets[MAX_BUCKETS];
    const htree_box centroids = ht_centroid_bounds(prims, count);
    const uint32_t widest = (uint32_t)ht_widest_axis(&centroids);
    const uint32_t axes = levels_are_scarce(count, rule->levels) ? 0 : options->axes;
    if (count == 2) {
        split_two(prims, widest, rule->cells, split);
        return;
    }
    if (axes > 0 && count <= FEW_PRIMS) {
        split_exactly(prims, count, widest, axes, rule, split);
        return;
    }
    double cheapest = INFINITY;
    for (uint32_t i = 0; i < axes; ++i) {
        ht_split candidate = {0};
        candidate.buckets = bucket_count(options, count);
        if (!split_scale(&candidate, (widest + i) % 3, &centroids)) continue;
        if (rule->cells)
            fill_with_cells(&candidate, prims, count, buckets);
        else
            fill_with_prims(&candidate, prims, count, buckets);
        const double cost = sweep(buckets, rule->block_bits, &candidate);
        if (cost < cheapest) {
            cheapest = cost;
            *split = candidate;
        }
    }
    if (cheapest == INFINITY) split_in_the_middle(prims, count, widest, rule->cells, split);
}

/* A spatial median is a split with two buckets, whatever it costs. */
static bool try_middle(const ht_prim *prims, uint32_t count, uint32_t axis, float lo, float hi,
                       ht_split *split) {
    bucket buckets[2];
    split->axis = axis;
    split->plane = 1;
    split->buckets = 2;
    split->origin = lo;
    split->scale = 2 / (hi - lo);
    if (!(hi > lo && split->scale <= 1e37f)) return false;
    fill_with_prims(split, prims, count, buckets);
    split->left_count = buckets[0].count;
    split->left = buckets[0].box;
    split->right = buckets[1].box;
    return buckets[0].count > 0 && buckets[1].count > 0;
}

HT_NOINLINE void ht_split_find_median(const ht_prim *prims, uint32_t count, const htree_box *box,
                                      uint32_t levels, ht_split *split) {
    uint32_t axis = (uint32_t)ht_widest_axis(box);
    if (!levels_are_scarce(count, levels)) {
        if (try_middle(prims, count, axis, 2 * box->lo[axis], 2 * box->hi[axis], split)) return;
        const htree_box centroids = ht_centroid_bounds(prims, count);
        axis = (uint32_t)ht_widest_axis(&centroids);
        if (try_middle(prims, count, axis, centroids.lo[axis], centroids.hi[axis], split)) return;
    }
    split_in_the_middle(prims, count, axis, false, split);
}

/* Branch-free: where a prim goes is as good as random, and a mispredicted branch costs more than
 * the second store. */
void ht_split_apply(const ht_split *split, ht_prim *prims, ht_prim *spare, uint32_t count) {
    if (split->plane == 0) return;
    uint32_t left = 0, right = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const ht_prim prim = prims[i];
        const uint32_t goes_left = bucket_index(split, centroid(&prim, split->axis)) < split->plane;
        prims[left] = prim;
        spare[right] = prim;
        left += goes_left;
        right += 1 - goes_left;
    }
    assert(left == split->left_count && left > 0 && right > 0);
    memcpy(prims + left, spare, right * sizeof *spare);
}

/* ---- Full blocks ---------------------------------------------------------------------------- */

enum { MOST_LISTED = 48 };

/* The prims of a side in as few buckets next to the plane as hold some `wanted`, or MOST_LISTED + 1
 * for more. */
static uint32_t list_nearest(const ht_split *split, const ht_prim *side, uint32_t count, bool left,
                             uint32_t wanted, uint32_t *list) {
    for (uint32_t buckets = 1;; ++buckets) {
        uint32_t listed = 0;
        for (uint32_t i = 0; i < count && listed <= MOST_LISTED; ++i) {
            const uint32_t index = bucket_index(split, centroid(&side[i], split->axis));
            list[listed] = i;
            listed += left ? index + buckets >= split->plane : index < split->plane + buckets;
        }
        if (listed >= wanted) return listed;
    }
}

static void swap_prims(ht_prim *a, ht_prim *b) {
    const ht_prim was = *a;
    *a = *b;
    *b = was;
}

/* Brings the `moved` last prims of the listed ones, by centroid, to the end of the side; or, mirrored,
 * the first to its start. */
static void bring_to_edge(const ht_split *split, ht_prim *side, uint32_t count, uint32_t *list,
                          uint32_t listed, uint32_t moved, bool to_end) {
    for (uint32_t k = 0; k < moved; ++k) {
        const uint32_t edge = to_end ? count - 1 - k : k;
        uint32_t best = k;
        for (uint32_t i = k + 1; i < listed; ++i) {
            const float c = centroid(&side[list[i]], split->axis);
            const float d = centroid(&side[list[best]], split->axis);
            best = (to_end ? c > d : c < d) ? i : best;
        }
        const uint32_t from = list[best];
        list[best] = list[k];
        for (uint32_t i = k + 1; i < listed; ++i)
            if (list[i] == edge) list[i] = from;
        swap_prims(&side[from], &side[edge]);
    }
}

void ht_split_fill_blocks(ht_split *split, ht_prim *prims, uint32_t count, uint32_t block_bits) {
    const uint32_t block = 1u << block_bits, left = split->left_count, right = count - left;
    const uint32_t rest_left = left % block, rest_right = right % block;
    if (split->plane == 0 || rest_left == 0 || rest_right == 0 || rest_left + rest_right > block)
        return;
    const bool from_left = left > block && (rest_left <= rest_right || right < block);
    if (!from_left && right < block) return;
    const uint32_t moved = from_left ? rest_left : rest_right;
    uint32_t list[MOST_LISTED + 1];
    ht_prim *side = from_left ? prims : prims + left;
    const uint32_t in_side = from_left ? left : right;
    const uint32_t listed = list_nearest(split, side, in_side, from_left, moved, list);
    if (listed > MOST_LISTED) return;
    bring_to_edge(split, side, in_side, list, listed, moved, from_left);
    const uint32_t cut = from_left ? left - moved : left + moved;
    const ht_box4 a = ht_prims_box(prims, cut), b = ht_prims_box(prims + cut, count - cut);
    const double before = blocks(left, block_bits) * (double)ht_box4_area(&split->left) +
                          blocks(right, block_bits) * (double)ht_box4_area(&split->right);
    const double after = blocks(cut, block_bits) * (double)ht_box4_area(&a) +
                         blocks(count - cut, block_bits) * (double)ht_box4_area(&b);
    if (after >= before) return;
    split->left_count = split->left_prims = cut;
    split->left = a;
    split->right = b;
}
