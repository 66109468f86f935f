/* wide_cells.c: grids over centroids, and finer ones inside of crowded cells: the recursion of
 * section 7.2. Its cells keep exact boxes of what they hold and become weighted prims for the top
 * of the tree, where the paper sums counts and searches: that costs less than the sums, and finds
 * better splits. */
#include "cells.h"
#include "prims.h"
#include "wide.h"

enum {
    ALONE = 2048,      /* prims of a mesh that needs no grid */
    PRIMS_A_CELL = 64, /* of a finer grid */
    MOST_CELLS = 1 << 15,
    GROUPS = 32
};

static void set_scales(ht_wide_grid *grid, const htree_box *centroids) {
    for (int i = 0; i < 3; ++i) {
        const float extent = centroids->hi[i] - centroids->lo[i];
        const float scale = (float)grid->cells[i] / extent;
        grid->origin[i] = extent >= 0 ? centroids->lo[i] : 0;
        /* A denormal extent makes the scale infinite; such centroids count as equal. */
        grid->scale[i] = extent > 0 && scale <= 1e37f ? scale : 0;
        grid->last[i] = (float)(grid->cells[i] - 1);
    }
    grid->total = grid->cells[0] * grid->cells[1] * grid->cells[2];
}

void ht_wide_grid_shape(ht_wide_grid *grid, const htree_box *centroids, double wanted) {
    float size[3];
    memset(grid, 0, sizeof *grid);
    for (int i = 0; i < 3; ++i) grid->cells[i] = 1;
    if (centroids->lo[0] < centroids->hi[0] || centroids->lo[1] < centroids->hi[1] ||
        centroids->lo[2] < centroids->hi[2])
        ht_cubic_cells(centroids, wanted, grid->cells, size);
    set_scales(grid, centroids);
}

/* ---- One crowded cell ----------------------------------------------------------------------- */

/* A cell to be refined, and how often its cells may be. */
typedef struct crowd {
    uint32_t first, prims, levels;
} crowd;

/* Crowded cells in a row, refined by one thread. */
typedef struct group {
    uint32_t first, end; /* of the list of crowded cells */
    uint64_t work;       /* prims in them */
    ht_prim *prims;      /* of the cell at hand */
    uint32_t *next;      /* by cell: how many prims, then where the next one goes */
    ht_box4 *boxes;      /* by cell */
    ht_array todo;       /* a stack of crowds */
    ht_array fine;       /* what they became */
    htree_status status;
} group;

typedef struct refining {
    ht_memory *memory;
    const ht_source *source;
    ht_wide_cells *cells;
    ht_array crowded; /* of ht_prim */
    group groups[GROUPS];
    uint32_t order[GROUPS]; /* most work first: one cell may hold a third of all prims */
    uint32_t group_count;
} refining;

/* Reads the prims of a cell; returns the box of their centroids. */
static htree_box gather(const refining *r, group *g, uint32_t first, uint32_t count) {
    const ht_source source = *r->source; /* which no store can change */
    const uint32_t *ids = r->cells->order + first;
    ht_box4 centroids = ht_box4_empty();
    for (uint32_t i = 0; i < count; ++i) {
        const ht_box4 box = ht_source_box(&source, ids[i]);
        ht_prim_set(&g->prims[i], &box, ids[i]);
        const ht_f4 c = ht_f4_add(box.lo, box.hi);
        ht_box4_add(&centroids, c, c);
    }
    return ht_box4_box(&centroids);
}

/* Sorts ids by cell: next[c] becomes the end of cell c. */
static void sort_range(const refining *r, group *g, const ht_wide_grid *given, uint32_t first,
                       uint32_t count) {
    const ht_wide_grid grid = *given; /* which no store can change */
    uint32_t *order = r->cells->order + first, *cell_of = r->cells->leaf_order + first;
    memset(g->next, 0, grid.total * sizeof *g->next);
    for (uint32_t i = 0; i < grid.total; ++i) g->boxes[i] = ht_box4_empty();
    for (uint32_t i = 0; i < count; ++i) {
        const ht_box4 box = ht_prim_box4(&g->prims[i]);
        const uint32_t cell = ht_wide_grid_cell(&grid, box.lo, box.hi);
        cell_of[i] = cell;
        ++g->next[cell];
        ht_box4_add(&g->boxes[cell], box.lo, box.hi);
    }
    uint32_t place = 0;
    for (uint32_t i = 0; i < grid.total; ++i) {
        const uint32_t here = g->next[i];
        g->next[i] = place;
        place += here;
    }
    for (uint32_t i = 0; i < count; ++i) order[g->next[cell_of[i]]++] = ht_prim_id(&g->prims[i]);
}

