/* ug.c: the uniform grid of section 9: cubic-like cells, five for every object. O(N).
 *
 * Boxes are entered with a margin that covers the rounding of a walk from any origin within `reach`
 * (see trace/ug.c), so that the walk may take the cells one by one without a pad of its own. */
#include "build.h"
#include "cells.h"

#include <float.h>

static const double CELLS_PER_OBJECT = 5;
static const double REFERENCES_PER_OBJECT = 32;

/* The reach of rays that walk cell by cell, in largest extents of the bounds. */
static const float REACH = 4;

/* 64 e reach + 8 e |coordinate|, e = 2^-24: the pad of trace/ray.h, which any such ray has,
 * twice. */
static void set_margin(const htree *tree, ht_ug_grid *grid, float *margin) {
    float extent = 0;
    for (int i = 0; i < 3; ++i) extent = ht_max(extent, tree->bounds.hi[i] - tree->bounds.lo[i]);
    grid->reach = REACH * extent;
    for (int i = 0; i < 3; ++i) {
        const float coordinate =
            ht_max(ht_magnitude(tree->bounds.lo[i]), ht_magnitude(tree->bounds.hi[i])) +
            grid->reach;
        margin[i] =
            ht_max(3.814697265625e-6f * grid->reach + 4.76837158203125e-7f * coordinate, FLT_MIN);
        grid->lo[i] = tree->bounds.lo[i] - margin[i];
        grid->hi[i] = tree->bounds.hi[i] + margin[i];
    }
}

/* ---- Filling -------------------------------------------------------------------------------- */

static uint32_t cell_of(const ht_ug_grid *grid, int axis, float x) {
    const float at = (x - grid->lo[axis]) / grid->size[axis];
    const float last = (float)(grid->cells[axis] - 1);
    return at <= 0 ? 0 : at >= last ? grid->cells[axis] - 1 : (uint32_t)at;
}

typedef struct cell_range {
    uint32_t first[3], last[3];
} cell_range;

/* The cells that the prim's box, widened by the margin, reaches into. */
static cell_range cells_of(const ht_ug_grid *grid, const float *margin, const ht_prim *prim) {
    cell_range range;
    for (int i = 0; i < 3; ++i) {
        range.first[i] = cell_of(grid, i, prim->lo[i] - margin[i]);
        range.last[i] = cell_of(grid, i, prim->hi[i] + margin[i]);
    }
    return range;
}

/* Large objects lie in many cells: where that would take too much, the cells are made larger. */
static void choose_cells(const ht_builder *builder, const float *margin) {
    htree *tree = builder->tree;
    ht_ug_grid *grid = &tree->grid;
    double wanted = CELLS_PER_OBJECT * (double)tree->prim_count;
    for (;; wanted /= 8) {
        const htree_box box = {{grid->lo[0], grid->lo[1], grid->lo[2]},
                               {grid->hi[0], grid->hi[1], grid->hi[2]}};
        ht_cubic_cells(&box, wanted, grid->cells, grid->size);
        double references = 0;
        for (uint32_t i = 0; i < tree->prim_count; ++i) {
            const cell_range range = cells_of(&tree->grid, margin, &builder->prims[i]);
            double cells = 1;
            for (int k = 0; k < 3; ++k) cells *= (double)(range.last[k] - range.first[k]) + 1;
            references += cells;
        }
        if (references <= REFERENCES_PER_OBJECT * (double)tree->prim_count || wanted <= 1) return;
    }
}

typedef void ht_cell_visit(void *data, uint32_t cell, uint32_t prim);

HT_INLINE void for_each_cell(const ht_ug_grid *grid, const float *margin, const ht_prim *prim,
                             ht_cell_visit *visit, void *data) {
    const cell_range r = cells_of(grid, margin, prim);
    for (uint32_t z = r.first[2]; z <= r.last[2]; ++z) {
        for (uint32_t y = r.first[1]; y <= r.last[1]; ++y) {
            const uint32_t row = (z * grid->cells[1] + y) * grid->cells[0];
            for (uint32_t x = r.first[0]; x <= r.last[0]; ++x)
                visit(data, row + x, ht_prim_id(prim));
        }
    }
}

HT_INLINE void count_reference(void *data, uint32_t cell, uint32_t prim) {
    uint32_t *ends = (uint32_t *)data;
    (void)prim;
    ++ends[cell];
}

HT_INLINE void write_reference(void *data, uint32_t cell, uint32_t prim) {
    htree *tree = (htree *)data;
    ht_ug_node *ends = (ht_ug_node *)tree->nodes;
    tree->refs[--ends[cell]] = prim;
}

/* Counts, sums, and fills from the back: afterwards each cell's word is where its references
 * begin. */
static htree_status fill(ht_builder *builder, const float *margin) {
    htree *tree = builder->tree;
    ht_ug_node *ends = (ht_ug_node *)tree->nodes;
    memset(ends, 0, (size_t)tree->node_slots * sizeof *ends);
    for (uint32_t i = 0; i < tree->prim_count; ++i) {
        for_each_cell(&tree->grid, margin, &builder->prims[i], count_reference, ends);
        if (!ht_progress_step(&builder->progress, 1)) return HTREE_ERROR_CANCELLED;
    }
    uint64_t sum = 0;
    for (uint32_t cell = 0; cell < tree->node_slots; ++cell) {
        sum += ends[cell];
        if (sum > UINT32_MAX)
            return ht_fail(HTREE_ERROR_LIMIT, "a grid holds at most 2^32 - 1 references");
        ends[cell] = (uint32_t)sum;
    }
    tree->ref_count = (uint32_t)sum;
    tree->refs = (uint32_t *)ht_allocate(&tree->memory, sum * sizeof *tree->refs);
    if (!tree->refs) return HTREE_ERROR_MEMORY;
    for (uint32_t i = tree->prim_count; i-- > 0;) {
        for_each_cell(&tree->grid, margin, &builder->prims[i], write_reference, tree);
        if (!ht_progress_step(&builder->progress, 1)) return HTREE_ERROR_CANCELLED;
    }
    return HTREE_OK;
}

htree_status ht_build_ug(ht_builder *builder) {
    htree *tree = builder->tree;
    float margin[3];
    set_margin(tree, &tree->grid, margin);
    choose_cells(builder, margin);
    builder->progress.total *= 2;
    tree->node_slots = tree->grid.cells[0] * tree->grid.cells[1] * tree->grid.cells[2] + 1;
    tree->node_bytes = (uint64_t)tree->node_slots * sizeof(ht_ug_node);
    tree->nodes = ht_allocate(&tree->memory, tree->node_bytes);
    if (!tree->nodes) return HTREE_ERROR_MEMORY;
    return fill(builder, margin);
}
