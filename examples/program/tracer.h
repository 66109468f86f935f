/* tracer.h: who answers the rays: the tree on the CPU, or its copy on an OpenCL device. Both give
 * the same hits, so a program asks either and does not care which. */
#ifndef EXAMPLES_TRACER_H
#define EXAMPLES_TRACER_H

#include "htree.h"

struct htree_cl;
struct htree_cl_tree;

typedef struct tracer {
    const htree *tree;
    uint32_t threads;           /* of the CPU, 0 for all cores */
    struct htree_cl *device;    /* NULL: the CPU answers */
    struct htree_cl_tree *copy; /* on the device */
    double kernel_seconds;      /* of the last call, on the device alone */
} tracer;

/* The CPU: nothing to end. */
tracer tracer_cpu(const htree *tree, uint32_t threads);

/* The tree's copy on an open device; the tree must stay, for counters. The caller ends it with
 * tracer_end. */
htree_status tracer_upload(tracer *out, struct htree_cl *device, const htree *tree,
                           uint32_t threads);
void tracer_end(tracer *t);

/* htree_intersect and htree_occluded, by whoever answers. */
htree_status tracer_intersect(tracer *t, const htree_ray *rays, uint64_t count, htree_hit *hits);
htree_status tracer_occluded(tracer *t, const htree_ray *rays, uint64_t count, uint8_t *occluded);

/* htree_intersect with counters: always by the CPU, as devices do not count. */
htree_status tracer_count(tracer *t, const htree_ray *rays, uint64_t count, htree_hit *hits,
                          htree_counters *counters);

/* What was wrong with the last call that failed on this thread; "" if nothing is known. */
const char *tracer_error_text(const tracer *t);

#endif
