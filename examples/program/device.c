#include "device.h"

#include <string.h>

#ifdef HAVE_OPENCL

#include "htree_cl.h"

static bool fail(char *error, size_t size, const char *advice) {
    snprintf(error, size, "%s%s", htree_cl_error_text(), advice);
    return false;
}

static const char *type_name(uint64_t type) {
    return type & CL_DEVICE_TYPE_GPU           ? "GPU"
           : type & CL_DEVICE_TYPE_CPU         ? "CPU"
           : type & CL_DEVICE_TYPE_ACCELERATOR ? "accelerator"
                                               : "other";
}

static double gibibytes(uint64_t bytes) {
    return (double)bytes / (1024.0 * 1024.0 * 1024.0);
}

struct htree_cl *device_open(const char *name, char *error, size_t size) {
    htree_cl *device = NULL;
    const char *wanted = strcmp(name, "default") == 0 ? NULL : name;
    const htree_status status = htree_cl_open(&device, wanted, NULL);
    uint32_t count = 0;
    if (status == HTREE_OK) return device;
    const bool another = status == HTREE_ERROR_NO_DEVICE && wanted;
    char text[256];
    snprintf(text, sizeof text, "%s", htree_cl_error_text());
    const bool some = another && htree_cl_get_device_count(&count) == HTREE_OK;
    snprintf(error, size, "%s%s", text, some ? "; --list-devices prints them" : "");
    return NULL;
}

void device_close(struct htree_cl *device) {
    htree_cl_close(device);
}

static htree_cl_info read_info(struct htree_cl *device) {
    htree_cl_info info;
    memset(&info, 0, sizeof info);
    info.size = sizeof info;
    htree_cl_get_info(device, &info);
    return info;
}

void device_describe(struct htree_cl *device, char *out, size_t size) {
    const htree_cl_info info = read_info(device);
    snprintf(out, size, "%s (%s), %s, %u unit%s, %.1f GiB, %s", info.device, info.platform,
             type_name(info.type), (unsigned)info.compute_units, info.compute_units == 1 ? "" : "s",
             gibibytes(info.memory_bytes),
             info.exact ? "same bits as the CPU" : "not the CPU's bits: t within 2^-16");
}

bool device_exact(struct htree_cl *device) {
    return read_info(device).exact != 0;
}

double device_compile_seconds(struct htree_cl *device) {
    return read_info(device).compile_seconds;
}

bool device_list(FILE *out, char *error, size_t size) {
    uint32_t count = 0;
    if (htree_cl_get_device_count(&count) != HTREE_OK) return fail(error, size, "");
    fprintf(out, "%5s  %-11s %5s %9s %5s  %s\n", "index", "type", "units", "memory", "fp64",
            "device, platform");
    for (uint32_t i = 0; i < count; ++i) {
        htree_cl_info info;
        info.size = sizeof info;
        if (htree_cl_get_device_info(i, &info) != HTREE_OK) return fail(error, size, "");
        fprintf(out, "%5u  %-11s %5u %5.1f GiB %5s  %s, %s%s\n", (unsigned)i, type_name(info.type),
                (unsigned)info.compute_units, gibibytes(info.memory_bytes),
                info.fp64 ? "yes" : "no", info.device, info.platform,
                info.available ? "" : " (not available)");
    }
    return true;
}

#else

static bool fail(char *error, size_t size) {
    snprintf(error, size,
             "this build has no OpenCL: install its headers (apt-get install opencl-headers) and "
             "build again");
    return false;
}

struct htree_cl *device_open(const char *name, char *error, size_t size) {
    (void)name;
    fail(error, size);
    return NULL;
}

void device_close(struct htree_cl *device) {
    (void)device;
}

void device_describe(struct htree_cl *device, char *out, size_t size) {
    (void)device;
    snprintf(out, size, "none");
}

bool device_exact(struct htree_cl *device) {
    (void)device;
    return false;
}

double device_compile_seconds(struct htree_cl *device) {
    (void)device;
    return 0;
}

bool device_list(FILE *out, char *error, size_t size) {
    (void)out;
    return fail(error, size);
}

#endif
