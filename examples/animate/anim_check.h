/* anim_check.h: hits of a tree against a test of every triangle, in double. */
#ifndef EXAMPLES_ANIM_CHECK_H
#define EXAMPLES_ANIM_CHECK_H

#include "film.h"

typedef struct anim_verdict {
    uint64_t rays, hits, edges, wrong; /* edges: too near to an edge to say; not wrong */
} anim_verdict;

/* Adds what it finds about every `step`-th ray. */
void anim_check(anim_verdict *sum, const film *f, const film_frame *frame, const htree_ray *rays,
                const htree_hit *hits, uint64_t count, uint64_t step);

#endif
