/* peer_none.c: a build without Embree. peer_open fails, so nothing else is called. */
#include "peer.h"

#include <stdio.h>

peer *peer_open(const peer_config *config, const shape *mesh, uint32_t threads, char *error,
                size_t size) {
    (void)config, (void)mesh, (void)threads;
    snprintf(error, size,
             "this build has no Embree: install version 3 (apt-get install libembree-dev) and "
             "build again");
    return NULL;
}

void peer_close(peer *p) {
    (void)p;
}

void peer_describe(const peer *p, char *out, size_t size) {
    (void)p;
    snprintf(out, size, "none");
}

bool peer_build(peer *p, const float *positions, bool again, double *seconds, char *error,
                size_t size) {
    (void)p, (void)positions, (void)again, (void)seconds;
    snprintf(error, size, "this build has no Embree");
    return false;
}

bool peer_commit(peer *p, const float *positions, double *seconds, char *error, size_t size) {
    return peer_build(p, positions, true, seconds, error, size);
}

void peer_drop(peer *p) {
    (void)p;
}

void peer_memory(const peer *p, uint64_t *bytes, uint64_t *peak) {
    (void)p;
    *bytes = *peak = 0;
}

void peer_intersect(const peer *p, const htree_ray *rays, uint64_t count, htree_hit *hits) {
    (void)p, (void)rays, (void)count, (void)hits;
}

void peer_occluded(const peer *p, const htree_ray *rays, uint64_t count, uint8_t *occluded) {
    (void)p, (void)rays, (void)count, (void)occluded;
}

peer_packets *peer_pack(const htree_ray *rays, uint64_t count, uint32_t row) {
    (void)rays, (void)count, (void)row;
    return NULL;
}

void peer_packets_free(peer_packets *packets) {
    (void)packets;
}

void peer_intersect_packets(const peer *p, peer_packets *packets) {
    (void)p, (void)packets;
}

void peer_unpack(const peer_packets *packets, htree_hit *hits) {
    (void)packets, (void)hits;
}
