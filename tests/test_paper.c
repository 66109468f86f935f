/* test_paper.c: what the paper says about the structures, seen through statistics and, white-box,
 * through the nodes of lib/tree/layout.h. Sections are those of Havran et al. 2006. */
#include "rays.h"

#include "tree/layout.h"
#include "tree/tree.h"

#include <math.h>

static bool is_here(htree_kind wanted) {
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        if (kind == wanted) return true;
    }
    return false;
}

/* Objects in leaves: the mesh's less what was skipped. */
static uint64_t hittable(const htree_stats *stats) {
    return stats->triangles + stats->objects - stats->invalid - stats->degenerate;
}

static void for_each_shape(htree_kind kind, void (*prove)(const char *name, const htree *tree,
                                                          const htree_stats *)) {
    uint32_t trees = 0;
    for (const char *const *name = shape_names(); *name != NULL; ++name) {
        for (uint64_t triangles = 30; triangles <= 30000; triangles *= 10) {
            shape s = shape_of(*name, triangles, 1);
            const htree_mesh mesh = mesh_of(&s);
            htree *const tree = tree_of_kind(&mesh, kind);
            const htree_stats stats = stats_of(tree);
            if (hittable(&stats) > 0) prove(*name, tree, &stats);
            htree_free(tree);
            shape_free(&s);
            ++trees;
        }
    }
    say("%s: %u trees", htree_kind_name(kind), trees);
}

/* ---- Section 5: BVH by SAH ------------------------------------------------------------------ */

static void prove_binary(const char *name, const htree *tree, const htree_stats *stats) {
    const uint64_t n = hittable(stats);
    (void)name;
    (void)tree;
    assert_int_equal(stats->leaves, n);
    assert_int_equal(stats->references, n);
    assert_int_equal(stats->nodes, 2 * n - 1);
    assert_true(stats->depth <= n);
}

static void a_bvh_has_one_object_a_leaf_and_2n_minus_1_nodes(void **state) {
    (void)state;
    if (is_here(HTREE_BVH_MEDIAN)) for_each_shape(HTREE_BVH_MEDIAN, prove_binary);
    for_each_shape(HTREE_BVH_SAH, prove_binary);
}

/* ---- Section 6: H-trees --------------------------------------------------------------------- */

static void prove_types(const char *name, const htree *tree, const htree_stats *stats) {
    const uint64_t n = hittable(stats);
    (void)name;
    (void)tree;
    assert_int_equal(stats->leaves, n);
    assert_int_equal(stats->references, n);
    /* Every split is an SKD node, and one with a shelf of oversize objects has a third child. */
    assert_int_equal(stats->skd_nodes + stats->ternary_nodes, n - 1);
    assert_true(stats->kind == HTREE_AH || stats->ternary_nodes == 0);
    assert_true(stats->bv6_nodes >= 1);
    assert_int_equal(stats->bvo_nodes, 0); /* unless HTREE_ANY_PLANES asks for them */
    const uint64_t bounds = stats->bv2_nodes + stats->bv6_nodes;
    assert_int_equal(stats->nodes, stats->leaves + stats->skd_nodes + bounds + stats->link_nodes);
}

static void an_h_tree_has_one_object_a_leaf_and_nine_node_types(void **state) {
    (void)state;
    for_each_shape(HTREE_H, prove_types);
    if (is_here(HTREE_AH)) for_each_shape(HTREE_AH, prove_types);
}

/* Three planes fit into a slot: a, b, and the bits of the word `child`. */
static void assert_planes(const ht_h_node *slot, const float *planes) {
    float third;
    memcpy(&third, &slot->child, sizeof third);
    assert_true(slot->a == planes[0] && slot->b == planes[1] && third == planes[2]);
}

/* Sections 6.1 and 6.2: six planes at the root, an SKD node below them, in 16-byte slots. */
static void prove_root(const char *name, const htree *tree, const htree_stats *stats) {
    const ht_h_node *const nodes = (const ht_h_node *)tree->nodes;
    const uint32_t below = nodes[2].tag & HT_H_TYPE;
    (void)name;
    assert_int_equal(sizeof(ht_h_node), 16);
    assert_true(tree->node_bytes >= 16 * (uint64_t)tree->node_slots);
    assert_int_equal(nodes[0].tag & HT_H_TYPE, HT_H_BV6);
    assert_planes(&nodes[0], tree->bounds.lo);
    assert_planes(&nodes[1], tree->bounds.hi);
    const bool is_skd = below >= HT_H_SKD && below < HT_H_BV2;
    assert_true(hittable(stats) == 1 ? below == HT_H_LEAF : is_skd);
}

