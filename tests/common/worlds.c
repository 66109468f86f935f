/* worlds.c: worlds, and a function for each change. */
#include "worlds.h"

#include <math.h>

enum { RAYS = WORLD_RAYS };

htree_mesh mesh_of_world(const world *w) {
    return plain_mesh(&w->xyz[0][0][0], w->triangles);
}

void draw_world(world *w, uint32_t number, dice *d) {
    static const char *const names[] = {"knot", "soup", "slivers", "terrain", "city"};
    memset(w, 0, sizeof *w);
    w->is_whole = number % 3 == 2;
    shape s = shape_of(names[number % COUNT_OF(names)], 20 + dice_below(d, 100), number);
    const htree_mesh mesh = mesh_of(&s);
    for (uint32_t i = 0; i < mesh.triangle_count && i < WORLD_TRIANGLES / 2; ++i, ++w->triangles) {
        for (uint32_t c = 0; c < 3; ++c) {
            const float *const p = mesh_corner(&mesh, i, c);
            for (int k = 0; k < 3; ++k) w->xyz[i][c][k] = w->is_whole ? floorf(16 * p[k]) : p[k];
        }
    }
    shape_free(&s);
    const htree_mesh own = mesh_of_world(w);
    const ray_target target = ray_target_of(&own);
    for (uint32_t i = 0; i < RAYS; ++i) {
        /* Families beyond these have special numbers in their rays, which do not scale. */
        rays_make(&target, i % 4, d, &w->rays[i], 1);
        w->rays[i].tmin = 0;
        w->rays[i].tmax = dice_below(d, 4) ? INFINITY : dice_between(d, 0, 4);
        for (int k = 0; k < 3 && w->is_whole; ++k) {
            w->rays[i].org[k] = floorf(w->rays[i].org[k]);
            w->rays[i].dir[k] = (float)dice_below(d, 15) - 7 + (k == 0 ? 0.25f : 0);
        }
    }
}

/* ---- Changes ---------------------------------------------------------------------------------- */

static void scale_hits(world *x, float scale) {
    for (uint32_t i = 0; i < RAYS; ++i) {
        x->rays[i].tmin *= scale;
        x->rays[i].tmax *= scale;
        x->hits[i].t *= scale;
    }
}

static void scale_space(const world *w, world *x, dice *d) {
    const float scale = ldexpf(1, (int)dice_below(d, 61) - 30);
    (void)w;
    for (uint32_t i = 0; i < x->triangles; ++i)
        for (int k = 0; k < 9; ++k) x->xyz[i][k / 3][k % 3] *= scale;
    for (uint32_t i = 0; i < RAYS; ++i)
        for (int k = 0; k < 3; ++k) x->rays[i].org[k] *= scale;
    scale_hits(x, scale);
}

static void scale_directions(const world *w, world *x, dice *d) {
    const int exponent = (int)dice_below(d, 41) - 20;
    (void)w;
    for (uint32_t i = 0; i < RAYS; ++i)
        for (int k = 0; k < 3; ++k) x->rays[i].dir[k] = ldexpf(x->rays[i].dir[k], exponent);
    scale_hits(x, ldexpf(1, -exponent));
}

static void mirror_an_axis(const world *w, world *x, dice *d) {
    const uint32_t axis = dice_below(d, 3);
    (void)w;
    for (uint32_t i = 0; i < x->triangles; ++i)
        for (int c = 0; c < 3; ++c) x->xyz[i][c][axis] = -x->xyz[i][c][axis];
    for (uint32_t i = 0; i < RAYS; ++i) {
        x->rays[i].org[axis] = -x->rays[i].org[axis];
        x->rays[i].dir[axis] = -x->rays[i].dir[axis];
    }
}

/* The axis that the triangle test takes for z must not depend on a tie. */
static bool has_one_largest(const float *dir) {
    const float x = fabsf(dir[0]), y = fabsf(dir[1]), z = fabsf(dir[2]);
    return (x > y && x > z) || (y > x && y > z) || (z > x && z > y);
}

