/* test_compact.c: a compact tree takes less than half of the memory and answers the same. White-box: a
 * tree's instruction set is written to. */
#include "ledger.h"
#include "oracle.h"
#include "rays.h"

#include "tree/tree.h"

static htree_options compact_options(uint32_t flags) {
    htree_options options = options_of(HTREE_WIDE);
    options.flags = HTREE_COMPACT | flags;
    return options;
}

/* ---- Hits ----------------------------------------------------------------------------------- */

static uint64_t rays_total, differences_total;

static void compare_with(const htree *tree, const htree_ray *rays, const htree_hit *truth,
                         uint64_t count) {
    differences_total += batch_differs(tree, rays, truth, count);
    rays_total += count;
}

static void compact_trees_answer_as_the_oracle(void **state) {
    const uint64_t count = scaled(3000);
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    htree_hit *const truth = (htree_hit *)take(count * sizeof *truth);
    uint32_t seed = 1;
    (void)state;
    for (const char *const *name = shape_names(); *name != NULL; ++name, ++seed) {
        for (uint64_t triangles = 2; triangles <= 4000; triangles *= 40) {
            shape s = shape_of(*name, triangles, seed);
            const htree_mesh mesh = mesh_of(&s);
            const ray_target target = ray_target_of(&mesh);
            const htree_options options = compact_options(seed % 2 ? HTREE_MORTON : 0);
            dice d = {seed};
            rays_make_mixed(&target, &d, rays, count);
            oracle o = oracle_of(&mesh);
            (void)oracle_batch(&o, rays, count, truth);
            oracle_free(&o);
            htree *const tree = tree_of(&mesh, &options);
            assert_int_equal(htree_check(tree), HTREE_OK);
            const ht_isa best = tree->isa;
            compare_with(tree, rays, truth, count);
            tree->isa = HT_PORTABLE;
            compare_with(tree, rays, truth, count);
            if (best == HT_AVX512) tree->isa = HT_AVX2;
            compare_with(tree, rays, truth, count);
            htree_free(tree);
            shape_free(&s);
        }
    }
    say("%llu rays, %llu differences", (unsigned long long)rays_total,
        (unsigned long long)differences_total);
    tally("oracle rays", rays_total);
    assert_int_equal(differences_total, 0);
    free(truth);
    free(rays);
}

static int32_t hit_a_box(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    const htree_box *const box = (const htree_box *)user + object;
    if (ray->dir[2] == 0) return 0;
    hit->t = (box->lo[2] - ray->org[2]) / ray->dir[2];
    for (int k = 0; k < 2; ++k) {
        const float p = ray->org[k] + hit->t * ray->dir[k];
        if (!(box->lo[k] <= p && p <= box->hi[k])) return 0;
    }
    return ray->tmin <= hit->t && hit->t <= ray->tmax;
}

static void compact_trees_hold_objects(void **state) {
    htree_box boxes[60];
    dice d = {9};
    (void)state;
    for (uint64_t triangles = 0; triangles <= 300; triangles += 100) {
        shape s = shape_of(triangles ? "soup" : "none", triangles, 4);
        htree_mesh mesh = mesh_of(&s);
        const htree_box cube = {{0, 0, 0}, {1, 1, 1}};
        for (uint32_t i = 0; i < COUNT_OF(boxes); ++i) {
            random_in_box(&cube, 0, &d, boxes[i].lo);
            for (int k = 0; k < 3; ++k) boxes[i].hi[k] = boxes[i].lo[k] + (k < 2 ? 0.1f : 0);
        }
        const htree_objects objects = {boxes, COUNT_OF(boxes), hit_a_box, boxes};
        mesh.objects = &objects;
        const htree_options options = compact_options(0);
        htree *const tree = tree_of(&mesh, &options);
        assert_int_equal(htree_check(tree), HTREE_OK);
        oracle_compare(tree, &mesh, 2000, triangles);
        htree_free(tree);
        shape_free(&s);
    }
}

