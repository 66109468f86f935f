/* test_lazy.c: a lazy tree answers as any other, whoever touches it first, and becomes the tree that
 * Morton order gives. */
#include "ledger.h"
#include "oracle.h"
#include "rays.h"

#include <pthread.h>

enum { TRIANGLES = 20000 };

static htree_options lazy_options(uint32_t flags) {
    htree_options options = options_of(HTREE_WIDE);
    options.flags = flags;
    return options;
}

static htree *lazy_tree(const htree_mesh *mesh) {
    const htree_options options = lazy_options(HTREE_LAZY);
    return tree_of(mesh, &options);
}

/* ---- Hits ----------------------------------------------------------------------------------- */

static uint64_t rays_total, differences_total, subtrees_total, built_total, built_early;

/* Batches that grow, with a proof of what is built after each. */
static void trace_in_steps(const htree *tree, const htree_ray *rays, const htree_hit *truth,
                           uint64_t count) {
    htree_hit *const hits = (htree_hit *)take(count * sizeof *hits);
    for (uint64_t first = 0, step = 1; first < count; first += step, step *= 4) {
        const uint64_t here = step < count - first ? step : count - first;
        assert_int_equal(htree_intersect(tree, rays + first, here, hits, NULL), HTREE_OK);
        differences_total += hits_differ(hits, truth + first, here);
        rays_total += here;
        assert_int_equal(htree_check(tree), HTREE_OK);
        if (first == 5) built_early += stats_of(tree).subtrees_built;
    }
    free(hits);
}

static void lazy_trees_answer_as_the_oracle(void **state) {
    const uint64_t count = scaled(3000);
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    htree_hit *const truth = (htree_hit *)take(count * sizeof *truth);
    (void)state;
    for (const char *const *name = shape_names(); *name != NULL; ++name) {
        for (uint64_t triangles = 3; triangles <= TRIANGLES; triangles *= 80) {
            shape s = shape_of(*name, triangles, 7);
            const htree_mesh mesh = mesh_of(&s);
            const ray_target target = ray_target_of(&mesh);
            const htree_options morton = lazy_options(HTREE_MORTON);
            dice d = {triangles};
            rays_make_mixed(&target, &d, rays, count);
            oracle o = oracle_of(&mesh);
            (void)oracle_batch(&o, rays, count, truth);
            htree *const lazy = lazy_tree(&mesh), *const eager = tree_of(&mesh, &morton);
            trace_in_steps(lazy, rays, truth, count);
            subtrees_total += stats_of(lazy).subtrees;
            built_total += stats_of(lazy).subtrees_built;
            assert_int_equal(htree_complete(lazy), HTREE_OK);
            assert_int_equal(stats_of(lazy).subtrees, 0);
            assert_same_trees(lazy, eager);
            trace_in_steps(lazy, rays, truth, count);
            oracle_free(&o);
            htree_free(eager);
            htree_free(lazy);
            shape_free(&s);
        }
    }
    say("%llu rays, %llu differences; of %llu subtrees the first 21 rays built %llu, all rays %llu",
        (unsigned long long)rays_total, (unsigned long long)differences_total,
        (unsigned long long)subtrees_total, (unsigned long long)built_early,
        (unsigned long long)built_total);
    tally("oracle rays", rays_total);
    assert_int_equal(differences_total, 0);
    assert_true(built_early > 0 && built_early < subtrees_total / 2);
    free(truth);
    free(rays);
}

/* ---- Threads -------------------------------------------------------------------------------- */

typedef struct tracer {
    const htree *tree;
    const htree_ray *rays;
    const htree_hit *truth;
    uint64_t count, differences;
    htree_status status;
} tracer;

static void *trace_on_a_thread(void *argument) {
    tracer *const t = (tracer *)argument;
    htree_hit *const hits = (htree_hit *)take(t->count * sizeof *hits);
    t->status = htree_intersect(t->tree, t->rays, t->count, hits, NULL);
    t->differences = hits_differ(hits, t->truth, t->count);
    free(hits);
    return NULL;
}

