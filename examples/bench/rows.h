/* rows.h: the figures of a contender over a scene, kept until the end, as JSON. */
#ifndef EXAMPLES_ROWS_H
#define EXAMPLES_ROWS_H

#include "duel.h"

#include <stdio.h>

/* NaN: there is no such figure. */
typedef enum figure {
    FIGURE_FRESH,   /* ns a triangle: a new handle, a new scene */
    FIGURE_WARM,    /* the same: update, re-commit */
    FIGURE_REFIT,   /* the same: new positions into the nodes there are */
    FIGURE_BYTES,   /* a triangle, of the finished structure */
    FIGURE_PEAK,    /* a triangle, while it is built */
    FIGURE_PRIMARY, /* these: Mrays/s */
    FIGURE_PACKET,
    FIGURE_FRAME,
    FIGURE_AMBIENT,
    FIGURE_DIFFUSE,
    FIGURE_SHADOW,
    FIGURE_TOTAL,        /* T_T in ms: a fresh build and the frame, packets if they are faster */
    FIGURE_TOTAL_SINGLE, /* ray by ray */
    FIGURE_TOTAL_PACKET,
    FIGURE_TOTAL_WARM, /* a warm build and the frame, packets if they are faster */
    FIGURE_UPLOAD,     /* seconds, of a device */
    FIGURE_COMPILE,
    FIGURE_DISAGREE, /* rays of all sets with another answer than the first contender's */
    FIGURES
} figure;

typedef struct bench_row {
    char scene[64], config[48];
    bool peer;
    uint32_t threads;
    uint64_t triangles;
    double figures[FIGURES];
} bench_row;

typedef struct bench_rows {
    bench_row *all; /* the owner frees it */
    uint32_t count;
} bench_rows;

/* A row per contender, packets in the row of their peer. False: no memory. */
bool rows_add(bench_rows *rows, const duel *d, const char *scene, uint64_t triangles,
              uint32_t threads);

/* Objects with commas between; numbers that are not finite become null. */
void rows_write(FILE *file, const bench_rows *rows);

/* Blank where there is no number. */
void rows_print_number(FILE *out, int width, int digits, double x);

#endif
