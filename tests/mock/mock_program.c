/* mock_program.c: programs and kernels: the compiler is a table of what was compiled before. */
#include "mock_inner.h"

#include <stdio.h>

/* ---- Programs ------------------------------------------------------------------------------- */

static void end_program(mock_object *object) {
    cl_program program = (cl_program)object;
    free(program->source);
    mock_drop_locked(program->context);
}

MOCK_API cl_program clCreateProgramWithSource(cl_context context, cl_uint count,
                                              const char **strings, const size_t *lengths,
                                              cl_int *code) {
    const cl_int refused = mock_enter(__func__, 0);
    if (refused) return (cl_program)mock_created(code, refused, NULL);
    if (!mock_is(context, MOCK_CONTEXT))
        return (cl_program)mock_created(code, CL_INVALID_CONTEXT, NULL);
    size_t bytes = 1;
    for (cl_uint i = 0; i < count; ++i) bytes += lengths ? lengths[i] : strlen(strings[i]);
    cl_program program = (cl_program)mock_new(MOCK_PROGRAM, sizeof *program, end_program);
    char *out = program->source = (char *)calloc(1, bytes);
    for (cl_uint i = 0; i < count; ++i) {
        const size_t length = lengths ? lengths[i] : strlen(strings[i]);
        memcpy(out, strings[i], length);
        out += length;
    }
    program->context = context;
    mock_lock();
    mock_hold_locked(context);
    mock_unlock();
    return (cl_program)mock_created(code, CL_SUCCESS, program);
}

/* The file whose walk the source ends in, compiled as the options say. */
static const mock_compiled *compile(const char *source, const char *options) {
    char file[16], rest;
    unsigned stack = 0;
    const char *const walk = strstr(source, "HT_KERNELS(walk_");
    const bool fp64 = strstr(options, " -DHT_FP64") != NULL;
    char expected[80];
    if (!walk || sscanf(walk, "HT_KERNELS(walk_%15[a-z]%c", file, &rest) != 2 || rest != ')' ||
        sscanf(options, "-cl-std=CL1.2 -DHT_STACK=%u", &stack) != 1) {
        return NULL;
    }
    snprintf(expected, sizeof expected, "-cl-std=CL1.2 -DHT_STACK=%u%s", stack,
             fp64 ? " -DHT_FP64" : "");
    if (strcmp(options, expected) != 0 || (fp64 && !mock_now.fp64)) return NULL;
    for (const mock_compiled *c = mock_compiled_kernels; c->file; ++c) {
        if (strcmp(c->file, file) == 0 && c->stack == stack && c->fp64 == (uint32_t)fp64) return c;
    }
    return NULL;
}

MOCK_API cl_int clBuildProgram(cl_program program, cl_uint count, const cl_device_id *ids,
                               const char *options, void(CL_CALLBACK *notify)(cl_program, void *),
                               void *user) {
    (void)notify;
    (void)user;
    const cl_int refused = mock_enter(__func__, 0);
    if (refused) return refused;
    if (!mock_is(program, MOCK_PROGRAM))
        return mock_mistake(CL_INVALID_PROGRAM, "clBuildProgram: program");
    if (count != 1 || ids[0] != program->context->device) return CL_INVALID_DEVICE;
    program->log = mock_now.build_log;
    if (mock_now.build_fails) return CL_BUILD_PROGRAM_FAILURE;
    program->compiled = compile(program->source, options ? options : "");
    if (program->compiled) return CL_SUCCESS;
    program->log = "the mock has no such kernel, or no such option";
    return mock_mistake(CL_BUILD_PROGRAM_FAILURE, "clBuildProgram: a program it knows not");
}

