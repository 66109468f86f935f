/* batch.c: batches in arrays of the host, in as many segments as the device's memory wants. */
#include "cl.h"
#include "base/sized.h"
#include "base/progress.h"

/* ---- Segments ------------------------------------------------------------------------------- */

/* A segment of a batch on its way through the device. */
typedef struct segment {
    const htree_cl_tree *tree;
    bool any, copies;
    const htree_ray *rays;
    char *answers;
    uint64_t count;
    size_t answer_bytes; /* of all */
    cl_mem ray_buffer, answer_buffer;
    cl_event written, done, unmapped;
    double kernel_seconds;
} segment;

static htree_status make_buffer(const segment *s, cl_mem_flags flags, size_t bytes, void *host,
                                cl_mem *out) {
    htree_cl *device = s->tree->device;
    cl_int code = CL_SUCCESS;
    if (!s->copies) flags |= CL_MEM_USE_HOST_PTR;
    *out = device->api.CreateBuffer(device->context, flags, bytes, s->copies ? NULL : host, &code);
    return ht_cl_call(device, code, "clCreateBuffer");
}

static htree_status send_rays(segment *s) {
    htree_cl *device = s->tree->device;
    const size_t bytes = (size_t)s->count * sizeof *s->rays;
    /* OpenCL does not write to a buffer that is read only. */
    HT_TRY(make_buffer(s, CL_MEM_READ_ONLY, bytes, (void *)(uintptr_t)s->rays, &s->ray_buffer));
    HT_TRY(make_buffer(s, CL_MEM_WRITE_ONLY, s->answer_bytes, s->answers, &s->answer_buffer));
    if (!s->copies) return HTREE_OK;
    return ht_cl_call(device,
                      device->api.EnqueueWriteBuffer(device->queue, s->ray_buffer, CL_FALSE, 0,
                                                     bytes, s->rays, 0, NULL, &s->written),
                      "clEnqueueWriteBuffer");
}

/* A buffer over the host's memory holds the answers there once it has been mapped. */
static htree_status receive_answers(segment *s) {
    htree_cl *device = s->tree->device;
    const ht_cl_api *api = &device->api;
    cl_int code = CL_SUCCESS;
    if (s->copies) {
        code = api->EnqueueReadBuffer(device->queue, s->answer_buffer, CL_TRUE, 0, s->answer_bytes,
                                      s->answers, 1, &s->done, NULL);
        return ht_cl_call(device, code, "clEnqueueReadBuffer");
    }
    void *mapped = api->EnqueueMapBuffer(device->queue, s->answer_buffer, CL_TRUE, CL_MAP_READ, 0,
                                         s->answer_bytes, 1, &s->done, NULL, &code);
    HT_TRY(ht_cl_call(device, code, "clEnqueueMapBuffer"));
    code =
        api->EnqueueUnmapMemObject(device->queue, s->answer_buffer, mapped, 0, NULL, &s->unmapped);
    HT_TRY(ht_cl_call(device, code, "clEnqueueUnmapMemObject"));
    return ht_cl_call(device, api->WaitForEvents(1, &s->unmapped), "clWaitForEvents");
}

/* A queue without profiling has no times to give. */
static void read_time(segment *s) {
    const ht_cl_api *api = &s->tree->device->api;
    cl_ulong start = 0, end = 0;
    if (api->GetEventProfilingInfo(s->done, CL_PROFILING_COMMAND_START, sizeof start, &start,
                                   NULL) == CL_SUCCESS &&
        api->GetEventProfilingInfo(s->done, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL) ==
            CL_SUCCESS)
        s->kernel_seconds = 1e-9 * (double)(end - start);
}

static htree_status process(segment *s) {
    HT_TRY(send_rays(s));
    HT_TRY(ht_cl_launch(s->tree, s->any, s->tree->device->queue, s->ray_buffer, s->answer_buffer, 0,
                        s->count, s->written ? 1 : 0, &s->written, &s->done));
    HT_TRY(receive_answers(s));
    read_time(s);
    return HTREE_OK;
}

static htree_status run_segment(segment *s) {
    const ht_cl_api *api = &s->tree->device->api;
    const htree_status status = process(s);
    /* Nothing may touch the caller's arrays after a failure. */
    if (status != HTREE_OK) (void)api->Finish(s->tree->device->queue);
    const cl_event events[] = {s->written, s->done, s->unmapped};
    for (int i = 0; i < 3; ++i) {
        if (events[i]) api->ReleaseEvent(events[i]);
    }
    if (s->answer_buffer) api->ReleaseMemObject(s->answer_buffer);
    if (s->ray_buffer) api->ReleaseMemObject(s->ray_buffer);
    return status;
}