static htree_status list_cell(ht_array *fine, const ht_box4 *box, uint32_t first, uint32_t prims) {
    ht_prim *listed = (ht_prim *)ht_array_add(fine);
    if (!listed) return HTREE_ERROR_MEMORY;
    ht_cell_set(listed, box, first, prims);
    return HTREE_OK;
}

/* Cuts a cell that no grid separates into pieces, in the order of its prims. */
static htree_status list_pieces(const refining *r, group *g, uint32_t first, uint32_t prims) {
    const uint32_t pieces = (prims + HT_WIDE_CELL_PRIMS - 1) / HT_WIDE_CELL_PRIMS;
    for (uint32_t i = 0; i < pieces; ++i) {
        const uint32_t start = (uint32_t)((uint64_t)prims * i / pieces);
        const uint32_t end = (uint32_t)((uint64_t)prims * (i + 1) / pieces);
        ht_box4 box = ht_box4_empty();
        for (uint32_t k = start; k < end; ++k) {
            const ht_box4 one = ht_source_box(r->source, r->cells->order[first + k]);
            ht_box4_add(&box, one.lo, one.hi);
        }
        HT_TRY(list_cell(&g->fine, &box, first + start, end - start));
    }
    return HTREE_OK;
}

static htree_status list_crowd(group *g, uint32_t first, uint32_t prims, uint32_t levels) {
    crowd *c = (crowd *)ht_array_add(&g->todo);
    if (!c) return HTREE_ERROR_MEMORY;
    c->first = first;
    c->prims = prims;
    c->levels = levels;
    return HTREE_OK;
}

/* Sorts the prims of a cell into finer cells and lists them. A grid that leaves nearly all of a
 * cell together did not pay, and its next one would not either: such cells are cut to pieces. */
static htree_status refine_cell(const refining *r, group *g, const crowd *c) {
    const uint32_t first = c->first, count = c->prims;
    const double wanted = (double)count / PRIMS_A_CELL;
    const htree_box centroids = gather(r, g, first, count);
    ht_wide_grid grid;
    ht_wide_grid_shape(&grid, &centroids, wanted < MOST_CELLS ? wanted : MOST_CELLS);
    sort_range(r, g, &grid, first, count);
    uint32_t place = 0;
    for (uint32_t i = 0; i < grid.total; ++i) {
        const uint32_t start = first + place, prims = g->next[i] - place;
        place = g->next[i];
        if (prims == 0) continue;
        if (prims <= HT_WIDE_CELL_PRIMS)
            HT_TRY(list_cell(&g->fine, &g->boxes[i], start, prims));
        else if (c->levels > 0 && prims <= count / 8 * 7)
            HT_TRY(list_crowd(g, start, prims, c->levels - 1));
        else
            HT_TRY(list_pieces(r, g, start, prims));
    }
    return HTREE_OK;
}

/* ---- All of them ---------------------------------------------------------------------------- */

enum { LEVELS = 8 };

static htree_status refine_cells(const refining *r, group *g) {
    if (!g->prims || !g->next || !g->boxes) return HTREE_ERROR_MEMORY;
    for (uint32_t i = g->first; i < g->end; ++i) {
        const ht_prim *cell = (const ht_prim *)ht_array_at(&r->crowded, i);
        crowd next = {ht_cell_first(cell), ht_cell_prims(cell), LEVELS};
        HT_TRY(refine_cell(r, g, &next));
        while (g->todo.count > 0) {
            next = *(const crowd *)ht_array_at(&g->todo, --g->todo.count);
            HT_TRY(refine_cell(r, g, &next));
        }
    }
    return HTREE_OK;
}

