#include "progress.h"

/* A report for every object would cost more than the object. */
static const double REPORT_STEP = 1.0 / 256;

/* The address of a thread's own variable names the thread without a system call. */
static const void *this_thread(void) {
    static __thread char here;
    return &here;
}

void ht_progress_begin(ht_progress *progress, const htree_progress *hook, uint64_t total) {
    progress->hook = *hook;
    progress->done = 0;
    progress->total = total;
    progress->thread = this_thread();
    progress->reported = 0;
    /* Once for sure: other threads may do all of the work before this one gets to any. */
    progress->cancelled = hook->report && hook->report(hook->user, 0) ? 1 : 0;
}

bool ht_progress_step(ht_progress *progress, uint64_t amount) {
    if (!progress->hook.report) return true;
    const uint64_t done = __atomic_add_fetch(&progress->done, amount, __ATOMIC_RELAXED);
    const double fraction = done < progress->total ? (double)done / (double)progress->total : 1;
    if (progress->thread == this_thread() &&
        !__atomic_load_n(&progress->cancelled, __ATOMIC_RELAXED) &&
        fraction >= progress->reported + REPORT_STEP) {
        progress->reported = fraction;
        if (progress->hook.report(progress->hook.user, fraction)) {
            __atomic_store_n(&progress->cancelled, 1, __ATOMIC_RELAXED);
        }
    }
    return !__atomic_load_n(&progress->cancelled, __ATOMIC_RELAXED);
}
