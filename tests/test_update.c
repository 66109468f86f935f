/* test_update.c: a tree that is brought to a new mesh answers as one that was built for it, and a
 * failure leaves it as it was. */
#include "ledger.h"
#include "oracle.h"
#include "rays.h"

#include <math.h>

enum { TRIANGLES = 6000, RAYS = 600 };

/* Bends the mesh, more from step to step. */
static void bend(shape *s, float amount) {
    for (uint64_t i = 0; i < s->vertex_count; ++i) {
        float *const p = s->positions + 3 * i;
        p[0] += amount * p[1] * p[2];
        p[2] -= amount * p[0] * p[0];
    }
}

static void update(htree *tree, const htree_mesh *mesh, int32_t how, double *quality) {
    assert_int_equal(htree_update(tree, mesh, how, quality), HTREE_OK);
    assert_int_equal(htree_check(tree), HTREE_OK);
}

/* ---- Rebuild -------------------------------------------------------------------------------- */

static void rebuilt_trees_have_the_bytes_of_new_ones(void **state) {
    static const char *const names[] = {"knot", "city", "soup", "none", "one", "knot"};
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        shape first = shape_of("terrain", TRIANGLES, 1);
        const htree_mesh first_mesh = mesh_of(&first);
        htree *const tree = tree_of_kind(&first_mesh, kind);
        for (uint32_t i = 0; i < COUNT_OF(names); ++i) {
            shape s = shape_of(names[i], TRIANGLES / (i + 1), 2);
            const htree_mesh mesh = mesh_of(&s);
            double quality = 0;
            update(tree, &mesh, HTREE_REBUILD, &quality);
            assert_true(quality == 1);
            htree *const fresh = tree_of_kind(&mesh, kind);
            const htree_view is = view_of(tree), should = view_of(fresh);
            assert_int_equal(is.node_bytes, should.node_bytes);
            assert_int_equal(is.leaf_bytes, should.leaf_bytes);
            if (is.nodes) assert_memory_equal(is.nodes, should.nodes, (size_t)is.node_bytes);
            if (is.leaves) assert_memory_equal(is.leaves, should.leaves, (size_t)is.leaf_bytes);
            oracle_compare(tree, &mesh, 100, i);
            htree_free(fresh);
            shape_free(&s);
        }
        htree_free(tree);
        shape_free(&first);
    }
}

/* A third build finds all its large blocks among those of the first two. */
static void rebuilding_takes_no_new_memory(void **state) {
    ledger books;
    shape s = shape_of("knot", 40000, 2);
    const htree_mesh mesh = mesh_of(&s);
    htree_options options = options_of(HTREE_WIDE);
    (void)state;
    ledger_init(&books);
    options.allocator = ledger_allocator(&books);
    options.threads = 1;
    htree *const tree = tree_of(&mesh, &options);
    for (uint32_t i = 0; i < 3; ++i) update(tree, &mesh, HTREE_REBUILD, NULL);
    const uint64_t peak = books.peak_bytes, live = books.live_bytes;
    for (uint32_t i = 0; i < 5; ++i) update(tree, &mesh, HTREE_REBUILD, NULL);
    assert_int_equal(books.live_bytes, live);
    assert_true(books.peak_bytes <= peak + (1 << 20));
    assert_int_equal(stats_of(tree).bytes, books.live_bytes);
    htree_free(tree);
    ledger_assert_balanced(&books);
    ledger_free(&books);
    shape_free(&s);
}

/* ---- Refit ---------------------------------------------------------------------------------- */

static uint64_t refits;

static void refitted_trees_answer_as_the_oracle(void **state) {
    static const uint32_t flags[] = {0, HTREE_MORTON, HTREE_LAZY};
    static const char *const names[] = {"knot", "city", "terrain", "one", "none", "crowd"};
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(flags) * COUNT_OF(names); ++i) {
        shape s = shape_of(names[i % COUNT_OF(names)], TRIANGLES, 3);
        const htree_mesh mesh = mesh_of(&s);
        htree_options options = options_of(HTREE_WIDE);
        double quality = 0, last = 1;
        options.flags = flags[i / COUNT_OF(names)];
        options.threads = 1 + i % 3;
        htree *const tree = tree_of(&mesh, &options);
        update(tree, &mesh, HTREE_REFIT, &quality);
        assert_true(fabs(quality - 1) < 1e-9);
        for (uint32_t step = 0; step < 4; ++step) {
            bend(&s, 0.1f);
            update(tree, &mesh, HTREE_REFIT, &quality);
            assert_true(quality > 0.2 && quality < 20);
            oracle_compare(tree, &mesh, RAYS, step);
            oracle o = oracle_of(&mesh);
            const htree_box should = oracle_bounds(&o);
            htree_box is;
            assert_int_equal(htree_get_bounds(tree, &is), HTREE_OK);
            if (o.count) assert_memory_equal(&is, &should, sizeof is);
            oracle_free(&o);
            refits += quality != last;
            last = quality;
        }
        htree_free(tree);
        shape_free(&s);
    }
    say("%llu refits changed the cost", (unsigned long long)refits);
    assert_true(refits > 10);
}

/* Refitting keeps the nodes of the first build; what it does is not a rebuild in disguise. */
static void refitting_keeps_the_nodes(void **state) {
    shape s = shape_of("knot", TRIANGLES, 3);
    const htree_mesh mesh = mesh_of(&s);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    const htree_view before = view_of(tree);
    (void)state;
    bend(&s, 0.2f);
    update(tree, &mesh, HTREE_REFIT, NULL);
    const htree_view after = view_of(tree);
    assert_ptr_equal(after.nodes, before.nodes);
    assert_int_equal(after.node_bytes, before.node_bytes);
    htree_free(tree);
    shape_free(&s);
}

