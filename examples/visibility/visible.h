/* visible.h: which triangles can be seen from a view cell, by sampled lines. */
#ifndef EXAMPLES_VISIBLE_H
#define EXAMPLES_VISIBLE_H

#include "camera.h"
#include "progress.h"

#include <stdio.h>

/* How a triangle was found to be visible. */
enum { VISIBLE_BY_LINE = 1, VISIBLE_BY_SEGMENT = 2 };

typedef struct visible_job {
    const htree *tree;
    const shape *mesh;
    htree_box cell;
    uint64_t lines;    /* random lines from the cell */
    uint32_t segments; /* segments to each triangle that no line has found */
    uint32_t threads, seed;
    bool quiet;
    FILE *report; /* a line each time the number of lines has doubled; NULL: none */
} visible_job;

typedef struct visible_result {
    uint8_t *marks;                       /* per triangle, VISIBLE_BY_... */
    uint64_t by_line, by_segment;         /* triangles */
    uint64_t segment_count;               /* that were tested */
    double line_seconds, segment_seconds; /* in the library */
} visible_result;

/* Places the cell where the most of the scene can be seen, of some random places in and around it.
 * `view`, if the camera is inside, is where the cell goes. */
htree_box visible_place_cell(const htree *tree, const shape *mesh, const camera *view, bool inside,
                             uint32_t seed);

/* Samples. The same job gives the same marks for every structure and number of threads. The caller
 * frees with visible_free; on failure *out is empty, and HTREE_ERROR_MEMORY may be our own. */
htree_status visible_sample(visible_result *out, const visible_job *job);
void visible_free(visible_result *result);

#endif
