#include "grid.h"
#include "cells.h"

/* Counts and sums of more cells than this leave the cache, and every prim would wait for memory
 * twice. Large sets get crowded cells instead, and these a grid of their own: the paper's
 * recursion. */
static const double MOST_CELLS = 1 << 17;

static uint32_t cell_index(const ht_grid *grid, const ht_prim *prim) {
    return (ht_grid_cell(grid, prim, 2) * grid->cells[1] + ht_grid_cell(grid, prim, 1)) *
               grid->cells[0] +
           ht_grid_cell(grid, prim, 0);
}

static bool is_small(const ht_grid *grid, const ht_prim *prim) {
    return prim->hi[0] - prim->lo[0] <= grid->size[0] &&
           prim->hi[1] - prim->lo[1] <= grid->size[1] && prim->hi[2] - prim->lo[2] <= grid->size[2];
}

static void set_cells(ht_grid *grid, const htree_box *centroids, double wanted) {
    float size[3];
    ht_cubic_cells(centroids, wanted, grid->cells, size);
    for (int i = 0; i < 3; ++i) {
        const float extent = centroids->hi[i] - centroids->lo[i];
        const float scale = (float)grid->cells[i] / extent;
        grid->origin[i] = centroids->lo[i];
        grid->scale[i] = extent > 0 && scale <= 1e37f ? scale : 0;
    }
    /* Cells are cubic-like, and an axis without extent must not make everything oversize. */
    const float side = ht_max(size[0], ht_max(size[1], size[2])) / 2;
    for (int i = 0; i < 3; ++i) grid->size[i] = grid->cells[i] > 1 ? size[i] / 2 : side;
}

/* Counting sort by cell. The cell of every prim is kept: computing it twice costs more. */
static void sort_prims(ht_grid *grid, uint32_t count, uint32_t *cell_of) {
    const uint32_t total = grid->cells[0] * grid->cells[1] * grid->cells[2];
    const uint32_t oversize = UINT32_MAX;
    memset(grid->start, 0, ((size_t)total + 1) * sizeof *grid->start);
    for (uint32_t i = 0; i < count; ++i) {
        if (is_small(grid, &grid->prims[i])) {
            cell_of[i] = cell_index(grid, &grid->prims[i]);
            ++grid->start[cell_of[i]];
        } else {
            cell_of[i] = oversize;
            grid->oversize[grid->oversize_count++] = i;
        }
    }
    uint32_t sum = 0;
    for (uint32_t cell = 0; cell <= total; ++cell) {
        sum += grid->start[cell];
        grid->start[cell] = sum;
    }
    grid->small_count = sum;
    for (uint32_t i = count; i-- > 0;) {
        if (cell_of[i] != oversize) grid->order[--grid->start[cell_of[i]]] = i;
    }
}

static uint32_t *sum_at(const ht_grid *grid, uint32_t x, uint32_t y, uint32_t z) {
    return &grid->sums[((size_t)z * (grid->cells[1] + 1) + y) * (grid->cells[0] + 1) + x];
}

/* Row by row: the sum of this row so far, on top of the sums one row below and one layer before. */
static void sum_up(ht_grid *grid) {
    const uint32_t nx = grid->cells[0], ny = grid->cells[1], nz = grid->cells[2];
    memset(grid->sums, 0, (size_t)(nx + 1) * (ny + 1) * sizeof *grid->sums);
    for (uint32_t z = 0; z < nz; ++z) {
        memset(sum_at(grid, 0, 0, z + 1), 0, (nx + 1) * sizeof *grid->sums);
        for (uint32_t y = 0; y < ny; ++y) {
            const uint32_t *starts = &grid->start[((size_t)z * ny + y) * nx];
            const uint32_t *below = sum_at(grid, 0, y, z + 1);
            const uint32_t *before = sum_at(grid, 0, y + 1, z);
            const uint32_t *both = sum_at(grid, 0, y, z);
            uint32_t *sums = sum_at(grid, 0, y + 1, z + 1);
            for (uint32_t x = 0; x <= nx; ++x) {
                sums[x] = starts[x] - starts[0] + below[x] + before[x] - both[x];
            }
        }
    }
}

