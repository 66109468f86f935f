/* tasks.h: the only way to threads: a team, which runs one parallel loop after another.
 *
 * Work is cut by input, never by the number of threads, so results cannot depend on it. */
#ifndef HT_TASKS_H
#define HT_TASKS_H

#include "base.h"

#ifndef HTREE_NO_THREADS
#include <pthread.h>
#endif

typedef void ht_task(void *data, uint32_t index);

typedef struct ht_loop {
    ht_task *task;
    void *data;
    uint32_t count;
    uint32_t taken, front, back; /* tasks that threads have come for, and from either end */
} ht_loop;

enum { HT_MOST_THREADS = 256 };

/* The caller's thread, and helpers that stay until the team ends: starting a thread takes as long
 * as thousands of triangles. */
typedef struct ht_team {
    const htree_tasks *hook;
    uint32_t threads; /* at most, the caller's among them; of a hook: 1, or what it likes */
    uint32_t helpers; /* started so far */
    ht_loop loop;
#ifndef HTREE_NO_THREADS
    uint32_t door;   /* OPEN while the loop may be entered, or ENDED | helpers inside */
    uint32_t asleep; /* helpers that wait until it has changed */
    pthread_mutex_t lock;
    pthread_cond_t changed, emptied;
    pthread_t helper[HT_MOST_THREADS - 1];
#endif
} ht_team;

/* Loops go through the hook if there is one, else run on at most `threads` threads (0: one per
 * core). Threads are started when a loop has work for them; one that cannot be started is work for
 * the others, not an error. */
void ht_team_begin(ht_team *team, const htree_tasks *hook, uint32_t threads);

/* Calls task(data, i) once for 0 <= i < count and returns when all are done. Not from a task. */
void ht_team_run(ht_team *team, uint32_t count, ht_task *task, void *data);

void ht_team_end(ht_team *team);

/* A team for one loop. */
void ht_parallel_for(const htree_tasks *hook, uint32_t threads, uint32_t count, ht_task *task,
                     void *data);

/* What `threads` of options means: 0 is one per core, and asking for their number takes as long as
 * several rays; where a hook decides it stays what it is. */
uint32_t ht_team_threads(const htree_tasks *hook, uint32_t threads);

/* Threads that such a loop may have: as many as cores where the hook decides. */
uint32_t ht_thread_count(const htree_tasks *hook, uint32_t threads);

#endif
