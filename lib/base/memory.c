#include "memory.h"

#include <stdlib.h>

static void *allocate_from_libc(uint64_t bytes) {
    void *block = NULL;
    if (bytes > SIZE_MAX) return NULL;
    return posix_memalign(&block, HT_ALIGNMENT, (size_t)bytes) == 0 ? block : NULL;
}

void *ht_allocate(ht_memory *memory, uint64_t bytes) {
    if (bytes == 0) bytes = HT_ALIGNMENT;
    void *block = memory->hook.allocate
                      ? memory->hook.allocate(memory->hook.user, bytes, HT_ALIGNMENT)
                      : allocate_from_libc(bytes);
    if (!block) {
        ht_fail(HTREE_ERROR_MEMORY, "out of memory: %llu bytes refused", (unsigned long long)bytes);
        return NULL;
    }
    const uint64_t held = __atomic_add_fetch(&memory->held, bytes, __ATOMIC_RELAXED);
    uint64_t peak = __atomic_load_n(&memory->peak, __ATOMIC_RELAXED);
    while (held > peak && !__atomic_compare_exchange_n(&memory->peak, &peak, held, true,
                                                       __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
    return block;
}

void ht_release(ht_memory *memory, void *block, uint64_t bytes) {
    if (!block) return;
    if (bytes == 0) bytes = HT_ALIGNMENT;
    __atomic_sub_fetch(&memory->held, bytes, __ATOMIC_RELAXED);
    if (memory->hook.release) {
        memory->hook.release(memory->hook.user, block, bytes);
    } else {
        free(block);
    }
}
