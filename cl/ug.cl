/* ug.cl: twin of lib/trace/ug.c. */

#define MAILBOXES  8
#define MAX_BLOCKS 64

typedef struct grid_walk {
    __global const ht_ug_grid *grid;
    __global const ht_ug_node *starts;
    __global const uint *refs;
    __global const float *triangles;
    const ht_ray *r;
    ht_hit *hit;
    uint mailbox[MAILBOXES];
} grid_walk;

/* Tests the prims of a cell; with `any`, true at the first hit. */
bool visit_cell(grid_walk *w, uint x, uint y, uint z, const bool any) {
    const uint cell = (z * w->grid->cells[1] + y) * w->grid->cells[0] + x;
    for (uint i = w->starts[cell]; i < w->starts[cell + 1]; ++i) {
        const uint prim = w->refs[i];
        if (w->mailbox[prim % MAILBOXES] == prim) continue;
        w->mailbox[prim % MAILBOXES] = prim;
        if (ht_triangle_intersect(w->r, w->triangles, prim, w->hit) && any) return true;
    }
    return false;
}

/* ---- Cell by cell --------------------------------------------------------------------------- */

float plane_distance(const grid_walk *w, int axis, uint plane) {
    const float at = w->grid->lo[axis] + (float)plane * w->grid->size[axis];
    return (at - w->r->org[axis]) * w->r->rdir[axis];
}

uint first_cell(const grid_walk *w, int axis, float t) {
    const float from = w->r->org[axis] + t * w->r->dir[axis] - w->grid->lo[axis];
    const float at = ht_divide(from, w->grid->size[axis]);
    const float last = (float)(w->grid->cells[axis] - 1);
    return at <= 0 ? 0 : at >= last ? w->grid->cells[axis] - 1 : (uint)at;
}

void walk_cells(grid_walk *w, const bool any) {
    const ht_ray *r = w->r;
    uint cell[3];
    float leaves[3];
    for (int i = 0; i < 3; ++i) {
        cell[i] = first_cell(w, i, r->tnear);
        leaves[i] = plane_distance(w, i, cell[i] + (r->negative[i] ? 0 : 1));
    }
    for (;;) {
        if (visit_cell(w, cell[0], cell[1], cell[2], any)) return;
        const int axis = leaves[0] <= leaves[1] ? (leaves[0] <= leaves[2] ? 0 : 2)
                                                : (leaves[1] <= leaves[2] ? 1 : 2);
        if (leaves[axis] > w->hit->t || leaves[axis] > r->tfar) return;
        if (r->negative[axis]) {
            if (cell[axis] == 0) return;
            --cell[axis];
        } else {
            if (++cell[axis] == w->grid->cells[axis]) return;
        }
        leaves[axis] = plane_distance(w, axis, cell[axis] + (r->negative[axis] ? 0 : 1));
    }
}

/* ---- By halves ------------------------------------------------------------------------------ */

typedef struct grid_block {
    uint first[3], last[3];
    float tnear, tfar;
} grid_block;

bool clip_block(const grid_walk *w, grid_block *block, int axis) {
    const float lo = w->grid->lo[axis] + (float)block->first[axis] * w->grid->size[axis];
    const float hi = w->grid->lo[axis] + (float)(block->last[axis] + 1) * w->grid->size[axis];
    ht_ray_clip(w->r, (uint)axis, lo, hi, &block->tnear, &block->tfar);
    return block->tnear <= block->tfar;
}

void walk_halves(grid_walk *w, const bool any) {
    grid_block stack[MAX_BLOCKS];
    uint top = 1;
    for (int i = 0; i < 3; ++i) {
        stack[0].first[i] = 0;
        stack[0].last[i] = w->grid->cells[i] - 1;
    }
    stack[0].tnear = w->r->tnear;
    stack[0].tfar = w->r->tfar;
    while (top > 0) {
        const grid_block block = stack[--top];
        if (block.tnear > w->hit->t) continue;
        const uint x = block.last[0] - block.first[0];
        const uint y = block.last[1] - block.first[1];
        const uint z = block.last[2] - block.first[2];
        const int axis = x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
        if (block.first[axis] == block.last[axis]) {
            if (visit_cell(w, block.first[0], block.first[1], block.first[2], any)) return;
            continue;
        }
        const uint middle = block.first[axis] + (block.last[axis] - block.first[axis]) / 2;
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

bool suits_cells(const grid_walk *w) {
    bool suits = w->r->reach <= w->grid->reach;
    for (int i = 0; i < 3; ++i)
        suits = suits && w->grid->size[i] * ht_magnitude(w->r->rdir[i]) >= 1e-30f;
    return suits;
}

void walk_ug(__global const ht_scene *scene, __global const void *nodes,
             __global const float *triangles, __global const void *leaves, const ht_ray *r,
             ht_hit *hit, const bool any) {
    grid_walk w;
    w.grid = &scene->grid;
    w.starts = (__global const ht_ug_node *)nodes;
    w.refs = (__global const uint *)leaves;
    w.triangles = triangles;
    w.r = r;
    w.hit = hit;
    for (int i = 0; i < MAILBOXES; ++i) w.mailbox[i] = HT_NONE;
    if (suits_cells(&w)) {
        walk_cells(&w, any);
    } else {
        walk_halves(&w, any);
    }
}

HT_KERNELS(walk_ug)
