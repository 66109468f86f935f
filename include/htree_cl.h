/* htree_cl.h: finished trees on OpenCL devices. Libhtree_cl; the only header that needs <CL/cl.h>.
 *
 *     htree_cl *device = NULL;
 *     htree_cl_tree *tree = NULL;
 *     if (htree_cl_open(&device, NULL, NULL) != HTREE_OK) puts(htree_cl_error_text());
 *     htree_cl_upload(&tree, device, htree);       // htree: from htree_build
 *     htree_cl_intersect(tree, rays, ray_count, hits, NULL);
 *     htree_cl_free(tree);
 *     htree_cl_close(device);
 *
 * Same answer. Where htree_cl_info.exact is 1, hits are those of htree_intersect, bit for bit: the
 * device said that its arithmetic is IEEE's, and a batch of known answers proved it when it was
 * opened, and each kernel when it was compiled. Elsewhere t is within HTREE_CL_T_ERROR of it.
 *
 * OpenCL is opened at run time: without it, every call here says HTREE_ERROR_NO_DEVICE.
 *
 * Threads. Any number of threads may use one device and one tree.
 *
 * Errors are those of htree.h, with the text and the raw OpenCL code of what went wrong last on the
 * calling thread in a call of this header, be it that a second try helped. On failure an
 * out-pointer is NULL.
 *
 * SPDX-License-Identifier: MIT */
#ifndef HTREE_CL_HEADER
#define HTREE_CL_HEADER

#include "htree.h"

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#ifdef __APPLE__
#include <OpenCL/cl.h>
#else
#include <CL/cl.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Errors --------------------------------------------------------------------------------- */

/* The last failure on this thread: a sentence, never NULL; and OpenCL's code, 0 if it had no part in
 * it. */
HTREE_API const char *htree_cl_error_text(void);
HTREE_API int32_t htree_cl_error_code(void);

/* ---- Devices -------------------------------------------------------------------------------- */

/* Bound of |t - t'| / |t'| where htree_cl_info.exact is 0 and t' is the CPU's: 2^-16. */
#define HTREE_CL_T_ERROR 1.52587890625e-5f

/* What is known of a device. */
typedef struct htree_cl_info {
    uint32_t size; /* sizeof(htree_cl_info), set by the caller */
    uint32_t
        index; /* in the order of htree_cl_get_device_info; HTREE_NONE: brought by the caller */
    char platform[128];
    char device[128];
    char version[128];     /* of OpenCL and of the driver */
    uint64_t type;         /* CL_DEVICE_TYPE_CPU, ... */
    uint64_t memory_bytes; /* of the device */
    uint64_t buffer_bytes; /* the largest buffer */
    uint32_t compute_units;
    uint32_t available;     /* 0 or 1, as the next ones */
    uint32_t fp64;          /* has double arithmetic */
    uint32_t shares_memory; /* with the host: batches are not copied */
    uint32_t group_size;    /* rays a work-group, wide trees on CPUs apart; 0 before it is opened */
    uint32_t exact;         /* gives the CPU's bits; 0 before the device is opened */
    float t_error;          /* largest relative error of t in the batch of known answers */
    uint32_t reserved;
    double compile_seconds; /* spent in compiling and proving kernels */
} htree_cl_info;

/* The number of devices of all platforms, at least 1.
 * Errors     ARGUMENT; NO_DEVICE: no OpenCL, or no device; MEMORY, DEVICE, DEVICE_LOST. */
HTREE_API htree_status htree_cl_get_device_count(uint32_t *count);

/* What is known of device `index` without opening it.
 * Errors     ARGUMENT, NO_DEVICE, MEMORY, DEVICE, DEVICE_LOST. */
HTREE_API htree_status htree_cl_get_device_info(uint32_t index, htree_cl_info *info);

/* Flags of htree_cl_options. */
enum {
    HTREE_CL_NO_FP64 = 1 /* no double arithmetic, as on devices without: see htree_cl_info.exact */
};

typedef struct htree_cl_options {
    uint32_t size; /* sizeof(htree_cl_options), written by htree_cl_options_init */
    uint32_t flags;
    uint32_t group_size;       /* rays a work-group; 0: chosen by device and kernel */
    uint32_t launch_rays;      /* most rays a launch; 0: as many as its memory takes. Long launches
                             freeze a display that the device drives as well */
    htree_allocator allocator; /* of host memory */
} htree_cl_options;

/* Writes the defaults; size is sizeof(htree_cl_options).
 * Errors     ARGUMENT; then *options is as it was. */
HTREE_API htree_status htree_cl_options_init(htree_cl_options *options, uint64_t size);

typedef struct htree_cl htree_cl;