MOCK_API cl_int clGetProgramBuildInfo(cl_program program, cl_device_id id,
                                      cl_program_build_info what, size_t size, void *value,
                                      size_t *size_ret) {
    const cl_int refused = mock_enter(__func__, what);
    if (refused) return refused;
    if (!mock_is(program, MOCK_PROGRAM))
        return mock_mistake(CL_INVALID_PROGRAM, "clGetProgramBuildInfo: program");
    if (!mock_is_device(id) || what != CL_PROGRAM_BUILD_LOG) return CL_INVALID_VALUE;
    return mock_give_text(size, value, size_ret, program->log ? program->log : "");
}

MOCK_API cl_int clReleaseProgram(cl_program program) {
    return mock_release(__func__, program, MOCK_PROGRAM, CL_INVALID_PROGRAM);
}

/* ---- Kernels -------------------------------------------------------------------------------- */

static void end_kernel(mock_object *object) {
    mock_drop_locked(((cl_kernel)object)->program);
}

MOCK_API cl_kernel clCreateKernel(cl_program program, const char *name, cl_int *code) {
    const cl_int refused = mock_enter(__func__, 0);
    if (refused) return (cl_kernel)mock_created(code, refused, NULL);
    if (!mock_is(program, MOCK_PROGRAM))
        return (cl_kernel)mock_created(
            code, mock_mistake(CL_INVALID_PROGRAM, "clCreateKernel: program"), NULL);
    if (!program->compiled)
        return (cl_kernel)mock_created(
            code, mock_mistake(CL_INVALID_PROGRAM_EXECUTABLE, "clCreateKernel: not built"), NULL);
    const bool any = strcmp(name, "htree_any") == 0;
    if (!any && strcmp(name, "htree_closest") != 0)
        return (cl_kernel)mock_created(code, CL_INVALID_KERNEL_NAME, NULL);
    cl_kernel kernel = (cl_kernel)mock_new(MOCK_KERNEL, sizeof *kernel, end_kernel);
    kernel->program = program;
    kernel->any = any;
    mock_lock();
    mock_hold_locked(program);
    mock_unlock();
    return (cl_kernel)mock_created(code, CL_SUCCESS, kernel);
}

MOCK_API cl_int clReleaseKernel(cl_kernel kernel) {
    return mock_release(__func__, kernel, MOCK_KERNEL, CL_INVALID_KERNEL);
}

/* Without a lock: OpenCL has none here, and two threads on one kernel are a race that TSan sees. */
MOCK_API cl_int clSetKernelArg(cl_kernel kernel, cl_uint index, size_t size, const void *value) {
    const cl_int refused = mock_enter(__func__, index);
    if (refused) return refused;
    if (!mock_is(kernel, MOCK_KERNEL))
        return mock_mistake(CL_INVALID_KERNEL, "clSetKernelArg: kernel");
    if (index >= MOCK_ARGUMENTS || !value || size != 8)
        return mock_mistake(CL_INVALID_ARG_VALUE, "clSetKernelArg: argument");
    if (index < MOCK_BUFFERS) {
        cl_mem buffer;
        memcpy(&buffer, value, sizeof buffer);
        if (!mock_is(buffer, MOCK_BUFFER)) return CL_INVALID_MEM_OBJECT;
        kernel->buffers[index] = buffer;
    } else {
        memcpy(index == MOCK_BUFFERS ? &kernel->first : &kernel->end, value, size);
    }
    kernel->set |= 1u << index;
    return CL_SUCCESS;
}

MOCK_API cl_int clGetKernelWorkGroupInfo(cl_kernel kernel, cl_device_id id,
                                         cl_kernel_work_group_info what, size_t size, void *value,
                                         size_t *size_ret) {
    const cl_int refused = mock_enter(__func__, what);
    if (refused) return refused;
    if (!mock_is(kernel, MOCK_KERNEL))
        return mock_mistake(CL_INVALID_KERNEL, "clGetKernelWorkGroupInfo: kernel");
    if (!mock_is_device(id) || what != CL_KERNEL_WORK_GROUP_SIZE) return CL_INVALID_VALUE;
    return mock_give(size, value, size_ret, &mock_now.group_limit, sizeof mock_now.group_limit);
}
