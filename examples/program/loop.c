#include "loop.h"

#include <pthread.h>

enum { BLOCK = 512, MAX_THREADS = 256 };

typedef struct loop {
    void (*task)(void *data, uint64_t first, uint64_t end);
    void *data;
    uint64_t count, next;
} loop;

static void *work(void *argument) {
    loop *l = (loop *)argument;
    for (;;) {
        const uint64_t first = __atomic_fetch_add(&l->next, BLOCK, __ATOMIC_RELAXED);
        if (first >= l->count) return NULL;
        l->task(l->data, first, first + BLOCK < l->count ? first + BLOCK : l->count);
    }
}

void loop_run(uint32_t threads, uint64_t count,
              void (*task)(void *data, uint64_t first, uint64_t end), void *data) {
    pthread_t helper[MAX_THREADS];
    uint32_t started = 0;
    loop l = {task, data, count, 0};
    if (threads > MAX_THREADS) threads = MAX_THREADS;
    /* A thread that cannot be started is work for the others. */
    while (started + 1 < threads && (uint64_t)(started + 1) * BLOCK < count &&
           pthread_create(&helper[started], NULL, work, &l) == 0)
        ++started;
    work(&l);
    while (started) pthread_join(helper[--started], NULL);
}
