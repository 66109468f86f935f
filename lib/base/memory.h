/* memory.h: the only way to memory. Every tree counts what it holds and the most it ever held. */
#ifndef HT_MEMORY_H
#define HT_MEMORY_H

#include "base.h"

#define HT_ALIGNMENT 64 /* a cache line: nodes must not straddle two */

/* Blocks that are kept for the next build of a tree that is built again and again: fresh memory
 * costs more than to fill it. */
typedef struct ht_recycler ht_recycler;

typedef struct ht_memory {
    htree_allocator hook;  /* zeroed: the C library */
    uint64_t held, peak;   /* threads of a build change them at once */
    ht_recycler *recycler; /* NULL: everything goes back at once */
} ht_memory;

/* Returns `bytes` bytes at a multiple of HT_ALIGNMENT, or NULL after recording the failure's text.
 * Zero bytes are allowed and give memory that may be released. */
void *ht_allocate(ht_memory *memory, uint64_t bytes);

/* NULL is allowed. */
void ht_release(ht_memory *memory, void *block, uint64_t bytes);

/* From now on keeps what is released; NULL after recording the failure's text. */
ht_recycler *ht_recycler_begin(ht_memory *memory);

/* Gives back what lay idle since the last call of this, so that no more is kept than two builds
 * need. */
void ht_recycler_tidy(ht_memory *memory);

/* Gives everything back; all blocks must have been released. */
void ht_recycler_end(ht_memory *memory);

#endif
