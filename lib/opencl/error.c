/* error.c: the text and the code of the last failure, and what OpenCL's codes mean here. */
#include "cl.h"

#include <stdarg.h>
#include <stdio.h>

static __thread char error_text[512];
static __thread cl_int error_code;

htree_status ht_cl_fail(htree_status status, cl_int code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error_text, sizeof error_text, format, arguments);
    va_end(arguments);
    error_code = code;
    return status;
}

const char *htree_cl_error_text(void) {
    return error_text;
}

int32_t htree_cl_error_code(void) {
    return error_code;
}

static const struct {
    cl_int code;
    htree_status status;
    const char *meaning;
} codes[] = {
    {CL_DEVICE_NOT_FOUND, HTREE_ERROR_NO_DEVICE, "there is no such device"},
    {-1001 /* CL_PLATFORM_NOT_FOUND_KHR */, HTREE_ERROR_NO_DEVICE,
     "there is no OpenCL driver: install one, for the CPU pocl-opencl-icd"},
    {CL_DEVICE_NOT_AVAILABLE, HTREE_ERROR_DEVICE_LOST, "the device is not available"},
    {CL_COMPILER_NOT_AVAILABLE, HTREE_ERROR_KERNEL, "the device has no compiler"},
    {CL_BUILD_PROGRAM_FAILURE, HTREE_ERROR_KERNEL,
     "the device's compiler refused a kernel: see htree_cl_build_log"},
    {CL_INVALID_BUILD_OPTIONS, HTREE_ERROR_KERNEL, "the device's compiler refused its options"},
    {CL_INVALID_BINARY, HTREE_ERROR_KERNEL, "the driver's cache of kernels is broken: clear it"},
    {CL_INVALID_PROGRAM_EXECUTABLE, HTREE_ERROR_KERNEL, "the driver made no kernel"},
    {CL_INVALID_KERNEL_NAME, HTREE_ERROR_KERNEL, "the driver lost a kernel"},
    {CL_MEM_OBJECT_ALLOCATION_FAILURE, HTREE_ERROR_MEMORY, "the device is out of memory"},
    {CL_OUT_OF_RESOURCES, HTREE_ERROR_MEMORY, "the device is out of resources"},
    {CL_OUT_OF_HOST_MEMORY, HTREE_ERROR_MEMORY, "the driver is out of memory"},
    {CL_INVALID_BUFFER_SIZE, HTREE_ERROR_MEMORY, "the device takes no buffer of this size"},
};

htree_status ht_cl_check(cl_int code, const char *what) {
    if (code == CL_SUCCESS) return HTREE_OK;
    for (size_t i = 0; i < sizeof codes / sizeof *codes; ++i) {
        if (codes[i].code == code) {
            return ht_cl_fail(codes[i].status, code, "%s: %s (%ld)", what, codes[i].meaning,
                              (long)code);
        }
    }
    return ht_cl_fail(HTREE_ERROR_DEVICE, code, "%s failed (%ld)", what, (long)code);
}