/* Memory for the cells is taken here, and given back: what a thread has just used is in its cache. */
static void refine_group(void *data, uint32_t index) {
    refining *r = (refining *)data;
    group *g = &r->groups[r->order[index]];
    uint32_t most = 0;
    for (uint32_t i = g->first; i < g->end; ++i) {
        const uint32_t prims = ht_cell_prims((const ht_prim *)ht_array_at(&r->crowded, i));
        if (prims > most) most = prims;
    }
    uint64_t cells = most / PRIMS_A_CELL + 1;
    if (cells > MOST_CELLS) cells = MOST_CELLS;
    g->prims = (ht_prim *)ht_allocate(r->memory, most * sizeof *g->prims);
    g->next = (uint32_t *)ht_allocate(r->memory, cells * sizeof *g->next);
    g->boxes = (ht_box4 *)ht_allocate(r->memory, cells * sizeof *g->boxes);
    g->status = refine_cells(r, g);
    ht_release(r->memory, g->boxes, cells * sizeof *g->boxes);
    ht_release(r->memory, g->next, cells * sizeof *g->next);
    ht_release(r->memory, g->prims, most * sizeof *g->prims);
}

/* Moves the crowded cells out of the list. */
static htree_status take_crowded(refining *r, uint64_t *prims) {
    ht_array *cells = &r->cells->cells;
    uint64_t kept = 0;
    *prims = 0;
    for (uint64_t i = 0; i < cells->count; ++i) {
        const ht_prim *cell = (const ht_prim *)ht_array_at(cells, i);
        const bool stays = ht_cell_prims(cell) <= HT_WIDE_CELL_PRIMS;
        ht_prim *to = (ht_prim *)(stays ? ht_array_at(cells, kept) : ht_array_add(&r->crowded));
        if (!to) return HTREE_ERROR_MEMORY;
        *to = *cell;
        kept += stays;
        *prims += stays ? 0 : ht_cell_prims(cell);
    }
    cells->count = kept;
    return HTREE_OK;
}

/* Puts the last group where its work comes. */
static void order_last(refining *r) {
    const uint32_t last = r->group_count - 1;
    uint32_t i = last;
    for (; i > 0 && r->groups[r->order[i - 1]].work < r->groups[last].work; --i)
        r->order[i] = r->order[i - 1];
    r->order[i] = last;
}

static htree_status group_crowded(refining *r, uint64_t prims) {
    const uint64_t share = prims / GROUPS + 1;
    for (uint32_t i = 0; i < r->crowded.count;) {
        group *g = &r->groups[r->group_count++];
        const bool last = r->group_count == GROUPS;
        g->first = i;
        while (i < r->crowded.count && (last || g->work < share))
            g->work += ht_cell_prims((const ht_prim *)ht_array_at(&r->crowded, i++));
        g->end = i;
        order_last(r);
        ht_array_begin(&g->todo, r->memory, sizeof(crowd));
        ht_array_begin(&g->fine, r->memory, sizeof(ht_prim));
        HT_TRY(ht_array_reserve(&g->fine, g->work / PRIMS_A_CELL + 16));
    }
    return HTREE_OK;
}

static htree_status join_groups(refining *r) {
    for (uint32_t i = 0; i < r->group_count; ++i) {
        const group *g = &r->groups[i];
        if (g->status == HTREE_ERROR_MEMORY)
            return ht_fail(HTREE_ERROR_MEMORY, "out of memory while a thread refined the grid");
        for (uint64_t k = 0; k < g->fine.count; ++k) {
            ht_prim *listed = (ht_prim *)ht_array_add(&r->cells->cells);
            if (!listed) return HTREE_ERROR_MEMORY;
            *listed = *(const ht_prim *)ht_array_at(&g->fine, k);
        }
    }
    return HTREE_OK;
}

htree_status ht_wide_refine(ht_wide_build *build) {
    const ht_builder *builder = build->builder;
    refining r;
    uint64_t prims;
    memset(&r, 0, sizeof r);
    r.memory = &builder->tree->memory;
    r.source = &build->source;
    r.cells = &build->cells;
    if (builder->tree->prim_count <= ALONE && build->cells.cells.count == 1) return HTREE_OK;
    ht_array_begin(&r.crowded, r.memory, sizeof(ht_prim));
    htree_status status = take_crowded(&r, &prims);
    if (status == HTREE_OK) status = group_crowded(&r, prims);
    if (status == HTREE_OK) {
        ht_builder_run(builder, r.group_count, refine_group, &r);
        status = join_groups(&r);
    }
    for (uint32_t i = 0; i < r.group_count; ++i) {
        ht_array_end(&r.groups[i].fine);
        ht_array_end(&r.groups[i].todo);
    }
    ht_array_end(&r.crowded);
    return status;
}
