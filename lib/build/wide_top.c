/* wide_top.c: the top of a wide tree, over cells as weighted prims, down to errands for all
 * threads. Also the split of runs into children, which the errands share. */
#include "prims.h"
#include "wide.h"

enum {
    ERRAND_PRIMS = 160,                 /* where the top over cells ends */
    MORTON_PRIMS = HT_LANES * HT_LANES, /* the same, for Morton order: a node of full leaves */
    LARGE_RUN = 16384,
    MOST_LARGE_RUNS = 64,           /* prims; of the top, each for one thread */
    TOP_LEVELS = HT_WIDE_LEVELS - 6 /* which leaves enough for errands */
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
    areas[0] = ht_box4_area(&all->box);
    while (count < HT_LANES) {
        const uint32_t chosen = choose_run(runs, count, areas, scarce, enough);
        if (chosen == count) break;
        ht_wide_run *left = &runs[chosen], *right = &runs[count];
        const ht_split_rule rule = {scarce ? ht_levels_needed(left->count) : HT_MAX_DEPTH,
                                    HT_LANE_BITS, cells};
        ht_split split;
        ht_split_find(options, left->items, left->count, &rule, &split);
        ht_split_apply(&split, left->items, spare, left->count);
        if (!cells) ht_split_fill_blocks(&split, left->items, left->count, HT_LANE_BITS);
        right->items = left->items + split.left_count;
        right->count = left->count - split.left_count;
        right->prims = left->prims - split.left_prims;
        right->box = split.right;
        left->count = split.left_count;
        left->prims = split.left_prims;
        left->box = split.left;
        areas[chosen] = ht_box4_area(&left->box);
        areas[count++] = ht_box4_area(&right->box);
    }
    return count;
}

/* ---- The top -------------------------------------------------------------------------------- */

/* The top, or what of it lies below one of its large runs. */
typedef struct building {
    const htree_options *options;
    ht_prim *spare;
    ht_wide_top *top;
    uint32_t enough; /* prims of an errand */
} building;

static htree_status add_errand(ht_wide_top *top, const ht_wide_run *cells, uint32_t level,
                               uint32_t waiting, uint32_t parent, uint32_t lane) {
    ht_wide_errand *e = (ht_wide_errand *)ht_array_add(&top->errands);
    if (!e) return HTREE_ERROR_MEMORY;
    e->cells = *cells;
    e->level = level;
    e->waiting = waiting;
    e->parent = parent;
    e->lane = lane;
    return HTREE_OK;
}

static bool is_errand(const building *b, const ht_wide_run *run) {
    return run->count == 1 || run->prims <= b->enough;
}

/* Levels of full nodes that separate so many cells. */
static uint32_t levels_needed(uint32_t cells) {
    uint32_t levels = 1;
    for (uint64_t room = HT_LANES; room < cells; room *= HT_LANES) ++levels;
    return levels;
}

static htree_status subtree(const building *b, const ht_wide_run *all, uint32_t level,
                            uint32_t waiting, uint32_t *slot) {
    ht_wide_part *part = &b->top->part;
    ht_wide_run runs[HT_LANES];
    uint32_t lane[HT_LANES];
    const bool scarce = level + levels_needed(all->count) >= TOP_LEVELS;
    const uint32_t count = ht_wide_split(b->options, b->spare, all, scarce, true, runs);
    HT_TRY(ht_wide_write_node(part, runs, count, &all->box, lane, slot));
    waiting += count - 1;
    if (waiting > part->deepest) part->deepest = waiting;
    for (uint32_t i = 0; i < count; ++i) {
        if (is_errand(b, &runs[i])) {
            HT_TRY(add_errand(b->top, &runs[i], level + 1, waiting, *slot, lane[i]));
        } else {
            uint32_t below;
            HT_TRY(subtree(b, &runs[i], level + 1, waiting, &below));
            ht_wide_set_child(part, *slot, lane[i], below);
        }
    }
    return HTREE_OK;
}

/* ---- On all threads ------------------------------------------------------------------------- */

/* What one thread makes of one errand that is too large for one. */
typedef struct growth {
    ht_wide_top top;
    htree_status status;
} growth;

typedef struct growing {
    ht_wide_build *build;
    ht_prim *spare;
    uint32_t enough;
    ht_array large; /* errands of the top so far: of ht_wide_errand */
    growth *grown;  /* one each */
} growing;

void ht_wide_top_begin(ht_wide_top *top, ht_memory *memory) {
    ht_array_begin(&top->errands, memory, sizeof(ht_wide_errand));
    ht_wide_part_begin(&top->part, memory);
}

void ht_wide_top_end(ht_wide_top *top) {
    ht_wide_part_end(&top->part);
    ht_array_end(&top->errands);
}

/* Errands are more than half full on average, and nodes have some five. By the caller's thread: the
 * first block that a thread asks of the C library takes it longer than its share of the work. */
static htree_status reserve(const growing *g) {
    for (uint32_t i = 0; i < g->large.count; ++i) {
        const ht_wide_errand *e = (const ht_wide_errand *)ht_array_at(&g->large, i);
        const uint32_t full_errands = e->cells.prims / g->enough;
        ht_wide_top *top = &g->grown[i].top;
        ht_wide_top_begin(top, &g->build->builder->tree->memory);
        HT_TRY(ht_array_reserve(&top->errands, 2 * full_errands + 16));
        HT_TRY(ht_array_reserve(&top->part.nodes, full_errands / 2 + 16));
    }
    return HTREE_OK;
}

