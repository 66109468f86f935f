/* peer.h: another ray tracer to measure against, through its own interface. A build without it has
 * the same calls, which say what to install. */
#ifndef EXAMPLES_PEER_H
#define EXAMPLES_PEER_H

#include "htree.h"
#include "shapes.h"

#include <stddef.h>

typedef struct peer peer;

/* The names, ending in NULL. */
const char *const *peer_names(void);

/* Takes a copy of the mesh. The caller closes it. NULL writes one line to `error`. */
peer *peer_open(const char *name, const shape *mesh, uint32_t threads, char *error, size_t size);
void peer_close(peer *p);

/* One line: version, how it builds, how it is asked. */
void peer_describe(const peer *p, char *out, size_t size);

/* Builds anew, by the threads it was opened with, and writes how long that took. */
bool peer_build(peer *p, double *seconds, char *error, size_t size);

/* As htree_intersect and htree_occluded. `row` is how many rays are in a row of a picture, for peers
 * that must be told which rays go together; 0: they do not. */
void peer_intersect(const peer *p, const htree_ray *rays, uint64_t count, uint32_t row,
                    htree_hit *hits);
void peer_occluded(const peer *p, const htree_ray *rays, uint64_t count, uint8_t *occluded);

#endif
