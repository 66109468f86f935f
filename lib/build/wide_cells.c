/* wide_cells.c: the grid of a wide tree: section 7.1's, but its cells keep exact boxes of what they
 * hold, and become weighted prims for the top of the tree, where the paper sums counts and searches.
 * That costs less than the sums, and finds better splits.
 *
 * Chunks of prims are counted and scattered apart; their number is fixed, and prims keep their order
 * within a cell, so the result does not depend on threads. */
#include "cells.h"
#include "prims.h"
#include "wide.h"

enum { CHUNKS = 16, PRIMS_A_CELL = 16, MOST_CELLS = 1 << 15 };

typedef struct sorting {
    ht_builder *builder;
    float origin[3], scale[3]; /* cell(c) = (c - origin) * scale */
    uint32_t cells[3], total;
    htree_box bounds[CHUNKS]; /* of centroids, doubled */
    uint32_t *cell_of;        /* by prim */
    uint32_t *next;           /* by chunk and cell: how many, then where the next one goes */
} sorting;

static void chunk_range(const sorting *s, uint32_t chunk, uint32_t *first, uint32_t *end) {
    const uint64_t count = s->builder->tree->prim_count;
    *first = (uint32_t)(count * chunk / CHUNKS);
    *end = (uint32_t)(count * (chunk + 1) / CHUNKS);
}

static void measure_chunk(void *data, uint32_t chunk) {
    sorting *s = (sorting *)data;
    uint32_t first, end;
    chunk_range(s, chunk, &first, &end);
    s->bounds[chunk] = ht_centroid_bounds(s->builder->prims + first, end - first);
}

HT_INLINE uint32_t cell_along(const sorting *s, const ht_prim *prim, int axis) {
    const float c = (prim->lo[axis] + prim->hi[axis] - s->origin[axis]) * s->scale[axis];
    const uint32_t cell = (uint32_t)(int32_t)c;
    return cell < s->cells[axis] ? cell : s->cells[axis] - 1;
}

static void count_chunk(void *data, uint32_t chunk) {
    sorting *s = (sorting *)data;
    uint32_t *counts = s->next + (size_t)chunk * s->total;
    uint32_t first, end;
    chunk_range(s, chunk, &first, &end);
    memset(counts, 0, s->total * sizeof *counts);
    for (uint32_t i = first; i < end; ++i) {
        const ht_prim *prim = &s->builder->prims[i];
        const uint32_t cell =
            (cell_along(s, prim, 2) * s->cells[1] + cell_along(s, prim, 1)) * s->cells[0] +
            cell_along(s, prim, 0);
        s->cell_of[i] = cell;
        ++counts[cell];
    }
}

static void scatter_chunk(void *data, uint32_t chunk) {
    sorting *s = (sorting *)data;
    uint32_t *next = s->next + (size_t)chunk * s->total;
    uint32_t first, end;
    chunk_range(s, chunk, &first, &end);
    for (uint32_t i = first; i < end; ++i)
        s->builder->spare[next[s->cell_of[i]]++] = s->builder->prims[i];
}

/* Turns counts into places, cell by cell and chunk by chunk, and lists the cells that hold any. */
static void list_cells(sorting *s, ht_wide_cells *out) {
    uint32_t place = 0;
    for (uint32_t cell = 0; cell < s->total; ++cell) {
        const uint32_t first = place;
        for (uint32_t chunk = 0; chunk < CHUNKS; ++chunk) {
            uint32_t *next = &s->next[(size_t)chunk * s->total + cell];
            const uint32_t count = *next;
            *next = place;
            place += count;
        }
        if (place == first) continue;
        ht_cell_set_range(&out->cells[out->count++], first, place - first);
    }
}

typedef struct boxing {
    const ht_prim *sorted;
    ht_wide_cells *out;
} boxing;

static void box_cells(void *data, uint32_t chunk) {
    const boxing *b = (const boxing *)data;
    const uint32_t first = (uint32_t)((uint64_t)b->out->count * chunk / CHUNKS);
    const uint32_t end = (uint32_t)((uint64_t)b->out->count * (chunk + 1) / CHUNKS);
    for (uint32_t i = first; i < end; ++i) {
        ht_prim *cell = &b->out->cells[i];
        const htree_box box = ht_prims_box(b->sorted + ht_cell_first(cell), ht_cell_prims(cell));
        memcpy(cell->lo, box.lo, sizeof box.lo);
        memcpy(cell->hi, box.hi, sizeof box.hi);
    }
}

static void shape_grid(sorting *s) {
    htree_box all = ht_box_empty();
    float size[3];
    const double wanted = (double)s->builder->tree->prim_count / PRIMS_A_CELL;
    for (int i = 0; i < CHUNKS; ++i) ht_box_add(&all, &s->bounds[i]);
    for (int i = 0; i < 3; ++i) s->cells[i] = 1;
    if (all.lo[0] < all.hi[0] || all.lo[1] < all.hi[1] || all.lo[2] < all.hi[2])
        ht_cubic_cells(&all, wanted < MOST_CELLS ? wanted : MOST_CELLS, s->cells, size);
    for (int i = 0; i < 3; ++i) {
        const float extent = all.hi[i] - all.lo[i];
        const float scale = (float)s->cells[i] / extent;
        s->origin[i] = all.lo[i];
        /* A denormal extent makes the scale infinite; such centroids count as equal. */
        s->scale[i] = extent > 0 && scale <= 1e37f ? scale : 0;
    }
    s->total = s->cells[0] * s->cells[1] * s->cells[2];
}

static void sort_prims(sorting *s, ht_wide_cells *out) {
    ht_builder *builder = s->builder;
    boxing b = {builder->spare, out};
    ht_builder_run(builder, CHUNKS, count_chunk, s);
    list_cells(s, out);
    ht_builder_run(builder, CHUNKS, scatter_chunk, s);
    ht_builder_run(builder, CHUNKS, box_cells, &b);
}

htree_status ht_wide_cells_begin(ht_wide_cells *out, ht_builder *builder) {
    ht_memory *memory = &builder->tree->memory;
    const uint64_t prims = builder->tree->prim_count;
    sorting s;
    memset(&s, 0, sizeof s);
    memset(out, 0, sizeof *out);
    s.builder = builder;
    ht_builder_run(builder, CHUNKS, measure_chunk, &s);
    shape_grid(&s);
    const uint64_t next_bytes = (uint64_t)CHUNKS * s.total * sizeof *s.next;
    out->capacity = s.total;
    out->cells = (ht_prim *)ht_allocate(memory, out->capacity * sizeof *out->cells);
    s.cell_of = (uint32_t *)ht_allocate(memory, prims * sizeof *s.cell_of);
    s.next = (uint32_t *)ht_allocate(memory, next_bytes);
    const bool memory_holds = out->cells && s.cell_of && s.next;
    if (memory_holds) sort_prims(&s, out);
    ht_release(memory, s.next, next_bytes);
    ht_release(memory, s.cell_of, prims * sizeof *s.cell_of);
    if (memory_holds) return HTREE_OK;
    ht_wide_cells_end(out, builder);
    return HTREE_ERROR_MEMORY;
}

void ht_wide_cells_end(ht_wide_cells *cells, ht_builder *builder) {
    ht_release(&builder->tree->memory, cells->cells, cells->capacity * sizeof *cells->cells);
    cells->cells = NULL;
}
