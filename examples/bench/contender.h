/* contender.h: who is measured: a tree on the CPU, its copy on a device, or another ray tracer, ray by
 * ray or by packets. */
#ifndef EXAMPLES_CONTENDER_H
#define EXAMPLES_CONTENDER_H

#include "peer.h"
#include "ray_sets.h"
#include "tracer.h"

enum { BENCH_MAX_ROUNDS = 99 };

/* PLACE_DEVICE and PLACE_PACKET use what the contender before them has built. */
typedef enum contender_place { PLACE_CPU, PLACE_DEVICE, PLACE_PEER, PLACE_PACKET } contender_place;

/* How a structure comes about. */
typedef enum build_way {
    BUILD_REFIT, /* the same nodes around other positions */
    BUILD_WARM,  /* anew for other positions, in the memory of the builds before */
    BUILD_FRESH, /* a new handle, a new scene */
    BUILD_WAYS
} build_way;

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
    char name[48];       /* "wide", "wide @device", "embree-low", "embree-low x16" */
    tree_config config;  /* of trees */
    peer_config by_peer; /* of peers */
    htree *tree;         /* PLACE_CPU owns it, PLACE_DEVICE borrows it */
    tracer by;
    peer *other;                      /* PLACE_PEER owns it, PLACE_PACKET borrows it */
    double build_seconds[BUILD_WAYS]; /* medians over the rounds; NaN where there is no such way */
    double frame_seconds[BUILD_WAYS]; /* T_T: these and the frame's rays, round by round */
    uint64_t update_differ[BUILD_WAYS]; /* rays of the frame with another answer after the last */
    double upload_seconds, compile_seconds; /* of a device: the second is part of the first */
    uint64_t bytes, peak;                   /* of a tree or scene at rest, and while it was built */
    contender_row rows[RAY_SETS];
} contender;

/* Where a failing call leaves its line. */
typedef struct bench_error {
    char *text;
    size_t size;
} bench_error;

/* Whether the contender builds by itself, and can be brought about in this way. */
bool contender_builds(const contender *c);
bool contender_can(const contender *c, build_way way);

/* Whether it answers this set at all: packets are for pictures. */
bool contender_takes(const contender *c, const ray_set *set);

/* A new structure in place of the one before; `again`: to be updated. Both write how long they took. */
bool contender_build(contender *c, const shape *mesh, uint32_t threads, bool again, double *seconds,
                     bench_error error);
bool contender_update(contender *c, build_way way, const shape *mesh, double *seconds,
                      bench_error error);

/* Reads what the structure holds, and ends it. */
bool contender_weigh(contender *c, bench_error error);
void contender_drop(contender *c);

/* The answers of a set: hits, or a byte a ray where any hit will do. `packed` is the same set for
 * packets, or NULL. Writes how long the tracing took. */
bool contender_trace(contender *c, const ray_set *set, peer_packets *packed, ray_set_name name,
                     void *answers, double *seconds, bench_error error);

/* How many rays of the set have another answer. Trees must agree in every byte, or, on a device that
 * does not give the CPU's bits, in t within HTREE_CL_T_ERROR; peers must agree on hit or miss, and in
 * t within rounding for coordinates as large as `largest`. */
uint64_t contender_differ(const contender *c, const ray_set *set, ray_set_name name, double largest,
                          const void *answers, const void *expected);

#endif
