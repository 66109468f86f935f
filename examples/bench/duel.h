/* duel.h: every contender over every set of rays of one scene, side by side. */
#ifndef EXAMPLES_DUEL_H
#define EXAMPLES_DUEL_H

#include "contender.h"

enum { DUEL_MAX_KINDS = 16, DUEL_MAX_PEERS = 4, DUEL_MAX = 2 * DUEL_MAX_KINDS + DUEL_MAX_PEERS };

typedef struct duel_job {
    const shape *mesh;
    const camera *view;
    ray_wish wish;
    const htree_kind *kinds; /* on the CPU and, with a device, on it */
    uint32_t kind_count;
    struct htree_cl *device;  /* NULL: none */
    const char *const *peers; /* names; the first is what ratios are against */
    uint32_t peer_count;
    uint32_t threads, rounds;
    double seconds;    /* that a contender traces in a round, at least */
    const char *label; /* of the progress bar */
    bool quiet;
} duel_job;

typedef struct duel {
    contender all[DUEL_MAX];
    uint32_t count;
    ray_set sets[RAY_SETS];
    char peer_text[DUEL_MAX_PEERS][256];
} duel;

/* Builds and traces in rounds, each contender once a round, so that a disturbance of the machine
 * meets them all; the hits of every round are compared with the first contender's. The caller ends
 * *out with duel_end in any case. False writes one line to `error`. */
bool duel_run(duel *out, const duel_job *job, char *error, size_t size);
void duel_end(duel *d);

/* Whether the answers of all trees were equal, and those of every peer in all but a thousandth of
 * the rays. False writes one line to `error`. */
bool duel_agrees(const duel *d, char *error, size_t size);

#endif
