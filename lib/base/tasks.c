#include "tasks.h"

#ifndef HTREE_NO_THREADS
#include <pthread.h>
#include <unistd.h>
#endif

typedef struct ht_loop {
    ht_task *task;
    void *data;
    uint32_t count;
    uint32_t next;
} ht_loop;

static void *loop_run(void *argument) {
    ht_loop *loop = (ht_loop *)argument;
    for (;;) {
        const uint32_t index = __atomic_fetch_add(&loop->next, 1, __ATOMIC_RELAXED);
        if (index >= loop->count) return NULL;
        loop->task(loop->data, index);
    }
}

#ifdef HTREE_NO_THREADS

uint32_t ht_thread_count(const htree_tasks *hook, uint32_t threads) {
    (void)hook;
    (void)threads;
    return 1;
}

static void loop_run_threaded(ht_loop *loop, uint32_t threads) {
    (void)threads;
    loop_run(loop);
}

#else

enum { MAX_THREADS = 256 };

uint32_t ht_thread_count(const htree_tasks *hook, uint32_t threads) {
    if (threads == 0 || (hook && hook->run)) {
        const long cores = sysconf(_SC_NPROCESSORS_ONLN);
        threads = cores < 1 ? 1 : (uint32_t)cores;
    }
    return threads < MAX_THREADS ? threads : MAX_THREADS;
}

static void loop_run_threaded(ht_loop *loop, uint32_t threads) {
    pthread_t helper[MAX_THREADS - 1];
    uint32_t started = 0;
    threads = ht_thread_count(NULL, threads);
    if (threads > loop->count) threads = loop->count;
    while (started + 1 < threads) {
        if (pthread_create(&helper[started], NULL, loop_run, loop) != 0) break;
        ++started;
    }
    loop_run(loop);
    while (started > 0) pthread_join(helper[--started], NULL);
}

#endif

void ht_parallel_for(const htree_tasks *hook, uint32_t threads, uint32_t count, ht_task *task,
                     void *data) {
    /* next wraps only if count + threads exceeds 2^32; callers cut work into far fewer tasks. */
    ht_loop loop = {task, data, count, 0};
    assert(count < UINT32_MAX / 2);
    if (count == 0) return;
    if (count == 1 || threads == 1) {
        loop_run(&loop);
    } else if (hook->run) {
        hook->run(hook->user, count, task, data);
    } else {
        loop_run_threaded(&loop, threads);
    }
}

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