/* ---- Batches -------------------------------------------------------------------------------- */

enum { RAYS_A_REPORT = 1 << 17, FEW_RAYS = 1024 };

static htree_status read_query(const htree_cl_query *given, htree_cl_query *query) {
    HT_TRY(htree_cl_query_init(query, sizeof *query));
    if (!given) return HTREE_OK;
    if (ht_sized_read(query, sizeof *query, sizeof *query, given, given->size, "query"))
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0,
                          "query.size is %lu, or a field is set that this version does not know",
                          (unsigned long)given->size);
    if (query->flags) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "query.flags must be 0");
    return HTREE_OK;
}

/* What one buffer and a quarter of the device's memory take. */
static uint64_t segment_rays(const htree_cl *device, const htree_cl_query *query) {
    const uint64_t buffer = device->info.buffer_bytes / sizeof(htree_ray);
    const uint64_t memory = device->info.memory_bytes / 4 / sizeof(htree_ray);
    uint64_t rays = buffer < memory ? buffer : memory;
    if (device->options.launch_rays && device->options.launch_rays < rays)
        rays = device->options.launch_rays;
    if (query->progress.report && rays > RAYS_A_REPORT) rays = RAYS_A_REPORT;
    return rays ? rays : 1;
}

static bool is_shared(const htree_cl *device, const void *rays, const void *answers) {
    return device->info.shares_memory && (uintptr_t)rays % 16 == 0 && (uintptr_t)answers % 16 == 0;
}

static htree_status run_batch(const htree_cl_tree *tree, const htree_ray *rays, uint64_t count,
                              char *answers, bool any, const htree_cl_query *query) {
    const size_t answer_size = any ? 1 : sizeof(htree_hit);
    uint64_t most = segment_rays(tree->device, query);
    ht_progress progress;
    ht_progress_begin(&progress, &query->progress, count);
    double seconds = 0;
    for (uint64_t first = 0; first < count;) {
        const uint64_t n = count - first < most ? count - first : most;
        segment s;
        memset(&s, 0, sizeof s);
        s.tree = tree;
        s.any = any;
        s.rays = rays + first;
        s.answers = answers + first * answer_size;
        s.count = n;
        s.answer_bytes = (size_t)n * answer_size;
        s.copies = !is_shared(tree->device, s.rays, s.answers);
        const htree_status status = run_segment(&s);
        if (status == HTREE_ERROR_MEMORY && n > FEW_RAYS) {
            most = n / 2;
            continue;
        }
        HT_TRY(status);
        seconds += s.kernel_seconds;
        first += n;
        if (!ht_progress_step(&progress, n))
            return ht_cl_fail(HTREE_ERROR_CANCELLED, 0, "the progress hook cancelled the query");
    }
    if (query->kernel_seconds) *query->kernel_seconds = seconds;
    return HTREE_OK;
}

static htree_status query_host(const htree_cl_tree *tree, const htree_ray *rays, uint64_t count,
                               void *answers, bool any, const htree_cl_query *given) {
    htree_cl_query query;
    if (!tree) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "tree is NULL");
    HT_TRY(read_query(given, &query));
    if (query.kernel_seconds) *query.kernel_seconds = 0;
    HT_TRY(ht_cl_alive(tree->device));
    if (count == 0) return HTREE_OK;
    if (!rays) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "rays is NULL");
    if (!answers) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "the array for the answers is NULL");
    if (count > UINT64_MAX / sizeof *rays)
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "count exceeds the address space");
    return run_batch(tree, rays, count, (char *)answers, any, &query);
}

htree_status htree_cl_query_init(htree_cl_query *query, uint64_t size) {
    if (!query) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "query is NULL");
    if (size < sizeof *query || size > 65536) {
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "size is %llu: pass sizeof(htree_cl_query)",
                          (unsigned long long)size);
    }
    memset(query, 0, (size_t)size);
    query->size = (uint32_t)size;
    return HTREE_OK;
}

htree_status htree_cl_intersect(const htree_cl_tree *tree, const htree_ray *rays, uint64_t count,
                                htree_hit *hits, const htree_cl_query *query) {
    return query_host(tree, rays, count, hits, false, query);
}

htree_status htree_cl_occluded(const htree_cl_tree *tree, const htree_ray *rays, uint64_t count,
                               uint8_t *occluded, const htree_cl_query *query) {
    return query_host(tree, rays, count, occluded, true, query);
}
