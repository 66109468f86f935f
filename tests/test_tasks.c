/* test_tasks.c: threads, hooks and progress change nothing but time; queries and builds run at
 * once. */
#include "ledger.h"
#include "rays.h"

#include <pthread.h>

enum { RAYS = 4200, QUERY_THREADS = 4 };

static uint64_t cancelled, combinations;

/* A scene with the answers of a build on one thread: hits and what every ray cost. */
typedef struct stage {
    shape s;
    htree_mesh mesh;
    htree_kind kind;
    uint64_t count;
    htree_ray rays[RAYS];
    htree_hit hits[RAYS], again[RAYS];
    htree_counters costs[RAYS], costs_again[RAYS];
    htree_stats stats;
} stage;

static htree_status query_counted(const htree *tree, stage *g, htree_hit *hits,
                                  htree_counters *costs) {
    htree_query query;
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    query.counters = costs;
    return htree_intersect(tree, g->rays, g->count, hits, &query);
}

static stage *stage_new(const char *name, uint64_t triangles, htree_kind kind) {
    stage *const g = (stage *)take(sizeof *g);
    dice d = {5};
    memset(g, 0, sizeof *g);
    g->s = shape_of(name, triangles, 1);
    g->mesh = mesh_of(&g->s);
    g->kind = kind;
    g->count = scaled(RAYS) < RAYS ? scaled(RAYS) + 1000 : RAYS;
    const ray_target target = ray_target_of(&g->mesh);
    rays_make_mixed(&target, &d, g->rays, g->count);
    htree *const tree = tree_of_kind(&g->mesh, kind);
    assert_int_equal(query_counted(tree, g, g->hits, g->costs), HTREE_OK);
    g->stats = stats_of(tree);
    htree_free(tree);
    return g;
}

static void stage_free(stage *g) {
    shape_free(&g->s);
    free(g);
}

/* The tree and the hits are those of one thread: the same numbers, and the same steps for every
 * ray. */
static void prove_same(stage *g, const htree_options *options) {
    htree *const tree = tree_of(&g->mesh, options);
    htree_stats stats = stats_of(tree);
    stats.build_seconds = g->stats.build_seconds;
    stats.peak_bytes = g->stats.peak_bytes;
    assert_memory_equal(&stats, &g->stats, sizeof stats);
    assert_int_equal(query_counted(tree, g, g->again, g->costs_again), HTREE_OK);
    assert_int_equal(hits_differ(g->again, g->hits, g->count), 0);
    assert_memory_equal(g->costs_again, g->costs, (size_t)g->count * sizeof *g->costs);
    assert_int_equal(htree_intersect(tree, g->rays, g->count, g->again, NULL), HTREE_OK);
    assert_int_equal(hits_differ(g->again, g->hits, g->count), 0);
    htree_free(tree);
    ++combinations;
}

/* A run of small scale takes smaller scenes too. */
static void for_each_kind(const char *name, uint64_t triangles, void (*prove)(stage *g)) {
    if (scaled(100) < 20) triangles /= 4;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        stage *const g = stage_new(name, triangles, kind);
        prove(g);
        stage_free(g);
    }
}

/* ---- Threads and hooks ---------------------------------------------------------------------- */

static void prove_threads(stage *g) {
    static const uint32_t many[] = {64, UINT32_MAX};
    const uint32_t step = scaled(100) < 20 ? 5 : 1;
    for (uint32_t i = 0; i <= 16 + COUNT_OF(many); i += step) {
        htree_options options = options_of(g->kind);
        options.threads = i <= 16 ? i : many[i - 17];
        prove_same(g, &options);
    }
}

static void any_number_of_threads_gives_the_same_tree_and_hits(void **state) {
    (void)state;
    for_each_kind("knot", 12000, prove_threads);
    for_each_kind("soup", 500, prove_threads);
}

typedef void task_function(void *data, uint32_t index);

static void run_serial(void *user, uint32_t count, task_function *task, void *data) {
    ++*(uint32_t *)user;
    for (uint32_t i = 0; i < count; ++i) task(data, i);
}

static void run_reversed(void *user, uint32_t count, task_function *task, void *data) {
    ++*(uint32_t *)user;
    for (uint32_t i = count; i > 0; --i) task(data, i - 1);
}

static void run_odd_then_even(void *user, uint32_t count, task_function *task, void *data) {
    ++*(uint32_t *)user;
    for (uint32_t i = 1; i < count; i += 2) task(data, i);
    for (uint32_t i = 0; i < count; i += 2) task(data, i);
}

typedef struct crew {
    uint32_t first, count;
    task_function *task;
    void *data;
} crew;

