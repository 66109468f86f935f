/* tasks.c: a team's helpers come and go through a door. The caller opens it with a loop behind it,
 * works along, closes it, and waits until the last helper has left; who comes late finds it closed
 * and misses nothing. */
#include "tasks.h"
#include "float_env.h"

#ifndef HTREE_NO_THREADS
#include <sched.h>
#include <unistd.h>
#endif

/* The caller goes up from the first task and helpers go down from the last: what a core wrote in the
 * loop before, or in the build before, it mostly meets again. */
static void loop_run(ht_loop *loop, bool helps) {
    while (__atomic_fetch_add(&loop->taken, 1, __ATOMIC_RELAXED) < loop->count) {
        const uint32_t index =
            helps ? loop->count - 1 - __atomic_fetch_add(&loop->back, 1, __ATOMIC_RELAXED)
                  : __atomic_fetch_add(&loop->front, 1, __ATOMIC_RELAXED);
        loop->task(loop->data, index);
    }
}

#ifdef HTREE_NO_THREADS

uint32_t ht_thread_count(const htree_tasks *hook, uint32_t threads) {
    (void)hook;
    (void)threads;
    return 1;
}

static void run_threaded(ht_team *team) {
    loop_run(&team->loop, false);
}

static void begin_threads(ht_team *team) {
    (void)team;
}

static void end_threads(ht_team *team) {
    (void)team;
}

#else

static const uint32_t OPEN = UINT32_C(1) << 31, ENDED = UINT32_C(1) << 30;

/* The next loop of a build comes soon: to ask again and again is cheaper than to sleep. In between
 * the core goes to whoever waits for it, which may be the very thread that is waited for. */
enum { PATIENCE = 300, BREATHS = 64 };

uint32_t ht_thread_count(const htree_tasks *hook, uint32_t threads) {
    if (threads == 0 || (hook && hook->run)) {
        const long cores = sysconf(_SC_NPROCESSORS_ONLN);
        threads = cores < 1 ? 1 : (uint32_t)cores;
    }
    return threads < HT_MOST_THREADS ? threads : HT_MOST_THREADS;
}

static void breathe(void) {
#if defined(__x86_64__) || defined(__i386__)
    for (uint32_t i = 0; i < BREATHS; ++i) __builtin_ia32_pause();
#endif
    sched_yield();
}

/* ---- The helpers' side ---------------------------------------------------------------------- */

static uint32_t look(const ht_team *team) {
    return __atomic_load_n(&team->door, __ATOMIC_ACQUIRE);
}

/* Waits until the door is open; returns false once the team has ended. */
static bool wait_at_door(ht_team *team) {
    for (uint32_t i = 0; i < PATIENCE && !(look(team) & (OPEN | ENDED)); ++i) breathe();
    if (!(look(team) & (OPEN | ENDED))) {
        pthread_mutex_lock(&team->lock);
        ++team->asleep;
        while (!(look(team) & (OPEN | ENDED))) pthread_cond_wait(&team->changed, &team->lock);
        --team->asleep;
        pthread_mutex_unlock(&team->lock);
    }
    return !(look(team) & ENDED);
}

static bool enter(ht_team *team) {
    uint32_t seen = __atomic_load_n(&team->door, __ATOMIC_RELAXED);
    while (seen & OPEN) {
        if (__atomic_compare_exchange_n(&team->door, &seen, seen + 1, true, __ATOMIC_ACQUIRE,
                                        __ATOMIC_RELAXED))
            return true;
    }
    return false;
}

/* Who finds no more work closes the door, lest helpers come back until the last one has finished. */
static void leave(ht_team *team) {
    __atomic_and_fetch(&team->door, ~OPEN, __ATOMIC_RELAXED);
    if (__atomic_sub_fetch(&team->door, 1, __ATOMIC_ACQ_REL) != 0) return;
    pthread_mutex_lock(&team->lock);
    pthread_cond_signal(&team->emptied);
    pthread_mutex_unlock(&team->lock);
}

