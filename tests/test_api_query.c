/* test_api_query.c: what test_api.c does for building, for the functions that take a finished tree.
 */
#include "refuse.h"

#include <pthread.h>

static htree *good_tree(void) {
    const htree_mesh mesh = good_mesh();
    return tree_of_kind(&mesh, next_kind(0));
}

static const htree_ray good_ray = {{0.25f, 0.25f, 1}, 0, {0, 0, -1}, 10};

static htree_query good_query(void) {
    htree_query query;
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    return query;
}

static void query_init_refuses_bad_arguments(void **state) {
    htree_query query;
    (void)state;
    assert_refused(htree_query_init(NULL, sizeof query), HTREE_ERROR_ARGUMENT);
    assert_refused(htree_query_init(&query, UINT64_MAX), HTREE_ERROR_ARGUMENT);
    for (uint64_t size = 0; size < sizeof query; ++size) {
        memset(&query, 0x5a, sizeof query);
        assert_refused(htree_query_init(&query, size), HTREE_ERROR_ARGUMENT);
        for (uint64_t i = 0; i < sizeof query; ++i)
            assert_int_equal(((const char *)&query)[i], 0x5a);
    }
}

static void query_init_writes_every_default(void **state) {
    htree_query a, b;
    (void)state;
    memset(&a, 0x00, sizeof a);
    memset(&b, 0xff, sizeof b);
    assert_int_equal(htree_query_init(&a, sizeof a), HTREE_OK);
    assert_int_equal(htree_query_init(&b, sizeof b), HTREE_OK);
    assert_memory_equal(&a, &b, sizeof a);
    assert_int_equal(a.size, sizeof a);
    assert_null(a.counters);
}

/* Both queries must refuse alike, and write nothing. */
static void assert_both_refused(const htree *tree, const htree_ray *rays, uint64_t count,
                                const htree_query *query) {
    htree_hit hit;
    uint8_t any = 0x5a;
    memset(&hit, 0x5a, sizeof hit);
    assert_refused(htree_intersect(tree, rays, count, &hit, query), HTREE_ERROR_ARGUMENT);
    assert_refused(htree_occluded(tree, rays, count, &any, query), HTREE_ERROR_ARGUMENT);
    for (uint64_t i = 0; i < sizeof hit; ++i) assert_int_equal(((const char *)&hit)[i], 0x5a);
    assert_int_equal(any, 0x5a);
}

static void queries_refuse_null(void **state) {
    htree *const tree = good_tree();
    (void)state;
    assert_both_refused(NULL, &good_ray, 1, NULL);
    assert_both_refused(NULL, NULL, 0, NULL);
    assert_both_refused(tree, NULL, 1, NULL);
    assert_refused(htree_intersect(tree, &good_ray, 1, NULL, NULL), HTREE_ERROR_ARGUMENT);
    assert_refused(htree_occluded(tree, &good_ray, 1, NULL, NULL), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_intersect(tree, NULL, 0, NULL, NULL), HTREE_OK);
    assert_int_equal(htree_occluded(tree, NULL, 0, NULL, NULL), HTREE_OK);
    htree_free(tree);
}

static void queries_refuse_counts_beyond_memory(void **state) {
    static const uint64_t counts[] = {UINT64_MAX, UINT64_MAX / 16 + 1, UINT64_MAX / 32 + 1};
    htree *const tree = good_tree();
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(counts); ++i)
        assert_both_refused(tree, &good_ray, counts[i], NULL);
    htree_free(tree);
}

static void queries_refuse_bad_flags_and_reserved_words(void **state) {
    htree *const tree = good_tree();
    (void)state;
    for (uint32_t bit = 0; bit < 32; ++bit) {
        htree_query bad = good_query();
        bad.flags = 1u << bit;
        assert_both_refused(tree, &good_ray, 1, &bad);
        bad = good_query();
        bad.reserved = 1u << bit;
        assert_both_refused(tree, &good_ray, 1, &bad);
    }
    htree_free(tree);
}

