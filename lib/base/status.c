/* status.c: version, status names, and the text of the last failure, the library's only global. */
#include "base.h"

#include <stdarg.h>
#include <stdio.h>

static __thread char error_text[256];

htree_status ht_fail(htree_status status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error_text, sizeof error_text, format, arguments);
    va_end(arguments);
    return status;
}

const char *htree_error_text(void) {
    return error_text;
}

const char *htree_status_name(htree_status status) {
    switch (status) {
    case HTREE_OK: return "ok";
    case HTREE_ERROR_ARGUMENT: return "bad argument";
    case HTREE_ERROR_MEMORY: return "out of memory";
    case HTREE_ERROR_LIMIT: return "limit exceeded";
    case HTREE_ERROR_GEOMETRY: return "bad geometry";
    case HTREE_ERROR_CANCELLED: return "cancelled";
    case HTREE_ERROR_UNSUPPORTED: return "unsupported";
    case HTREE_ERROR_CORRUPT: return "corrupt tree";
    case HTREE_ERROR_NO_DEVICE: return "no such device";
    case HTREE_ERROR_DEVICE: return "device failed";
    case HTREE_ERROR_DEVICE_LOST: return "device lost";
    case HTREE_ERROR_KERNEL: return "kernel refused";
    default: return "unknown status";
    }
}

uint32_t htree_version(void) {
    return HTREE_VERSION_MAJOR * 10000 + HTREE_VERSION_MINOR * 100 + HTREE_VERSION_PATCH;
}
