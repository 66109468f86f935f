/* primary.h: the primary rays, one through the centre of every pixel: traced, timed and counted. */
#ifndef EXAMPLES_PRIMARY_H
#define EXAMPLES_PRIMARY_H

#include "camera.h"
#include "tracer.h"

typedef struct primary {
    uint64_t count; /* width * height, row by row from the top left */
    htree_ray *rays;
    htree_hit *hits;
    htree_counters *counters;
    double seconds;      /* T_R: the median of three batches without counters */
    double hit_fraction; /* these four: means over all rays */
    double intersections, traversal_steps, leaf_steps;
} primary;

/* Traces the rays of `view`. On failure *out is empty and tracer_error_text() or, for
 * HTREE_ERROR_MEMORY, the status says why. The caller frees with primary_free. */
htree_status primary_trace(primary *out, tracer *by, const camera *view, uint32_t width,
                           uint32_t height);

void primary_free(primary *p);

/* Seconds on a clock that never steps back. */
double clock_seconds(void);

#endif