static void *help(void *argument) {
    ht_team *team = (ht_team *)argument;
    while (wait_at_door(team)) {
        if (!enter(team)) continue;
        loop_run(&team->loop, true);
        leave(team);
    }
    return NULL;
}

/* ---- The caller's side ---------------------------------------------------------------------- */

static void set_door(ht_team *team, uint32_t door) {
    pthread_mutex_lock(&team->lock);
    __atomic_store_n(&team->door, door, __ATOMIC_RELEASE);
    if (team->asleep > 0) pthread_cond_broadcast(&team->changed);
    pthread_mutex_unlock(&team->lock);
}

static void start_helpers(ht_team *team) {
    const uint32_t wanted = team->threads < team->loop.count ? team->threads : team->loop.count;
    while (team->helpers + 1 < wanted) {
        if (pthread_create(&team->helper[team->helpers], NULL, help, team) != 0) {
            team->threads = team->helpers + 1;
            return;
        }
        ++team->helpers;
    }
}

static void close_door(ht_team *team) {
    if (__atomic_and_fetch(&team->door, ~OPEN, __ATOMIC_ACQ_REL) == 0) return;
    for (uint32_t i = 0; i < PATIENCE && look(team) != 0; ++i) breathe();
    if (look(team) == 0) return;
    pthread_mutex_lock(&team->lock);
    while (look(team) != 0) pthread_cond_wait(&team->emptied, &team->lock);
    pthread_mutex_unlock(&team->lock);
}

static void run_threaded(ht_team *team) {
    set_door(team, OPEN);
    start_helpers(team);
    loop_run(&team->loop, false);
    close_door(team);
}

static void begin_threads(ht_team *team) {
    team->door = team->asleep = 0;
    pthread_mutex_init(&team->lock, NULL);
    pthread_cond_init(&team->changed, NULL);
    pthread_cond_init(&team->emptied, NULL);
}

static void end_threads(ht_team *team) {
    set_door(team, ENDED);
    while (team->helpers > 0) pthread_join(team->helper[--team->helpers], NULL);
    pthread_cond_destroy(&team->emptied);
    pthread_cond_destroy(&team->changed);
    pthread_mutex_destroy(&team->lock);
}

#endif

/* ---- The hook's threads --------------------------------------------------------------------- */

/* Our helpers have the environment of the thread that started them, by POSIX; these have any. */
static void run_hooked(void *data, uint32_t index) {
    const ht_loop *loop = (const ht_loop *)data;
    const ht_float_env env = ht_float_env_enter();
    loop->task(loop->data, index);
    ht_float_env_leave(env);
}

/* ---- Teams ---------------------------------------------------------------------------------- */

uint32_t ht_team_threads(const htree_tasks *hook, uint32_t threads) {
    return hook->run ? threads : ht_thread_count(NULL, threads);
}

void ht_team_begin(ht_team *team, const htree_tasks *hook, uint32_t threads) {
    team->hook = hook;
    team->threads = ht_team_threads(hook, threads);
    team->helpers = 0;
    begin_threads(team);
}

void ht_team_run(ht_team *team, uint32_t count, ht_task *task, void *data) {
    /* taken wraps only if count + threads exceeds 2^32; callers cut work into far fewer tasks. */
    const ht_loop loop = {task, data, count, 0, 0, 0};
    assert(count < UINT32_MAX / 2);
    team->loop = loop;
    if (count <= 1 || team->threads == 1) {
        loop_run(&team->loop, false);
    } else if (team->hook->run) {
        team->hook->run(team->hook->user, count, run_hooked, &team->loop);
    } else {
        run_threaded(team);
    }
}

void ht_team_end(ht_team *team) {
    end_threads(team);
}

void ht_parallel_for(const htree_tasks *hook, uint32_t threads, uint32_t count, ht_task *task,
                     void *data) {
    ht_team team;
    if (count <= 1) {
        if (count == 1) task(data, 0);
        return;
    }
    ht_team_begin(&team, hook, threads);
    ht_team_run(&team, count, task, data);
    ht_team_end(&team);
}
