/* duel.h: every contender over one scene, side by side: how it builds, and every set of rays. */
#ifndef EXAMPLES_DUEL_H
#define EXAMPLES_DUEL_H

#include "contender.h"

enum {
    DUEL_MAX_TREES = 16,
    DUEL_MAX_PEERS = 16,
    DUEL_MAX = 2 * DUEL_MAX_TREES + 2 * DUEL_MAX_PEERS
};

typedef struct duel_job {
    const shape *mesh;
    const camera_wish *view;
    ray_wish wish;
    const char *load_rays, *save_rays; /* files; NULL: none */
    const tree_config *trees;          /* on the CPU and, with a device, on it */
    uint32_t tree_count;
    struct htree_cl *device;  /* NULL: none */
    const peer_config *peers; /* the first is what ratios are against */
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
    peer_packets *packed[RAY_SETS]; /* of sets whose neighbours agree, where there is a peer */
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
