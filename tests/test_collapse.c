/* test_collapse.c: binary hierarchies become wide trees that answer the same. */
#include "ledger.h"
#include "oracle.h"

static const htree_kind kinds[] = {HTREE_BVH_MEDIAN, HTREE_BVH_SAH, HTREE_SKD, HTREE_H, HTREE_AH};

static htree_options collapse_options(htree_kind kind, uint32_t flags) {
    htree_options options = options_of(kind);
    options.flags = HTREE_COLLAPSE | flags;
    return options;
}

static void collapsed_trees_answer_as_the_oracle(void **state) {
    static const uint32_t flags[] = {0, HTREE_COMPACT, HTREE_ANY_PLANES};
    uint32_t seed = 1;
    (void)state;
    for (const char *const *name = shape_names(); *name != NULL; ++name, ++seed) {
        for (uint32_t i = 0; i < COUNT_OF(kinds); ++i) {
            shape s = shape_of(*name, 10 + 700 * (seed % 4), seed);
            const htree_mesh mesh = mesh_of(&s);
            const htree_options options = collapse_options(kinds[i], flags[(seed + i) % 3]);
            htree *const tree = tree_of(&mesh, &options);
            const htree_stats stats = stats_of(tree);
            assert_int_equal(htree_check(tree), HTREE_OK);
            if (stats.nodes) assert_int_equal(stats.kind, HTREE_WIDE);
            assert_int_equal(stats.references + stats.invalid + stats.degenerate, s.triangle_count);
            oracle_compare(tree, &mesh, scaled(600) + 20, seed);
            htree_free(tree);
            shape_free(&s);
        }
    }
}

/* Chains of nodes, as equal centroids and far outliers make them, stay within the wide levels. */
static void deep_trees_stay_within_their_levels(void **state) {
    enum { CHAIN = 400 };
    float *const positions = (float *)take(CHAIN * 9 * sizeof *positions);
    htree_mesh mesh;
    (void)state;
    memset(&mesh, 0, sizeof mesh);
    float scale = 1e-18f;
    for (uint32_t i = 0; i < CHAIN; ++i, scale *= 1.24f) {
        const float corners[9] = {scale, 0, 0, 2 * scale, scale, 0, scale, 0, scale};
        memcpy(positions + 9 * i, corners, sizeof corners);
    }
    mesh.positions = positions;
    mesh.vertex_count = 3 * CHAIN;
    mesh.triangle_count = CHAIN;
    for (uint32_t i = 0; i < COUNT_OF(kinds); ++i) {
        const htree_options options = collapse_options(kinds[i], 0);
        htree *const tree = tree_of(&mesh, &options);
        say("%s: depth %lu, stack %lu", htree_kind_name(kinds[i]),
            (unsigned long)stats_of(tree).depth, (unsigned long)stats_of(tree).stack);
        assert_int_equal(htree_check(tree), HTREE_OK);
        oracle_compare(tree, &mesh, 500, i);
        htree_free(tree);
    }
    free(positions);
}

static void every_allocation_may_fail(void **state) {
    shape s = shape_of("knot", 3000, 3);
    const htree_mesh mesh = mesh_of(&s);
    const htree_options options = collapse_options(HTREE_H, 0);
    (void)state;
    ledger_fail_builds(&mesh, &options);
    shape_free(&s);
}

/* Rebuilding begins with the binary kind again. */
static void collapsed_trees_can_be_updated(void **state) {
    shape s = shape_of("knot", 3000, 3);
    const htree_mesh mesh = mesh_of(&s);
    const htree_options options = collapse_options(HTREE_H, 0);
    htree *const tree = tree_of(&mesh, &options);
    (void)state;
    for (uint64_t i = 0; i < 3 * s.vertex_count; ++i) s.positions[i] *= i % 3 ? 1.5f : 0.5f;
    assert_int_equal(htree_update(tree, &mesh, HTREE_REFIT, NULL), HTREE_OK);
    oracle_compare(tree, &mesh, 500, 1);
    assert_int_equal(htree_update(tree, &mesh, HTREE_REBUILD, NULL), HTREE_OK);
    assert_int_equal(stats_of(tree).kind, HTREE_WIDE);
    oracle_compare(tree, &mesh, 500, 2);
    htree_free(tree);
    shape_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(collapsed_trees_answer_as_the_oracle),
        cmocka_unit_test(deep_trees_stay_within_their_levels),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(collapsed_trees_can_be_updated),
    };
    return cmocka_run_group_tests_name("collapse", tests, NULL, NULL);
}
