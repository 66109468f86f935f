/* enqueue.c: one kernel's launch, and batches in buffers of the caller's, asynchronously. */
#include "cl.h"

/* ---- Launches ------------------------------------------------------------------------------- */

static htree_status set_arguments(const htree_cl_tree *tree, cl_kernel kernel, cl_mem rays,
                                  cl_mem answers, uint64_t first, uint64_t end) {
    const cl_ulong range[2] = {first, end};
    const cl_mem arrays[] = {tree->scene,  tree->nodes, tree->triangles,
                             tree->leaves, rays,        answers};
    enum { ARRAYS = sizeof arrays / sizeof *arrays };
    cl_int code = CL_SUCCESS;
    for (cl_uint i = 0; i < ARRAYS && code == CL_SUCCESS; ++i) {
        /* Not every driver takes NULL for an array that is not there. */
        const cl_mem array = arrays[i] ? arrays[i] : tree->scene;
        code = tree->device->api.SetKernelArg(kernel, i, sizeof array, &array);
    }
    for (cl_uint i = 0; i < 2 && code == CL_SUCCESS; ++i)
        code = tree->device->api.SetKernelArg(kernel, ARRAYS + i, sizeof range[i], &range[i]);
    return ht_cl_call(tree->device, code, "clSetKernelArg");
}

htree_status ht_cl_launch(const htree_cl_tree *tree, bool any, cl_command_queue queue, cl_mem rays,
                          cl_mem answers, uint64_t first, uint64_t end, uint32_t wait_count,
                          const cl_event *wait, cl_event *event) {
    htree_cl *device = tree->device;
    const size_t group = tree->program->group_size;
    const uint64_t groups = end > first ? (end - first + group - 1) / group : 1;
    const size_t items = (size_t)groups * group;
    cl_kernel kernel;
    HT_TRY(ht_cl_take_kernel(device, tree->program, any, &kernel));
    htree_status status = set_arguments(tree, kernel, rays, answers, first, end);
    if (status == HTREE_OK) {
        const cl_int code = device->api.EnqueueNDRangeKernel(
            queue, kernel, 1, NULL, &items, &group, wait_count, wait_count ? wait : NULL, event);
        status = ht_cl_call(device, code, "clEnqueueNDRangeKernel");
    }
    ht_cl_give_kernel(device, tree->program, any, kernel);
    return status;
}

/* ---- Buffers of the caller's ---------------------------------------------------------------- */

static htree_status check_buffer(htree_cl *device, cl_mem buffer, uint64_t bytes,
                                 const char *what) {
    size_t size = 0;
    if (!buffer) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "%s is NULL", what);
    const cl_int code = device->api.GetMemObjectInfo(buffer, CL_MEM_SIZE, sizeof size, &size, NULL);
    if (code == CL_INVALID_MEM_OBJECT)
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, code, "%s is no buffer", what);
    HT_TRY(ht_cl_call(device, code, "clGetMemObjectInfo"));
    if (size < bytes) {
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, CL_INVALID_BUFFER_SIZE,
                          "%s holds %llu bytes, the batch needs %llu", what,
                          (unsigned long long)size, (unsigned long long)bytes);
    }
    return HTREE_OK;
}

/* Launches of at most launch_rays, each after the one before. */
static htree_status launch_all(const htree_cl_tree *tree, bool any, cl_command_queue queue,
                               cl_mem rays, uint64_t count, cl_mem answers, uint32_t wait_count,
                               const cl_event *wait, cl_event *event) {
    const ht_cl_api *api = &tree->device->api;
    const uint32_t limit = tree->device->options.launch_rays;
    const uint64_t step = limit && limit < count ? limit : count;
    cl_event before = NULL;
    uint64_t first = 0;
    do {
        const uint64_t end = count - first < step ? count : first + step;
        const bool last = end == count;
        cl_event here = NULL;
        const htree_status status =
            ht_cl_launch(tree, any, queue, rays, answers, first, end, before ? 1 : wait_count,
                         before ? &before : wait, last ? event : &here);
        if (before) api->ReleaseEvent(before);
        HT_TRY(status);
        before = here;
        first = end;
    } while (first < count);
    return HTREE_OK;
}

static htree_status enqueue(const htree_cl_tree *tree, bool any, cl_command_queue queue,
                            cl_mem rays, uint64_t count, cl_mem answers, uint32_t wait_count,
                            const cl_event *wait, cl_event *event) {
    if (event) *event = NULL;
    if (!tree) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "tree is NULL");
    if (wait_count && !wait) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "wait is NULL");
    if (count > UINT64_MAX / sizeof(htree_ray))
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "count exceeds the address space");
    htree_cl *device = tree->device;
    HT_TRY(ht_cl_alive(device));
    HT_TRY(check_buffer(device, rays, count * sizeof(htree_ray), "rays"));
    HT_TRY(check_buffer(device, answers, count * (any ? 1 : sizeof(htree_hit)),
                        any ? "occluded" : "hits"));
    return launch_all(tree, any, queue ? queue : device->queue, rays, count, answers, wait_count,
                      wait, event);
}

htree_status htree_cl_enqueue_intersect(const htree_cl_tree *tree, cl_command_queue queue,
                                        cl_mem rays, uint64_t count, cl_mem hits,
                                        uint32_t wait_count, const cl_event *wait,
                                        cl_event *event) {
    return enqueue(tree, false, queue, rays, count, hits, wait_count, wait, event);
}

htree_status htree_cl_enqueue_occluded(const htree_cl_tree *tree, cl_command_queue queue,
                                       cl_mem rays, uint64_t count, cl_mem occluded,
                                       uint32_t wait_count, const cl_event *wait, cl_event *event) {
    return enqueue(tree, true, queue, rays, count, occluded, wait_count, wait, event);
}
