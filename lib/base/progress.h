/* progress.h: how far a call is, for the caller's hook, which may cancel it. */
#ifndef HT_PROGRESS_H
#define HT_PROGRESS_H

#include "base.h"

/* Any thread may ask ht_progress_step; only the thread that began reports. */
typedef struct ht_progress {
    htree_progress hook;
    uint64_t done, total;
    double reported;
    const void *thread;
    uint32_t cancelled;
} ht_progress;

void ht_progress_begin(ht_progress *progress, const htree_progress *hook, uint64_t total);

/* Adds `amount` of the total; returns false once the call has been cancelled. */
bool ht_progress_step(ht_progress *progress, uint64_t amount);

#endif
