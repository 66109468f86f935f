/* peer.h: another ray tracer to measure against, through its own interface. A build without it has
 * the same calls, which say what to install. */
#ifndef EXAMPLES_PEER_H
#define EXAMPLES_PEER_H

#include "config.h"
#include "shapes.h"

#include <stddef.h>

typedef struct peer peer;
typedef struct peer_packets peer_packets;

/* Takes a copy of the mesh. The caller closes it. NULL writes one line to `error`. */
peer *peer_open(const peer_config *config, const shape *mesh, uint32_t threads, char *error,
                size_t size);
void peer_close(peer *p);

/* One line: version, how it builds, how it is asked. */
void peer_describe(const peer *p, char *out, size_t size);

/* Builds a new scene, by the threads it was opened with, in place of the one before, and writes how
 * long that took; the positions are in its buffer before the clock starts. `again`: one to be
 * committed again. */
bool peer_build(peer *p, const float *positions, bool again, double *seconds, char *error,
                size_t size);

/* Commits the same scene again, with other positions. */
bool peer_commit(peer *p, const float *positions, double *seconds, char *error, size_t size);

/* Ends the scene. */
void peer_drop(peer *p);

/* What the last peer_build holds, and held at most, beside the mesh, as its memory monitor says. */
void peer_memory(const peer *p, uint64_t *bytes, uint64_t *peak);

/* As htree_intersect and htree_occluded, ray by ray. */
void peer_intersect(const peer *p, const htree_ray *rays, uint64_t count, htree_hit *hits);
void peer_occluded(const peer *p, const htree_ray *rays, uint64_t count, uint8_t *occluded);

/* Rays of a picture with `row` of them in a row, by packets of 16 over tiles of 4x4, in the peer's own
 * layout: what it costs to get them there, and to read its answers, is nobody's time. NULL: no
 * memory. */
peer_packets *peer_pack(const htree_ray *rays, uint64_t count, uint32_t row);
void peer_packets_free(peer_packets *packets);

/* Traces all, and turns the answers into hits of the rays as they were given. */
void peer_intersect_packets(const peer *p, peer_packets *packets);
void peer_unpack(const peer_packets *packets, htree_hit *hits);

#endif
