/* anim_report.h: what a film cost, frame by frame and on average, in the paper's names. */
#ifndef EXAMPLES_ANIM_REPORT_H
#define EXAMPLES_ANIM_REPORT_H

#include "anim_args.h"
#include "anim_check.h"

typedef struct anim_figures {
    double time;                                       /* of the frame in the film */
    double pose;                                       /* seconds to move the vertices */
    double build, trace;                               /* T_C, T_R */
    double nodes, leaves, references;                  /* N_NS, N_E, N_ER */
    double intersections, traversal_steps, leaf_steps; /* N_IT, N_TS, N_ETS: means over rays */
    double hit_fraction;
} anim_figures;

typedef struct anim_report {
    const anim_args *args;
    const film *f;
    const anim_figures *frames;
    uint32_t count;
    double sequential, pipeline; /* frames per second; pipeline 0: not measured */
    anim_verdict verdict;
} anim_report;

anim_figures anim_mean(const anim_figures *frames, uint32_t count);

void anim_report_print(const anim_report *r);

/* False writes one line to `error`. */
bool anim_report_write(const anim_report *r, const char *path, char *error, size_t size);

#endif
