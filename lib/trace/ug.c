/* ug.c: walks a uniform grid cell by cell: J. Amanatides, A. Woo, "A Fast Voxel Traversal
 * Algorithm for Ray Tracing", 1987, with the distance of every plane computed from its index,
 * so that errors do not add up.
 *
 * Why it loses no hit: the cells' intervals along the ray, as computed, leave no gap, so the t
 * of a hit lies in one of them, and the hit then lies within 10 e D of that cell (ray.h: 7 of
 * the hit, 3 of the planes). Boxes were entered with a wider margin than that, for D up to
 * grid.reach. Any other ray walks the same grid by halving it, with its own pad. */
#include "trace.h"

/* The prims tested last, by id: most repeats are of the cell just left. */
enum { MAILBOXES = 8 };

typedef struct grid_walk {
    const htree *tree;
    const htree_ray *ray;
    const ht_ray *r;
    htree_hit *hit;
    htree_counters *counters;
    uint32_t mailbox[MAILBOXES];
} grid_walk;

/* Tests the prims of a cell; with `any`, true at the first hit. */
HT_INLINE bool visit_cell(grid_walk *w, uint32_t cell, const bool any, const bool counted) {
    const ht_ug_node *starts = (const ht_ug_node *)w->tree->nodes;
    if (counted) {
        ++w->counters->traversal_steps;
        ++w->counters->leaf_steps;
    }
    for (uint32_t i = starts[cell]; i < starts[cell + 1]; ++i) {
        const uint32_t prim = w->tree->refs[i];
        if (w->mailbox[prim % MAILBOXES] == prim) continue;
        w->mailbox[prim % MAILBOXES] = prim;
        if (counted) ++w->counters->intersections;
        if (ht_intersect_prim(w->tree, prim, w->ray, w->r, w->hit) && any) return true;
    }
    return false;
}

/* ---- Cell by cell --------------------------------------------------------------------------- */

HT_INLINE float plane_distance(const ht_ug_grid *grid, const ht_ray *r, int axis, uint32_t plane) {
    return ((grid->lo[axis] + (float)plane * grid->size[axis]) - r->shear.org[axis]) *
           r->rdir[axis];
}

HT_INLINE uint32_t first_cell(const ht_ug_grid *grid, const htree_ray *ray, int axis, float t) {
    const float at = (ray->org[axis] + t * ray->dir[axis] - grid->lo[axis]) / grid->size[axis];
    const float last = (float)(grid->cells[axis] - 1);
    return at <= 0 ? 0 : at >= last ? grid->cells[axis] - 1 : (uint32_t)at;
}

/* Every step leaves a cell for good along one axis, so there are at most as many as cells on
 * all axes. */
HT_INLINE void walk_cells(grid_walk *w, const bool any, const bool counted) {
    const ht_ug_grid *grid = &w->tree->grid;
    const ht_ray *r = w->r;
    uint32_t cell[3];
    float leaves[3]; /* the distance at which the ray leaves the cell, by axis */
    for (int i = 0; i < 3; ++i) {
        cell[i] = first_cell(grid, w->ray, i, r->tnear);
        leaves[i] = plane_distance(grid, r, i, cell[i] + (r->negative[i] ? 0 : 1));
    }
    for (;;) {
        if (visit_cell(w, (cell[2] * grid->cells[1] + cell[1]) * grid->cells[0] + cell[0], any,
                       counted))
            return;
        const int axis = leaves[0] <= leaves[1] ? (leaves[0] <= leaves[2] ? 0 : 2)
                                                : (leaves[1] <= leaves[2] ? 1 : 2);
        /* Strictly beyond the best hit: at equal t a lower prim may still win. */
        if (leaves[axis] > w->hit->t || leaves[axis] > r->tfar) return;
        if (r->negative[axis]) {
            if (cell[axis] == 0) return;
            --cell[axis];
        } else {
            if (++cell[axis] == grid->cells[axis]) return;
        }
        leaves[axis] = plane_distance(grid, r, axis, cell[axis] + (r->negative[axis] ? 0 : 1));
    }
}

