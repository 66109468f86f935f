/* bridge.c: structs with pointers, put together on C's stack, and callbacks that carry a handle.
 *
 * SPDX-License-Identifier: MIT */
#include "bridge.h"
#include "_cgo_export.h"

#include <stdlib.h>
#include <string.h>

/* ---- Callbacks into Go ---------------------------------------------------------------------- */

static int32_t intersect_object(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    return htreeGoObject((uintptr_t)user, object, (htree_ray *)ray, hit);
}

static void run_tasks(void *user, uint32_t count, htree_go_task task, void *data) {
    htreeGoTasks((uintptr_t)user, count, task, data);
}

static void *allocate(void *user, uint64_t bytes, uint64_t alignment) {
    return htreeGoAllocate((uintptr_t)user, bytes, alignment);
}

static void release(void *user, void *memory, uint64_t bytes) {
    htreeGoRelease((uintptr_t)user, memory, bytes);
}

static int32_t report_progress(void *user, double fraction) {
    return htreeGoProgress((uintptr_t)user, fraction);
}

static htree_progress progress_of(uintptr_t handle) {
    const htree_progress none = {NULL, NULL};
    const htree_progress progress = {report_progress, (void *)handle};
    return handle ? progress : none;
}

void htree_go_call(htree_go_task task, void *data, uint32_t index) {
    task(data, index);
}

/* ---- Calls from Go -------------------------------------------------------------------------- */

static htree_tasks tasks_of(uint32_t which, uintptr_t hooks) {
    const htree_tasks none = {NULL, NULL};
    const htree_tasks tasks = {run_tasks, (void *)hooks};
    return which & HTREE_GO_TASKS ? tasks : none;
}

static htree_allocator allocator_of(uint32_t which, uintptr_t hooks) {
    const htree_allocator none = {NULL, NULL, NULL};
    const htree_allocator allocator = {allocate, release, (void *)hooks};
    return which & HTREE_GO_ALLOCATOR ? allocator : none;
}

htree_status htree_go_build(htree **out, const htree_mesh *mesh, const float *positions,
                            const uint32_t *indices, const htree_box *boxes, uint64_t box_count,
                            const htree_options *options, uint32_t which, uintptr_t hooks,
                            uintptr_t progress) {
    if (!mesh || !options) return htree_build(out, mesh, options);
    const htree_objects objects = {boxes, box_count, intersect_object, (void *)hooks};
    htree_mesh whole = *mesh;
    htree_options how = *options;
    whole.positions = positions;
    whole.indices = indices;
    if (which & HTREE_GO_OBJECTS) whole.objects = &objects;
    how.tasks = tasks_of(which, hooks);
    how.allocator = allocator_of(which, hooks);
    how.progress = progress_of(progress);
    return htree_build(out, &whole, &how);
}

htree_status htree_go_load(htree **out, const void *file, uint64_t size, uint32_t threads,
                           uint32_t which, uintptr_t hooks) {
    htree_load_options options;
    const htree_status status = htree_load_options_init(&options, sizeof options);
    if (status != HTREE_OK) return status;
    options.threads = threads;
    options.tasks = tasks_of(which, hooks);
    options.allocator = allocator_of(which, hooks);
    if (which & HTREE_GO_OBJECTS) {
        options.intersect = intersect_object;
        options.user = (void *)hooks;
    }
    /* An empty slice has no address. */
    return htree_load(out, file ? file : "", size, &options);
}

htree_status htree_go_update(htree *tree, const htree_mesh *mesh, const float *positions,
                             const uint32_t *indices, const htree_box *boxes, uint64_t box_count,
                             uint32_t which, uintptr_t hooks, int32_t how, double *quality) {
    if (!mesh) return htree_update(tree, mesh, how, quality);
    const htree_objects objects = {boxes, box_count, intersect_object, (void *)hooks};
    htree_mesh whole = *mesh;
    whole.positions = positions;
    whole.indices = indices;
    if (which & HTREE_GO_OBJECTS) whole.objects = &objects;
    return htree_update(tree, &whole, how, quality);
}

void *htree_go_copy(const void *memory, uint64_t bytes) {
    void *const copy = bytes <= SIZE_MAX ? malloc((size_t)bytes) : NULL;
    return copy ? memcpy(copy, memory, (size_t)bytes) : NULL;
}

htree_status htree_go_intersect(const htree *tree, const htree_ray *rays, uint64_t count,
                                htree_hit *hits, const htree_query *query, htree_counters *counters,
                                uintptr_t progress) {
    if (!query) return htree_intersect(tree, rays, count, hits, NULL);
    htree_query whole = *query;
    whole.counters = counters;
    whole.progress = progress_of(progress);
    return htree_intersect(tree, rays, count, hits, &whole);
}

htree_status htree_go_occluded(const htree *tree, const htree_ray *rays, uint64_t count,
                               uint8_t *occluded, const htree_query *query,
                               htree_counters *counters, uintptr_t progress) {
    if (!query) return htree_occluded(tree, rays, count, occluded, NULL);
    htree_query whole = *query;
    whole.counters = counters;
    whole.progress = progress_of(progress);
    return htree_occluded(tree, rays, count, occluded, &whole);
}
