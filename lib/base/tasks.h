/* tasks.h: one parallel loop, and the progress that calls report from it.
 *
 * Work is cut by input, never by the number of threads, so results cannot depend on it. */
#ifndef HT_TASKS_H
#define HT_TASKS_H

#include "base.h"

typedef void ht_task(void *data, uint32_t index);

/* Calls task(data, i) once for 0 <= i < count and returns when all are done: through the hook if
 * there is one, else on at most `threads` threads (0: one per core), the caller's among them. A
 * thread that cannot be started is work for the others, not an error. */
void ht_parallel_for(const htree_tasks *hook, uint32_t threads, uint32_t count, ht_task *task,
                     void *data);

/* Threads that such a loop may have: as many as cores where the hook decides. */
uint32_t ht_thread_count(const htree_tasks *hook, uint32_t threads);

/* Progress of one call. Any thread may ask ht_progress_step; only the thread that began reports. */
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
