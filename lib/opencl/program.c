/* program.c: compiles the file of a structure when it is first needed, and lends its kernels out.
 *
 * No text of the caller's ever reaches the compiler. Binaries are not kept: drivers do that. */
#include "cl.h"
#include "base/clock.h"

#include <stdio.h>

/* Rays of a work-group: enough to fill a GPU's core, few enough to balance a CPU's. A wide tree on
 * a CPU has many of them in flight on a thread: see cl/wide.cl. */
enum { USUAL_GROUP = 64, STREAMS_GROUP = 512 };

/* ---- Compile -------------------------------------------------------------------------------- */

static uint32_t full_stack(ht_cl_file file) {
    return file == HT_CL_WIDE ? HT_WIDE_STACK : HT_MAX_DEPTH;
}

/* On a CPU a stack costs nothing, and a second program would. */
static uint32_t stack_class(const htree_cl *device, ht_cl_file file, uint32_t stack) {
    static const uint32_t sizes[HT_CL_STACKS - 1] = {32, 64};
    if (device->info.type & CL_DEVICE_TYPE_CPU) return full_stack(file);
    for (int i = 0; i < HT_CL_STACKS - 1; ++i) {
        if (stack < sizes[i]) return sizes[i];
    }
    return full_stack(file);
}

static uint32_t class_index(uint32_t stack) {
    return stack == 32 ? 0 : stack == 64 ? 1 : 2;
}

/* Keeps what the compiler said; a log that cannot be had is no failure of its own. */
static void keep_log(htree_cl *device, cl_program program) {
    const ht_cl_api *api = &device->api;
    size_t length = 0;
    if (api->GetProgramBuildInfo(program, device->id, CL_PROGRAM_BUILD_LOG, 0, NULL, &length) !=
            CL_SUCCESS ||
        length < 2 || length > 1 << 24) {
        return;
    }
    const uint64_t bytes = sizeof(ht_cl_log) + length;
    ht_cl_log *log = (ht_cl_log *)ht_allocate(&device->memory, bytes);
    if (!log) return;
    memset(log, 0, (size_t)bytes);
    log->bytes = bytes;
    (void)api->GetProgramBuildInfo(program, device->id, CL_PROGRAM_BUILD_LOG, length, log->text,
                                   NULL);
    log->older = __atomic_load_n(&device->log, __ATOMIC_RELAXED);
    while (!__atomic_compare_exchange_n(&device->log, &log->older, log, false, __ATOMIC_RELEASE,
                                        __ATOMIC_RELAXED)) {
    }
}

static htree_status build_program(htree_cl *device, ht_cl_file file, uint32_t stack,
                                  cl_program *out) {
    const ht_cl_api *api = &device->api;
    const char *sources[] = {ht_cl_layout, ht_cl_common, ht_cl_source[file]};
    const bool fp64 = device->info.fp64 && !(device->options.flags & HTREE_CL_NO_FP64);
    char options[96];
    cl_int code = CL_SUCCESS;
    snprintf(options, sizeof options, "-cl-std=CL1.2 -DHT_STACK=%lu%s", (unsigned long)stack,
             fp64 ? " -DHT_FP64" : "");
    *out = api->CreateProgramWithSource(device->context, 3, sources, NULL, &code);
    HT_TRY(ht_cl_call(device, code, "clCreateProgramWithSource"));
    code = api->BuildProgram(*out, 1, &device->id, options, NULL, NULL);
    keep_log(device, *out);
    const htree_status status = ht_cl_call(device, code, "clBuildProgram");
    if (code != CL_BUILD_PROGRAM_FAILURE) return status;
    /* Where a device cannot be opened, nobody can ask it for its log. */
    return ht_cl_fail(status, code, "clBuildProgram: %s refused a kernel (%ld): %.300s",
                      device->info.device, (long)code, htree_cl_build_log(device));
}

/* ---- Kernels -------------------------------------------------------------------------------- */

htree_status ht_cl_take_kernel(htree_cl *device, ht_cl_program *program, bool any,
                               cl_kernel *kernel) {
    cl_kernel *spare = any ? program->any : program->closest;
    cl_int code = CL_SUCCESS;
    for (int i = 0; i < HT_CL_SPARE_KERNELS; ++i) {
        *kernel = __atomic_exchange_n(&spare[i], (cl_kernel)NULL, __ATOMIC_ACQ_REL);
        if (*kernel) return HTREE_OK;
    }
    *kernel =
        device->api.CreateKernel(program->program, any ? "htree_any" : "htree_closest", &code);
    return ht_cl_call(device, code, "clCreateKernel");
}

