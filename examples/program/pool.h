/* pool.h: memory that is kept from one build to the next, through the allocator hook.
 *
 * A fresh page costs the kernel more than a builder needs to fill it, so a program that builds
 * a tree for every frame keeps what the last tree gave back. Not for several threads at once. */
#ifndef POOL_H
#define POOL_H

#include "htree.h"

enum { POOL_BLOCKS = 256 };

typedef struct pool {
    struct {
        void *memory;
        uint64_t bytes;
        int in_use;
    } block[POOL_BLOCKS];
    int count;
} pool;

/* The hook of a pool that starts as all zeros. The pool must outlive every tree built through
 * it. */
htree_allocator pool_allocator(pool *p);

/* Gives everything back; no tree may be left. */
void pool_free(pool *p);

#endif