/* Opens a device: by index in decimal, or by part of its name, platform or version in any case
 * ("pocl"). Compiles a small kernel and compares its answers with the CPU's.
 * NULL       name: the first GPU, or else the first device. options: the defaults.
 * Errors     ARGUMENT, NO_DEVICE, MEMORY, DEVICE, DEVICE_LOST; KERNEL: its compiler refuses the
 *            kernel or its answers are beyond HTREE_CL_T_ERROR. */
HTREE_API htree_status htree_cl_open(htree_cl **out, const char *name,
                                     const htree_cl_options *options);

/* The same for the caller's own context, device and queue, which are retained. NULL is allowed for
 * the queue (one is made) and the options. */
HTREE_API htree_status htree_cl_open_context(htree_cl **out, cl_context context,
                                             cl_device_id device, cl_command_queue queue,
                                             const htree_cl_options *options);

/* Closes it; NULL is allowed. Trees that were uploaded live on until they are freed themselves. */
HTREE_API void htree_cl_close(htree_cl *device);

/* Fills *info, whose `size` the caller has set. Errors: ARGUMENT, DEVICE. */
HTREE_API htree_status htree_cl_get_info(const htree_cl *device, htree_cl_info *info);

/* What the device's compiler said last, as far as it said anything. Never NULL; stays valid until the
 * device is closed. */
HTREE_API const char *htree_cl_build_log(const htree_cl *device);

/* The context, device and default queue: borrowed, for buffers and queues of the caller's own. NULL
 * is allowed for what is not wanted. */
HTREE_API htree_status htree_cl_get_objects(const htree_cl *device, cl_context *context,
                                            cl_device_id *id, cl_command_queue *queue);

/* ---- Trees ---------------------------------------------------------------------------------- */

typedef struct htree_cl_tree htree_cl_tree;

/* Copies a tree to the device, of any kind; the first of a kind compiles and proves its kernel. The
 * tree itself may be freed right after.
 * Errors     ARGUMENT, MEMORY, LIMIT (an array exceeds the largest buffer), DEVICE, DEVICE_LOST,
 *            KERNEL; UNSUPPORTED: the tree holds user objects, which a device cannot call. */
HTREE_API htree_status htree_cl_upload(htree_cl_tree **out, htree_cl *device, const htree *tree);

/* NULL is allowed. No call may be using it; what was enqueued finishes. */
HTREE_API void htree_cl_free(htree_cl_tree *tree);

/* ---- Queries -------------------------------------------------------------------------------- */

typedef struct htree_cl_query {
    uint32_t size;          /* sizeof(htree_cl_query), written by htree_cl_query_init */
    uint32_t flags;         /* 0 */
    double *kernel_seconds; /* time on the device alone, 0 if its queue keeps no times; or NULL */
    htree_progress progress;
} htree_cl_query;

/* Writes the defaults; size is sizeof(htree_cl_query).
 * Errors     ARGUMENT; then *query is as it was. */
HTREE_API htree_status htree_cl_query_init(htree_cl_query *query, uint64_t size);

/* As htree_intersect and htree_occluded, for arrays of the host. Batches go in as many launches as
 * the device's memory wants, and without a copy where it shares memory with the host and the arrays
 * are aligned to 16 bytes.
 * Errors     ARGUMENT, MEMORY, DEVICE, DEVICE_LOST; CANCELLED. The answers are then unspecified.
 * NULL       query: defaults. */
HTREE_API htree_status htree_cl_intersect(const htree_cl_tree *tree, const htree_ray *rays,
                                          uint64_t count, htree_hit *hits,
                                          const htree_cl_query *query);
HTREE_API htree_status htree_cl_occluded(const htree_cl_tree *tree, const htree_ray *rays,
                                         uint64_t count, uint8_t *occluded,
                                         const htree_cl_query *query);

/* The same for buffers of the device's context, asynchronous: `rays` holds count htree_ray, `hits`
 * count htree_hit, `occluded` count bytes. Begins after the events of `wait`; *event, if not NULL,
 * is an event that the caller releases. The buffers and the tree must outlive it.
 * NULL       queue: the device's own. wait if wait_count is 0. event.
 * Errors     ARGUMENT, also where a buffer is too small; MEMORY, DEVICE, DEVICE_LOST. */
HTREE_API htree_status htree_cl_enqueue_intersect(const htree_cl_tree *tree, cl_command_queue queue,
                                                  cl_mem rays, uint64_t count, cl_mem hits,
                                                  uint32_t wait_count, const cl_event *wait,
                                                  cl_event *event);
HTREE_API htree_status htree_cl_enqueue_occluded(const htree_cl_tree *tree, cl_command_queue queue,
                                                 cl_mem rays, uint64_t count, cl_mem occluded,
                                                 uint32_t wait_count, const cl_event *wait,
                                                 cl_event *event);

#ifdef __cplusplus
}
#endif

#endif
