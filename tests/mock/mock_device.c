/* mock_device.c: platforms, devices, contexts. */
#include "mock_inner.h"

enum { MOST = 4 };

static struct _cl_platform_id platforms[MOST] = {{0}, {1}, {2}, {3}};
#define DEVICES_OF(p)                                                                              \
    { {&platforms[p], 0}, {&platforms[p], 1}, {&platforms[p], 2}, {&platforms[p], 3}, }
static struct _cl_device_id devices[MOST][MOST] = {DEVICES_OF(0), DEVICES_OF(1), DEVICES_OF(2),
                                                   DEVICES_OF(3)};

static bool is_platform(cl_platform_id id) {
    for (uint32_t i = 0; i < mock_now.platforms; ++i) {
        if (id == &platforms[i]) return true;
    }
    return false;
}

bool mock_is_device(cl_device_id id) {
    for (uint32_t i = 0; i < mock_now.platforms; ++i) {
        for (uint32_t k = 0; k < mock_now.devices; ++k) {
            if (id == &devices[i][k]) return true;
        }
    }
    return false;
}

/* ---- Platforms ------------------------------------------------------------------------------ */

MOCK_API cl_int clGetPlatformIDs(cl_uint room, cl_platform_id *out, cl_uint *count) {
    const cl_int refused = mock_enter(__func__, 0);
    if (refused) return refused;
    if (count) *count = mock_now.platforms;
    for (cl_uint i = 0; out && i < room && i < mock_now.platforms; ++i) out[i] = &platforms[i];
    return mock_now.platforms ? CL_SUCCESS : -1001; /* CL_PLATFORM_NOT_FOUND_KHR */
}

MOCK_API cl_int clGetPlatformInfo(cl_platform_id id, cl_platform_info what, size_t size,
                                  void *value, size_t *size_ret) {
    const cl_int refused = mock_enter(__func__, what);
    if (refused) return refused;
    if (!is_platform(id)) return mock_mistake(CL_INVALID_PLATFORM, "clGetPlatformInfo: platform");
    if (what != CL_PLATFORM_NAME) return CL_INVALID_VALUE;
    return mock_give_text(size, value, size_ret, "Mock Platform");
}

/* ---- Devices -------------------------------------------------------------------------------- */

MOCK_API cl_int clGetDeviceIDs(cl_platform_id id, cl_device_type type, cl_uint room,
                               cl_device_id *out, cl_uint *count) {
    const cl_int refused = mock_enter(__func__, type);
    if (refused) return refused;
    if (!is_platform(id)) return mock_mistake(CL_INVALID_PLATFORM, "clGetDeviceIDs: platform");
    const bool any = (type & mock_now.type) && mock_now.devices > 0;
    if (count) *count = any ? mock_now.devices : 0;
    for (cl_uint i = 0; any && out && i < room && i < mock_now.devices; ++i)
        out[i] = &devices[id->index][i];
    return any ? CL_SUCCESS : CL_DEVICE_NOT_FOUND;
}

static cl_int give_number(cl_device_info what, size_t size, void *value, size_t *size_ret) {
    const cl_bool available = mock_now.available, unified = mock_now.unified;
    const cl_uint units = 2;
    const cl_device_fp_config usual = CL_FP_INF_NAN | CL_FP_ROUND_TO_NEAREST;
    const cl_device_fp_config fp32 = usual | (mock_now.denormals ? CL_FP_DENORM : 0);
    const cl_device_fp_config fp64 = mock_now.fp64 ? usual | CL_FP_DENORM | CL_FP_FMA : 0;
#define GIVE(number) mock_give(size, value, size_ret, &(number), sizeof(number))
    switch (what) {
    case CL_DEVICE_TYPE: return GIVE(mock_now.type);
    case CL_DEVICE_AVAILABLE: return GIVE(available);
    case CL_DEVICE_HOST_UNIFIED_MEMORY: return GIVE(unified);
    case CL_DEVICE_MAX_COMPUTE_UNITS: return GIVE(units);
    case CL_DEVICE_GLOBAL_MEM_SIZE: return GIVE(mock_now.memory_bytes);
    case CL_DEVICE_MAX_MEM_ALLOC_SIZE: return GIVE(mock_now.buffer_bytes);
    case CL_DEVICE_SINGLE_FP_CONFIG: return GIVE(fp32);
    case CL_DEVICE_DOUBLE_FP_CONFIG: return GIVE(fp64);
    default: return mock_mistake(CL_INVALID_VALUE, "clGetDeviceInfo: a parameter it knows not");
    }
#undef GIVE
}

MOCK_API cl_int clGetDeviceInfo(cl_device_id id, cl_device_info what, size_t size, void *value,
                                size_t *size_ret) {
    const cl_int refused = mock_enter(__func__, what);
    if (refused) return refused;
    if (!mock_is_device(id)) return mock_mistake(CL_INVALID_DEVICE, "clGetDeviceInfo: device");
    switch (what) {
    case CL_DEVICE_PLATFORM:
        return mock_give(size, value, size_ret, &id->platform, sizeof id->platform);
    case CL_DEVICE_NAME: return mock_give_text(size, value, size_ret, "Mock Device");
    case CL_DEVICE_VERSION: return mock_give_text(size, value, size_ret, "OpenCL 1.2 mock");
    case CL_DRIVER_VERSION: return mock_give_text(size, value, size_ret, "1.0");
    default: return give_number(what, size, value, size_ret);
    }
}

/* ---- Contexts ------------------------------------------------------------------------------- */

MOCK_API cl_context clCreateContext(const cl_context_properties *properties, cl_uint count,
                                    const cl_device_id *ids,
                                    void(CL_CALLBACK *notify)(const char *, const void *, size_t,
                                                              void *),
                                    void *user, cl_int *code) {
    (void)properties;
    (void)notify;
    (void)user;
    const cl_int refused = mock_enter(__func__, 0);
    if (refused) return (cl_context)mock_created(code, refused, NULL);
    if (count != 1 || !ids || !mock_is_device(ids[0]))
        return (cl_context)mock_created(
            code, mock_mistake(CL_INVALID_DEVICE, "clCreateContext: device"), NULL);
    cl_context context = (cl_context)mock_new(MOCK_CONTEXT, sizeof *context, NULL);
    context->device = ids[0];
    return (cl_context)mock_created(code, CL_SUCCESS, context);
}

MOCK_API cl_int clRetainContext(cl_context context) {
    return mock_retain(__func__, context, MOCK_CONTEXT, CL_INVALID_CONTEXT);
}

MOCK_API cl_int clReleaseContext(cl_context context) {
    return mock_release(__func__, context, MOCK_CONTEXT, CL_INVALID_CONTEXT);
}

MOCK_API cl_int clGetContextInfo(cl_context context, cl_context_info what, size_t size, void *value,
                                 size_t *size_ret) {
    const cl_int refused = mock_enter(__func__, what);
    const cl_uint one = 1;
    if (refused) return refused;
    if (!mock_is(context, MOCK_CONTEXT)) return CL_INVALID_CONTEXT;
    switch (what) {
    case CL_CONTEXT_NUM_DEVICES: return mock_give(size, value, size_ret, &one, sizeof one);
    case CL_CONTEXT_DEVICES:
        return mock_give(size, value, size_ret, &context->device, sizeof context->device);
    default: return CL_INVALID_VALUE;
    }
}
