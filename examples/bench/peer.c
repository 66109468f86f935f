/* peer.c: Embree 3: devices, scenes, and what they hold. Its scene flag "robust" is what comes closest
 * to this library's watertight test; without it, it is faster. */
#include "embree.h"

#include "primary.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool fail(RTCDevice device, const char *what, char *error, size_t size) {
    snprintf(error, size, "Embree: %s failed, error %d", what, (int)rtcGetDeviceError(device));
    return false;
}

/* Called by any of its threads. */
static bool monitor(void *user, ssize_t bytes, bool post) {
    peer *p = (peer *)user;
    (void)post;
    const int64_t held = __atomic_add_fetch(&p->held, (int64_t)bytes, __ATOMIC_RELAXED);
    int64_t most = __atomic_load_n(&p->most, __ATOMIC_RELAXED);
    while (held > most && !__atomic_compare_exchange_n(&p->most, &most, held, true,
                                                       __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
    return true;
}

/* ---- The mesh ------------------------------------------------------------------------------- */

/* In our memory, as the mesh of our trees is the caller's. It knows no empty buffers: no triangles are
 * no geometry. */
static bool copy_mesh(peer *p, const shape *mesh) {
    static const enum RTCBuildQuality qualities[] = {
        RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_HIGH,
        RTC_BUILD_QUALITY_REFIT};
    if (!mesh->triangle_count) return true;
    const size_t indices = 12 * (size_t)mesh->triangle_count;
    p->position_bytes = 12 * mesh->vertex_count;
    p->positions = (float *)calloc(1, (size_t)p->position_bytes + 16);
    p->indices = (uint32_t *)malloc(indices);
    p->geometry = rtcNewGeometry(p->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!p->geometry || !p->positions || !p->indices) return false;
    memcpy(p->positions, mesh->positions, (size_t)p->position_bytes);
    memcpy(p->indices, mesh->indices, indices);
    rtcSetSharedGeometryBuffer(p->geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               p->positions, 0, 12, (size_t)mesh->vertex_count);
    rtcSetSharedGeometryBuffer(p->geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, p->indices,
                               0, 12, (size_t)mesh->triangle_count);
    rtcSetGeometryBuildQuality(p->geometry, qualities[p->config.quality]);
    rtcCommitGeometry(p->geometry);
    return rtcGetDeviceError(p->device) == RTC_ERROR_NONE;
}

peer *peer_open(const peer_config *config, const shape *mesh, uint32_t threads, char *error,
                size_t size) {
    char settings[64];
    peer *p = (peer *)calloc(1, sizeof *p);
    snprintf(settings, sizeof settings, "threads=%u,set_affinity=0", threads);
    if (p) {
        p->config = *config;
        p->threads = threads;
        p->device = rtcNewDevice(settings);
    }
    if (p && p->device) rtcSetDeviceMemoryMonitorFunction(p->device, monitor, p);
    if (p && p->device && copy_mesh(p, mesh)) return p;
    fail(p ? p->device : NULL, "taking the mesh", error, size);
    peer_close(p);
    return NULL;
}

void peer_close(peer *p) {
    if (!p) return;
    peer_drop(p);
    if (p->geometry) rtcReleaseGeometry(p->geometry);
    if (p->device) rtcReleaseDevice(p->device);
    free(p->positions);
    free(p->indices);
    free(p);
}

void peer_describe(const peer *p, char *out, size_t size) {
    static const char *const qualities[] = {"LOW", "MEDIUM", "HIGH", "LOW, of its geometry REFIT"};
    const int version = (int)rtcGetDeviceProperty(p->device, RTC_DEVICE_PROPERTY_VERSION);
    snprintf(out, size,
             "Embree %d.%d.%d, RTC_BUILD_QUALITY_%s,%s%s%s in blocks of 512 rays by rtcIntersect1 "
             "and rtcOccluded1, x16: rtcIntersect16 over 4x4 rays, %u thread%s",
             version / 10000, version / 100 % 100, version % 100, qualities[p->config.quality],
             p->config.robust ? " RTC_SCENE_FLAG_ROBUST," : "",
             p->config.compact ? " RTC_SCENE_FLAG_COMPACT," : "",
             p->config.robust || p->config.compact ? "" : " no scene flags,", p->threads,
             p->threads == 1 ? "" : "s");
}

/* ---- Builds --------------------------------------------------------------------------------- */

static enum RTCSceneFlags flags_of(const peer_config *config, bool again) {
    int flags = RTC_SCENE_FLAG_NONE;
    if (config->robust) flags |= RTC_SCENE_FLAG_ROBUST;
    if (config->compact) flags |= RTC_SCENE_FLAG_COMPACT;
    if (again) flags |= RTC_SCENE_FLAG_DYNAMIC;
    return (enum RTCSceneFlags)flags;
}

/* Its builder of Morton codes, and its refitting, are to be had of scenes of quality LOW. */
static enum RTCBuildQuality quality_of(const peer_config *config) {
    return config->quality == PEER_HIGH     ? RTC_BUILD_QUALITY_HIGH
           : config->quality == PEER_MEDIUM ? RTC_BUILD_QUALITY_MEDIUM
                                            : RTC_BUILD_QUALITY_LOW;
}

static void put(peer *p, const float *positions) {
    if (!p->geometry) return;
    memcpy(p->positions, positions, (size_t)p->position_bytes);
    rtcUpdateGeometryBuffer(p->geometry, RTC_BUFFER_TYPE_VERTEX, 0);
}

bool peer_build(peer *p, const float *positions, bool again, double *seconds, char *error,
                size_t size) {
    peer_drop(p);
    put(p, positions);
    if (p->geometry) rtcCommitGeometry(p->geometry);
    const int64_t before = p->most = p->held;
    const double start = clock_seconds();
    p->scene = rtcNewScene(p->device);
    if (!p->scene) return fail(p->device, "rtcNewScene", error, size);
    rtcSetSceneFlags(p->scene, flags_of(&p->config, again));
    rtcSetSceneBuildQuality(p->scene, quality_of(&p->config));
    if (p->geometry) rtcAttachGeometry(p->scene, p->geometry);
    rtcCommitScene(p->scene);
    *seconds = clock_seconds() - start;
    p->bytes = (uint64_t)(p->held - before);
    p->peak = (uint64_t)(p->most - before);
    return rtcGetDeviceError(p->device) == RTC_ERROR_NONE ||
           fail(p->device, "rtcCommitScene", error, size);
}

bool peer_commit(peer *p, const float *positions, double *seconds, char *error, size_t size) {
    put(p, positions);
    const double start = clock_seconds();
    if (p->geometry) rtcCommitGeometry(p->geometry);
    rtcCommitScene(p->scene);
    *seconds = clock_seconds() - start;
    return rtcGetDeviceError(p->device) == RTC_ERROR_NONE ||
           fail(p->device, "rtcCommitScene", error, size);
}

void peer_drop(peer *p) {
    if (p->scene) rtcReleaseScene(p->scene);
    p->scene = NULL;
}

void peer_memory(const peer *p, uint64_t *bytes, uint64_t *peak) {
    *bytes = p->bytes;
    *peak = p->peak;
}
