/* cl.h: what the files of libhtree_cl share: OpenCL's entry points, found at run time; an opened
 * device; its programs.
 *
 * Locks are not needed: a device's fields are set before anyone else sees it, but for `lost`, the
 * programs and the log, which change by one atomic exchange each. */
#ifndef HT_OPENCL_CL_H
#define HT_OPENCL_CL_H

#include "htree_cl.h"

#include "base/memory.h"
#include "tree/layout.h"

/* ---- Entry points --------------------------------------------------------------------------- */

/* clang-format off */
#define HT_CL_FUNCTIONS(f)                                                                         \
    f(GetPlatformIDs) f(GetPlatformInfo) f(GetDeviceIDs) f(GetDeviceInfo)                          \
    f(CreateContext) f(RetainContext) f(ReleaseContext)                                            \
    f(CreateCommandQueue) f(RetainCommandQueue) f(ReleaseCommandQueue) f(GetCommandQueueInfo)      \
    f(CreateProgramWithSource) f(BuildProgram) f(GetProgramBuildInfo) f(ReleaseProgram)            \
    f(CreateKernel) f(ReleaseKernel) f(SetKernelArg) f(GetKernelWorkGroupInfo)                     \
    f(CreateBuffer) f(ReleaseMemObject) f(GetMemObjectInfo)                                        \
    f(EnqueueWriteBuffer) f(EnqueueReadBuffer) f(EnqueueMapBuffer) f(EnqueueUnmapMemObject)        \
    f(EnqueueNDRangeKernel) f(WaitForEvents) f(GetEventProfilingInfo) f(ReleaseEvent) f(Finish)
/* clang-format on */

typedef struct ht_cl_api {
#define HT_CL_POINTER(name) __typeof__(&cl##name) name;
    HT_CL_FUNCTIONS(HT_CL_POINTER)
#undef HT_CL_POINTER
} ht_cl_api;

/* Finds the ICD loader and every entry point; it stays loaded. */
htree_status ht_cl_load(ht_cl_api *api);

/* ---- Errors --------------------------------------------------------------------------------- */

/* Stores the text and OpenCL's code for this thread, and returns `status`. */
htree_status ht_cl_fail(htree_status status, cl_int code, const char *format, ...) HT_PRINTF(3, 4);

/* Says that call `what` failed with `code`, and returns what that means; OK for CL_SUCCESS. */
htree_status ht_cl_check(cl_int code, const char *what);

/* ---- A device ------------------------------------------------------------------------------- */

/* The kernels, by file in cl/; the probe belongs to no structure. */
typedef enum ht_cl_file {
    HT_CL_PROBE,
    HT_CL_BVH,
    HT_CL_H,
    HT_CL_KD,
    HT_CL_UG,
    HT_CL_WIDE,
    HT_CL_FILES
} ht_cl_file;

/* Stacks come in sizes: private memory is what GPUs are short of. */
enum { HT_CL_STACKS = 3, HT_CL_SPARE_KERNELS = 8 };

/* A compiled file. clSetKernelArg is not thread-safe on one kernel, so each call takes its own. */
typedef struct ht_cl_program {
    cl_program program;
    size_t group_size;
    cl_kernel closest[HT_CL_SPARE_KERNELS], any[HT_CL_SPARE_KERNELS];
} ht_cl_program;

/* What compilers said: newest first, kept until the device is closed. */
typedef struct ht_cl_log {
    struct ht_cl_log *older;
    uint64_t bytes; /* of this struct and its text */
    char text[1];
} ht_cl_log;

struct htree_cl {
    ht_cl_api api;
    ht_memory memory;
    htree_cl_options options;
    htree_cl_info info;
    cl_context context;
    cl_device_id id;
    cl_command_queue queue;
    uint32_t users; /* the caller's handle and the trees */
    uint32_t lost;
    ht_cl_program *programs[HT_CL_FILES][HT_CL_STACKS];
    ht_cl_log *log;
    uint64_t compile_nanoseconds;
};

/* info.c: what OpenCL says of a device, and whether it is bound to give the CPU's bits. */
htree_status ht_cl_read_info(const ht_cl_api *api, cl_device_id id, htree_cl_info *info);
bool ht_cl_promises_ieee(const ht_cl_api *api, cl_device_id id);
htree_status ht_cl_write_info(const htree_cl_info *known, htree_cl_info *info);
htree_status ht_cl_find(const ht_cl_api *api, const char *name, cl_device_id *id, uint32_t *index);

/* device.c: one more user, one fewer; the last one ends it. */
void ht_cl_retain(htree_cl *device);
void ht_cl_release(htree_cl *device);

/* Fails if the device was lost; as ht_cl_check, and notes a loss. */
htree_status ht_cl_alive(const htree_cl *device);
htree_status ht_cl_call(htree_cl *device, cl_int code, const char *what);

/* ---- Programs ------------------------------------------------------------------------------- */

/* program.c: the program of a file, for trees that need so much stack; compiled and proved by the
 * first who asks. */
htree_status ht_cl_get_program(htree_cl *device, ht_cl_file file, uint32_t stack,
                               ht_cl_program **out);
void ht_cl_program_release(htree_cl *device, ht_cl_program *program);
htree_status ht_cl_take_kernel(htree_cl *device, ht_cl_program *program, bool any,
                               cl_kernel *kernel);
void ht_cl_give_kernel(htree_cl *device, ht_cl_program *program, bool any, cl_kernel kernel);

/* proof.c: a batch of known answers, through the program. The probe's decides what the device is
 * worth; any other must be worth as much. */
htree_status ht_cl_prove(htree_cl *device, ht_cl_file file, ht_cl_program *program);

/* ---- A tree --------------------------------------------------------------------------------- */

struct htree_cl_tree {
    htree_cl *device;
    ht_cl_program *program;
    cl_mem scene, nodes, triangles, leaves;
};

/* tree.c: uploads for a given program, which the proof of a program needs. */
htree_status ht_cl_upload_for(htree_cl *device, ht_cl_program *program, const htree_view *view,
                              htree_cl_tree **out);

/* enqueue.c: rays first .. end of the buffers. */
htree_status ht_cl_launch(const htree_cl_tree *tree, bool any, cl_command_queue queue, cl_mem rays,
                          cl_mem answers, uint64_t first, uint64_t end, uint32_t wait_count,
                          const cl_event *wait, cl_event *event);

/* kernels.c, written by the build: the sources of cl/, each as one string. */
extern const char ht_cl_layout[], ht_cl_common[];
extern const char *const ht_cl_source[HT_CL_FILES];

#endif
