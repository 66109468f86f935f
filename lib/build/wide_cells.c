/* wide_cells.c: grids over centroids, and finer ones inside of crowded cells: the recursion of
 * section 7.2. Its cells keep exact boxes of what they hold and become weighted prims for the top
 * of the tree, where the paper sums counts and searches: that costs less than the sums, and finds
 * better splits. */
#include "cells.h"
#include "prims.h"
#include "wide.h"

enum {
    ALONE = 2048, /* prims of a mesh that needs no grid */
    PRIMS_A_CELL = 8,
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

void ht_wide_grid_cut(ht_wide_grid *grid, const htree_box *centroids, uint32_t cells) {
    memset(grid, 0, sizeof *grid);
    for (int i = 0; i < 3; ++i) grid->cells[i] = cells;
    set_scales(grid, centroids);
}

/* ---- One crowded cell ----------------------------------------------------------------------- */

/* Crowded cells in a row, refined by one thread. */
typedef struct group {
    uint32_t first, end; /* of the list of crowded cells */
    ht_array fine;       /* what they became */
    htree_status status;
} group;

typedef struct refining {
    ht_memory *memory;
    const ht_source *source;
    ht_wide_cells *cells;
    ht_array crowded; /* of ht_prim */
    group groups[GROUPS];
    uint32_t group_count;
} refining;

/* Memory of a group for its largest cell. */
typedef struct bench {
    ht_prim *prims;
    uint32_t *next;
    ht_box4 *boxes;
} bench;

static void sort_range(const refining *r, const ht_wide_grid *grid, uint32_t first, uint32_t count,
                       bench *b) {
    uint32_t *order = r->cells->order + first, *cell_of = r->cells->leaf_order + first;
    memset(b->next, 0, grid->total * sizeof *b->next);
    for (uint32_t i = 0; i < grid->total; ++i) b->boxes[i] = ht_box4_empty();
    for (uint32_t i = 0; i < count; ++i) {
        const ht_box4 box = ht_prim_box4(&b->prims[i]);
        const uint32_t cell = ht_wide_grid_cell(grid, box.lo, box.hi);
        cell_of[i] = cell;
        ++b->next[cell];
        ht_box4_add(&b->boxes[cell], box.lo, box.hi);
    }
    uint32_t place = 0;
    for (uint32_t i = 0; i < grid->total; ++i) {
        const uint32_t here = b->next[i];
        b->next[i] = place;
        place += here;
    }
    for (uint32_t i = 0; i < count; ++i) order[b->next[cell_of[i]]++] = ht_prim_id(&b->prims[i]);
}

/* Sorts the prims of a cell into finer cells and lists them; those that are crowded still go to the
 * end of `fine` again, unless the grid did not separate them. */
static htree_status refine_cell(const refining *r, const ht_prim *cell, bench *b, ht_array *fine) {
    const uint32_t first = ht_cell_first(cell), count = ht_cell_prims(cell);
    ht_wide_grid grid;
    for (uint32_t i = 0; i < count; ++i)
        ht_source_prim(r->source, r->cells->order[first + i], &b->prims[i]);
    const htree_box centroids = ht_centroid_bounds(b->prims, count);
    const double wanted = (double)count / PRIMS_A_CELL;
    ht_wide_grid_shape(&grid, &centroids, wanted < MOST_CELLS ? wanted : MOST_CELLS);
    sort_range(r, &grid, first, count, b);
    uint32_t place = 0;
    for (uint32_t i = 0; i < grid.total; ++i) {
        if (b->next[i] == place) continue;
        ht_prim *listed = (ht_prim *)ht_array_add(fine);
        if (!listed) return HTREE_ERROR_MEMORY;
        ht_f4_store(listed->lo, b->boxes[i].lo);
        ht_f4_store(listed->hi, b->boxes[i].hi);
        ht_cell_set_range(listed, first + place, b->next[i] - place);
        place = b->next[i];
    }
    return HTREE_OK;
}

/* A grid that leaves nearly all of a cell together did not pay, and its next one would not either:
 * such cells stay as they are. */
static bool is_worth_refining(const ht_prim *cell, uint32_t parent_prims) {
    const uint32_t prims = ht_cell_prims(cell);
    return prims > HT_WIDE_CELL_PRIMS && prims <= parent_prims / 8 * 7;
}

/* Cuts a cell that no grid separates into pieces, in the order of its prims. */
static htree_status add_pieces(const refining *r, const ht_prim *cell, ht_array *fine) {
    const uint32_t first = ht_cell_first(cell), prims = ht_cell_prims(cell);
    const uint32_t pieces = (prims + HT_WIDE_CELL_PRIMS - 1) / HT_WIDE_CELL_PRIMS;
    for (uint32_t i = 0; i < pieces; ++i) {
        const uint32_t start = (uint32_t)((uint64_t)prims * i / pieces);
        const uint32_t end = (uint32_t)((uint64_t)prims * (i + 1) / pieces);
        ht_box4 box = ht_prim_box4(cell);
        for (uint32_t k = start; k < end && pieces > 1; ++k) {
            ht_prim prim;
            ht_source_prim(r->source, r->cells->order[first + k], &prim);
            if (k == start) box = ht_prim_box4(&prim);
            ht_box4_add(&box, ht_f4_load(prim.lo), ht_f4_load(prim.hi));
        }
        ht_prim *listed = (ht_prim *)ht_array_add(fine);
        if (!listed) return HTREE_ERROR_MEMORY;
        ht_f4_store(listed->lo, box.lo);
        ht_f4_store(listed->hi, box.hi);
        ht_cell_set_range(listed, first + start, end - start);
    }
    return HTREE_OK;
}

/* Refines a cell, and what is still crowded afterwards, in place of it in the list. */
static htree_status refine_deeply(const refining *r, const ht_prim *cell, bench *b, ht_array *fine,
                                  uint32_t levels) {
    ht_array here;
    ht_array_begin(&here, fine->memory, sizeof(ht_prim));
    htree_status status = refine_cell(r, cell, b, &here);
    for (uint64_t i = 0; i < here.count && status == HTREE_OK; ++i) {
        const ht_prim *sub = (const ht_prim *)ht_array_at(&here, i);
        status = levels > 0 && is_worth_refining(sub, ht_cell_prims(cell))
                     ? refine_deeply(r, sub, b, fine, levels - 1)
                     : add_pieces(r, sub, fine);
    }
    ht_array_end(&here);
    return status;
}

/* ---- All of them ---------------------------------------------------------------------------- */

enum { LEVELS = 8 };

static htree_status refine_on(const refining *r, group *g, bench *b) {
    if (!b->prims || !b->next || !b->boxes) return HTREE_ERROR_MEMORY;
    for (uint32_t i = g->first; i < g->end; ++i) {
        const ht_prim *cell = (const ht_prim *)ht_array_at(&r->crowded, i);
        HT_TRY(refine_deeply(r, cell, b, &g->fine, LEVELS));
    }
    return HTREE_OK;
}

static void refine_group(void *data, uint32_t index) {
    refining *r = (refining *)data;
    group *g = &r->groups[index];
    ht_memory *memory = r->memory;
    uint64_t most = 0;
    for (uint32_t i = g->first; i < g->end; ++i) {
        const uint32_t prims = ht_cell_prims((const ht_prim *)ht_array_at(&r->crowded, i));
        if (prims > most) most = prims;
    }
    const uint64_t cells =
        most / PRIMS_A_CELL + 1 < MOST_CELLS ? most / PRIMS_A_CELL + 1 : MOST_CELLS;
    bench b;
    b.prims = (ht_prim *)ht_allocate(memory, most * sizeof *b.prims);
    b.next = (uint32_t *)ht_allocate(memory, cells * sizeof *b.next);
    b.boxes = (ht_box4 *)ht_allocate(memory, cells * sizeof *b.boxes);
    g->status = refine_on(r, g, &b);
    ht_release(memory, b.boxes, cells * sizeof *b.boxes);
    ht_release(memory, b.next, cells * sizeof *b.next);
    ht_release(memory, b.prims, most * sizeof *b.prims);
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

static void group_crowded(refining *r, uint64_t prims) {
    const uint64_t share = prims / GROUPS + 1;
    for (uint32_t i = 0; i < r->crowded.count;) {
        group *g = &r->groups[r->group_count++];
        const bool last = r->group_count == GROUPS;
        uint64_t taken = 0;
        g->first = i;
        while (i < r->crowded.count && (last || taken < share))
            taken += ht_cell_prims((const ht_prim *)ht_array_at(&r->crowded, i++));
        g->end = i;
        ht_array_begin(&g->fine, r->crowded.memory, sizeof(ht_prim));
    }
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
    if (status == HTREE_OK) {
        group_crowded(&r, prims);
        ht_builder_run(builder, r.group_count, refine_group, &r);
        status = join_groups(&r);
    }
    for (uint32_t i = 0; i < r.group_count; ++i) ht_array_end(&r.groups[i].fine);
    ht_array_end(&r.crowded);
    return status;
}
