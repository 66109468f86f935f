/* info.c: the devices there are, by index and by name, and what OpenCL says of each. */
#include "cl.h"
#include "base/sized.h"

#include <stdio.h>

enum { MAX_PLATFORMS = 32, MAX_DEVICES = 64 };

/* ---- One device ----------------------------------------------------------------------------- */

/* Cuts a driver's text to the size of its place. */
static void copy_text(char *out, size_t size, const char *text) {
    size_t length = 0;
    while (length < size - 1 && text[length]) ++length;
    memcpy(out, text, length);
    out[length] = 0;
}

static htree_status read_text(const ht_cl_api *api, cl_device_id id, cl_device_info what, char *out,
                              size_t size) {
    char text[1024];
    size_t length = 0;
    memset(text, 0, sizeof text);
    const cl_int code = api->GetDeviceInfo(id, what, sizeof text - 1, text, &length);
    HT_TRY(ht_cl_check(code, "clGetDeviceInfo"));
    copy_text(out, size, text);
    return HTREE_OK;
}

static htree_status read_number(const ht_cl_api *api, cl_device_id id, cl_device_info what,
                                void *number, size_t size) {
    memset(number, 0, size);
    return ht_cl_check(api->GetDeviceInfo(id, what, size, number, NULL), "clGetDeviceInfo");
}

static htree_status read_numbers(const ht_cl_api *api, cl_device_id id, htree_cl_info *info) {
    cl_bool available, unified;
    cl_uint units;
    cl_ulong memory, buffer;
    cl_device_type type;
    cl_device_fp_config fp64;
    HT_TRY(read_number(api, id, CL_DEVICE_TYPE, &type, sizeof type));
    HT_TRY(read_number(api, id, CL_DEVICE_AVAILABLE, &available, sizeof available));
    HT_TRY(read_number(api, id, CL_DEVICE_HOST_UNIFIED_MEMORY, &unified, sizeof unified));
    HT_TRY(read_number(api, id, CL_DEVICE_MAX_COMPUTE_UNITS, &units, sizeof units));
    HT_TRY(read_number(api, id, CL_DEVICE_GLOBAL_MEM_SIZE, &memory, sizeof memory));
    HT_TRY(read_number(api, id, CL_DEVICE_MAX_MEM_ALLOC_SIZE, &buffer, sizeof buffer));
    HT_TRY(read_number(api, id, CL_DEVICE_DOUBLE_FP_CONFIG, &fp64, sizeof fp64));
    info->type = type;
    info->available = available != CL_FALSE;
    info->shares_memory = unified != CL_FALSE;
    info->compute_units = units;
    info->memory_bytes = memory;
    info->buffer_bytes = buffer;
    info->fp64 = fp64 != 0;
    return HTREE_OK;
}

htree_status ht_cl_read_info(const ht_cl_api *api, cl_device_id id, htree_cl_info *info) {
    char version[60], driver[60];
    cl_platform_id platform;
    memset(info, 0, sizeof *info);
    info->size = sizeof *info;
    info->index = HTREE_NONE;
    HT_TRY(read_number(api, id, CL_DEVICE_PLATFORM, &platform, sizeof platform));
    char name[1024];
    memset(name, 0, sizeof name);
    HT_TRY(
        ht_cl_check(api->GetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof name - 1, name, NULL),
                    "clGetPlatformInfo"));
    copy_text(info->platform, sizeof info->platform, name);
    HT_TRY(read_text(api, id, CL_DEVICE_NAME, info->device, sizeof info->device));
    HT_TRY(read_text(api, id, CL_DEVICE_VERSION, version, sizeof version));
    HT_TRY(read_text(api, id, CL_DRIVER_VERSION, driver, sizeof driver));
    snprintf(info->version, sizeof info->version, "%s, driver %s", version, driver);
    return read_numbers(api, id, info);
}

/* The struct as version 0.1 knew it. */
enum { FIRST_INFO_SIZE = sizeof(htree_cl_info) };

htree_status ht_cl_write_info(const htree_cl_info *known, htree_cl_info *info) {
    if (!info) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "info is NULL");
    if (ht_sized_verify(info->size, FIRST_INFO_SIZE, "cl_info")) {
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0,
                          "info.size is %lu: set it to sizeof(htree_cl_info)",
                          (unsigned long)info->size);
    }
    ht_sized_write(info, known, sizeof *known);
    return HTREE_OK;
}

/* Rounding to nearest, denormals, infinities and NaN, of float and double alike. Division may be
 * less than that: kernels divide in double. */
