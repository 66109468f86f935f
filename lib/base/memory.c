#ifdef __linux__
#define _DEFAULT_SOURCE 1 /* for madvise */
#endif
#include "memory.h"

#include <stdlib.h>
#ifdef __linux__
#include <sys/mman.h>
#endif

enum {
    LARGE_PAGE = 1 << 21,  /* bytes */
    LEAST_PAGED = 1 << 24, /* of a block that is worth the rest of its last large page */
    LEAST_KEPT = 1 << 14   /* smaller blocks are cheap */
};

/* A large block by large pages, where the system has them: to get its pages one by one takes as long
 * as to fill them. */
static void *allocate_from_libc(uint64_t bytes) {
    const bool large = bytes >= LEAST_PAGED;
    void *block = NULL;
    if (bytes > SIZE_MAX) return NULL;
    if (posix_memalign(&block, large ? LARGE_PAGE : HT_ALIGNMENT, (size_t)bytes) != 0) return NULL;
#ifdef MADV_HUGEPAGE
    if (large) (void)madvise(block, (size_t)bytes, MADV_HUGEPAGE);
#endif
    return block;
}

static void *allocate_fresh(ht_memory *memory, uint64_t bytes) {
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

static void give_back(ht_memory *memory, void *block, uint64_t bytes) {
    __atomic_sub_fetch(&memory->held, bytes, __ATOMIC_RELAXED);
    if (memory->hook.release) {
        memory->hook.release(memory->hook.user, block, bytes);
    } else {
        free(block);
    }
}

/* ---- Recycling ------------------------------------------------------------------------------ */

enum { KEPT_BLOCKS = 320 /* 64 parts of a tree keep four each */ };

typedef struct kept_block {
    void *block; /* NULL: the row is free */
    uint64_t bytes;
    bool in_use, used; /* used: since the last tidying */
} kept_block;

struct ht_recycler {
    uint32_t locked; /* for some hundred comparisons */
    uint32_t rows;   /* those behind were never used */
    kept_block row[KEPT_BLOCKS];
};

static void lock(ht_recycler *r) {
    while (__atomic_exchange_n(&r->locked, 1, __ATOMIC_ACQUIRE)) {
    }
}

static void unlock(ht_recycler *r) {
    __atomic_store_n(&r->locked, 0, __ATOMIC_RELEASE);
}

/* The row of a block, or the first free one for NULL; r->rows if there is none. */
static uint32_t find_row(const ht_recycler *r, const void *block) {
    uint32_t i = 0;
    while (i < r->rows && r->row[i].block != block) ++i;
    return i;
}

/* The tightest idle block of enough bytes, unless more than half of it would stay idle. */
static void *reuse(ht_recycler *r, uint64_t bytes) {
    kept_block *best = NULL;
    lock(r);
    for (uint32_t i = 0; i < r->rows; ++i) {
        kept_block *row = &r->row[i];
        if (!row->block || row->in_use || row->bytes < bytes || row->bytes / 2 > bytes) continue;
        if (!best || row->bytes < best->bytes) best = row;
    }
    if (best) best->in_use = best->used = true;
    unlock(r);
    return best ? best->block : NULL;
}

/* The smallest idle block that is smaller than so many bytes; r->rows if there is none. */
static uint32_t find_smaller(const ht_recycler *r, uint64_t bytes) {
    uint32_t best = r->rows;
    for (uint32_t i = 0; i < r->rows; ++i) {
        const kept_block *row = &r->row[i];
        if (row->in_use || row->bytes >= (best < r->rows ? r->row[best].bytes : bytes)) continue;
        best = i;
    }
    return best;
}

/* Where a new block goes: a free row, or that of a smaller block, which takes less time to get again;
 * r->rows if there is none. */
static uint32_t make_row(ht_recycler *r, uint64_t bytes) {
    const uint32_t free_row = find_row(r, NULL);
    if (free_row < r->rows) return free_row;
    return r->rows < KEPT_BLOCKS ? r->rows++ : find_smaller(r, bytes);
}

/* False if there is no room to keep the block. */
static bool keep(ht_memory *memory, void *block, uint64_t bytes) {
    ht_recycler *r = memory->recycler;
    kept_block given_up = {NULL, 0, false, false};
    lock(r);
    uint32_t i = find_row(r, block);
    if (i < r->rows) {
        r->row[i].in_use = false; /* its size stays: it may have been used in part */
    } else {
        const kept_block row = {block, bytes, false, true};
        i = make_row(r, bytes);
        if (i < r->rows) {
            given_up = r->row[i];
            r->row[i] = row;
        }
    }
    const bool kept = i < r->rows;
    unlock(r);
    if (given_up.block) give_back(memory, given_up.block, given_up.bytes);
    return kept;
}

ht_recycler *ht_recycler_begin(ht_memory *memory) {
    if (!memory->recycler) {
        memory->recycler = (ht_recycler *)allocate_fresh(memory, sizeof *memory->recycler);
        if (memory->recycler) memset(memory->recycler, 0, sizeof *memory->recycler);
    }
    return memory->recycler;
}

void ht_recycler_tidy(ht_memory *memory) {
    ht_recycler *r = memory->recycler;
    lock(r);
    for (uint32_t i = 0; i < r->rows; ++i) {
        kept_block *row = &r->row[i];
        if (row->block && !row->in_use && !row->used) {
            give_back(memory, row->block, row->bytes);
            row->block = NULL;
        }
        row->used = row->in_use;
    }
    unlock(r);
}

void ht_recycler_end(ht_memory *memory) {
    ht_recycler *r = memory->recycler;
    if (!r) return;
    ht_recycler_tidy(memory);
    ht_recycler_tidy(memory);
    memory->recycler = NULL;
    give_back(memory, r, sizeof *r);
}

/* ---- The way to memory ---------------------------------------------------------------------- */

void *ht_allocate(ht_memory *memory, uint64_t bytes) {
    if (bytes == 0) bytes = HT_ALIGNMENT;
    void *kept = NULL;
    if (memory->recycler && bytes >= LEAST_KEPT) kept = reuse(memory->recycler, bytes);
    return kept ? kept : allocate_fresh(memory, bytes);
}

void ht_release(ht_memory *memory, void *block, uint64_t bytes) {
    if (!block) return;
    if (bytes == 0) bytes = HT_ALIGNMENT;
    if (memory->recycler && bytes >= LEAST_KEPT && keep(memory, block, bytes)) return;
    give_back(memory, block, bytes);
}
