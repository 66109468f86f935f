/* peer_trace.c: Embree 3, in the same loop as the library's: ray by ray, or by packets of 16. */
#include "embree.h"
#include "loop.h"

#include <string.h>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

/* ---- Rays ----------------------------------------------------------------------------------- */

typedef struct batch {
    const peer *by;
    const htree_ray *rays;
    htree_hit *hits; /* one of these three is asked for */
    uint8_t *occluded;
    peer_packets *packets;
} batch;

static struct RTCRay make_ray(const htree_ray *ray) {
    const struct RTCRay out = {ray->org[0], ray->org[1], ray->org[2], ray->tmin,
                               ray->dir[0], ray->dir[1], ray->dir[2], 0,
                               ray->tmax,   UINT32_MAX,  0,           0};
    return out;
}

static void intersect_block(const batch *b, uint64_t first, uint64_t end) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint64_t i = first; i < end; ++i) {
        struct RTCRayHit both;
        both.ray = make_ray(&b->rays[i]);
        both.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(b->by->scene, &context, &both);
        const bool miss = both.hit.geomID == RTC_INVALID_GEOMETRY_ID;
        const htree_hit hit = {both.ray.tfar, miss ? 0 : both.hit.u, miss ? 0 : both.hit.v,
                               miss ? HTREE_NONE : both.hit.primID};
        b->hits[i] = hit;
    }
}

static void occlude_block(const batch *b, uint64_t first, uint64_t end) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint64_t i = first; i < end; ++i) {
        struct RTCRay ray = make_ray(&b->rays[i]);
        rtcOccluded1(b->by->scene, &context, &ray);
        b->occluded[i] = ray.tfar < 0;
    }
}

static void intersect_packets(const batch *b, uint64_t first, uint64_t end) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (uint64_t i = first; i < end; ++i) {
        const peer_packet *in = &b->packets->in[i];
        peer_answer *out = &b->packets->out[i];
        struct RTCRayHit16 both;
        both.ray = in->ray;
        memset(both.hit.geomID, 0xff, sizeof both.hit.geomID); /* RTC_INVALID_GEOMETRY_ID */
        rtcIntersect16(in->valid, b->by->scene, &context, &both);
        memcpy(out->t, both.ray.tfar, sizeof out->t);
        memcpy(out->u, both.hit.u, sizeof out->u);
        memcpy(out->v, both.hit.v, sizeof out->v);
        memcpy(out->prim, both.hit.primID, sizeof out->prim);
        memcpy(out->geometry, both.hit.geomID, sizeof out->geometry);
    }
}

/* Its manual wants denormals flushed while it works. */
static void trace_block(void *data, uint64_t first, uint64_t end) {
    const batch *b = (const batch *)data;
#ifdef __SSE__
    const unsigned kept = _mm_getcsr();
    _mm_setcsr(kept | 0x8040);
#endif
    if (b->packets)
        intersect_packets(b, first / PEER_PACKET, end / PEER_PACKET);
    else if (b->hits)
        intersect_block(b, first, end);
    else
        occlude_block(b, first, end);
#ifdef __SSE__
    _mm_setcsr(kept);
#endif
}

void peer_intersect(const peer *p, const htree_ray *rays, uint64_t count, htree_hit *hits) {
    batch b = {p, rays, hits, NULL, NULL};
    loop_run(p->threads, count, trace_block, &b);
}

void peer_occluded(const peer *p, const htree_ray *rays, uint64_t count, uint8_t *occluded) {
    batch b = {p, rays, NULL, occluded, NULL};
    loop_run(p->threads, count, trace_block, &b);
}

void peer_intersect_packets(const peer *p, peer_packets *packets) {
    batch b = {p, NULL, NULL, NULL, packets};
    loop_run(p->threads, packets->count * PEER_PACKET, trace_block, &b);
}