/* Triangles that come, go, and change places with each other. */
static void other_prims_than_before_mean_a_rebuild(void **state) {
    shape s = shape_of("knot", TRIANGLES, 3);
    const htree_mesh mesh = mesh_of(&s);
    float *const hidden = s.positions + 3 * s.indices[30], *const shown =
                                                               s.positions + 3 * s.indices[3000];
    const float was[2] = {hidden[0], shown[0]};
    (void)state;
    hidden[0] = NAN;
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    const uint64_t invalid = stats_of(tree).invalid;
    assert_true(invalid > 0);
    update(tree, &mesh, HTREE_REFIT, NULL);
    oracle_compare(tree, &mesh, RAYS, 1);
    hidden[0] = was[0];
    shown[0] = INFINITY;
    update(tree, &mesh, HTREE_REFIT, NULL);
    oracle_compare(tree, &mesh, RAYS, 2);
    shown[0] = was[1];
    update(tree, &mesh, HTREE_REFIT, NULL);
    assert_int_equal(stats_of(tree).invalid, 0);
    oracle_compare(tree, &mesh, RAYS, 3);
    /* Without area, and with it again: the tree was built without the triangle. */
    float *const corner = s.positions + 3 * s.indices[30];
    memcpy(corner, s.positions + 3 * s.indices[31], 3 * sizeof *corner);
    update(tree, &mesh, HTREE_REBUILD, NULL);
    assert_true(stats_of(tree).degenerate > 0);
    corner[0] = was[0];
    update(tree, &mesh, HTREE_REFIT, NULL);
    assert_int_equal(stats_of(tree).degenerate, 0);
    oracle_compare(tree, &mesh, RAYS, 4);
    htree_free(tree);
    shape_free(&s);
}

/* ---- Failures ------------------------------------------------------------------------------- */

typedef struct witness {
    htree_ray rays[RAYS];
    htree_hit hits[RAYS];
} witness;

static void assert_unchanged(const htree *tree, const witness *w) {
    htree_hit hits[RAYS];
    assert_int_equal(htree_check(tree), HTREE_OK);
    assert_int_equal(htree_intersect(tree, w->rays, RAYS, hits, NULL), HTREE_OK);
    assert_int_equal(hits_differ(hits, w->hits, RAYS), 0);
}

static void see(witness *w, const htree *tree, const htree_mesh *mesh) {
    const ray_target target = ray_target_of(mesh);
    dice d = {5};
    rays_make_mixed(&target, &d, w->rays, RAYS);
    assert_int_equal(htree_intersect(tree, w->rays, RAYS, w->hits, NULL), HTREE_OK);
}

static void failures_leave_the_tree_as_it_was(void **state) {
    ledger books;
    witness w;
    shape s = shape_of("knot", scaled(100) < 20 ? TRIANGLES / 10 : TRIANGLES, 3);
    htree_mesh mesh = mesh_of(&s);
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree_options options = options_of(kind);
        ledger_init(&books);
        options.allocator = ledger_allocator(&books);
        options.threads = 1;
        htree *const tree = tree_of(&mesh, &options);
        see(&w, tree, &mesh);
        htree_status status = HTREE_ERROR_MEMORY;
        for (uint64_t k = 1; status != HTREE_OK; ++k) {
            ledger_fail(&books, k, true);
            status = htree_update(tree, &mesh, HTREE_REBUILD, NULL);
            ledger_fail(&books, 0, false);
            assert_true(status == HTREE_OK || status == HTREE_ERROR_MEMORY);
            assert_unchanged(tree, &w);
        }
        htree_free(tree);
        ledger_assert_balanced(&books);
        ledger_free(&books);
    }
    shape_free(&s);
}

static void bad_arguments_leave_the_tree_as_it_was(void **state) {
    witness w;
    shape s = shape_of("knot", TRIANGLES, 3);
    htree_mesh mesh = mesh_of(&s);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    double quality = 7;
    (void)state;
    see(&w, tree, &mesh);
    assert_int_equal(htree_update(NULL, &mesh, HTREE_REFIT, &quality), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_update(tree, NULL, HTREE_REFIT, &quality), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_update(tree, &mesh, 0, &quality), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_update(tree, &mesh, 3, &quality), HTREE_ERROR_ARGUMENT);
    mesh.position_stride = 7;
    assert_int_equal(htree_update(tree, &mesh, HTREE_REFIT, &quality), HTREE_ERROR_ARGUMENT);
    mesh.position_stride = 0;
    s.indices[100] += (uint32_t)s.vertex_count;
    assert_int_equal(htree_update(tree, &mesh, HTREE_REFIT, &quality), HTREE_ERROR_GEOMETRY);
    assert_int_equal(htree_update(tree, &mesh, HTREE_REBUILD, &quality), HTREE_ERROR_GEOMETRY);
    assert_true(quality == 7);
    assert_unchanged(tree, &w);
    htree_free(tree);
    shape_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rebuilt_trees_have_the_bytes_of_new_ones),
        cmocka_unit_test(rebuilding_takes_no_new_memory),
        cmocka_unit_test(refitted_trees_answer_as_the_oracle),
        cmocka_unit_test(refitting_keeps_the_nodes),
        cmocka_unit_test(other_prims_than_before_mean_a_rebuild),
        cmocka_unit_test(failures_leave_the_tree_as_it_was),
        cmocka_unit_test(bad_arguments_leave_the_tree_as_it_was),
    };
    return cmocka_run_group_tests_name("update", tests, NULL, NULL);
}
