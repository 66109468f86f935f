/* bench.h: the public calls of libhtree_cl as operations: a sound state to start from, the call,
 * and what must be true afterwards. */
#ifndef BENCH_H
#define BENCH_H

#include "rig.h"

/* What a call works on; the hosts' arrays are the rig's. */
typedef struct bench {
    mock_world world;
    htree_cl *device;
    htree_cl_tree *tree; /* uploaded, or the result of an upload */
    cl_context context;  /* the caller's own */
    cl_device_id id;
    cl_command_queue queue;
    cl_mem rays, answers;
    cl_event wait, event;
    uint32_t count;
    htree_cl_info info;
    double seconds;
} bench;

typedef enum bench_group { BENCH_DEVICES, BENCH_UPLOADS, BENCH_QUERIES, BENCH_BUFFERS } bench_group;

typedef struct operation {
    bench_group group;
    const char *name;
    void (*prepare)(bench *b);
    htree_status (*act)(bench *b);
    bool (*done)(bench *b);         /* after success: whether the result is right; takes it back */
    bool (*undone)(const bench *b); /* after failure: whether nothing came out */
    uint32_t kind;                  /* index of a tree of the rig */
    uint64_t rays;
    bool copies; /* the device does not share the host's memory */
} operation;

enum { BENCH_MANY = 1500, BENCH_FEW = 200, BENCH_OPERATIONS = 22 };

extern const operation bench_operations[BENCH_OPERATIONS];
extern const operation *bench_op; /* the one at work */
extern rig bench_rig;

/* Ends all that the bench holds, and fails the test if something is left; then it is as new. */
void bench_close(bench *b);

/* Uploads, queries and enqueues on a lost device; true if each says so. */
bool bench_says_lost(bench *b);

#endif
