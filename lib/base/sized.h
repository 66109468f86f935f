/* sized.h: structs that begin with their size, so that they can grow without breaking the ABI. */
#ifndef HT_SIZED_H
#define HT_SIZED_H

#include "base.h"

/* Copies a struct of `size` bytes into one of `known` bytes, which holds defaults already. A
 * smaller struct than the first version's is refused, and so is a larger one whose extra bytes are
 * not 0: it asks for something that this library does not know. */
HT_INLINE htree_status ht_sized_read(void *known_struct, uint64_t known, uint64_t first_version,
                                     const void *given, uint64_t size, const char *what) {
    if (size < first_version || size > 65536) {
        return ht_fail(HTREE_ERROR_ARGUMENT,
                       "%s.size is %llu: write it with the struct's init function", what,
                       (unsigned long long)size);
    }
    for (uint64_t i = known; i < size; ++i) {
        if (((const char *)given)[i] != 0) {
            return ht_fail(HTREE_ERROR_ARGUMENT,
                           "%s sets a field that this version of the library does not know", what);
        }
    }
    memcpy(known_struct, given, (size_t)(size < known ? size : known));
    return HTREE_OK;
}

/* For a struct that a call fills: the caller has set its size. */
HT_INLINE htree_status ht_sized_verify(uint32_t size, uint64_t first_version, const char *what) {
    if (size >= first_version && size <= 65536) return HTREE_OK;
    return ht_fail(HTREE_ERROR_ARGUMENT, "%s.size is %lu: set it to sizeof(htree_%s)", what,
                   (unsigned long)size, what);
}

/* Fills it with as much of the `known` bytes as it holds, and with zeros; its size stays. */
HT_INLINE void ht_sized_write(void *out, const void *known_struct, uint64_t known) {
    uint32_t size;
    memcpy(&size, out, sizeof size);
    memset(out, 0, size);
    memcpy(out, known_struct, (size_t)(size < known ? size : known));
    memcpy(out, &size, sizeof size);
}

#endif
