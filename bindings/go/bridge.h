/* bridge.h: what Go cannot say to C by itself. A struct in Go's memory must not hold pointers into Go's
 * memory, so arrays come beside the structs that name them, and hooks as handles.
 *
 * SPDX-License-Identifier: MIT */
#ifndef HTREE_GO_BRIDGE
#define HTREE_GO_BRIDGE

#include <htree.h>

/* Which hooks the handle of a tree has. */
enum { HTREE_GO_OBJECTS = 1, HTREE_GO_TASKS = 2, HTREE_GO_ALLOCATOR = 4 };

/* What a tree is built from beside the numbers of its mesh and options; a handle is 0 for none. */
htree_status htree_go_build(htree **out, const htree_mesh *mesh, const float *positions,
                            const uint32_t *indices, const htree_box *boxes, uint64_t box_count,
                            const htree_options *options, uint32_t which, uintptr_t hooks,
                            uintptr_t progress);

htree_status htree_go_load(htree **out, const void *file, uint64_t size, uint32_t threads,
                           uint32_t which, uintptr_t hooks);

htree_status htree_go_update(htree *tree, const htree_mesh *mesh, const float *positions,
                             const uint32_t *indices, const htree_box *boxes, uint64_t box_count,
                             uint32_t which, uintptr_t hooks, int32_t how, double *quality);

/* A copy from malloc, or NULL. */
void *htree_go_copy(const void *memory, uint64_t bytes);

htree_status htree_go_intersect(const htree *tree, const htree_ray *rays, uint64_t count,
                                htree_hit *hits, const htree_query *query, htree_counters *counters,
                                uintptr_t progress);

htree_status htree_go_occluded(const htree *tree, const htree_ray *rays, uint64_t count,
                               uint8_t *occluded, const htree_query *query,
                               htree_counters *counters, uintptr_t progress);

/* Go cannot call a C function by its address. */
typedef void (*htree_go_task)(void *data, uint32_t index);
void htree_go_call(htree_go_task task, void *data, uint32_t index);

#endif
