/* lacking.c: a libOpenCL.so.1 that lacks all but its first function, as a broken installation
 * may. */
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

__attribute__((visibility("default"))) cl_int clGetPlatformIDs(cl_uint room, cl_platform_id *out,
                                                               cl_uint *count) {
    (void)room;
    (void)out;
    if (count) *count = 0;
    return CL_SUCCESS;
}