htree_status ht_grid_make(ht_grid *grid, ht_stack_memory *stack, const ht_prim *prims,
                          uint32_t count, const htree_box *centroids, float cells_per_prim) {
    memset(grid, 0, sizeof *grid);
    grid->prims = prims;
    double wanted = (double)cells_per_prim * (double)count;
    if (wanted > MOST_CELLS) wanted = MOST_CELLS;
    set_cells(grid, centroids, wanted);
    const uint64_t total = (uint64_t)grid->cells[0] * grid->cells[1] * grid->cells[2];
    const uint64_t sums =
        ((uint64_t)grid->cells[0] + 1) * (grid->cells[1] + 1) * (grid->cells[2] + 1);
    grid->oversize = (uint32_t *)ht_stack_push(stack, count * sizeof(uint32_t));
    grid->order = (uint32_t *)ht_stack_push(stack, count * sizeof(uint32_t));
    grid->start = (uint32_t *)ht_stack_push(stack, (total + 1) * sizeof(uint32_t));
    grid->sums = (uint32_t *)ht_stack_push(stack, sums * sizeof(uint32_t));
    const ht_stack_mark mark = ht_stack_top(stack);
    uint32_t *cell_of = (uint32_t *)ht_stack_push(stack, count * sizeof(uint32_t));
    if (!grid->oversize || !grid->order || !grid->start || !grid->sums || !cell_of)
        return HTREE_ERROR_MEMORY;
    sort_prims(grid, count, cell_of);
    ht_stack_pop(stack, mark);
    sum_up(grid);
    return HTREE_OK;
}

uint32_t ht_grid_count(const ht_grid *grid, const ht_cells *c) {
    const uint32_t *a = c->first, *b = c->end;
    return *sum_at(grid, b[0], b[1], b[2]) - *sum_at(grid, a[0], b[1], b[2]) -
           *sum_at(grid, b[0], a[1], b[2]) - *sum_at(grid, b[0], b[1], a[2]) +
           *sum_at(grid, a[0], a[1], b[2]) + *sum_at(grid, a[0], b[1], a[2]) +
           *sum_at(grid, b[0], a[1], a[2]) - *sum_at(grid, a[0], a[1], a[2]);
}

htree_box ht_grid_box(const ht_grid *grid, const ht_cells *cells) {
    htree_box box;
    for (int i = 0; i < 3; ++i) {
        const float origin = grid->origin[i] / 2;
        box.lo[i] = origin + ((float)cells->first[i] - 0.5f) * grid->size[i];
        box.hi[i] = origin + ((float)cells->end[i] + 0.5f) * grid->size[i];
    }
    return box;
}

/* The number of empty slabs at the lower (or upper) end of an axis: emptiness is monotonic. */
static uint32_t empty_slabs(const ht_grid *grid, const ht_cells *cells, int axis, bool upper) {
    uint32_t empty = 0, full = cells->end[axis] - cells->first[axis];
    while (empty + 1 < full) {
        const uint32_t middle = empty + (full - empty) / 2;
        ht_cells part = *cells;
        if (upper) {
            part.first[axis] = cells->end[axis] - middle;
        } else {
            part.end[axis] = cells->first[axis] + middle;
        }
        if (ht_grid_count(grid, &part) == 0) {
            empty = middle;
        } else {
            full = middle;
        }
    }
    return empty;
}

void ht_grid_shrink(const ht_grid *grid, ht_cells *cells) {
    assert(ht_grid_count(grid, cells) > 0);
    for (int axis = 0; axis < 3; ++axis) {
        cells->first[axis] += empty_slabs(grid, cells, axis, false);
        cells->end[axis] -= empty_slabs(grid, cells, axis, true);
    }
}

void ht_grid_gather(const ht_grid *grid, const ht_cells *cells, ht_prim *out) {
    for (uint32_t z = cells->first[2]; z < cells->end[2]; ++z) {
        for (uint32_t y = cells->first[1]; y < cells->end[1]; ++y) {
            const size_t row = ((size_t)z * grid->cells[1] + y) * grid->cells[0];
            const uint32_t end = grid->start[row + cells->end[0]];
            for (uint32_t i = grid->start[row + cells->first[0]]; i < end; ++i)
                *out++ = grid->prims[grid->order[i]];
        }
    }
}
