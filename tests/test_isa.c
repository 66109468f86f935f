/* test_isa.c: every instruction set gives the same hits and builds the same trees, bit for bit: each path
 * is forced, where the machine has it. White-box: a tree's choice is written to. */
#include "oracle.h"
#include "rays.h"

#include "tree/tree.h"

/* What this architecture may have, each on top of those before it. */
static const struct {
    ht_isa isa;
    const char *name;
} paths[] = {
    {HT_PORTABLE, "portable"},
#ifdef HT_ARM
    {HT_NEON, "NEON"},
#endif
#ifdef HT_X86
    {HT_AVX2, "AVX2"},
    {HT_AVX512, "AVX-512"},
#endif
};

static uint64_t rays_total, differences_total;
static uint32_t last_path;

/* Rays in one batch, one by one, and all but the last: no ray knows its neighbours. */
static void compare_path(const htree *tree, const htree_ray *rays, const htree_hit *truth,
                         uint64_t count) {
    htree_hit *const hits = (htree_hit *)take(count * sizeof *hits);
    differences_total += batch_differs(tree, rays, truth, count);
    for (uint64_t i = 0; i < count; i += 7) {
        uint8_t one_any = 0x5a;
        htree_hit one;
        const uint64_t few = i % 5 < count - i ? i % 5 : 0;
        assert_int_equal(htree_intersect(tree, &rays[i], 1, &one, NULL), HTREE_OK);
        assert_int_equal(htree_occluded(tree, &rays[i], 1, &one_any, NULL), HTREE_OK);
        differences_total += hits_differ(&one, &truth[i], 1);
        differences_total += one_any != (truth[i].prim != HTREE_NONE);
        assert_int_equal(htree_intersect(tree, &rays[i], few, hits, NULL), HTREE_OK);
        differences_total += hits_differ(hits, &truth[i], few);
    }
    rays_total += count;
    free(hits);
}

static void compare_paths(const htree_mesh *mesh, uint32_t flags, const htree_ray *rays,
                          uint64_t count) {
    htree_hit *const truth = (htree_hit *)take(count * sizeof *truth);
    oracle o = oracle_of(mesh);
    htree_options options = options_of(HTREE_WIDE);
    options.threads = 1;
    options.flags |= flags;
    htree *const tree = tree_of(mesh, &options);
    const ht_isa best = tree->isa;
    (void)oracle_batch(&o, rays, count, truth);
    for (uint32_t i = 0; i < COUNT_OF(paths) && paths[i].isa <= best; ++i) {
        tree->isa = paths[i].isa;
        compare_path(tree, rays, truth, count);
        last_path = i;
    }
    oracle_free(&o);
    htree_free(tree);
    free(truth);
}

static void every_path_equals_the_oracle(void **state) {
    const uint64_t count = scaled(14 * 700);
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    uint32_t seed = 1;
    (void)state;
    for (const char *const *name = shape_names(); *name != NULL; ++name, ++seed) {
        for (uint64_t triangles = 5; triangles <= 1000; triangles *= 14) {
            shape s = shape_of(*name, triangles, seed);
            const htree_mesh mesh = mesh_of(&s);
            const ray_target target = ray_target_of(&mesh);
            dice d = {seed};
            rays_make_mixed(&target, &d, rays, count);
            compare_paths(&mesh, 0, rays, count);
            compare_paths(&mesh, HTREE_COMPACT, rays, count / 4);
            shape_free(&s);
        }
    }
    free(rays);
    say("%s to %s: %llu rays in all, %llu differences", paths[0].name, paths[last_path].name,
        (unsigned long long)rays_total, (unsigned long long)differences_total);
    tally("oracle rays", rays_total);
    assert_int_equal(differences_total, 0);
}

/* ---- Builds --------------------------------------------------------------------------------- */

/* Every ninth triangle loses its area: a corner is there twice, or all are on a line; or nearly so. */
static void flatten_some(shape *s) {
    static const float on_line[3][3] = {{0, 0, 0}, {1, 2, 3}, {2, 4, 6}};
    for (uint64_t i = 4; i < s->triangle_count; i += 9) {
        uint32_t *const corners = s->indices + 3 * i;
        if (i % 27 == 4) {
            corners[1] = corners[0];
            continue;
        }
        for (uint32_t k = 0; k < 3; ++k)
            memcpy(s->positions + 3 * (uint64_t)corners[k], on_line[k], sizeof on_line[k]);
        if (i % 27 == 22) s->positions[3 * (uint64_t)corners[2]] = 2.0000002f;
    }
}

static uint64_t trees_total;

static void compare_builds(const htree_mesh *mesh, htree_kind effort) {
    htree_options options;
    htree_options_init(&options, sizeof options, effort);
    options.threads = 2;
    htree *const tree = tree_of(mesh, &options), *const other = tree_of(mesh, &options);
    const ht_isa best = tree->isa;
    for (uint32_t i = 0; i < COUNT_OF(paths) && paths[i].isa <= best; ++i, ++trees_total) {
        other->isa = paths[i].isa;
        assert_int_equal(htree_update(other, mesh, HTREE_REBUILD, NULL), HTREE_OK);
        assert_int_equal(other->isa, paths[i].isa);
        assert_same_trees(tree, other);
    }
    htree_free(other);
    htree_free(tree);
}

static void every_path_builds_the_same_tree(void **state) {
    (void)state;
    for (const char *const *name = shape_names(); *name != NULL; ++name) {
        for (uint64_t triangles = 30; triangles <= 30000; triangles *= 10) {
            shape s = shape_of(*name, triangles, 3);
            const htree_mesh mesh = mesh_of(&s);
            compare_builds(&mesh, HTREE_FAST);
            flatten_some(&s);
            compare_builds(&mesh, HTREE_FAST);
            compare_builds(&mesh, HTREE_BALANCED);
            shape_free(&s);
        }
    }
    say("%llu trees", (unsigned long long)trees_total);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_path_equals_the_oracle),
                                       cmocka_unit_test(every_path_builds_the_same_tree)};
    return cmocka_run_group_tests_name("isa", tests, NULL, NULL);
}
