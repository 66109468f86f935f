/* test_special.c: every ray whose origin and direction are made of eleven special numbers: 11^6 of them,
 * on every kind, against the oracle and against the rule of htree.h for rays that miss by their numbers.
 */
#include "oracle.h"

#include <float.h>
#include <math.h>

enum { VALUES = 11, BATCH = VALUES * VALUES * VALUES };

static const float special[VALUES] = {0,       -0.0f,    1,         -1,  1e-45f, FLT_MIN,
                                      FLT_MAX, INFINITY, -INFINITY, NAN, 1e30f};

/* Triangles in planes, on lines and at points where such rays come by, near and at the limits. */
static const float corners[][9] = {
    {0, 0, 0, 1, 0, 0, 0, 1, 0},
    {0, 0, 0, 0, 0, 1, 1, 0, 0},
    {0, 0, 0, 0, 1, 0, 0, 0, 1},
    {1, 0, 0, 0, 1, 0, 0, 0, 1},
    {-1, -1, -1, -1, 2, -1, 2, -1, -1},
    {-1, -1, 1, 3, -1, 1, -1, 3, 1},
    {1, -1, -1, 1, 3, -1, 1, -1, 3},
    {-1, 2, -1, 3, 2, -1, -1, 2, 3},
    {1e-45f, 0, 0, 0, 1e-45f, 0, 0, 0, 1e-45f},
    {FLT_MIN, 0, 0, 0, FLT_MIN, 0, 0, 0, -FLT_MIN},
    {-1e18f, -1e18f, 5, 1e18f, -1e18f, 5, 0, 1e18f, 5},
    {1e18f, -3, -3, 1e18f, 3, -3, 1e18f, 0, 3},
};

static bool is_within(float x, float most) {
    return fabsf(x) <= most;
}

/* As htree.h says it; written apart from the library. */
static bool is_valid(const htree_ray *ray) {
    const float most = HTREE_COORDINATE_MAX;
    float largest = 0;
    for (int k = 0; k < 3; ++k) {
        if (!is_within(ray->org[k], most) || !is_within(ray->dir[k], most)) return false;
        if (fabsf(ray->dir[k]) > largest) largest = fabsf(ray->dir[k]);
    }
    return largest >= 1 / most && ray->tmin <= ray->tmax;
}

/* The rays of one origin with every direction. */
static void make_rays(uint32_t number, float tmin, float tmax, htree_ray *rays) {
    for (uint32_t i = 0; i < BATCH; ++i) {
        const uint32_t org[3] = {number % 11, number / 11 % 11, number / 121};
        const uint32_t dir[3] = {i % 11, i / 11 % 11, i / 121};
        for (int k = 0; k < 3; ++k) {
            rays[i].org[k] = special[org[k]];
            rays[i].dir[k] = special[dir[k]];
        }
        rays[i].tmin = tmin;
        rays[i].tmax = tmax;
    }
}

typedef struct sums {
    uint64_t rays, answers, hits, valid;
} sums;

/* Rays that miss by their numbers take no step, whatever the tree. */
static void check_batch(const htree *tree, const htree_ray *rays, const htree_hit *truth) {
    static htree_hit hits[BATCH];
    static uint8_t any[BATCH];
    static htree_counters counters[BATCH];
    htree_query query;
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    query.threads = 1;
    query.counters = counters;
    assert_int_equal(htree_intersect(tree, rays, BATCH, hits, NULL), HTREE_OK);
    assert_memory_equal(hits, truth, sizeof hits);
    assert_int_equal(htree_intersect(tree, rays, BATCH, hits, &query), HTREE_OK);
    assert_memory_equal(hits, truth, sizeof hits);
    assert_int_equal(htree_occluded(tree, rays, BATCH, any, NULL), HTREE_OK);
    for (uint32_t i = 0; i < BATCH; ++i) {
        assert_int_equal(any[i], truth[i].prim != HTREE_NONE);
        if (is_valid(&rays[i])) continue;
        assert_int_equal(truth[i].prim, HTREE_NONE);
        assert_int_equal(counters[i].traversal_steps, 0);
        assert_int_equal(counters[i].intersections, 0);
    }
}

static void prove(float tmin, float tmax, uint32_t step) {
    static htree_ray rays[BATCH];
    static htree_hit truth[BATCH];
    const htree_mesh mesh = plain_mesh(&corners[0][0], COUNT_OF(corners));
    htree *trees[HTREE_WIDE + 1] = {NULL};
    oracle o = oracle_of(&mesh);
    sums all = {0, 0, 0, 0};
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind))
        trees[kind] = tree_of_kind(&mesh, kind);
    for (uint32_t number = 0; number < BATCH; number += step) {
        make_rays(number, tmin, tmax, rays);
        all.hits += oracle_batch(&o, rays, BATCH, truth);
        all.rays += BATCH;
        for (uint32_t i = 0; i < BATCH; ++i) all.valid += is_valid(&rays[i]);
        for (htree_kind kind = 1; kind <= HTREE_WIDE; ++kind)
            if (trees[kind] != NULL) {
                check_batch(trees[kind], rays, truth);
                all.answers += BATCH;
            }
    }
    for (htree_kind kind = 1; kind <= HTREE_WIDE; ++kind) htree_free(trees[kind]);
    oracle_free(&o);
    say("t from %g to %g: %llu rays on every kind, %llu of them valid, %llu hits", (double)tmin,
        (double)tmax, (unsigned long long)all.rays, (unsigned long long)all.valid,
        (unsigned long long)all.hits);
    tally("special rays", all.answers);
    assert_true(all.hits > 0 && all.valid >= all.hits && all.valid < all.rays);
}

/* One origin in so many: all in a whole run. */
static uint32_t step_of(uint32_t wanted) {
    const uint64_t part = scaled(1000);
    return part >= 1000 ? wanted : (uint32_t)(wanted * 1000 / part) | 1;
}

static void every_special_ray_has_one_answer(void **state) {
    (void)state;
    prove(0, INFINITY, step_of(1));
}

static void and_so_it_has_on_the_whole_line(void **state) {
    (void)state;
    prove(-INFINITY, INFINITY, step_of(7));
    prove(-1, 1, step_of(7));
    prove(1e-45f, FLT_MAX, step_of(7));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_special_ray_has_one_answer),
        cmocka_unit_test(and_so_it_has_on_the_whole_line),
    };
    return cmocka_run_group_tests_name("special", tests, NULL, NULL);
}
