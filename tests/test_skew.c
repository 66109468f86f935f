/* test_skew.c: inputs that no split separates or that every split separates badly: builds stay
 * quick, depth stays bounded, and a thread with a small stack is enough. */
#include "oracle.h"
#include "rays.h"

#include <math.h>
#include <pthread.h>
#include <unistd.h>

static uint64_t trees_built;

/* Levels that any tree may have; half of it is enough for a million triangles in good order. */
enum { DEPTH_LIMIT = 160 };

/* Returns the seconds of the build. */
static double prove(const htree_mesh *mesh, htree_kind kind, uint32_t depth_limit, uint64_t rays) {
    htree *const tree = tree_of_kind(mesh, kind);
    const htree_stats stats = stats_of(tree);
    if (stats.depth > depth_limit)
        fail_msg("%s: depth %u > %u", htree_kind_name(kind), stats.depth, depth_limit);
    assert_true(stats.stack <= (stats.kind == HTREE_WIDE ? 7 : 1) * stats.depth);
    oracle_compare(tree, mesh, rays, 1);
    htree_free(tree);
    ++trees_built;
    return stats.build_seconds;
}

static void put_triangle(float *p, float x, float y, float z, float size) {
    const float corner[9] = {x, y, z, x + size, y, z, x, y + size, z};
    memcpy(p, corner, sizeof corner);
}

/* ---- The claims ----------------------------------------------------------------------------- */

/* n triangles that are one: the depth is that of a balanced tree, and time that of random ones. */
static void identical_triangles_are_split_by_index(void **state) {
    const uint64_t n = scaled(100) < 20 ? 8000 : 100000;
    float *const same = (float *)take(n * 36);
    float *const random = (float *)take(n * 36);
    dice d = {2};
    (void)state;
    for (uint64_t i = 0; i < n; ++i) {
        put_triangle(same + 9 * i, 1, 2, 3, 1);
        put_triangle(random + 9 * i, dice_unit(&d), dice_unit(&d), dice_unit(&d), 0.01f);
    }
    const htree_mesh equal = plain_mesh(same, n), other = plain_mesh(random, n);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        const double base = prove(&other, kind, DEPTH_LIMIT, 10);
        const double took = prove(&equal, kind, 32, 10);
        say("%s: %llu identical triangles built in %.2f of the time of random ones",
            htree_kind_name(kind), (unsigned long long)n, took / base);
#ifndef SUITE_SANITIZED
        assert_true(took <= 4 * base + 0.05);
#endif
    }
    free(same);
    free(random);
}

/* Equal centroids, different sizes: nested like the rings of a target. */
static void equal_centroids_are_bounded(void **state) {
    enum { N = 3000 };
    float *const xyz = (float *)take(N * 36);
    (void)state;
    for (uint32_t i = 0; i < N; ++i) {
        const float r = 1 + (float)i;
        const float corner[9] = {-r, -r, -r, r, r, -r, r, -r, r};
        memcpy(xyz + 9 * i, corner, sizeof corner);
    }
    const htree_mesh mesh = plain_mesh(xyz, N);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        (void)prove(&mesh, kind, DEPTH_LIMIT, 300);
    }
    free(xyz);
}

/* x = 2^-i: halving the box never halves the triangles. */
static void geometric_series_are_bounded(void **state) {
    enum { LEVELS = 250, EACH = 12 };
    static float xyz[LEVELS * EACH * 9];
    (void)state;
    for (uint32_t shape_kind = 0; shape_kind < 3; ++shape_kind) {
        for (int i = 0; i < LEVELS * EACH; ++i) {
            const float at = ldexpf(1, 60 - i / EACH - (shape_kind == 2 ? 0 : 50));
            const float y = shape_kind == 1 ? at : 0,
                        z = shape_kind == 1 ? -at : (float)(i % EACH) * at;
            put_triangle(xyz + 9 * i, at * 0.5f, y * 0.5f, z * 0.125f, at * 0.25f);
        }
        const htree_mesh mesh = plain_mesh(xyz, LEVELS * EACH);
        for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
            (void)prove(&mesh, kind, DEPTH_LIMIT, 300);
        }
    }
}

