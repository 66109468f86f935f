/* calibrate.c: htree_calibrate: the costs of section 6.3, measured: random nodes, met by random
 * rays.
 *
 * The nodes are those that a walk meets: planes inside the unit cube, rays that start in it.
 * Random order matters, since what a node costs is mostly the branch that nobody could predict. */
#include "h_steps.h"
#include "base/clock.h"
#include "base/float_env.h"

enum { SAMPLES = 4096, RAYS = 256, REPEATS = 9 };

typedef struct calibration {
    ht_h_node nodes[2 * SAMPLES]; /* two slots each, for six planes */
    ht_triangle triangles[SAMPLES];
    ht_ray rays[RAYS];
    uint32_t state;
} calibration;

static float next_float(calibration *c) {
    c->state = c->state * 1664525u + 1013904223u;
    return (float)(c->state >> 8) / 16777216.0f;
}

static void make_rays(calibration *c) {
    const htree_box unit = {{0, 0, 0}, {1, 1, 1}};
    for (uint32_t i = 0; i < RAYS;) {
        htree_ray ray = {{0, 0, 0}, 0, {0, 0, 0}, 4};
        for (int k = 0; k < 3; ++k) {
            ray.org[k] = next_float(c);
            ray.dir[k] = 2 * next_float(c) - 1;
        }
        i += ht_ray_init(&c->rays[i], &ray, &unit);
    }
}

/* Writes nodes of one type: `planes` ordered planes along one random axis, or a box. */
static void make_nodes(calibration *c, uint32_t type) {
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        ht_h_node *node = &c->nodes[2 * i];
        const uint32_t axis = type == HT_H_BV6 ? 0 : (uint32_t)(3 * next_float(c)) % 3;
        memset(node, 0, 2 * sizeof *node);
        node->tag = type + axis;
        for (uint32_t k = 0; k < 3; ++k) {
            const float x = next_float(c), y = next_float(c);
            ht_h_set_plane(node, k, ht_min(x, y));
            ht_h_set_plane(node, 3 + k, ht_max(x, y));
        }
        node->b = type == HT_H_BV6 ? node->b : next_float(c);
        if (type == HT_H_BV2 && node->b < node->a) {
            const float low = node->b;
            node->b = node->a;
            node->a = low;
        }
    }
}

static void make_triangles(calibration *c) {
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        for (int k = 0; k < 9; ++k) c->triangles[i].v[k / 3][k % 3] = next_float(c);
    }
}

/* Each returns a number that depends on every step, so that none is left out. */

static uint32_t run_skd(const calibration *c) {
    ht_stack_entry stack[2];
    uint32_t sum = 0;
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        const ht_ray *r = &c->rays[i % RAYS];
        const ht_h_node *node = &c->nodes[2 * i];
        ht_stack_entry here = {2 * i, r->tnear, r->tfar};
        uint32_t top = 0;
        sum += step_skd(node, node->tag - HT_H_SKD, r, &here, stack, &top) ? here.slot : top;
    }
    return sum;
}

static uint32_t run_bound(const calibration *c) {
    uint32_t sum = 0;
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        const ht_ray *r = &c->rays[i % RAYS];
        const ht_h_node *node = &c->nodes[2 * i];
        ht_stack_entry here = {2 * i, r->tnear, r->tfar};
        if (step_bound(node, node->tag & HT_H_TYPE, r, &here)) sum += here.slot;
    }
    return sum;
}

static uint32_t run_intersect(const calibration *c) {
    uint32_t sum = 0;
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        const ht_ray *r = &c->rays[i % RAYS];
        const ht_triangle *t = &c->triangles[i];
        htree_hit hit;
        sum += ht_triangle_intersect(&r->shear, t->v[0], t->v[1], t->v[2], r->tmin, r->tfar, &hit);
    }
    return sum;
}

/* The least time of several runs: what disturbs a run only ever adds to it. */
static float seconds(const calibration *c, uint32_t (*run)(const calibration *), uint32_t *sink) {
    double least = INFINITY;
    for (int i = 0; i < REPEATS; ++i) {
        const double start = ht_seconds();
        *sink += run(c);
        const double took = ht_seconds() - start;
        if (took < least) least = took;
    }
    return (float)least;
}

static void measure(calibration *c, htree_options *options) {
    uint32_t sink = 0;
    make_rays(c);
    make_nodes(c, HT_H_SKD);
    const float skd = seconds(c, run_skd, &sink);
    make_nodes(c, HT_H_BV2);
    const float bv2 = seconds(c, run_bound, &sink);
    make_nodes(c, HT_H_BV6);
    const float bv6 = seconds(c, run_bound, &sink);
    make_triangles(c);
    const float intersect = seconds(c, run_intersect, &sink);
    /* A clock too coarse to see a run leaves the defaults. The sum is never this number. */
    if (!(skd > 0 && bv2 > 0 && bv6 > 0 && intersect > 0) || sink == 0xdeadbeef) return;
    options->cost_skd = 1;
    options->cost_bv2 = bv2 / skd;
    options->cost_bv6 = bv6 / skd;
    options->cost_intersect = intersect / skd;
}

static htree_status calibrate(htree_options *options) {
    if (!options) return ht_fail(HTREE_ERROR_ARGUMENT, "options is NULL");
    if (options->size < sizeof *options) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "options.size is %lu: call htree_options_init first",
                       (unsigned long)options->size);
    }
    ht_memory memory = {options->allocator, 0, 0, NULL};
    calibration *c = (calibration *)ht_allocate(&memory, sizeof *c);
    if (!c) return HTREE_ERROR_MEMORY;
    c->state = 1;
    measure(c, options);
    ht_release(&memory, c, sizeof *c);
    return HTREE_OK;
}

htree_status htree_calibrate(htree_options *options) {
    HT_RETURN_IN_DEFAULT_ENV(calibrate(options));
}
