/* duel_run.h: what the parts of a duel share while it runs. */
#ifndef EXAMPLES_DUEL_RUN_H
#define EXAMPLES_DUEL_RUN_H

#include "duel.h"
#include "progress.h"

typedef struct duel_runner {
    const duel_job *job;
    duel *d;
    void *answers, *expected; /* of a set; expected: of the first contender that answers it */
    double seconds[DUEL_MAX][BENCH_MAX_ROUNDS], more[DUEL_MAX][BENCH_MAX_ROUNDS];
    double largest; /* coordinate of the scene */
    progress bar;
    uint32_t done, steps; /* of the bar */
    bench_error error;
} duel_runner;

/* Moves the bar; there are duel_steps of them. */
void duel_step(duel_runner *r);

/* One call. */
bool duel_trace(const duel_runner *r, contender *c, ray_set_name name, double *seconds);

/* Every way of building, over the sets that there are; the trees of the last stay, on devices too. */
bool duel_build_all(duel_runner *r);

/* The rounds over one set. */
bool duel_trace_set(duel_runner *r, ray_set_name name);

#endif
