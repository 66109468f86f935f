/* contender.h: who is measured: a tree on the CPU, its copy on a device, or another ray tracer. */
#ifndef EXAMPLES_CONTENDER_H
#define EXAMPLES_CONTENDER_H

#include "peer.h"
#include "ray_sets.h"
#include "tracer.h"

enum { BENCH_MAX_ROUNDS = 99 };

typedef enum contender_place { PLACE_CPU, PLACE_DEVICE, PLACE_PEER } contender_place;

/* Medians over the rounds, for one set of rays. */
typedef struct contender_row {
    double seconds;        /* for the whole set */
    double spread;         /* greatest less least, as a part of the median */
    double kernel_seconds; /* of these on the device alone; 0 elsewhere */
    double first_seconds;  /* the very first call, before the rounds */
    uint64_t hits;         /* rays that hit */
    uint64_t differ;       /* rays whose answer is not the first contender's */
    double versus_cpu;     /* speed against the CPU of the same kind; NaN elsewhere */
    double versus_peer;    /* speed against the first peer; NaN without one */
} contender_row;

typedef struct contender {
    contender_place place;
    htree_kind kind; /* not of peers */
    char name[48];   /* "wide", "wide @device", "embree" */
    htree *tree;     /* PLACE_CPU owns it, PLACE_DEVICE borrows it */
    tracer by;
    peer *other;
    double build_seconds;                   /* T_C, the median over the rounds; NaN on a device */
    double upload_seconds, compile_seconds; /* of a device: the second is part of the first */
    uint64_t bytes;                         /* of a tree; 0 where it is not known */
    contender_row rows[RAY_SETS];
} contender;

/* The answers of a set: hits, or a byte a ray for the ambient rays. */
htree_status contender_trace(contender *c, const ray_set *set, ray_set_name name, void *answers);

/* How many rays of the set have another answer. Trees must agree in every byte, or, on a device that
 * does not give the CPU's bits, in t within HTREE_CL_T_ERROR; peers must agree on hit or miss. */
uint64_t contender_differ(const contender *c, uint64_t count, ray_set_name name,
                          const void *answers, const void *expected);

#endif
