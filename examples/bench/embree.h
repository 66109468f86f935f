/* embree.h: what the files of the peer Embree 3 share. */
#ifndef EXAMPLES_EMBREE_H
#define EXAMPLES_EMBREE_H

#include "peer.h"

/* Headers of others are not held to our warnings. */
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wc++-compat"
#pragma GCC diagnostic ignored "-Wstrict-prototypes"
#endif
#include <embree3/rtcore.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

struct peer {
    RTCDevice device;
    RTCGeometry geometry;
    RTCScene scene;
    float *positions; /* a little longer than the mesh's: it reads beyond the last vertex */
    uint32_t *indices;
    uint64_t position_bytes;
    peer_config config;
    uint32_t threads;
    int64_t held, most; /* by its memory monitor; most: since the last build began */
    uint64_t bytes, peak;
};

enum { PEER_SIDE = 4, PEER_PACKET = PEER_SIDE * PEER_SIDE };

typedef struct peer_packet {
    struct RTCRay16 ray;
    int valid[PEER_PACKET]; /* -1, and 0 behind the last ray */
} peer_packet;

typedef struct peer_answer {
    float t[PEER_PACKET], u[PEER_PACKET], v[PEER_PACKET];
    unsigned prim[PEER_PACKET], geometry[PEER_PACKET];
} peer_answer;

struct peer_packets {
    peer_packet *in;
    peer_answer *out;
    uint64_t count, rays;
    uint32_t row;
};

#endif