/* ---- By halves ------------------------------------------------------------------------------ */

/* A block of cells, first to last, and the ray's interval in it. */
typedef struct grid_block {
    uint32_t first[3], last[3];
    float tnear, tfar;
} grid_block;

enum { MAX_BLOCKS = 64 }; /* twenty halvings an axis, and one block waits for each */

HT_INLINE int longest_side(const grid_block *block) {
    const uint32_t x = block->last[0] - block->first[0];
    const uint32_t y = block->last[1] - block->first[1];
    const uint32_t z = block->last[2] - block->first[2];
    return x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
}

HT_INLINE bool clip_block(const grid_walk *w, grid_block *block, int axis) {
    const ht_ug_grid *grid = &w->tree->grid;
    const float lo = grid->lo[axis] + (float)block->first[axis] * grid->size[axis];
    const float hi = grid->lo[axis] + (float)(block->last[axis] + 1) * grid->size[axis];
    ht_ray_clip(w->r, (uint32_t)axis, lo, hi, &block->tnear, &block->tfar);
    return block->tnear <= block->tfar;
}

HT_INLINE void walk_halves(grid_walk *w, const bool any, const bool counted) {
    const ht_ug_grid *grid = &w->tree->grid;
    grid_block stack[MAX_BLOCKS];
    uint32_t top = 1;
    for (int i = 0; i < 3; ++i) {
        stack[0].first[i] = 0;
        stack[0].last[i] = grid->cells[i] - 1;
    }
    stack[0].tnear = w->r->tnear;
    stack[0].tfar = w->r->tfar;
    while (top > 0) {
        grid_block block = stack[--top];
        if (block.tnear > w->hit->t) continue;
        const int axis = longest_side(&block);
        if (block.first[axis] == block.last[axis]) {
            const uint32_t *c = block.first;
            if (visit_cell(w, (c[2] * grid->cells[1] + c[1]) * grid->cells[0] + c[0], any, counted))
                return;
            continue;
        }
        const uint32_t middle = block.first[axis] + (block.last[axis] - block.first[axis]) / 2;
        grid_block lower = block, upper = block;
        lower.last[axis] = middle;
        upper.first[axis] = middle + 1;
        const bool in_lower = clip_block(w, &lower, axis), in_upper = clip_block(w, &upper, axis);
        const bool upper_first = w->r->negative[axis] != 0;
        if (in_lower && upper_first) stack[top++] = lower;
        if (in_upper) stack[top++] = upper;
        if (in_lower && !upper_first) stack[top++] = lower;
    }
}

/* Whether the ray comes from within reach, and t resolves single cells: where distances
 * underflow, the order of planes is lost, but not the order of a plane and a hit, which is all
 * that halving needs. */
HT_INLINE bool suits_cells(const ht_ug_grid *grid, const ht_ray *r) {
    bool suits = r->reach <= grid->reach;
    for (int i = 0; i < 3; ++i) suits = suits && grid->size[i] * ht_magnitude(r->rdir[i]) >= 1e-30f;
    return suits;
}

HT_INLINE void walk_ug(const htree *tree, const htree_ray *ray, const ht_ray *r, htree_hit *hit,
                       htree_counters *counters, const bool any, const bool counted) {
    grid_walk w;
    w.tree = tree;
    w.ray = ray;
    w.r = r;
    w.hit = hit;
    w.counters = counters;
    for (int i = 0; i < MAILBOXES; ++i) w.mailbox[i] = HTREE_NONE;
    if (suits_cells(&tree->grid, r)) {
        walk_cells(&w, any, counted);
    } else {
        walk_halves(&w, any, counted);
    }
}

HT_DEFINE_WALKS(ht_ug_walks, walk_ug);
