/* primary.c: timing and counting are apart, because counting costs time of its own, and is the
 * CPU's; the hits that stay are of who was timed. */
#include "primary.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

double clock_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double median3(const double *x) {
    const double lo = x[0] < x[1] ? x[0] : x[1], hi = x[0] < x[1] ? x[1] : x[0];
    return x[2] < lo ? lo : x[2] > hi ? hi : x[2];
}

static htree_status time_batch(primary *p, tracer *by) {
    double seconds[3];
    htree_status status = tracer_count(by, p->rays, p->count, p->hits, p->counters);
    for (int i = 0; i < 3 && status == HTREE_OK; ++i) {
        const double start = clock_seconds();
        status = tracer_intersect(by, p->rays, p->count, p->hits);
        seconds[i] = clock_seconds() - start;
    }
    if (status == HTREE_OK) p->seconds = median3(seconds);
    return status;
}

static void take_means(primary *p) {
    uint64_t hits = 0, tests = 0, steps = 0, leaves = 0;
    for (uint64_t i = 0; i < p->count; ++i) {
        hits += p->hits[i].prim != HTREE_NONE;
        tests += p->counters[i].intersections;
        steps += p->counters[i].traversal_steps;
        leaves += p->counters[i].leaf_steps;
    }
    const double count = (double)p->count;
    p->hit_fraction = (double)hits / count;
    p->intersections = (double)tests / count;
    p->traversal_steps = (double)steps / count;
    p->leaf_steps = (double)leaves / count;
}

htree_status primary_trace(primary *out, tracer *by, const camera *view, uint32_t width,
                           uint32_t height) {
    const size_t count = (size_t)width * height;
    htree_status status = HTREE_OK;
    memset(out, 0, sizeof *out);
    out->count = count;
    out->rays = (htree_ray *)malloc(count * sizeof *out->rays);
    out->hits = (htree_hit *)malloc(count * sizeof *out->hits);
    out->counters = (htree_counters *)malloc(count * sizeof *out->counters);
    if (!out->rays || !out->hits || !out->counters) status = HTREE_ERROR_MEMORY;
    if (status == HTREE_OK) {
        for (size_t i = 0; i < count; ++i)
            out->rays[i] = camera_ray(view, (double)(i % width) + 0.5, (double)(i / width) + 0.5,
                                      width, height);
        status = time_batch(out, by);
    }
    if (status == HTREE_OK)
        take_means(out);
    else
        primary_free(out);
    return status;
}

void primary_free(primary *p) {
    free(p->rays);
    free(p->hits);
    free(p->counters);
    memset(p, 0, sizeof *p);
}
