/* memory.h: the only way to memory. Every tree counts what it holds and the most it ever held. */
#ifndef HT_MEMORY_H
#define HT_MEMORY_H

#include "base.h"

#define HT_ALIGNMENT 64 /* a cache line: nodes must not straddle two */

typedef struct ht_memory {
    htree_allocator hook; /* zeroed: the C library */
    uint64_t held, peak;  /* threads of a build change them at once */
} ht_memory;

/* Returns `bytes` bytes at a multiple of HT_ALIGNMENT, or NULL after recording the failure's text.
 * Zero bytes are allowed and give memory that may be released. */
void *ht_allocate(ht_memory *memory, uint64_t bytes);

/* NULL is allowed. */
void ht_release(ht_memory *memory, void *block, uint64_t bytes);

#endif
