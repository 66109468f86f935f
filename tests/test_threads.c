/* test_threads.c: threads that cannot be started are work for the others: whichever call of
 * pthread_create fails, trees and hits are the same. Linked with --wrap=pthread_create. */
#include "rays.h"
#include "saved.h"

#include <errno.h>
#include <pthread.h>

enum { RAYS = 4000, THREADS = 4 };

int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes,
                          void *(*start)(void *), void *argument);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes,
                          void *(*start)(void *), void *argument);

/* The library starts threads from the one that calls it, and tests from here: one at a time. */
static uint64_t started, fail_at;
static bool fail_for_good;

int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes,
                          void *(*start)(void *), void *argument) {
    ++started;
    if (fail_at != 0 && (started == fail_at || (fail_for_good && started > fail_at))) return EAGAIN;
    return __real_pthread_create(thread, attributes, start, argument);
}

static void order_failure(uint64_t at, bool for_good) {
    started = 0;
    fail_at = at;
    fail_for_good = for_good;
}

static saved build_and_ask(const htree_mesh *mesh, htree_kind kind, const htree_ray *rays,
                           htree_hit *hits) {
    htree_options options = options_of(kind);
    options.threads = THREADS;
    htree *const tree = tree_of(mesh, &options);
    assert_int_equal(htree_intersect(tree, rays, RAYS, hits, NULL), HTREE_OK);
    saved file = saved_of(tree);
    htree_free(tree);
    return file;
}

static void threads_that_do_not_start_change_nothing(void **state) {
    static htree_ray rays[RAYS];
    static htree_hit truth[RAYS], hits[RAYS];
    shape s = shape_of("city", 12000, 4);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    uint64_t failures = 0;
    dice d = {9};
    (void)state;
    rays_make_mixed(&target, &d, rays, RAYS);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        order_failure(0, false);
        saved should = build_and_ask(&mesh, kind, rays, truth);
        const uint64_t calls = started;
        assert_true(calls > 0);
        for (uint64_t at = 1; at <= 2 * calls; at += scaled(100) < 100 ? 5 : 1) {
            order_failure((at + 1) / 2, at % 2 != 0);
            saved is = build_and_ask(&mesh, kind, rays, hits);
            assert_int_equal(is.size, should.size);
            assert_memory_equal(is.bytes, should.bytes, (size_t)is.size);
            assert_int_equal(hits_differ(hits, truth, RAYS), 0);
            saved_free(&is);
            ++failures;
        }
        saved_free(&should);
    }
    order_failure(0, false);
    shape_free(&s);
    say("builds and queries with a thread that does not start, once or for good: %llu",
        (unsigned long long)failures);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_that_do_not_start_change_nothing),
    };
    return cmocka_run_group_tests_name("threads", tests, NULL, NULL);
}
