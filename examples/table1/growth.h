/* growth.h: two studies that the paper's table does not hold: construction time against the
 * number of triangles, and what coarser or finer splitting is worth. Both write files that
 * gnuplot reads: blocks with a name on a line of their own, two empty lines between them. */
#ifndef EXAMPLES_GROWTH_H
#define EXAMPLES_GROWTH_H

#include "bench_scene.h"
#include "measure.h"

#include <stdio.h>

typedef struct growth_job {
    const char *scene; /* of shapes.h */
    uint64_t from, to; /* triangles; two sizes per factor of ten */
    const htree_kind *kinds;
    uint32_t kind_count, threads, repeat;
    uint32_t patience; /* a kind stops growing after a build that took more seconds */
    bool quiet;
} growth_job;

/* A block "SCENE-KIND" for each kind. */
htree_status growth_print(FILE *out, const growth_job *job);

/* Two blocks over job->mesh: "NAME-h-buckets" for the H-tree with 2 to 64 buckets, and
 * "NAME-ah-cells" for the AH-tree with 1/16 to 16 cells per triangle. */
htree_status precision_print(FILE *out, const measure_job *job, const char *name);

#endif
