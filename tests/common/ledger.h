/* ledger.h: an allocator hook that keeps books, checks what it is given, and fails on command. */
#ifndef LEDGER_H
#define LEDGER_H

#include "suite.h"

#include <pthread.h>

typedef struct ledger {
    pthread_mutex_t lock;
    uint64_t calls;       /* allocations asked for, failed ones included */
    uint64_t live_blocks; /* handed out and not released */
    uint64_t live_bytes;
    uint64_t peak_bytes;
    uint64_t mistakes;  /* wrong sizes, foreign blocks, odd alignments */
    uint64_t fail_at;   /* this call returns NULL, counted from 1; 0: none */
    bool fail_for_good; /* and so do all calls after it */
} ledger;

void ledger_init(ledger *l);
void ledger_free(ledger *l);

/* The hook; `l` must outlive every tree that is built with it. */
htree_allocator ledger_allocator(ledger *l);

/* Forgets the calls and orders call number `call` to fail; 0 for none. */
void ledger_fail(ledger *l, uint64_t call, bool for_good);

/* Builds the mesh again and again on one thread, each time with one more allocation that succeeds,
 * until the build does: it must fail with MEMORY before, and leave nothing behind. */
void ledger_fail_builds(const htree_mesh *mesh, const htree_options *options);

/* Fails the test unless everything came back and nothing was wrong. */
void ledger_assert_balanced(const ledger *l);

#endif