/* ---- Memory --------------------------------------------------------------------------------- */

static void compact_trees_are_small(void **state) {
    static const uint32_t flags[] = {0, HTREE_MORTON};
    shape s = shape_of("knot", 50000, 3);
    const htree_mesh mesh = mesh_of(&s);
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(flags); ++i) {
        htree_options options = compact_options(flags[i]);
        htree *const tree = tree_of(&mesh, &options);
        options.flags = flags[i];
        htree *const large = tree_of(&mesh, &options);
        const htree_stats a = stats_of(tree), b = stats_of(large);
        const double bytes = (double)a.bytes / (double)s.triangle_count;
        say("%.1f bytes a triangle, %.1f otherwise", bytes,
            (double)b.bytes / (double)s.triangle_count);
        assert_true(bytes < 24);
        assert_true(a.nodes == b.nodes && a.leaves == b.leaves && a.references == b.references);
        assert_true(a.sah_cost >= b.sah_cost && a.sah_cost < 1.1 * b.sah_cost);
        htree_free(large);
        htree_free(tree);
    }
    shape_free(&s);
}

static void threads_compact_to_the_same_bytes(void **state) {
    shape s = shape_of("city", 20000, 3);
    const htree_mesh mesh = mesh_of(&s);
    htree_options options = compact_options(0);
    options.threads = 1;
    htree *const one = tree_of(&mesh, &options);
    (void)state;
    for (uint32_t threads = 2; threads <= 8; threads += 3) {
        options.threads = threads;
        htree *const many = tree_of(&mesh, &options);
        assert_int_equal(many->node_bytes, one->node_bytes);
        assert_int_equal(many->vertex_count, one->vertex_count);
        assert_memory_equal(many->nodes, one->nodes, (size_t)one->node_bytes);
        assert_memory_equal(many->compact_leaves, one->compact_leaves,
                            one->leaf_count * sizeof *one->compact_leaves);
        assert_memory_equal(many->vertices, one->vertices, 12 * (size_t)one->vertex_count);
        htree_free(many);
    }
    htree_free(one);
    shape_free(&s);
}

static void every_allocation_may_fail(void **state) {
    shape s = shape_of("knot", 6000, 3);
    const htree_mesh mesh = mesh_of(&s);
    const htree_options options = compact_options(0);
    (void)state;
    ledger_fail_builds(&mesh, &options);
    shape_free(&s);
}

/* ---- What they cannot do -------------------------------------------------------------------- */

static void what_they_cannot_do_is_said(void **state) {
    shape s = shape_of("knot", 3000, 3);
    const htree_mesh mesh = mesh_of(&s);
    htree_options options = compact_options(HTREE_LAZY);
    htree *tree = (htree *)(uintptr_t)8;
    htree_view view;
    double quality = 0;
    (void)state;
    assert_int_equal(htree_build(&tree, &mesh, &options), HTREE_ERROR_ARGUMENT);
    assert_null(tree);
    options.flags = HTREE_COMPACT;
    tree = tree_of(&mesh, &options);
    view.size = sizeof view;
    assert_int_equal(htree_get_view(tree, &view), HTREE_ERROR_UNSUPPORTED);
    assert_int_equal(htree_complete(tree), HTREE_OK);
    for (uint64_t i = 0; i < 3 * s.vertex_count; ++i) s.positions[i] *= 2;
    assert_int_equal(htree_update(tree, &mesh, HTREE_REFIT, &quality), HTREE_OK);
    assert_true(quality == 1 && ht_is_compact(tree));
    oracle_compare(tree, &mesh, 1000, 3);
    htree_free(tree);
    shape_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(compact_trees_answer_as_the_oracle),
        cmocka_unit_test(compact_trees_hold_objects),
        cmocka_unit_test(compact_trees_are_small),
        cmocka_unit_test(threads_compact_to_the_same_bytes),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(what_they_cannot_do_is_said),
    };
    return cmocka_run_group_tests_name("compact", tests, NULL, NULL);
}
