/* mock_cl.h: orders for, and books of, a libOpenCL.so.1 that lives in host memory: every call may
 * be told to fail, devices may be anything, and what is not released is seen.
 *
 * It runs the kernels of cl/, compiled for the host. It is as lazy as OpenCL allows: commands run
 * when someone waits for them and no earlier, a buffer over the host's memory is a copy until it is
 * mapped, and fresh memory holds garbage. */
#ifndef MOCK_CL_H
#define MOCK_CL_H

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>

#include <stdbool.h>
#include <stdint.h>

#define MOCK_API __attribute__((visibility("default")))

/* ---- The world: platforms and devices ------------------------------------------------------- */

/* What a kernel makes of its answers. */
typedef enum mock_wrong {
    MOCK_RIGHT,
    MOCK_WRONG_ULP,     /* the distance of every hit is one step off */
    MOCK_WRONG_MISS,    /* every ray misses */
    MOCK_WRONG_NAN,     /* every distance is NaN */
    MOCK_WRONG_OCCLUDED /* every ray is occluded */
} mock_wrong;

typedef struct mock_world {
    uint32_t platforms; /* 0: clGetPlatformIDs fails, as ICD loaders do */
    uint32_t devices;   /* of each platform; up to 4, as the platforms */
    cl_device_type type;
    bool available;
    bool unified;   /* CL_DEVICE_HOST_UNIFIED_MEMORY */
    bool fp64;      /* double arithmetic */
    bool denormals; /* of float */
    cl_ulong memory_bytes, buffer_bytes;
    size_t group_limit; /* CL_KERNEL_WORK_GROUP_SIZE */
    bool build_fails;
    const char *build_log; /* NULL: the compiler is silent */
    mock_wrong wrong;
    const char *wrong_file;    /* whose kernels are wrong: "bvh"; NULL: all */
    uint64_t broken_kernel;    /* this kernel to run fails, counted from 1; 0: none */
    cl_int broken_kernel_code; /* and so says its event */
} mock_world;

/* One platform with one CPU that shares memory, has all it takes and is always right. */
MOCK_API mock_world mock_usual_world(void);
MOCK_API void mock_set_world(const mock_world *world);

/* ---- Orders --------------------------------------------------------------------------------- */

/* Counts calls from 1 again, and call number `call` fails with `code`; for_good: and so do all
 * after it. 0: none fails. A call that releases something releases it all the same. */
MOCK_API void mock_fail(uint64_t call, cl_int code, bool for_good);

/* Calls since then; the name of one of the first 4096, and what it asked for: the parameter of a
 * clGet*Info, the flags of a buffer, the index of an argument. */
MOCK_API uint64_t mock_calls(void);
MOCK_API const char *mock_call(uint64_t call, uint64_t *detail);

/* The next `threads` launches wait for each other: so many threads hold a kernel at once. */
MOCK_API void mock_meet(uint32_t threads);

/* Commands that were enqueued and have not run. */
MOCK_API uint64_t mock_pending(void);

/* ---- Books ---------------------------------------------------------------------------------- */

typedef enum mock_kind {
    MOCK_CONTEXT,
    MOCK_QUEUE,
    MOCK_PROGRAM,
    MOCK_KERNEL,
    MOCK_BUFFER,
    MOCK_EVENT,
    MOCK_KINDS
} mock_kind;

/* Objects that someone still holds; all kinds, and what commands hold too. */
MOCK_API uint64_t mock_live(mock_kind kind);
MOCK_API uint64_t mock_live_all(void);
MOCK_API uint64_t mock_live_bytes(void); /* of buffers */

/* What no program may do: releasing twice, using what is gone, ranges beyond a buffer, arguments
 * that are not set; the first of them in words. */
MOCK_API uint64_t mock_mistakes(void);
MOCK_API const char *mock_first_mistake(void);

/* The size of the last work-group, and how many buffers over the host's memory there were. */
MOCK_API size_t mock_last_group(void);
MOCK_API uint64_t mock_shared_buffers(void);

/* ---- Memory of answers: proofs ask the same questions again and again ------------------------ */

/* The answer to an equal question, if it was learnt. A question is a hash of all that decides
 * it. */
MOCK_API bool mock_remember(uint64_t question, void *answers, size_t bytes);
MOCK_API void mock_learn(uint64_t question, const void *answers, size_t bytes);
MOCK_API uint64_t mock_hash(uint64_t hash, const void *data, size_t bytes);

/* The usual world, no orders, fresh books. Nothing may be live. */
MOCK_API void mock_reset(void);

#endif