/* Takes every third task. */
static void *crew_run(void *argument) {
    const crew *const c = (const crew *)argument;
    for (uint32_t i = c->first; i < c->count; i += 3) c->task(c->data, i);
    return NULL;
}

/* All tasks on other threads: the caller's does none. */
static void run_on_threads(void *user, uint32_t count, task_function *task, void *data) {
    crew crews[3];
    pthread_t threads[3];
    ++*(uint32_t *)user;
    for (uint32_t i = 0; i < 3; ++i) {
        const crew c = {i, count, task, data};
        crews[i] = c;
        if (pthread_create(&threads[i], NULL, crew_run, &crews[i]) != 0) abort();
    }
    for (uint32_t i = 0; i < 3; ++i) pthread_join(threads[i], NULL);
}

static void prove_hooks(stage *g) {
    void (*const hooks[])(void *, uint32_t, task_function *,
                          void *) = {run_serial, run_reversed, run_odd_then_even, run_on_threads};
    for (uint32_t i = 0; i < COUNT_OF(hooks); ++i) {
        uint32_t calls = 0;
        htree_options options = options_of(g->kind);
        options.tasks.run = hooks[i];
        options.tasks.user = &calls;
        prove_same(g, &options);
        assert_true(calls > 0); /* the hook was asked, at least for the queries */
    }
}

static void a_task_hook_in_any_order_gives_the_same_tree_and_hits(void **state) {
    (void)state;
    for_each_kind("knot", 12000, prove_hooks);
    say("%llu builds and batches equal to those of one thread", (unsigned long long)combinations);
}

/* ---- Progress ------------------------------------------------------------------------------- */

typedef struct watch {
    pthread_t thread;
    uint64_t calls, cancel_at;
    double last;
    uint32_t mistakes;
} watch;

static int32_t watch_report(void *user, double fraction) {
    watch *const w = (watch *)user;
    ++w->calls;
    if (!pthread_equal(w->thread, pthread_self())) ++w->mistakes;
    if (!(fraction >= w->last && fraction <= 1)) ++w->mistakes;
    if (w->cancel_at != 0 && w->calls > w->cancel_at) ++w->mistakes; /* asked again after the end */
    w->last = fraction;
    return w->calls == w->cancel_at;
}

static htree_progress watch_begin(watch *w, uint64_t cancel_at) {
    const htree_progress hook = {watch_report, w};
    memset(w, 0, sizeof *w);
    w->thread = pthread_self();
    w->cancel_at = cancel_at;
    return hook;
}

/* Returns the number of reports; 0 means that the build came to its end before report
 * `cancel_at`. */
static uint64_t cancel_build(stage *g, uint32_t threads, uint64_t cancel_at) {
    watch w;
    ledger books;
    htree *tree = (htree *)(uintptr_t)8;
    htree_options options = options_of(g->kind);
    ledger_init(&books);
    options.threads = threads;
    options.allocator = ledger_allocator(&books);
    options.progress = watch_begin(&w, cancel_at);
    const htree_status status = htree_build(&tree, &g->mesh, &options);
    assert_int_equal(w.mistakes, 0);
    if (cancel_at == 0 || w.calls < cancel_at) {
        assert_int_equal(status, HTREE_OK);
        htree_free(tree);
    } else {
        assert_int_equal(status, HTREE_ERROR_CANCELLED);
        assert_null(tree);
        assert_true(strlen(htree_error_text()) > 5);
        ++cancelled;
    }
    ledger_assert_balanced(&books);
    ledger_free(&books);
    return w.calls;
}

static void prove_build_progress(stage *g) {
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        const uint64_t calls = cancel_build(g, threads, 0);
        assert_true(threads > 1 || calls > 2); /* one thread reports for sure */
        const uint64_t step = scaled(100) < 100 ? 1 + calls / 10 : 1;
        for (uint64_t at = 1; at <= calls; at += step) (void)cancel_build(g, threads, at);
    }
}

static void a_build_reports_in_order_and_stops_at_any_report(void **state) {
    (void)state;
    for_each_kind("knot", 6000, prove_build_progress);
}

static uint64_t cancel_query(stage *g, const htree *tree, uint32_t threads, uint64_t cancel_at,
                             bool any) {
    static uint8_t occluded[RAYS];
    watch w;
    htree_query query;
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    query.threads = threads;
    query.progress = watch_begin(&w, cancel_at);
    const htree_status status = any ? htree_occluded(tree, g->rays, g->count, occluded, &query)
                                    : htree_intersect(tree, g->rays, g->count, g->again, &query);
    assert_int_equal(w.mistakes, 0);
    if (cancel_at == 0 || w.calls < cancel_at) {
        assert_int_equal(status, HTREE_OK);
        if (!any) assert_int_equal(hits_differ(g->again, g->hits, g->count), 0);
    } else {
        assert_int_equal(status, HTREE_ERROR_CANCELLED);
        ++cancelled;
    }
    return w.calls;
}