static void queries_take_longer_structs_with_a_zero_tail_only(void **state) {
    enum { LONGER = 32 };
    union {
        htree_query query;
        unsigned char bytes[sizeof(htree_query) + LONGER];
    } u;
    htree *const tree = good_tree();
    (void)state;
    for (uint32_t extra = 0; extra <= LONGER; extra += 4) {
        htree_hit hit;
        memset(&u, 0, sizeof u);
        u.query = good_query();
        u.query.size = (uint32_t)sizeof u.query + extra;
        assert_int_equal(htree_intersect(tree, &good_ray, 1, &hit, &u.query), HTREE_OK);
        assert_int_equal(hit.prim, 0);
        if (extra == 0) continue;
        u.bytes[sizeof u.query + extra - 1] = 1;
        assert_both_refused(tree, &good_ray, 1, &u.query);
    }
    for (uint32_t size = 0; size < sizeof u.query; ++size) {
        u.query = good_query();
        u.query.size = size;
        assert_both_refused(tree, &good_ray, 1, &u.query);
    }
    htree_free(tree);
}

static void inspection_refuses_bad_arguments(void **state) {
    htree *const tree = good_tree();
    htree_box box;
    htree_stats stats;
    (void)state;
    assert_refused(htree_get_bounds(NULL, &box), HTREE_ERROR_ARGUMENT);
    assert_refused(htree_get_bounds(tree, NULL), HTREE_ERROR_ARGUMENT);
    assert_refused(htree_get_bounds(NULL, NULL), HTREE_ERROR_ARGUMENT);
    assert_refused(htree_get_stats(tree, NULL), HTREE_ERROR_ARGUMENT);
    assert_refused(htree_check(NULL), HTREE_ERROR_ARGUMENT);
    memset(&stats, 0x5a, sizeof stats);
    stats.size = sizeof stats;
    assert_refused(htree_get_stats(NULL, &stats), HTREE_ERROR_ARGUMENT);
    for (uint32_t size = 0; size < sizeof stats; ++size) {
        stats.size = size;
        assert_refused(htree_get_stats(tree, &stats), HTREE_ERROR_ARGUMENT);
        assert_int_equal(stats.size, size);
        for (uint64_t i = 4; i < sizeof stats; ++i)
            assert_int_equal(((const char *)&stats)[i], 0x5a);
    }
    htree_free(tree);
}

static void stats_are_of_the_tree(void **state) {
    htree *const tree = good_tree();
    (void)state;
    const htree_stats stats = stats_of(tree);
    assert_int_equal(stats.size, sizeof stats);
    assert_int_equal(stats.kind, next_kind(0));
    assert_int_equal(stats.triangles, 1);
    assert_int_equal(stats.objects, 0);
    assert_int_equal(stats.invalid, 0);
    assert_int_equal(stats.degenerate, 0);
    assert_true(stats.references >= 1);
    assert_true(stats.nodes >= 1 && stats.leaves >= 1 && stats.depth >= 1);
    assert_true(stats.bytes > 36 && stats.peak_bytes >= stats.bytes);
    assert_true(stats.build_seconds >= 0 && stats.build_seconds < 1);
    assert_true(stats.sah_cost > 0);
    htree_free(tree);
}

static void bounds_are_those_of_the_triangle(void **state) {
    const htree_box should = {{0, 0, 0}, {1, 1, 0}};
    htree *const tree = good_tree();
    htree_box box;
    (void)state;
    assert_int_equal(htree_get_bounds(tree, &box), HTREE_OK);
    assert_memory_equal(&box, &should, sizeof box);
    htree_free(tree);
}

static void *read_text(void *out) {
    (void)snprintf((char *)out, 256, "%s", htree_error_text());
    return NULL;
}

static void the_text_belongs_to_the_thread(void **state) {
    char text[256] = "?";
    pthread_t thread;
    (void)state;
    assert_refused(htree_check(NULL), HTREE_ERROR_ARGUMENT);
    assert_int_equal(pthread_create(&thread, NULL, read_text, text), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_string_equal(text, "");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(query_init_refuses_bad_arguments),
        cmocka_unit_test(query_init_writes_every_default),
        cmocka_unit_test(queries_refuse_null),
        cmocka_unit_test(queries_refuse_counts_beyond_memory),
        cmocka_unit_test(queries_refuse_bad_flags_and_reserved_words),
        cmocka_unit_test(queries_take_longer_structs_with_a_zero_tail_only),
        cmocka_unit_test(inspection_refuses_bad_arguments),
        cmocka_unit_test(stats_are_of_the_tree),
        cmocka_unit_test(bounds_are_those_of_the_triangle),
        cmocka_unit_test(the_text_belongs_to_the_thread),
    };
    const int failed = cmocka_run_group_tests_name("api_query", tests, NULL, NULL);
    say("%llu bad calls refused", (unsigned long long)refusals());
    return failed;
}