bool ht_cl_promises_ieee(const ht_cl_api *api, cl_device_id id) {
    const cl_device_fp_config wanted = CL_FP_DENORM | CL_FP_INF_NAN | CL_FP_ROUND_TO_NEAREST;
    cl_device_fp_config fp32, fp64;
    return read_number(api, id, CL_DEVICE_SINGLE_FP_CONFIG, &fp32, sizeof fp32) == HTREE_OK &&
           read_number(api, id, CL_DEVICE_DOUBLE_FP_CONFIG, &fp64, sizeof fp64) == HTREE_OK &&
           (fp32 & wanted) == wanted && (fp64 & wanted) == wanted;
}

/* ---- All devices ---------------------------------------------------------------------------- */

typedef struct device_list {
    cl_device_id id[MAX_DEVICES];
    uint32_t count;
} device_list;

/* Platforms without devices are no failure. */
static htree_status list_devices(const ht_cl_api *api, device_list *list) {
    cl_platform_id platforms[MAX_PLATFORMS];
    cl_uint platform_count = 0;
    list->count = 0;
    HT_TRY(ht_cl_check(api->GetPlatformIDs(MAX_PLATFORMS, platforms, &platform_count),
                       "clGetPlatformIDs"));
    for (cl_uint i = 0; i < platform_count && i < MAX_PLATFORMS; ++i) {
        const uint32_t room = MAX_DEVICES - list->count;
        cl_uint found = 0;
        if (room == 0) break;
        const cl_int code = api->GetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, room,
                                              list->id + list->count, &found);
        if (code == CL_DEVICE_NOT_FOUND) continue;
        HT_TRY(ht_cl_check(code, "clGetDeviceIDs"));
        list->count += found < room ? found : room;
    }
    if (list->count == 0) {
        return ht_cl_fail(HTREE_ERROR_NO_DEVICE, CL_DEVICE_NOT_FOUND,
                          "OpenCL is here, but no device: install a driver, for the CPU "
                          "pocl-opencl-icd");
    }
    return HTREE_OK;
}

static char lower(char c) {
    return c >= 'A' && c <= 'Z' ? (char)(c + ('a' - 'A')) : c;
}

static bool contains(const char *text, const char *part) {
    for (; *text; ++text) {
        size_t i = 0;
        while (part[i] && lower(text[i]) == lower(part[i])) ++i;
        if (!part[i]) return true;
    }
    return false;
}

/* Digits alone are an index; HTREE_NONE if the name is none. */
static uint32_t index_of(const char *name) {
    uint32_t index = 0;
    for (const char *c = name; *c; ++c) {
        if (*c < '0' || *c > '9' || index > 1000) return HTREE_NONE;
        index = 10 * index + (uint32_t)(*c - '0');
    }
    return *name ? index : HTREE_NONE;
}

static bool is_wanted(const htree_cl_info *info, const char *name, uint32_t index) {
    const uint32_t wanted = index_of(name);
    if (wanted != HTREE_NONE) return index == wanted;
    return contains(info->platform, name) || contains(info->device, name) ||
           contains(info->version, name);
}

htree_status ht_cl_find(const ht_cl_api *api, const char *name, cl_device_id *id, uint32_t *index) {
    device_list list;
    bool found = false;
    HT_TRY(list_devices(api, &list));
    for (uint32_t i = 0; i < list.count; ++i) {
        htree_cl_info info;
        HT_TRY(ht_cl_read_info(api, list.id[i], &info));
        const bool better = !found || (info.type & CL_DEVICE_TYPE_GPU);
        if (name ? is_wanted(&info, name, i) : better) {
            *id = list.id[i];
            *index = i;
            found = true;
            if (name || (info.type & CL_DEVICE_TYPE_GPU)) break;
        }
    }
    if (!found) {
        return ht_cl_fail(HTREE_ERROR_NO_DEVICE, CL_DEVICE_NOT_FOUND,
                          "no OpenCL device is called \"%.64s\": there are %lu", name ? name : "",
                          (unsigned long)list.count);
    }
    return HTREE_OK;
}

/* ---- Public --------------------------------------------------------------------------------- */

htree_status htree_cl_get_device_count(uint32_t *count) {
    ht_cl_api api;
    device_list list;
    if (!count) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "count is NULL");
    *count = 0;
    HT_TRY(ht_cl_load(&api));
    HT_TRY(list_devices(&api, &list));
    *count = list.count;
    return HTREE_OK;
}

htree_status htree_cl_get_device_info(uint32_t index, htree_cl_info *info) {
    ht_cl_api api;
    device_list list;
    htree_cl_info found;
    if (!info) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "info is NULL");
    HT_TRY(ht_cl_load(&api));
    HT_TRY(list_devices(&api, &list));
    if (index >= list.count) {
        return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "index is %lu: there are %lu devices",
                          (unsigned long)index, (unsigned long)list.count);
    }
    HT_TRY(ht_cl_read_info(&api, list.id[index], &found));
    found.index = index;
    return ht_cl_write_info(&found, info);
}