/* All threads come to the same subtrees at the same time. */
static void threads_meet_in_a_lazy_tree(void **state) {
    enum { THREADS = 6 };
    const uint64_t count = scaled(20000);
    shape s = shape_of("knot", TRIANGLES, 7);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    htree_hit *const truth = (htree_hit *)take(count * sizeof *truth);
    const htree_options morton = lazy_options(HTREE_MORTON);
    htree *const eager = tree_of(&mesh, &morton);
    dice d = {3};
    (void)state;
    rays_make_mixed(&target, &d, rays, count);
    assert_int_equal(htree_intersect(eager, rays, count, truth, NULL), HTREE_OK);
    for (uint32_t round = 0; round < 8; ++round) {
        htree *const lazy = lazy_tree(&mesh);
        pthread_t threads[THREADS];
        tracer tracers[THREADS];
        for (uint32_t i = 0; i < THREADS; ++i) {
            const tracer t = {lazy, rays, truth, count, 0, HTREE_OK};
            tracers[i] = t;
            assert_int_equal(pthread_create(&threads[i], NULL, trace_on_a_thread, &tracers[i]), 0);
        }
        for (uint32_t i = 0; i < THREADS; ++i) {
            assert_int_equal(pthread_join(threads[i], NULL), 0);
            assert_int_equal(tracers[i].status, HTREE_OK);
            assert_int_equal(tracers[i].differences, 0);
        }
        assert_int_equal(htree_complete(lazy), HTREE_OK);
        assert_same_trees(lazy, eager);
        htree_free(lazy);
    }
    htree_free(eager);
    free(truth);
    free(rays);
    shape_free(&s);
}

/* ---- The object ----------------------------------------------------------------------------- */

static void lazy_trees_take_no_memory_in_queries(void **state) {
    ledger books;
    shape s = shape_of("city", TRIANGLES, 7);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree_options options = lazy_options(HTREE_LAZY);
    htree_ray rays[500];
    htree_hit hits[500];
    dice d = {3};
    (void)state;
    ledger_init(&books);
    options.allocator = ledger_allocator(&books);
    options.threads = 1;
    htree *const tree = tree_of(&mesh, &options);
    rays_make_mixed(&target, &d, rays, COUNT_OF(rays));
    const uint64_t calls = books.calls;
    assert_int_equal(htree_intersect(tree, rays, COUNT_OF(rays), hits, NULL), HTREE_OK);
    assert_true(stats_of(tree).subtrees_built > 0);
    assert_int_equal(htree_complete(tree), HTREE_OK);
    assert_int_equal(htree_complete(tree), HTREE_OK);
    assert_int_equal(books.calls, calls);
    htree_free(tree);
    htree *const untouched = tree_of(&mesh, &options);
    htree_free(untouched);
    ledger_assert_balanced(&books);
    ledger_free(&books);
    shape_free(&s);
}

static void incomplete_trees_show_no_arrays(void **state) {
    shape s = shape_of("city", TRIANGLES, 7);
    const htree_mesh mesh = mesh_of(&s);
    htree *const tree = lazy_tree(&mesh);
    htree_view view;
    view.size = sizeof view;
    (void)state;
    assert_int_equal(htree_get_view(tree, &view), HTREE_ERROR_UNSUPPORTED);
    assert_non_null(strstr(htree_error_text(), "htree_complete"));
    assert_int_equal(htree_complete(NULL), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_complete(tree), HTREE_OK);
    assert_int_equal(htree_get_view(tree, &view), HTREE_OK);
    htree_free(tree);
    shape_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lazy_trees_answer_as_the_oracle),
        cmocka_unit_test(threads_meet_in_a_lazy_tree),
        cmocka_unit_test(lazy_trees_take_no_memory_in_queries),
        cmocka_unit_test(incomplete_trees_show_no_arrays),
    };
    return cmocka_run_group_tests_name("lazy", tests, NULL, NULL);
}
