/* rig.h: what tests on the mock start from: a tree of every kind, rays, and the CPU's answers. */
#ifndef RIG_H
#define RIG_H

#include "cl_suite.h"
#include "ledger.h"
#include "mock_cl.h"
#include "rays.h"

enum { RIG_KINDS = 8 };

typedef struct rig {
    shape s;
    htree_mesh mesh;
    uint32_t kinds;
    htree *trees[RIG_KINDS];
    uint64_t count;
    htree_ray *rays; /* at a multiple of 16, as the answers: fit to be shared with a device */
    htree_hit *truth, *hits;
    uint8_t *any_truth, *any;
    ledger books; /* of the device's host memory */
} rig;

/* All answers are those of every kind, bit for bit, so one array of each will do. */
void rig_begin(rig *r, const char *shape_name, uint64_t triangles, uint64_t rays);
void rig_end(rig *r);

/* Options whose host memory is on the rig's books. */
htree_cl_options rig_options(rig *r);

/* Whether r->hits and r->any hold the CPU's answers to the first `count` rays. */
bool rig_hits_are_right(const rig *r, uint64_t count);
bool rig_any_is_right(const rig *r, uint64_t count);

/* Writes garbage over r->hits and r->any. */
void rig_spoil(rig *r);

/* Asks a tree of the device for both answers, and fails the test unless they are the CPU's. */
void rig_prove(rig *r, const htree_cl_tree *tree);

/* Fails the test unless the mock holds nothing any more and saw nothing wrong. */
void rig_nothing_is_left(const rig *r);

#endif