static void an_h_tree_has_six_planes_at_the_root_and_two_below(void **state) {
    (void)state;
    for_each_shape(HTREE_H, prove_root);
}

/* ---- Section 10: sizes and steps ------------------------------------------------------------ */

typedef struct work {
    double steps, tests;
} work;

/* Mean steps and tests of camera and random rays that are the same for all kinds. */
static work measure(const htree *tree, const ray_target *target) {
    enum { RAYS = 40000 };
    htree_ray *const rays = (htree_ray *)take(RAYS * sizeof *rays);
    htree_hit *const hits = (htree_hit *)take(RAYS * sizeof *hits);
    htree_counters *const counters = (htree_counters *)take(RAYS * sizeof *counters);
    htree_query query;
    work w = {0, 0};
    dice d = {8};
    rays_make(target, 1, &d, rays, RAYS / 2);
    rays_make(target, 0, &d, rays + RAYS / 2, RAYS / 2);
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    query.counters = counters;
    assert_int_equal(htree_intersect(tree, rays, RAYS, hits, &query), HTREE_OK);
    for (uint32_t i = 0; i < RAYS; ++i) {
        w.steps += (double)counters[i].traversal_steps / RAYS;
        w.tests += (double)counters[i].intersections / RAYS;
    }
    free(rays);
    free(hits);
    free(counters);
    return w;
}

static void compare_h_with_bvh(const char *name) {
    shape s = shape_of(name, 70000, 1);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree *const h = tree_of_kind(&mesh, HTREE_H), *const bvh = tree_of_kind(&mesh, HTREE_BVH_SAH);
    const htree_stats stats = stats_of(h);
    const work a = measure(h, &target), b = measure(bvh, &target);
    const double share = (double)stats.nodes / (double)hittable(&stats);
    say("%s, %llu triangles: h %.2f nodes a triangle, %.2f steps, %.2f tests a ray; bvh-sah %.2f "
        "steps, %.2f tests",
        name, (unsigned long long)stats.triangles, share, a.steps, a.tests, b.steps, b.tests);
    assert_true(a.steps < b.steps);
    assert_true(share >= 2 && share <= 3.2);
    assert_true(stats.link_nodes > 0);
    assert_true(stats.sah_cost > 1 && stats.sah_cost < 1000);

    htree_free(h);
    htree_free(bvh);
    shape_free(&s);
}

static void an_h_tree_takes_fewer_steps_than_a_bvh(void **state) {
    (void)state;
    compare_h_with_bvh("sphere");
    compare_h_with_bvh("knot");
}

/* Of 12000 objects a ray meets a few; a pure SKD tree, which bounds nothing, meets tens. */
static void no_tree_tests_many_objects_a_ray(void **state) {
    (void)state;
    shape s = shape_of("knot", 12000, 1);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&mesh, kind);
        const work w = measure(tree, &target);
        say("%s, %llu triangles: %.2f steps, %.2f tests a ray", htree_kind_name(kind),
            (unsigned long long)s.triangle_count, w.steps, w.tests);
        /* A wide tree tests all triangles of a leaf at once: of two leaves a ray at most. */
        const double most = kind == HTREE_SKD || kind == HTREE_UG ? 100
                            : kind == HTREE_WIDE                  ? 16
                                                                  : 10;
        assert_true(w.tests < most);
        assert_true(w.steps < 200);
        htree_free(tree);
    }
    shape_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bvh_has_one_object_a_leaf_and_2n_minus_1_nodes),
        cmocka_unit_test(an_h_tree_has_one_object_a_leaf_and_nine_node_types),
        cmocka_unit_test(an_h_tree_has_six_planes_at_the_root_and_two_below),
        cmocka_unit_test(an_h_tree_takes_fewer_steps_than_a_bvh),
        cmocka_unit_test(no_tree_tests_many_objects_a_ray),
    };
    return cmocka_run_group_tests_name("paper", tests, NULL, NULL);
}
