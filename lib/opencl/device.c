/* device.c: a device from its opening, by name or from the caller's own objects, to its end. */
#include "cl.h"
#include "base/sized.h"

/* The struct as version 0.1 knew it. */
enum { FIRST_OPTIONS_SIZE = sizeof(htree_cl_options) };

/* ---- Options -------------------------------------------------------------------------------- */

htree_status htree_cl_options_init(htree_cl_options *options, uint64_t size) {
    if (!options) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "options is NULL");
    if (size < FIRST_OPTIONS_SIZE || size > 65536) {
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "size is %llu: pass sizeof(htree_cl_options)",
                          (unsigned long long)size);
    }
    memset(options, 0, (size_t)size);
    options->size = (uint32_t)size;
    return HTREE_OK;
}

static htree_status read_options(const htree_cl_options *given, htree_cl_options *options) {
    HT_TRY(htree_cl_options_init(options, sizeof *options));
    if (!given) return HTREE_OK;
    if (ht_sized_read(options, sizeof *options, FIRST_OPTIONS_SIZE, given, given->size, "options"))
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0,
                          "options.size is %lu, or a field is set that this version does not know",
                          (unsigned long)given->size);
    if (options->flags & ~(uint32_t)HTREE_CL_NO_FP64) {
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "options.flags is %#lx: unknown bits",
                          (unsigned long)options->flags);
    }
    if (!options->allocator.allocate != !options->allocator.release) {
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0,
                          "options.allocator needs both allocate and release, or neither");
    }
    return HTREE_OK;
}

/* ---- Losing it ------------------------------------------------------------------------------ */

htree_status ht_cl_alive(const htree_cl *device) {
    if (!__atomic_load_n(&device->lost, __ATOMIC_RELAXED)) return HTREE_OK;
    return ht_cl_fail(HTREE_ERROR_DEVICE_LOST, CL_DEVICE_NOT_AVAILABLE,
                      "the device was lost: close it and open it again");
}

/* A lost device often says OUT_OF_RESOURCES; whether it is available tells the two apart. */
htree_status ht_cl_call(htree_cl *device, cl_int code, const char *what) {
    const htree_status status = ht_cl_check(code, what);
    if (status == HTREE_OK) return status;
    cl_bool available = CL_FALSE;
    const bool asked = code == CL_OUT_OF_RESOURCES &&
                       device->api.GetDeviceInfo(device->id, CL_DEVICE_AVAILABLE, sizeof available,
                                                 &available, NULL) == CL_SUCCESS;
    const bool lost = status == HTREE_ERROR_DEVICE_LOST || (asked && !available);
    if (!lost) return status;
    __atomic_store_n(&device->lost, 1, __ATOMIC_RELAXED);
    return ht_cl_fail(HTREE_ERROR_DEVICE_LOST, code, "%s: the device is lost (%ld)", what,
                      (long)code);
}

/* ---- Life ----------------------------------------------------------------------------------- */

static void device_end(htree_cl *device) {
    const ht_cl_api *api = &device->api;
    for (int i = 0; i < HT_CL_FILES; ++i) {
        for (int k = 0; k < HT_CL_STACKS; ++k)
            ht_cl_program_release(device, device->programs[i][k]);
    }
    while (device->log) {
        ht_cl_log *log = device->log;
        device->log = log->older;
        ht_release(&device->memory, log, log->bytes);
    }
    if (device->queue) api->ReleaseCommandQueue(device->queue);
    if (device->context) api->ReleaseContext(device->context);
    ht_memory memory = device->memory;
    ht_release(&memory, device, sizeof *device);
}

void ht_cl_retain(htree_cl *device) {
    __atomic_add_fetch(&device->users, 1, __ATOMIC_RELAXED);
}

void ht_cl_release(htree_cl *device) {
    if (__atomic_sub_fetch(&device->users, 1, __ATOMIC_ACQ_REL) == 0) device_end(device);
}

static htree_status device_new(const ht_cl_api *api, const htree_cl_options *options,
                               htree_cl **out) {
    ht_memory memory = {options->allocator, 0, 0, NULL};
    htree_cl *device = (htree_cl *)ht_allocate(&memory, sizeof *device);
    if (!device) return ht_cl_fail(HTREE_ERROR_MEMORY, 0, "out of memory");
    memset(device, 0, sizeof *device);
    device->api = *api;
    device->memory = memory;
    device->options = *options;
    device->users = 1;
    *out = device;
    return HTREE_OK;
}

