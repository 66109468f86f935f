/* measure.h: several ways to build a hierarchy over one mesh, measured side by side. */
#ifndef EXAMPLES_MEASURE_H
#define EXAMPLES_MEASURE_H

#include "camera.h"
#include "progress.h"

enum { MEASURE_MAX_REPEAT = 99 };

/* A structure, and what differs from its defaults. */
typedef struct measure_way {
    htree_kind kind;
    uint32_t buckets;     /* 0: the default */
    float cells_per_prim; /* 0: the default */
} measure_way;

typedef struct measure_job {
    const shape *mesh;
    camera view;
    uint32_t width, height; /* 0: builds alone are measured */
    uint32_t threads, repeat;
    bool keep_memory;  /* every build but the first reuses the memory of the one before (pool.h) */
    const char *label; /* of the progress bar */
    bool quiet;
} measure_job;

/* One row of the paper's Table 1. Times are medians in seconds; speed-ups are against the kd-tree
 * of the same job, and NaN without one. */
typedef struct measure_row {
    measure_way way;
    htree_stats stats;
    double build, trace;                               /* T_C, T_R */
    double hit_fraction;                               /* of the rays */
    double intersections, traversal_steps, leaf_steps; /* means over the rays */
    double build_speedup, trace_speedup, total_speedup;
    uint64_t answer; /* a hash of all hits: equal for all ways, or something is wrong */
} measure_row;

/* Measures every way job->repeat times, in rounds, so that a disturbance of the machine meets them
 * all; the trees live one at a time. On failure htree_error_text() says why, unless it is
 * HTREE_ERROR_MEMORY, which may be the program's own. */
htree_status measure_run(const measure_job *job, const measure_way *ways, uint32_t count,
                         measure_row *rows);

#endif