static void turn_axes(const world *w, world *x, dice *d) {
    (void)d;
    for (uint32_t i = 0; i < x->triangles; ++i)
        for (int k = 0; k < 9; ++k) x->xyz[i][k / 3][(k + 1) % 3] = w->xyz[i][k / 3][k % 3];
    for (uint32_t i = 0; i < RAYS; ++i) {
        for (int k = 0; k < 3; ++k) {
            x->rays[i].org[(k + 1) % 3] = w->rays[i].org[k];
            x->rays[i].dir[(k + 1) % 3] = w->rays[i].dir[k];
        }
        if (has_one_largest(w->rays[i].dir)) continue;
        x->rays[i].tmin = x->hits[i].t = 1; /* a ray that misses by its numbers */
        x->rays[i].tmax = x->hits[i].t = 0;
        x->hits[i].u = x->hits[i].v = 0;
        x->hits[i].prim = HTREE_NONE;
    }
}

/* The first come first; ties may fall to another prim, so the order is kept among equals of t. */
static void turn_order(const world *w, world *x, dice *d) {
    const uint32_t shift = 1 + dice_below(d, w->triangles);
    for (uint32_t i = 0; i < w->triangles; ++i)
        memcpy(x->xyz[(i + shift) % w->triangles], w->xyz[i], sizeof w->xyz[i]);
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (w->hits[i].prim != HTREE_NONE)
            x->hits[i].prim = (w->hits[i].prim + shift) % w->triangles;
    }
}

/* v0 becomes the last corner: the weights 1 - u - v, u, v change places. */
static void turn_corners(const world *w, world *x, dice *d) {
    (void)d;
    for (uint32_t i = 0; i < w->triangles; ++i)
        for (uint32_t c = 0; c < 3; ++c)
            memcpy(x->xyz[i][(c + 2) % 3], w->xyz[i][c], sizeof w->xyz[i][c]);
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (w->hits[i].prim == HTREE_NONE) continue;
        x->hits[i].u = w->hits[i].v;
        x->hits[i].v = 1 - w->hits[i].u - w->hits[i].v;
    }
}

static void flip_triangles(const world *w, world *x, dice *d) {
    (void)d;
    for (uint32_t i = 0; i < w->triangles; ++i) {
        memcpy(x->xyz[i][1], w->xyz[i][2], sizeof w->xyz[i][2]);
        memcpy(x->xyz[i][2], w->xyz[i][1], sizeof w->xyz[i][1]);
    }
    for (uint32_t i = 0; i < RAYS; ++i) {
        x->hits[i].u = w->hits[i].v;
        x->hits[i].v = w->hits[i].u;
    }
}

/* Of twins the lower number is hit. */
static void add_twins(const world *w, world *x, dice *d) {
    (void)d;
    memcpy(x->xyz[w->triangles], w->xyz, w->triangles * sizeof w->xyz[0]);
    x->triangles = 2 * w->triangles;
}

static void add_what_is_never_hit(const world *w, world *x, dice *d) {
    static const float bad[] = {NAN, INFINITY, -INFINITY, 2e18f, -3e38f};
    (void)w;
    for (int i = 0; i < 60; ++i) {
        float(*const t)[3] = x->xyz[x->triangles++];
        for (int k = 0; k < 9; ++k) t[k / 3][k % 3] = dice_between(d, -1, 1);
        if (i % 2)
            t[dice_below(d, 3)][dice_below(d, 3)] = bad[dice_below(d, COUNT_OF(bad))];
        else
            memcpy(t[0], t[dice_below(d, 2) + 1], sizeof t[0]);
    }
}

/* Beyond all that is there, and beyond every tmax. */
static void add_what_lies_beyond(const world *w, world *x, dice *d) {
    (void)w;
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (isinf(x->rays[i].tmax)) x->rays[i].tmax = x->hits[i].t = fminf(x->hits[i].t, 1e9f);
    }
    for (int i = 0; i < 20; ++i) {
        float(*const t)[3] = x->xyz[x->triangles++];
        for (int k = 0; k < 9; ++k)
            t[k / 3][k % 3] = (k % 3 == 0 ? 1e15f : 1e14f) * dice_between(d, 1, 2);
    }
}