static void prove_query_progress(stage *g) {
    htree *const tree = tree_of_kind(&g->mesh, g->kind);
    for (uint32_t i = 0; i < 4; ++i) {
        const uint32_t threads = i < 2 ? 1 : 3;
        const uint64_t calls = cancel_query(g, tree, threads, 0, i % 2 != 0);
        assert_true(threads > 1 || calls > 2);
        for (uint64_t at = 1; at <= calls; ++at)
            (void)cancel_query(g, tree, threads, at, i % 2 != 0);
    }
    assert_int_equal(htree_intersect(tree, g->rays, g->count, g->again, NULL), HTREE_OK);
    assert_int_equal(hits_differ(g->again, g->hits, g->count), 0);
    htree_free(tree);
}

static void a_batch_reports_in_order_and_stops_at_any_report(void **state) {
    (void)state;
    for_each_kind("knot", 2000, prove_query_progress);
    say("%llu builds and batches cancelled", (unsigned long long)cancelled);
}

/* ---- At once -------------------------------------------------------------------------------- */

typedef struct worker {
    stage *g;
    const htree *tree; /* NULL: builds one */
    uint32_t rounds;
    uint64_t mistakes;
} worker;

static bool query_equals(const stage *g, const htree *tree, htree_hit *hits,
                         const htree_query *query) {
    if (htree_intersect(tree, g->rays, g->count, hits, query) != HTREE_OK) return false;
    return hits_differ(hits, g->hits, g->count) == 0;
}

static void *work(void *argument) {
    worker *const w = (worker *)argument;
    htree_hit *const hits = (htree_hit *)malloc(RAYS * sizeof *hits);
    for (uint32_t round = 0; round < w->rounds; ++round) {
        htree *own = NULL;
        htree_stats stats;
        stats.size = sizeof stats;
        if (w->tree == NULL) {
            htree_options options;
            w->mistakes += htree_options_init(&options, sizeof options, w->g->kind) != HTREE_OK;
            options.threads = 1 + round % 2;
            w->mistakes += htree_build(&own, &w->g->mesh, &options) != HTREE_OK;
        }
        const htree *const tree = own != NULL ? own : w->tree;
        w->mistakes += tree == NULL || !query_equals(w->g, tree, hits, NULL);
        w->mistakes += htree_check(tree) != HTREE_OK;
        w->mistakes +=
            htree_get_stats(tree, &stats) != HTREE_OK || stats.nodes != w->g->stats.nodes;
        w->mistakes +=
            htree_check(NULL) != HTREE_ERROR_ARGUMENT; /* texts of four threads at once */
        htree_free(own);
    }
    free(hits);
    return NULL;
}

static void work_at_once(stage *g, const htree *tree, uint32_t rounds) {
    worker workers[QUERY_THREADS];
    pthread_t threads[QUERY_THREADS];
    for (uint32_t i = 0; i < QUERY_THREADS; ++i) {
        const worker w = {g, tree, rounds, 0};
        workers[i] = w;
        assert_int_equal(pthread_create(&threads[i], NULL, work, &workers[i]), 0);
    }
    for (uint32_t i = 0; i < QUERY_THREADS; ++i) {
        pthread_join(threads[i], NULL);
        assert_int_equal(workers[i].mistakes, 0);
    }
}

static void prove_queries_at_once(stage *g) {
    htree_options options = options_of(g->kind);
    options.threads = 2;
    htree *const tree = tree_of(&g->mesh, &options);
    work_at_once(g, tree, 3);
    htree_free(tree);
}

static void four_threads_query_one_tree_at_once(void **state) {
    (void)state;
    for_each_kind("waves", 3000, prove_queries_at_once);
}

static void prove_builds_at_once(stage *g) {
    work_at_once(g, NULL, 3);
}

static void four_threads_build_at_once(void **state) {
    (void)state;
    for_each_kind("waves", 3000, prove_builds_at_once);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_number_of_threads_gives_the_same_tree_and_hits),
        cmocka_unit_test(a_task_hook_in_any_order_gives_the_same_tree_and_hits),
        cmocka_unit_test(a_build_reports_in_order_and_stops_at_any_report),
        cmocka_unit_test(a_batch_reports_in_order_and_stops_at_any_report),
        cmocka_unit_test(four_threads_query_one_tree_at_once),
        cmocka_unit_test(four_threads_build_at_once),
    };
    return cmocka_run_group_tests_name("tasks", tests, NULL, NULL);
}
