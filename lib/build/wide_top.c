/* wide_top.c: the top of a wide tree, over cells as weighted prims, down to errands for all
 * threads. Also the split of runs into children, which the errands share. */
#include "prims.h"
#include "wide.h"

enum {
    ERRAND_PRIMS = 160,                 /* where the top over cells ends */
    MORTON_PRIMS = HT_LANES * HT_LANES, /* the same, for Morton order: a node of full leaves */
    TOP_LEVELS = HT_WIDE_LEVELS - 6     /* which leaves enough for errands */
};

/* ---- Runs ----------------------------------------------------------------------------------- */

/* The run to split next: the largest box, or where levels are scarce the most prims; `count` if
 * every run is of at most `enough` prims, or a single cell. */
static uint32_t choose_run(const ht_wide_run *runs, uint32_t count, const float *areas, bool scarce,
                           uint32_t enough) {
    uint32_t best = count;
    float most = -1;
    for (uint32_t i = 0; i < count; ++i) {
        const float worth = scarce ? (float)runs[i].prims : areas[i];
        if (runs[i].prims > enough && runs[i].count > 1 && worth > most) {
            most = worth;
            best = i;
        }
    }
    return best;
}

uint32_t ht_wide_split(const htree_options *options, ht_prim *spare, const ht_wide_run *all,
                       bool scarce, bool cells, ht_wide_run *runs) {
    /* What a node of leaves can hold is left whole for one, lest nodes stay half empty. */
    const bool is_large = all->prims > HT_LANES * HT_LANES && !scarce;
    const uint32_t enough = is_large ? HT_LANES * HT_LANES : HT_LANES;
    float areas[HT_LANES];
    uint32_t count = 1;
    runs[0] = *all;
    areas[0] = ht_box_area(&all->box);
    while (count < HT_LANES) {
        const uint32_t chosen = choose_run(runs, count, areas, scarce, enough);
        if (chosen == count) break;
        ht_wide_run *left = &runs[chosen], *right = &runs[count];
        const ht_split_rule rule = {scarce ? ht_levels_needed(left->count) : HT_MAX_DEPTH,
                                    HT_LANE_BITS, cells};
        ht_split split;
        ht_split_find(options, left->items, left->count, &rule, &split);
        ht_split_apply(&split, left->items, spare, left->count);
        right->items = left->items + split.left_count;
        right->count = left->count - split.left_count;
        right->prims = left->prims - split.left_prims;
        right->box = split.right;
        left->count = split.left_count;
        left->prims = split.left_prims;
        left->box = split.left;
        areas[chosen] = ht_box_area(&left->box);
        areas[count++] = ht_box_area(&right->box);
    }
    return count;
}

/* ---- The top -------------------------------------------------------------------------------- */

typedef struct building {
    const htree_options *options;
    ht_prim *spare;
    ht_wide_top *top;
} building;

static htree_status add_errand(ht_wide_top *top, const ht_wide_run *cells, uint32_t level,
                               uint32_t waiting, uint32_t parent, uint32_t lane) {
    ht_wide_errand *e = (ht_wide_errand *)ht_array_add(&top->errands);
    if (!e) return HTREE_ERROR_MEMORY;
    e->cells = *cells;
    e->first = top->prims;
    e->level = level;
    e->waiting = waiting;
    e->parent = parent;
    e->lane = lane;
    top->prims += cells->prims;
    return HTREE_OK;
}

static bool is_errand(const htree_options *options, const ht_wide_run *run) {
    const bool by_order = (options->flags & (HTREE_MORTON | HTREE_LAZY)) != 0;
    return run->count == 1 || run->prims <= (uint32_t)(by_order ? MORTON_PRIMS : ERRAND_PRIMS);
}

/* Levels of full nodes that separate so many cells. */
static uint32_t levels_needed(uint32_t cells) {
    uint32_t levels = 1;
    for (uint64_t room = HT_LANES; room < cells; room *= HT_LANES) ++levels;
    return levels;
}

static htree_status subtree(building *b, const ht_wide_run *all, uint32_t level, uint32_t waiting,
                            uint32_t *slot) {
    ht_wide_part *part = &b->top->part;
    ht_wide_run runs[HT_LANES];
    uint32_t lane[HT_LANES];
    const bool scarce = level + levels_needed(all->count) >= TOP_LEVELS;
    const uint32_t count = ht_wide_split(b->options, b->spare, all, scarce, true, runs);
    HT_TRY(ht_wide_write_node(part, runs, count, &all->box, lane, slot));
    waiting += count - 1;
    if (waiting > part->deepest) part->deepest = waiting;
    for (uint32_t i = 0; i < count; ++i) {
        if (is_errand(b->options, &runs[i])) {
            HT_TRY(add_errand(b->top, &runs[i], level + 1, waiting, *slot, lane[i]));
        } else {
            uint32_t below;
            HT_TRY(subtree(b, &runs[i], level + 1, waiting, &below));
            ht_wide_set_child(part, *slot, lane[i], below);
        }
    }
    return HTREE_OK;
}

htree_status ht_wide_build_top(ht_wide_build *build) {
    const htree_options *options = build->builder->options;
    htree *tree = build->builder->tree;
    const ht_array *cells = &build->cells.cells;
    const ht_wide_run all = {(ht_prim *)(void *)cells->items, (uint32_t)cells->count,
                             tree->prim_count, tree->bounds};
    uint32_t root;
    if (is_errand(options, &all)) return add_errand(&build->top, &all, 0, 0, HT_WIDE_NONE, 0);
    const uint64_t bytes = all.count * sizeof(ht_prim);
    building b = {options, (ht_prim *)ht_allocate(&tree->memory, bytes), &build->top};
    if (!b.spare) return HTREE_ERROR_MEMORY;
    const htree_status status = subtree(&b, &all, 0, 0, &root);
    ht_release(&tree->memory, b.spare, bytes);
    return status;
}
