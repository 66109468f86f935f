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
    memory->held += bytes;
    if (memory->held > memory->peak) memory->peak = memory->held;
    return block;
}

void ht_release(ht_memory *memory, void *block, uint64_t bytes) {
    if (!block) return;
    if (bytes == 0) bytes = HT_ALIGNMENT;
    memory->held -= bytes;
    if (memory->hook.release) {
        memory->hook.release(memory->hook.user, block, bytes);
    } else {
        free(block);
    }
}
