/* wide_errand.c: the subtree over the prims of a few cells.
 *
 * A node begins as one run of prims and splits the run with the largest box, until it has eight
 * or all are nodes of leaves; then leaves come up as far as there is room. A leaf tests its prims
 * at once, so eq. 1 counts leaves where it has counted prims (`block_bits` of split.h): that fills
 * leaves, and measured faster to build and to trace. */
#include "wide.h"

typedef struct building {
    const htree_options *options;
    ht_wide_part *part;
    const ht_prim *prims;
    ht_prim *spare;
    uint32_t first;
} building;

/* Levels of nodes that so many prims need at least, every node full. */
static uint32_t levels_needed(uint32_t count) {
    uint32_t levels = 1;
    for (uint64_t room = HT_LANES * HT_LANES; room < count; room *= HT_LANES) ++levels;
    return levels;
}

static htree_status add_leaf(building *b, const ht_wide_run *run, uint32_t *child) {
    return ht_wide_add_leaf(b->part, b->first + (uint32_t)(run->items - b->prims), run->count,
                            child);
}

/* The run with the largest box whose leaves there is room for here, and which has not been tried;
 * `count` if there is none. */
static uint32_t choose_small(const ht_wide_run *runs, uint32_t count, uint32_t tried) {
    uint32_t best = count;
    float most = -1;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t leaves = (runs[i].count + HT_LANES - 1) / HT_LANES;
        const float area = ht_box4_area(&runs[i].box);
        const bool fits = leaves > 1 && count - 1 + leaves <= HT_LANES && !(tried >> i & 1);
        best = fits && area > most ? i : best;
        most = fits && area > most ? area : most;
    }
    return best;
}

/* Leaves come up into a node that has room for all of their own node's: the tree has a node less,
 * and so have the rays that go there. Returns how many runs there are then. */
static uint32_t lift_leaves(const building *b, ht_wide_run *runs, uint32_t count) {
    uint32_t tried = 0, chosen;
    while ((chosen = choose_small(runs, count, tried)) < count) {
        ht_wide_run leaves[HT_LANES];
        const uint32_t more =
            ht_wide_split(b->options, b->spare, &runs[chosen], false, false, leaves);
        tried |= 1u << chosen;
        if (count - 1 + more > HT_LANES) continue;
        runs[chosen] = leaves[0];
        for (uint32_t i = 1; i < more; ++i) runs[count++] = leaves[i];
    }
    return count;
}

/* The subtree over a run, `level` nodes below the root, where `waiting` entries stand on a ray's
 * stack already. */
static htree_status subtree(building *b, const ht_wide_run *all, uint32_t level, uint32_t waiting,
                            uint32_t *child) {
    ht_wide_run runs[HT_LANES];
    uint32_t lane[HT_LANES], slot;
    const bool scarce = level + levels_needed(all->count) >= HT_WIDE_LEVELS;
    const uint32_t parts = ht_wide_split(b->options, b->spare, all, scarce, false, runs);
    const uint32_t count = lift_leaves(b, runs, parts);
    HT_TRY(ht_wide_write_node(b->part, runs, count, &all->box, lane, &slot));
    waiting += count - 1;
    if (waiting > b->part->deepest) b->part->deepest = waiting;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t below;
        HT_TRY(runs[i].count > HT_LANES ? subtree(b, &runs[i], level + 1, waiting, &below)
                                        : add_leaf(b, &runs[i], &below));
        ht_wide_set_child(b->part, slot, lane[i], below);
    }
    *child = slot;
    return HTREE_OK;
}

void ht_wide_gather(const ht_source *from, const uint32_t *order, const ht_wide_run *cells,
                    ht_prim *out) {
    const ht_source source = *from; /* which no store can change */
    for (uint32_t i = 0; i < cells->count; ++i) {
        const uint32_t *ids = order + ht_cell_first(&cells->items[i]);
        const uint32_t count = ht_cell_prims(&cells->items[i]);
        for (uint32_t k = 0; k < count; ++k) {
            const ht_box4 box = ht_source_box(&source, ids[k]);
            ht_prim_set(out++, &box, ids[k]);
        }
    }
}

htree_status ht_wide_run_errand(const ht_wide_build *build, ht_wide_errand *errand,
                                ht_wide_part *part, ht_prim *prims, ht_prim *spare) {
    const uint32_t count = errand->cells.prims;
    const ht_wide_run all = {prims, count, count, errand->cells.box};
    building b = {build->builder->options, part, prims, spare, errand->first};
    ht_wide_gather(&build->source, build->cells.order, &errand->cells, prims);
    /* A tree is never a leaf alone: walks begin with a node. */
    if (count <= HT_LANES && errand->parent != HT_WIDE_NONE)
        HT_TRY(add_leaf(&b, &all, &errand->child));
    else
        HT_TRY(subtree(&b, &all, errand->level, errand->waiting, &errand->child));
    for (uint32_t i = 0; i < count; ++i)
        build->cells.leaf_order[errand->first + i] = ht_prim_id(&prims[i]);
    return HTREE_OK;
}
