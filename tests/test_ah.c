/* test_ah.c: the AH-tree of section 7 on what it is made for and on what breaks it: objects
 * larger than a cell, in every share; a crowd in one cell; shelves inside shelves; planes as
 * loose as the paper's. */
#include "oracle.h"

static uint64_t trees_proved, rays_compared;

/* `n` small triangles spread in a unit cube, of which every `one_in`-th spans a good part of it. */
static float *mixed_sizes(uint64_t n, uint32_t one_in, uint32_t seed) {
    float *const xyz = (float *)take(n * 36);
    dice d = {seed};
    for (uint64_t i = 0; i < n; ++i) {
        const float size = one_in && i % one_in == 0 ? dice_between(&d, 0.05f, 0.8f) : 0.004f;
        for (uint64_t k = 0; k < 9; ++k) xyz[9 * i + k] = dice_between(&d, -size, size);
        for (uint64_t axis = 0; axis < 3; ++axis) {
            const float at = dice_unit(&d);
            for (uint64_t corner = 0; corner < 3; ++corner) xyz[9 * i + 3 * corner + axis] += at;
        }
    }
    return xyz;
}

/* The least of three builds: what else runs on the machine only ever adds. */
static double build_seconds(const htree_mesh *mesh, const htree_options *options) {
    double least = 1e9;
    for (int i = 0; i < 3; ++i) {
        htree *const tree = tree_of(mesh, options);
        const double took = stats_of(tree).build_seconds;
        if (took < least) least = took;
        htree_free(tree);
    }
    return least;
}

static htree_stats compare(const htree_mesh *mesh, const htree_options *options, uint64_t rays) {
    htree *const tree = tree_of(mesh, options);
    oracle_compare(tree, mesh, rays, 7);
    const htree_stats stats = stats_of(tree);
    if (stats.kind != HTREE_WIDE) assert_int_equal(stats.leaves, stats.references);
    rays_compared += rays;
    ++trees_proved;
    htree_free(tree);
    return stats;
}

static void oversize_objects_wait_on_shelves(void **state) {
    static const uint32_t one_in[] = {0, 100, 10, 2, 1};
    (void)state;
    double uniform = 0;
    for (uint32_t i = 0; i < COUNT_OF(one_in); ++i) {
        const uint64_t n = scaled(20000) + 400;
        float *const xyz = mixed_sizes(n, one_in[i], 3);
        const htree_mesh mesh = plain_mesh(xyz, n);
        htree_options options = options_of(HTREE_AH);
        const htree_stats stats = compare(&mesh, &options, scaled(2000));
        const double seconds = build_seconds(&mesh, &options);
        if (i == 0) uniform = seconds;
        say("1 in %u oversize: %llu shelves, built in %.2f of the time of none", one_in[i],
            (unsigned long long)stats.ternary_nodes, seconds / uniform);
        if (one_in[i] == 100 && n > 10000) assert_true(stats.ternary_nodes > 0);
#ifndef SUITE_SANITIZED
        assert_true(seconds <= 4 * uniform + 0.01);
#endif
        options.flags = HTREE_LOOSE_PLANES;
        options.few_prims = 4;
        compare(&mesh, &options, scaled(1000));
        options.flags = HTREE_ANY_PLANES;
        options.cells_per_prim = 16;
        compare(&mesh, &options, scaled(1000));
        free(xyz);
    }
}

static void a_teapot_in_a_stadium_gets_a_grid_of_its_own(void **state) {
    const uint64_t n = scaled(20000) + 400;
    float *const xyz = mixed_sizes(n, 0, 5);
    (void)state;
    /* All but a few in a millionth of the stadium's width. */
    for (uint64_t i = 0; i < 9 * n; ++i) xyz[i] *= i < 9 * 20 ? 1000.0f : 0.001f;
    const htree_mesh mesh = plain_mesh(xyz, n);
    const htree_options options = options_of(HTREE_AH);
    const htree_stats stats = compare(&mesh, &options, scaled(2000));
    say("stadium: depth %u, %.1f ms", stats.depth, 1e3 * stats.build_seconds);
    free(xyz);
}

static void every_small_handover_and_density_equals_the_oracle(void **state) {
    static const uint32_t few[] = {1, 2, 7, 50, 1000};
    static const float density[] = {1.0f / 64, 0.25f, 1, 8, 64};
    (void)state;
    for (uint32_t n = 1; n <= 1024; n = n < 8 ? n + 1 : n + n / 3) {
        float *const xyz = mixed_sizes(n, n % 7, n);
        const htree_mesh mesh = plain_mesh(xyz, n);
        for (uint32_t i = 0; i < COUNT_OF(few); ++i) {
            htree_options options = options_of(HTREE_AH);
            options.few_prims = few[i];
            options.cells_per_prim = density[(i + n) % COUNT_OF(density)];
            options.flags = n % 2 ? HTREE_LOOSE_PLANES : 0;
            compare(&mesh, &options, scaled(64));
        }
        free(xyz);
    }
}

static void presets_are_kinds_and_costs_can_be_measured(void **state) {
    static const htree_kind preset[] = {HTREE_FAST, HTREE_BALANCED, HTREE_BEST};
    float *const xyz = mixed_sizes(500, 9, 1);
    const htree_mesh mesh = plain_mesh(xyz, 500);
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(preset); ++i) {
        htree_options options = options_of(preset[i]);
        assert_true(options.kind >= HTREE_UG && options.kind <= HTREE_WIDE);
        assert_int_equal(htree_kind_from_name(htree_kind_name(preset[i])), preset[i]);
        compare(&mesh, &options, 200);
        options.kind = preset[i]; /* by hand, after htree_options_init */
        compare(&mesh, &options, 10);
        options = options_of(preset[i]);
        assert_int_equal(htree_calibrate(&options), HTREE_OK);
        assert_true(options.cost_skd == 1 && options.cost_bv2 > 0 && options.cost_bv6 > 0);
        compare(&mesh, &options, 200);
    }
    assert_int_equal(htree_calibrate(NULL), HTREE_ERROR_ARGUMENT);
    free(xyz);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(oversize_objects_wait_on_shelves),
        cmocka_unit_test(a_teapot_in_a_stadium_gets_a_grid_of_its_own),
        cmocka_unit_test(every_small_handover_and_density_equals_the_oracle),
        cmocka_unit_test(presets_are_kinds_and_costs_can_be_measured),
    };
    const int failed = cmocka_run_group_tests_name("ah", tests, NULL, NULL);
    say("%llu trees proved, %llu rays, 0 differences", (unsigned long long)trees_proved,
        (unsigned long long)rays_compared);
    tally("oracle rays", rays_compared);
    return failed;
}
