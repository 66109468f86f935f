#include "pool.h"

#include <stdlib.h>

static void *take(pool *p, int i) {
    p->block[i].in_use = 1;
    return p->block[i].memory;
}

/* The free block that fits best, unless it wastes half of itself. */
static int find_block(const pool *p, uint64_t bytes) {
    int best = -1;
    for (int i = 0; i < p->count; ++i) {
        const uint64_t size = p->block[i].bytes;
        if (p->block[i].in_use || size < bytes || size / 2 > bytes) continue;
        if (best < 0 || size < p->block[best].bytes) best = i;
    }
    return best;
}

static void *pool_allocate(void *user, uint64_t bytes, uint64_t alignment) {
    pool *p = (pool *)user;
    const int found = find_block(p, bytes);
    void *memory = NULL;
    if (found >= 0) return take(p, found);
    if (posix_memalign(&memory, (size_t)alignment, (size_t)bytes) != 0) return NULL;
    /* A full table is no failure: the block is given back to the system when it is released. */
    if (p->count < POOL_BLOCKS) {
        p->block[p->count].memory = memory;
        p->block[p->count].bytes = bytes;
        return take(p, p->count++);
    }
    return memory;
}

static void pool_release(void *user, void *memory, uint64_t bytes) {
    pool *p = (pool *)user;
    (void)bytes;
    for (int i = 0; i < p->count; ++i) {
        if (p->block[i].memory == memory) {
            p->block[i].in_use = 0;
            return;
        }
    }
    free(memory);
}

htree_allocator pool_allocator(pool *p) {
    const htree_allocator hook = {pool_allocate, pool_release, p};
    return hook;
}

void pool_free(pool *p) {
    for (int i = 0; i < p->count; ++i) free(p->block[i].memory);
    p->count = 0;
}
