/* test_isa.c: every instruction set gives the same hits, bit for bit: each path is forced, where the
 * machine has it. White-box: a tree's choice is written to. */
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

static void compare_paths(const htree_mesh *mesh, const htree_ray *rays, uint64_t count) {
    htree_hit *const truth = (htree_hit *)take(count * sizeof *truth);
    oracle o = oracle_of(mesh);
    htree *const tree = tree_of_kind(mesh, HTREE_WIDE);
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
            compare_paths(&mesh, rays, count);
            shape_free(&s);
        }
    }
    free(rays);
    say("%s to %s: %llu rays in all, %llu differences", paths[0].name, paths[last_path].name,
        (unsigned long long)rays_total, (unsigned long long)differences_total);
    tally("oracle rays", rays_total);
    assert_int_equal(differences_total, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_path_equals_the_oracle)};
    return cmocka_run_group_tests_name("isa", tests, NULL, NULL);
}