void ht_cl_give_kernel(htree_cl *device, ht_cl_program *program, bool any, cl_kernel kernel) {
    cl_kernel *spare = any ? program->any : program->closest;
    for (int i = 0; kernel && i < HT_CL_SPARE_KERNELS; ++i) {
        cl_kernel none = NULL;
        if (__atomic_compare_exchange_n(&spare[i], &none, kernel, false, __ATOMIC_ACQ_REL,
                                        __ATOMIC_RELAXED)) {
            kernel = NULL;
        }
    }
    if (kernel) device->api.ReleaseKernel(kernel);
}

/* The largest that both kernels take, up to what is wanted. */
static htree_status choose_group(htree_cl *device, ht_cl_file file, ht_cl_program *program) {
    const uint32_t wanted = device->options.group_size;
    const bool streams = file == HT_CL_WIDE && device->info.type & CL_DEVICE_TYPE_CPU;
    program->group_size = wanted ? wanted : streams ? STREAMS_GROUP : USUAL_GROUP;
    for (int any = 0; any < 2; ++any) {
        cl_kernel kernel;
        size_t most = 0;
        HT_TRY(ht_cl_take_kernel(device, program, any, &kernel));
        const cl_int code = device->api.GetKernelWorkGroupInfo(
            kernel, device->id, CL_KERNEL_WORK_GROUP_SIZE, sizeof most, &most, NULL);
        ht_cl_give_kernel(device, program, any, kernel);
        HT_TRY(ht_cl_call(device, code, "clGetKernelWorkGroupInfo"));
        if (most < 1) most = 1;
        if (program->group_size > most) program->group_size = most;
    }
    return HTREE_OK;
}

/* ---- Programs ------------------------------------------------------------------------------- */

void ht_cl_program_release(htree_cl *device, ht_cl_program *program) {
    if (!program) return;
    for (int i = 0; i < HT_CL_SPARE_KERNELS; ++i) {
        if (program->closest[i]) device->api.ReleaseKernel(program->closest[i]);
        if (program->any[i]) device->api.ReleaseKernel(program->any[i]);
    }
    if (program->program) device->api.ReleaseProgram(program->program);
    ht_release(&device->memory, program, sizeof *program);
}

/* Some compilers do half of their work at the first launch, so the proof counts as well. */
static htree_status make_program(htree_cl *device, ht_cl_file file, uint32_t stack,
                                 ht_cl_program *program) {
    const double start = ht_seconds();
    HT_TRY(build_program(device, file, stack, &program->program));
    HT_TRY(choose_group(device, file, program));
    HT_TRY(ht_cl_prove(device, file, program));
    __atomic_add_fetch(&device->compile_nanoseconds, (uint64_t)(1e9 * (ht_seconds() - start)),
                       __ATOMIC_RELAXED);
    return HTREE_OK;
}

htree_status ht_cl_get_program(htree_cl *device, ht_cl_file file, uint32_t stack,
                               ht_cl_program **out) {
    const uint32_t size = stack_class(device, file, stack);
    ht_cl_program **place = &device->programs[file][class_index(size)];
    *out = __atomic_load_n(place, __ATOMIC_ACQUIRE);
    if (*out) return HTREE_OK;
    ht_cl_program *program = (ht_cl_program *)ht_allocate(&device->memory, sizeof *program);
    if (!program) return ht_cl_fail(HTREE_ERROR_MEMORY, 0, "out of memory");
    memset(program, 0, sizeof *program);
    const htree_status status = make_program(device, file, size, program);
    if (status != HTREE_OK) {
        ht_cl_program_release(device, program);
        return status;
    }
    /* Who compiled it at the same time and came first is as good. */
    if (__atomic_compare_exchange_n(place, out, program, false, __ATOMIC_ACQ_REL,
                                    __ATOMIC_ACQUIRE)) {
        *out = program;
    } else {
        ht_cl_program_release(device, program);
    }
    return HTREE_OK;
}