static void grow(void *data, uint32_t index) {
    const growing *g = (const growing *)data;
    const ht_wide_errand *e = (const ht_wide_errand *)ht_array_at(&g->large, index);
    const ht_prim *cells = (const ht_prim *)(const void *)g->build->cells.cells.items;
    growth *grown = &g->grown[index];
    /* Runs do not overlap, and so neither do their spares. */
    const building b = {g->build->builder->options, g->spare + (e->cells.items - cells),
                        &grown->top, g->enough};
    uint32_t root;
    if (!is_errand(&b, &e->cells))
        grown->status = subtree(&b, &e->cells, e->level, e->waiting, &root);
}

/* Puts what grew below an errand into the top, and the errand itself if nothing did. */
static htree_status join_growth(ht_wide_top *top, const ht_wide_errand *e, const growth *grown) {
    const ht_wide_part *part = &grown->top.part;
    const uint32_t base = (uint32_t)top->part.nodes.count;
    if (part->nodes.count == 0)
        return add_errand(top, &e->cells, e->level, e->waiting, e->parent, e->lane);
    for (uint64_t i = 0; i < part->nodes.count; ++i) {
        ht_wide_node *node = (ht_wide_node *)ht_array_add(&top->part.nodes);
        if (!node) return HTREE_ERROR_MEMORY;
        *node = *(const ht_wide_node *)ht_array_at(&part->nodes, i);
        for (uint32_t k = 0; k < HT_LANES; ++k)
            if (node->child[k] != HT_WIDE_NONE) node->child[k] += base;
    }
    if (part->deepest > top->part.deepest) top->part.deepest = part->deepest;
    ht_wide_set_child(&top->part, e->parent, e->lane, base);
    for (uint64_t i = 0; i < grown->top.errands.count; ++i) {
        const ht_wide_errand *below = (const ht_wide_errand *)ht_array_at(&grown->top.errands, i);
        HT_TRY(add_errand(top, &below->cells, below->level, below->waiting, below->parent + base,
                          below->lane));
    }
    return HTREE_OK;
}

static htree_status join_all(growing *g) {
    ht_wide_top *top = &g->build->top;
    for (uint32_t i = 0; i < g->large.count; ++i) {
        if (g->grown[i].status != HTREE_OK)
            return ht_fail(g->grown[i].status, "out of memory while a thread built the top");
        HT_TRY(join_growth(top, (const ht_wide_errand *)ht_array_at(&g->large, i), &g->grown[i]));
    }
    return HTREE_OK;
}

static htree_status grow_all(growing *g) {
    ht_memory *memory = &g->build->builder->tree->memory;
    const uint64_t bytes = g->large.count * sizeof *g->grown;
    g->grown = (growth *)ht_allocate(memory, bytes);
    if (!g->grown) return HTREE_ERROR_MEMORY;
    memset(g->grown, 0, (size_t)bytes);
    htree_status status = reserve(g);
    if (status == HTREE_OK) {
        ht_builder_run(g->build->builder, (uint32_t)g->large.count, grow, g);
        status = join_all(g);
    }
    for (uint32_t i = 0; i < g->large.count; ++i)
        if (g->grown[i].top.errands.memory) ht_wide_top_end(&g->grown[i].top);
    ht_release(memory, g->grown, bytes);
    return status;
}

/* The top down to large runs by one thread, and the rest by all of them: where they part follows
 * from the input alone. */
static htree_status build_by_all(growing *g, const ht_wide_run *all) {
    ht_wide_top *top = &g->build->top;
    const uint32_t share = all->prims / MOST_LARGE_RUNS;
    const building b = {g->build->builder->options, g->spare, top,
                        share > LARGE_RUN ? share : LARGE_RUN};
    uint32_t root;
    HT_TRY(subtree(&b, all, 0, 0, &root));
    g->large = top->errands;
    ht_array_begin(&top->errands, g->large.memory, sizeof(ht_wide_errand));
    const htree_status status = grow_all(g);
    ht_array_end(&g->large);
    return status;
}

/* Errands' prims follow each other in leaf_order. */
static void place_errands(ht_wide_build *build) {
    uint32_t prims = 0;
    for (uint32_t i = 0; i < build->top.errands.count; ++i) {
        ht_wide_errand *e = ht_wide_errand_at(build, i);
        e->first = prims;
        prims += e->cells.prims;
    }
}

htree_status ht_wide_build_top(ht_wide_build *build) {
    const htree_options *options = build->builder->options;
    htree *tree = build->builder->tree;
    const ht_array *cells = &build->cells.cells;
    const ht_wide_run all = {(ht_prim *)(void *)cells->items, (uint32_t)cells->count,
                             tree->prim_count, ht_box4_of(&tree->bounds)};
    const bool by_order = (options->flags & (HTREE_MORTON | HTREE_LAZY)) != 0;
    growing g;
    memset(&g, 0, sizeof g);
    g.build = build;
    g.enough = by_order ? MORTON_PRIMS : ERRAND_PRIMS;
    if (all.count == 1 || all.prims <= g.enough)
        return add_errand(&build->top, &all, 0, 0, HT_WIDE_NONE, 0);
    const uint64_t bytes = all.count * sizeof(ht_prim);
    g.spare = (ht_prim *)ht_allocate(&tree->memory, bytes);
    if (!g.spare) return HTREE_ERROR_MEMORY;
    const htree_status status = build_by_all(&g, &all);
    ht_release(&tree->memory, g.spare, bytes);
    place_errands(build);
    return status;
}