static void clusters_with_outliers_are_bounded(void **state) {
    enum { N = 20000 };
    float *const xyz = (float *)take(N * 36);
    (void)state;
    for (uint32_t outliers = 1; outliers <= 64; outliers *= 8) {
        dice d = {outliers};
        for (uint32_t i = 0; i < N; ++i) {
            const bool out = i >= N - outliers;
            const float far = out ? ldexpf(1, (int)(i % 40)) : 0;
            put_triangle(xyz + 9 * i, far + dice_unit(&d), dice_unit(&d) - far, dice_unit(&d),
                         0.02f);
        }
        const htree_mesh mesh = plain_mesh(xyz, N);
        for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
            (void)prove(&mesh, kind, DEPTH_LIMIT, 60);
        }
    }
    free(xyz);
}

/* All but one are the same; and two heaps of identical ones. */
static void heaps_are_bounded(void **state) {
    enum { N = 5000 };
    float *const xyz = (float *)take(N * 36);
    (void)state;
    for (uint32_t other = 1; other <= N / 2; other = other * 7 + 1) {
        for (uint32_t i = 0; i < N; ++i)
            put_triangle(xyz + 9 * i, i < other ? 5.0f : 0.0f, 0, 0, 1);
        const htree_mesh mesh = plain_mesh(xyz, N);
        for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
            (void)prove(&mesh, kind, 32, 60);
        }
    }
    free(xyz);
}

#ifdef SUITE_SMALL_STACK

/* ---- A small stack -------------------------------------------------------------------------- */

typedef struct errand {
    const htree_mesh *mesh;
    htree_kind kind;
    htree_status status;
} errand;

static void *run_errand(void *data) {
    errand *const e = (errand *)data;
    htree_options options;
    htree *tree = NULL;
    e->status = htree_options_init(&options, sizeof options, e->kind);
    if (e->status == HTREE_OK) e->status = htree_build(&tree, e->mesh, &options);
    if (e->status == HTREE_OK) e->status = htree_check(tree);
    const htree_ray ray = {{0.3f, 0.4f, 9}, 0, {0, 0.01f, -1}, INFINITY};
    htree_hit hits[2];
    const htree_ray rays[2] = {ray, ray};
    if (e->status == HTREE_OK) e->status = htree_intersect(tree, rays, 2, hits, NULL);
    htree_free(tree);
    return NULL;
}

static void a_stack_of_64_kib_is_enough(void **state) {
    (void)state;
    enum { N = 3000 };
    static float xyz[N * 9];
    for (int i = 0; i < N; ++i) {
        const float at = ldexpf(1, 55 - i / 20);
        put_triangle(xyz + 9 * i, at * 0.5f, 0, (float)(i % 20) * at * 0.1f, at * 0.25f);
    }
    const htree_mesh mesh = plain_mesh(xyz, N);
    const long least = sysconf(_SC_THREAD_STACK_MIN); /* on 64-bit ARM: 128 KiB */
    const size_t bytes = least > 65536 ? (size_t)least : 65536;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        errand e = {&mesh, kind, HTREE_ERROR_CORRUPT};
        pthread_attr_t attributes;
        pthread_t thread;
        assert_int_equal(pthread_attr_init(&attributes), 0);
        assert_int_equal(pthread_attr_setstacksize(&attributes, bytes), 0);
        assert_int_equal(pthread_create(&thread, &attributes, run_errand, &e), 0);
        assert_int_equal(pthread_join(thread, NULL), 0);
        assert_int_equal(e.status, HTREE_OK);
        pthread_attr_destroy(&attributes);
    }
}

#endif

static void report_trees(void **state) {
    (void)state;
    say("%llu skewed trees proved", (unsigned long long)trees_built);
    assert_true(trees_built > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(identical_triangles_are_split_by_index),
        cmocka_unit_test(equal_centroids_are_bounded),
        cmocka_unit_test(geometric_series_are_bounded),
        cmocka_unit_test(clusters_with_outliers_are_bounded),
        cmocka_unit_test(heaps_are_bounded),
#ifdef SUITE_SMALL_STACK
        cmocka_unit_test(a_stack_of_64_kib_is_enough),
#endif
        cmocka_unit_test(report_trees),
    };
    return cmocka_run_group_tests_name("skew", tests, NULL, NULL);
}
