/* loader.c: finds OpenCL at run time, so that the library loads where there is none. */
#include "cl.h"

#include <dlfcn.h>

static const char *const libraries[] = {
#ifdef __APPLE__
    "/System/Library/Frameworks/OpenCL.framework/OpenCL",
#endif
    "libOpenCL.so.1",
    "libOpenCL.so",
};

htree_status ht_cl_load(ht_cl_api *api) {
    void *library = NULL;
    for (size_t i = 0; !library && i < sizeof libraries / sizeof *libraries; ++i) {
        /* Drivers do not survive being unloaded. */
        library = dlopen(libraries[i], RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    }
    if (!library) {
        return ht_cl_fail(HTREE_ERROR_NO_DEVICE, 0,
                          "no OpenCL on this machine: install an ICD loader (ocl-icd-libopencl1) "
                          "and a driver (pocl-opencl-icd for the CPU)");
    }
    /* A pointer to data becomes one to a function by its bytes: C has no cast for it. */
#define FIND(name)                                                                                 \
    {                                                                                              \
        void *found = dlsym(library, "cl" #name);                                                  \
        memcpy(&api->name, &found, sizeof found);                                                  \
        if (!found) {                                                                              \
            dlclose(library);                                                                      \
            return ht_cl_fail(HTREE_ERROR_NO_DEVICE, 0, "the OpenCL library lacks cl" #name);      \
        }                                                                                          \
    }
    HT_CL_FUNCTIONS(FIND)
#undef FIND
    dlclose(library);
    return HTREE_OK;
}