/* The probe decides what the device's arithmetic is worth. */
static htree_status prove_device(htree_cl *device) {
    ht_cl_program *probe;
    device->info.exact = device->info.fp64 && !(device->options.flags & HTREE_CL_NO_FP64) &&
                         ht_cl_promises_ieee(&device->api, device->id);
    HT_TRY(ht_cl_get_program(device, HT_CL_PROBE, 0, &probe));
    device->info.group_size = (uint32_t)probe->group_size;
    return HTREE_OK;
}

static htree_status open_parts(htree_cl *device, uint32_t index) {
    const ht_cl_api *api = &device->api;
    cl_int code = CL_SUCCESS;
    HT_TRY(ht_cl_read_info(api, device->id, &device->info));
    device->info.index = index;
    if (!device->info.available) {
        return ht_cl_fail(HTREE_ERROR_DEVICE_LOST, CL_DEVICE_NOT_AVAILABLE,
                          "the device is there, but not available");
    }
    if (!device->context) {
        device->context = api->CreateContext(NULL, 1, &device->id, NULL, NULL, &code);
        HT_TRY(ht_cl_call(device, code, "clCreateContext"));
    }
    if (!device->queue) {
        device->queue =
            api->CreateCommandQueue(device->context, device->id, CL_QUEUE_PROFILING_ENABLE, &code);
        HT_TRY(ht_cl_call(device, code, "clCreateCommandQueue"));
    }
    return prove_device(device);
}

static htree_status finish_open(htree_cl *device, uint32_t index, htree_cl **out) {
    const htree_status status = open_parts(device, index);
    if (status == HTREE_OK)
        *out = device;
    else
        ht_cl_release(device);
    return status;
}

htree_status htree_cl_open(htree_cl **out, const char *name, const htree_cl_options *given) {
    htree_cl_options options;
    ht_cl_api api;
    cl_device_id id;
    uint32_t index;
    htree_cl *device;
    if (!out) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "out is NULL");
    *out = NULL;
    HT_TRY(read_options(given, &options));
    HT_TRY(ht_cl_load(&api));
    HT_TRY(ht_cl_find(&api, name, &id, &index));
    HT_TRY(device_new(&api, &options, &device));
    device->id = id;
    return finish_open(device, index, out);
}

/* Retains the caller's objects; they are checked by OpenCL, as far as it does. */
static htree_status adopt(htree_cl *device, cl_context context, cl_command_queue queue) {
    const ht_cl_api *api = &device->api;
    HT_TRY(ht_cl_call(device, api->RetainContext(context), "clRetainContext"));
    device->context = context;
    if (!queue) return HTREE_OK;
    cl_context of_queue = NULL;
    HT_TRY(ht_cl_call(device, api->RetainCommandQueue(queue), "clRetainCommandQueue"));
    device->queue = queue;
    HT_TRY(ht_cl_call(
        device, api->GetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof of_queue, &of_queue, NULL),
        "clGetCommandQueueInfo"));
    if (of_queue != context) {
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, CL_INVALID_CONTEXT,
                          "the queue belongs to another context");
    }
    return HTREE_OK;
}

htree_status htree_cl_open_context(htree_cl **out, cl_context context, cl_device_id id,
                                   cl_command_queue queue, const htree_cl_options *given) {
    htree_cl_options options;
    ht_cl_api api;
    htree_cl *device;
    if (!out) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "out is NULL");
    *out = NULL;
    if (!context || !id) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "context or device is NULL");
    HT_TRY(read_options(given, &options));
    HT_TRY(ht_cl_load(&api));
    HT_TRY(device_new(&api, &options, &device));
    device->id = id;
    const htree_status status = adopt(device, context, queue);
    if (status == HTREE_OK) return finish_open(device, HTREE_NONE, out);
    ht_cl_release(device);
    return status;
}

void htree_cl_close(htree_cl *device) {
    if (device) ht_cl_release(device);
}

/* ---- Inspect -------------------------------------------------------------------------------- */

htree_status htree_cl_get_info(const htree_cl *device, htree_cl_info *info) {
    if (!device) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "device is NULL");
    htree_cl_info known = device->info;
    known.compile_seconds =
        1e-9 * (double)__atomic_load_n(&device->compile_nanoseconds, __ATOMIC_RELAXED);
    return ht_cl_write_info(&known, info);
}

const char *htree_cl_build_log(const htree_cl *device) {
    if (!device) return "";
    const ht_cl_log *log = __atomic_load_n(&device->log, __ATOMIC_ACQUIRE);
    return log ? log->text : "";
}

htree_status htree_cl_get_objects(const htree_cl *device, cl_context *context, cl_device_id *id,
                                  cl_command_queue *queue) {
    if (!device) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "device is NULL");
    if (context) *context = device->context;
    if (id) *id = device->id;
    if (queue) *queue = device->queue;
    return HTREE_OK;
}
