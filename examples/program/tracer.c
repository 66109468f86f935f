#include "tracer.h"

#include <stddef.h>

tracer tracer_cpu(const htree *tree, uint32_t threads) {
    const tracer t = {tree, threads, NULL, NULL, 0};
    return t;
}

static htree_query make_query(const tracer *t, htree_counters *counters) {
    htree_query query;
    htree_query_init(&query, sizeof query);
    query.threads = t->threads;
    query.counters = counters;
    return query;
}

htree_status tracer_count(tracer *t, const htree_ray *rays, uint64_t count, htree_hit *hits,
                          htree_counters *counters) {
    const htree_query query = make_query(t, counters);
    return htree_intersect(t->tree, rays, count, hits, &query);
}

static htree_status cpu_occluded(tracer *t, const htree_ray *rays, uint64_t count,
                                 uint8_t *occluded) {
    const htree_query query = make_query(t, NULL);
    return htree_occluded(t->tree, rays, count, occluded, &query);
}

#ifdef HAVE_OPENCL

#include "htree_cl.h"

htree_status tracer_upload(tracer *out, struct htree_cl *device, const htree *tree,
                           uint32_t threads) {
    *out = tracer_cpu(tree, threads);
    out->device = device;
    return htree_cl_upload(&out->copy, device, tree);
}

void tracer_end(tracer *t) {
    htree_cl_free(t->copy);
    t->copy = NULL;
}

static htree_cl_query make_device_query(tracer *t) {
    htree_cl_query query;
    htree_cl_query_init(&query, sizeof query);
    query.kernel_seconds = &t->kernel_seconds;
    return query;
}

htree_status tracer_intersect(tracer *t, const htree_ray *rays, uint64_t count, htree_hit *hits) {
    if (!t->device) return tracer_count(t, rays, count, hits, NULL);
    const htree_cl_query query = make_device_query(t);
    return htree_cl_intersect(t->copy, rays, count, hits, &query);
}

htree_status tracer_occluded(tracer *t, const htree_ray *rays, uint64_t count, uint8_t *occluded) {
    if (!t->device) return cpu_occluded(t, rays, count, occluded);
    const htree_cl_query query = make_device_query(t);
    return htree_cl_occluded(t->copy, rays, count, occluded, &query);
}

const char *tracer_error_text(const tracer *t) {
    return t->device ? htree_cl_error_text() : htree_error_text();
}

#else

htree_status tracer_upload(tracer *out, struct htree_cl *device, const htree *tree,
                           uint32_t threads) {
    (void)device;
    *out = tracer_cpu(tree, threads);
    return HTREE_ERROR_NO_DEVICE;
}

void tracer_end(tracer *t) {
    (void)t;
}

htree_status tracer_intersect(tracer *t, const htree_ray *rays, uint64_t count, htree_hit *hits) {
    return tracer_count(t, rays, count, hits, NULL);
}

htree_status tracer_occluded(tracer *t, const htree_ray *rays, uint64_t count, uint8_t *occluded) {
    return cpu_occluded(t, rays, count, occluded);
}

const char *tracer_error_text(const tracer *t) {
    (void)t;
    return htree_error_text();
}

#endif