static void remove_what_is_not_hit(const world *w, world *x, dice *d) {
    uint32_t number[WORLD_TRIANGLES];
    bool kept[WORLD_TRIANGLES] = {false};
    for (uint32_t i = 0; i < RAYS; ++i)
        if (w->hits[i].prim != HTREE_NONE) kept[w->hits[i].prim] = true;
    x->triangles = 0;
    for (uint32_t i = 0; i < w->triangles; ++i) {
        if (!kept[i] && dice_below(d, 4)) continue;
        memcpy(x->xyz[x->triangles], w->xyz[i], sizeof w->xyz[i]);
        number[i] = x->triangles++;
    }
    for (uint32_t i = 0; i < RAYS; ++i)
        if (w->hits[i].prim != HTREE_NONE) x->hits[i].prim = number[w->hits[i].prim];
}

static void negate_zeros(const world *w, world *x, dice *d) {
    float *const xyz = &x->xyz[0][0][0];
    (void)w;
    (void)d;
    for (uint32_t i = 0; i < 9 * x->triangles; ++i)
        if (xyz[i] == 0) xyz[i] = -xyz[i];
    for (uint32_t i = 0; i < RAYS; ++i) {
        float *const f = x->rays[i].org; /* and all that follows it */
        for (int k = 0; k < 8; ++k)
            if (f[k] == 0) f[k] = -f[k];
    }
}

/* Whole numbers move by whole numbers without rounding. */
static void move_whole_numbers(const world *w, world *x, dice *d) {
    float by[3];
    for (int k = 0; k < 3; ++k) by[k] = w->is_whole ? (float)dice_below(d, 100000) - 50000 : 0;
    for (uint32_t i = 0; i < x->triangles; ++i)
        for (int k = 0; k < 9; ++k) x->xyz[i][k / 3][k % 3] += by[k % 3];
    for (uint32_t i = 0; i < RAYS; ++i)
        for (int k = 0; k < 3; ++k) x->rays[i].org[k] += by[k];
}

/* tmin may come up to the hit, and tmax down to it. */
static void close_in(const world *w, world *x, dice *d) {
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (w->hits[i].prim == HTREE_NONE) continue;
        if (dice_below(d, 2)) x->rays[i].tmin = w->hits[i].t;
        if (dice_below(d, 2)) x->rays[i].tmax = w->hits[i].t;
    }
}

static void end_just_before(const world *w, world *x, dice *d) {
    (void)d;
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (w->hits[i].prim == HTREE_NONE) continue;
        x->rays[i].tmax = nextafterf(w->hits[i].t, -INFINITY);
        x->hits[i].t = x->rays[i].tmax;
        x->hits[i].u = x->hits[i].v = 0;
        x->hits[i].prim = HTREE_NONE;
    }
}

/* ---- The table -------------------------------------------------------------------------------- */

const world_change world_changes[WORLD_CHANGES] = {
    {"scale space by a power of two", scale_space, EXACT},
    {"scale directions by a power of two", scale_directions, EXACT},
    {"mirror an axis", mirror_an_axis, EXACT},
    {"turn the axes", turn_axes, EXACT},
    {"turn the order of triangles", turn_order, TIES},
    {"turn the corners of triangles", turn_corners, NEXT_FLOAT},
    {"flip triangles", flip_triangles, NEXT_FLOAT},
    {"add twins", add_twins, EXACT},
    {"add what is never hit", add_what_is_never_hit, EXACT},
    {"add what lies beyond", add_what_lies_beyond, EXACT},
    {"remove what is not hit", remove_what_is_not_hit, EXACT},
    {"negate zeros", negate_zeros, EXACT},
    {"move whole numbers", move_whole_numbers, EXACT},
    {"close in on the hit", close_in, EXACT},
    {"end just before the hit", end_just_before, EXACT},
};
