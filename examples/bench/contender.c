#include "contender.h"

#include "device.h"
#include "primary.h"
#include "shape_mesh.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

bool contender_builds(const contender *c) {
    return c->place == PLACE_CPU || c->place == PLACE_PEER;
}

/* As the library would refit it, not rebuild it: wide trees, or such as become one. */
static bool refits(const tree_config *config) {
    htree_options options;
    if (htree_options_init(&options, sizeof options, config->kind) != HTREE_OK) return false;
    const uint32_t flags = options.flags | config->flags;
    const bool divides_space = options.kind == HTREE_UG || options.kind == HTREE_KD;
    const bool wide = options.kind == HTREE_WIDE || ((flags & HTREE_COLLAPSE) && !divides_space);
    return wide && !(flags & (HTREE_LAZY | HTREE_COMPACT));
}

/* A geometry of the peer either refits or does not. */
bool contender_can(const contender *c, build_way way) {
    const bool by_refit = c->by_peer.quality == PEER_REFIT;
    if (c->place == PLACE_DEVICE) return false;
    if (way == BUILD_FRESH) return true;
    if (c->place == PLACE_CPU) return way == BUILD_WARM || refits(&c->config);
    return (way == BUILD_REFIT) == by_refit;
}

bool contender_takes(const contender *c, const ray_set *set) {
    return c->place != PLACE_PACKET || set->row;
}

static bool check(htree_status status, const char *text, bench_error error) {
    const bool own = status == HTREE_ERROR_MEMORY || !*text;
    if (status == HTREE_OK) return true;
    snprintf(error.text, error.size, "%s",
             own ? "out of memory: try a smaller scene or --size" : text);
    return false;
}

/* ---- Structures ----------------------------------------------------------------------------- */

bool contender_build(contender *c, const shape *mesh, uint32_t threads, bool again, double *seconds,
                     bench_error error) {
    if (c->place == PLACE_PEER)
        return peer_build(c->other, mesh->positions, again, seconds, error.text, error.size);
    const htree_mesh m = shape_mesh(mesh);
    htree_options options;
    htree_status status = htree_options_init(&options, sizeof options, c->config.kind);
    options.threads = threads;
    options.flags |= c->config.flags;
    contender_drop(c);
    const double start = clock_seconds();
    if (status == HTREE_OK) status = htree_build(&c->tree, &m, &options);
    *seconds = clock_seconds() - start;
    c->by = tracer_cpu(c->tree, threads);
    return check(status, htree_error_text(), error);
}

bool contender_update(contender *c, build_way way, const shape *mesh, double *seconds,
                      bench_error error) {
    if (c->place == PLACE_PEER)
        return peer_commit(c->other, mesh->positions, seconds, error.text, error.size);
    const htree_mesh m = shape_mesh(mesh);
    const double start = clock_seconds();
    const htree_status status =
        htree_update(c->tree, &m, way == BUILD_REFIT ? HTREE_REFIT : HTREE_REBUILD, NULL);
    *seconds = clock_seconds() - start;
    return check(status, htree_error_text(), error);
}

bool contender_weigh(contender *c, bench_error error) {
    if (c->place == PLACE_PEER) return peer_memory(c->other, &c->bytes, &c->peak), true;
    htree_stats stats;
    stats.size = sizeof stats;
    const htree_status status = htree_get_stats(c->tree, &stats);
    if (!check(status, htree_error_text(), error)) return false;
    c->bytes = stats.bytes;
    c->peak = stats.peak_bytes;
    return true;
}

void contender_drop(contender *c) {
    if (c->place == PLACE_PEER && c->other) peer_drop(c->other);
    if (c->place != PLACE_CPU) return;
    htree_free(c->tree);
    c->tree = NULL;
}

/* ---- Rays ----------------------------------------------------------------------------------- */

static void trace_peer(const contender *c, const ray_set *set, peer_packets *packed, bool any,
                       void *answers) {
    if (c->place == PLACE_PACKET)
        peer_intersect_packets(c->other, packed);
    else if (any)
        peer_occluded(c->other, set->rays, set->count, (uint8_t *)answers);
    else
        peer_intersect(c->other, set->rays, set->count, (htree_hit *)answers);
}

static htree_status trace_tree(contender *c, const ray_set *set, bool any, void *answers) {
    return any ? tracer_occluded(&c->by, set->rays, set->count, (uint8_t *)answers)
               : tracer_intersect(&c->by, set->rays, set->count, (htree_hit *)answers);
}

bool contender_trace(contender *c, const ray_set *set, peer_packets *packed, ray_set_name name,
                     void *answers, double *seconds, bench_error error) {
    const bool any = ray_set_any(name);
    htree_status status = HTREE_OK;
    const double start = clock_seconds();
    if (c->other)
        trace_peer(c, set, packed, any, answers);
    else
        status = trace_tree(c, set, any, answers);
    *seconds = clock_seconds() - start;
    if (c->place == PLACE_PACKET) peer_unpack(packed, (htree_hit *)answers);
    return check(status, status == HTREE_OK ? "" : tracer_error_text(&c->by), error);
}

/* ---- Agreement ------------------------------------------------------------------------------ */

typedef struct tolerance {
    double relative, absolute;
} tolerance;

/* 2^-16 of t for devices, see htree_cl.h. Peers take what is left of a coordinate beside others. */
static tolerance tolerance_of(const contender *c, double largest) {
    tolerance of = {0, 0};
    if (c->place == PLACE_DEVICE && !device_exact(c->by.device)) of.relative = 1.52587890625e-5;
    if (c->other) of.relative = 1e-4, of.absolute = 1e-5 * largest;
    return of;
}

/* Infinities are equal. t is in lengths of the ray's direction. */
static bool near_hit(const htree_hit *a, const htree_hit *b, const htree_ray *ray, tolerance by) {
    const float *d = ray->dir;
    if ((a->prim == HTREE_NONE) != (b->prim == HTREE_NONE)) return false;
    const double length = sqrt((double)(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
    const double apart = fabs((double)a->t - (double)b->t) * length;
    return a->t == b->t || apart <= by.relative * fabs((double)b->t) * length + by.absolute;
}

uint64_t contender_differ(const contender *c, const ray_set *set, ray_set_name name, double largest,
                          const void *answers, const void *expected) {
    const bool any = ray_set_any(name);
    const tolerance by = tolerance_of(c, largest);
    const bool exact = by.relative == 0;
    const htree_hit *a = (const htree_hit *)answers, *b = (const htree_hit *)expected;
    uint64_t differ = 0;
    if (memcmp(answers, expected, (size_t)set->count * (any ? 1 : sizeof *a)) == 0) return 0;
    for (uint64_t i = 0; i < set->count; ++i) {
        if (any)
            differ += ((const uint8_t *)answers)[i] != ((const uint8_t *)expected)[i];
        else if (exact)
            differ += memcmp(&a[i], &b[i], sizeof *a) != 0;
        else
            differ += !near_hit(&a[i], &b[i], &set->rays[i], by);
    }
    return differ;
}
