/* peer.c: Embree 3, in the same loop as the library's: ray by ray, or where rays are known to agree
 * by packets of 16. Its scene flag "robust" is what comes closest to this library's watertight
 * test; without it, it is faster. */
#include "peer.h"

#include <stdio.h>

static const char *const names[] = {"embree", "embree-robust", "embree-packet", NULL};

const char *const *peer_names(void) {
    return names;
}

#ifdef HAVE_EMBREE

#include "loop.h"
#include "primary.h"

#include <stdlib.h>
#include <string.h>

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

#ifdef __SSE__
#include <xmmintrin.h>
#endif

struct peer {
    RTCDevice device;
    RTCGeometry geometry;
    RTCScene scene;
    uint32_t threads;
    bool robust, packets;
};

static bool fail(RTCDevice device, const char *what, char *error, size_t size) {
    snprintf(error, size, "Embree: %s failed, error %d", what, (int)rtcGetDeviceError(device));
    return false;
}

/* Buffers of its own, as it reads a little beyond the last vertex. It knows no empty ones: no
 * triangles are no geometry. */
static bool copy_mesh(peer *p, const shape *mesh) {
    if (!mesh->triangle_count) return true;
    p->geometry = rtcNewGeometry(p->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!p->geometry) return false;
    void *positions = rtcSetNewGeometryBuffer(p->geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                              RTC_FORMAT_FLOAT3, 12, mesh->vertex_count);
    void *indices = rtcSetNewGeometryBuffer(p->geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            12, mesh->triangle_count);
    if (!positions || !indices) return false;
    memcpy(positions, mesh->positions, 12 * mesh->vertex_count);
    memcpy(indices, mesh->indices, 12 * mesh->triangle_count);
    rtcSetGeometryBuildQuality(p->geometry, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitGeometry(p->geometry);
    return true;
}

peer *peer_open(const char *name, const shape *mesh, uint32_t threads, char *error, size_t size) {
    char config[64];
    peer *p = (peer *)calloc(1, sizeof *p);
    snprintf(config, sizeof config, "threads=%u,set_affinity=0", threads);
    if (p) p->device = rtcNewDevice(config);
    if (!p || !p->device || !copy_mesh(p, mesh)) {
        fail(p ? p->device : NULL, "taking the mesh", error, size);
        peer_close(p);
        return NULL;
    }
    p->threads = threads;
    p->robust = strcmp(name, names[1]) == 0;
    p->packets = strcmp(name, names[2]) == 0;
    return p;
}

void peer_close(peer *p) {
    if (!p) return;
    if (p->scene) rtcReleaseScene(p->scene);
    if (p->geometry) rtcReleaseGeometry(p->geometry);
    if (p->device) rtcReleaseDevice(p->device);
    free(p);
}

void peer_describe(const peer *p, char *out, size_t size) {
    const int version = (int)rtcGetDeviceProperty(p->device, RTC_DEVICE_PROPERTY_VERSION);
    snprintf(out, size,
             "Embree %d.%d.%d, RTC_BUILD_QUALITY_MEDIUM, %s, %srtcIntersect1 and rtcOccluded1 "
             "in blocks of 512 rays, builds and traces by %u thread%s",
             version / 10000, version / 100 % 100, version % 100,
             p->robust ? "RTC_SCENE_FLAG_ROBUST" : "RTC_SCENE_FLAG_NONE",
             p->packets ? "rtcIntersect16 over 4x4 primary rays, " : "", p->threads,
             p->threads == 1 ? "" : "s");
}

bool peer_build(peer *p, double *seconds, char *error, size_t size) {
    if (p->scene) rtcReleaseScene(p->scene);
    const double start = clock_seconds();
    p->scene = rtcNewScene(p->device);
    if (!p->scene) return fail(p->device, "rtcNewScene", error, size);
    rtcSetSceneFlags(p->scene, p->robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(p->scene, RTC_BUILD_QUALITY_MEDIUM);
    if (p->geometry) rtcAttachGeometry(p->scene, p->geometry);
    rtcCommitScene(p->scene);
    *seconds = clock_seconds() - start;
    return rtcGetDeviceError(p->device) == RTC_ERROR_NONE ||
           fail(p->device, "rtcCommitScene", error, size);
}

/* ---- Rays ----------------------------------------------------------------------------------- */

typedef struct batch {
    const peer *by;
    const htree_ray *rays;
    uint64_t count;
    uint32_t row; /* 0: no packets */
    htree_hit *hits;
    uint8_t *occluded;
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

/* ---- Packets -------------------------------------------------------------------------------- */

enum { SIDE = 4, PACKET = SIDE * SIDE };

/* The rays of a packet: their indices, as many as there are. */
typedef struct packet {
    uint64_t index[PACKET];
    uint32_t count;
} packet;

static uint64_t packets_across(uint64_t row) {
    return (row + SIDE - 1) / SIDE;
}

/* Packet `number` of a picture, the last row of which may be short. */
static packet find_packet(uint64_t number, uint64_t row, uint64_t count) {
    const uint64_t left = number % packets_across(row) * SIDE;
    const uint64_t top = number / packets_across(row) * SIDE;
    packet p = {{0}, 0};
    for (uint64_t y = top; y < top + SIDE; ++y)
        for (uint64_t x = left; x < left + SIDE && x < row; ++x)
            if (y * row + x < count) p.index[p.count++] = y * row + x;
    return p;
}

static void intersect_packet(const batch *b, const packet *p, struct RTCIntersectContext *context) {
    struct RTCRayHit16 both;
    int valid[PACKET] __attribute__((aligned(64)));
    for (uint32_t i = 0; i < PACKET; ++i) {
        const struct RTCRay ray = make_ray(&b->rays[p->index[i]]);
        valid[i] = i < p->count ? -1 : 0;
        both.ray.org_x[i] = ray.org_x, both.ray.org_y[i] = ray.org_y;
        both.ray.org_z[i] = ray.org_z, both.ray.tnear[i] = ray.tnear;
        both.ray.dir_x[i] = ray.dir_x, both.ray.dir_y[i] = ray.dir_y;
        both.ray.dir_z[i] = ray.dir_z, both.ray.tfar[i] = ray.tfar;
        both.ray.time[i] = 0, both.ray.mask[i] = ray.mask;
        both.ray.id[i] = both.ray.flags[i] = 0;
        both.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, b->by->scene, context, &both);
    for (uint32_t i = 0; i < p->count; ++i) {
        const bool miss = both.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID;
        const htree_hit hit = {both.ray.tfar[i], miss ? 0 : both.hit.u[i], miss ? 0 : both.hit.v[i],
                               miss ? HTREE_NONE : both.hit.primID[i]};
        b->hits[p->index[i]] = hit;
    }
}

static void intersect_packets(const batch *b, uint64_t first, uint64_t end) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (uint64_t i = first; i < end; ++i) {
        const packet p = find_packet(i, b->row, b->count);
        intersect_packet(b, &p, &context);
    }
}

/* ---- Blocks --------------------------------------------------------------------------------- */

/* Its manual wants denormals flushed while it works. */
static void trace_block(void *data, uint64_t first, uint64_t end) {
    const batch *b = (const batch *)data;
#ifdef __SSE__
    const unsigned kept = _mm_getcsr();
    _mm_setcsr(kept | 0x8040);
#endif
    if (b->row)
        intersect_packets(b, first / PACKET, end / PACKET);
    else if (b->hits)
        intersect_block(b, first, end);
    else
        occlude_block(b, first, end);
#ifdef __SSE__
    _mm_setcsr(kept);
#endif
}

void peer_intersect(const peer *p, const htree_ray *rays, uint64_t count, uint32_t row,
                    htree_hit *hits) {
    batch b = {p, rays, count, p->packets ? row : 0, hits, NULL};
    if (b.row) {
        const uint64_t rows = (count + b.row - 1) / b.row;
        count = packets_across(b.row) * ((rows + SIDE - 1) / SIDE) * PACKET;
    }
    loop_run(p->threads, count, trace_block, &b);
}

void peer_occluded(const peer *p, const htree_ray *rays, uint64_t count, uint8_t *occluded) {
    batch b = {p, rays, count, 0, NULL, occluded};
    loop_run(p->threads, count, trace_block, &b);
}

#else

peer *peer_open(const char *name, const shape *mesh, uint32_t threads, char *error, size_t size) {
    (void)name;
    (void)mesh;
    (void)threads;
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

bool peer_build(peer *p, double *seconds, char *error, size_t size) {
    (void)p;
    *seconds = 0;
    snprintf(error, size, "this build has no Embree");
    return false;
}

void peer_intersect(const peer *p, const htree_ray *rays, uint64_t count, uint32_t row,
                    htree_hit *hits) {
    (void)p, (void)rays, (void)count, (void)row, (void)hits;
}

void peer_occluded(const peer *p, const htree_ray *rays, uint64_t count, uint8_t *occluded) {
    (void)p, (void)rays, (void)count, (void)occluded;
}

#endif
