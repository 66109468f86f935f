/* test_refit.c: refits give the same bytes on every path and in every order of nodes, and change
 * nothing where they fail. White-box: trees are written to. */
#include "ledger.h"
#include "oracle.h"
#include "rays.h"

#include "tree/tree.h"

#include <math.h>

enum { TRIANGLES = 6000, RAYS = 600, STRIDE = 5 };

static const char *const scenes[] = {"knot", "city", "soup", "crowd", "one"};

/* Moves every vertex; zeros of both signs stay what they are. */
static void stretch(shape *s, float by) {
    for (uint64_t i = 0; i < 3 * s->vertex_count; ++i) s->positions[i] *= by;
}

/* Some coordinates become zeros, whose sign tells which of two equal ones was taken. */
static void flatten(shape *s) {
    for (uint64_t i = 0; i < 3 * s->vertex_count; i += 5) s->positions[i] = i % 2 ? 0.0f : -0.0f;
}

static uint64_t bytes_compared;

static void assert_same_bytes(const htree *a, const htree *b) {
    assert_int_equal(a->node_slots, b->node_slots);
    assert_int_equal(a->leaf_count, b->leaf_count);
    assert_memory_equal(&a->bounds, &b->bounds, sizeof a->bounds);
    if (!a->leaves) return;
    assert_memory_equal(a->nodes, b->nodes, a->node_slots * sizeof(ht_wide_node));
    assert_memory_equal(a->leaves, b->leaves, a->leaf_count * sizeof *a->leaves);
    bytes_compared += a->node_slots * sizeof(ht_wide_node) + a->leaf_count * sizeof *a->leaves;
}

static double refit(htree *tree, const htree_mesh *mesh) {
    double quality = 0;
    assert_int_equal(htree_update(tree, mesh, HTREE_REFIT, &quality), HTREE_OK);
    assert_int_equal(htree_check(tree), HTREE_OK);
    return quality;
}

/* ---- Paths ---------------------------------------------------------------------------------- */

/* The same triangles without indices, each vertex with something behind it. */
static htree_mesh spread_mesh(const shape *s, float *positions) {
    htree_mesh mesh = {0};
    for (uint64_t i = 0; i < 3 * s->triangle_count; ++i) {
        memcpy(positions + STRIDE * i, s->positions + 3 * s->indices[i], 12);
        for (int k = 3; k < STRIDE; ++k) positions[STRIDE * i + (uint64_t)k] = NAN;
    }
    mesh.positions = positions;
    mesh.position_stride = STRIDE * sizeof *positions;
    mesh.vertex_count = 3 * s->triangle_count;
    mesh.triangle_count = s->triangle_count;
    return mesh;
}

/* From the same tree to the same mesh, by one thread of portable C and otherwise. */
static void compare_paths(const htree_mesh *was, const htree_mesh *is, uint32_t flags) {
    static const ht_isa paths[] = {HT_PORTABLE, HT_NEON, HT_AVX2, HT_AVX512};
    htree_options options = options_of(HTREE_WIDE);
    options.flags = flags;
    options.threads = 1;
    htree *const should = tree_of(was, &options);
    const ht_isa best = should->isa;
    should->isa = HT_PORTABLE;
    const double quality = refit(should, is);
    for (uint32_t i = 0; i < COUNT_OF(paths) && paths[i] <= best; ++i) {
        options.threads = 1 + i % 3;
        htree *const tree = tree_of(was, &options);
        tree->isa = paths[i];
        assert_true(refit(tree, is) == quality);
        assert_same_bytes(tree, should);
        htree_free(tree);
    }
    htree_free(should);
}

static void every_path_refits_to_the_same_bytes(void **state) {
    static const uint32_t flags[] = {0, HTREE_MORTON};
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(scenes) * COUNT_OF(flags); ++i) {
        shape s = shape_of(scenes[i % COUNT_OF(scenes)], TRIANGLES, 3);
        shape moved = shape_of(scenes[i % COUNT_OF(scenes)], TRIANGLES, 3);
        float *const xyz = (float *)take(3 * s.triangle_count * STRIDE * sizeof *xyz);
        stretch(&moved, 1.25f);
        flatten(&moved);
        const htree_mesh was = mesh_of(&s), spread = spread_mesh(&moved, xyz);
        htree_mesh is = mesh_of(&moved);
        /* Where the last vertex ends, its memory does. */
        float *const tight = (float *)take(12 * moved.vertex_count);
        memcpy(tight, moved.positions, 12 * (size_t)moved.vertex_count);
        is.positions = tight;
        compare_paths(&was, &is, flags[i / COUNT_OF(scenes)]);
        compare_paths(&was, &spread, flags[i / COUNT_OF(scenes)]);
        free(tight);
        free(xyz);
        shape_free(&moved);
        shape_free(&s);
    }
    say("%llu bytes compared", (unsigned long long)bytes_compared);
}

/* ---- Order ---------------------------------------------------------------------------------- */

/* The root stays; all other nodes go the other way round. */
static uint32_t turned(const htree *tree, uint32_t slot) {
    return slot == 0 ? 0 : tree->node_slots - slot;
}

static void turn_nodes(htree *tree) {
    const uint64_t bytes = tree->node_slots * sizeof(ht_wide_node);
    ht_wide_node *const nodes = (ht_wide_node *)tree->nodes;
    ht_wide_node *const was = (ht_wide_node *)take(bytes);
    memcpy(was, nodes, (size_t)bytes);
    for (uint32_t i = 0; i < tree->node_slots; ++i) {
        ht_wide_node *const node = &nodes[turned(tree, i)];
        *node = was[i];
        for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
            if (!(node->child[lane] & HT_WIDE_LEAF))
                node->child[lane] = turned(tree, node->child[lane]);
        }
    }
    free(was);
}

/* As files may have them: parents after their children, so that no task can close a node. */
static void nodes_may_come_in_any_order(void **state) {
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(scenes); ++i) {
        shape s = shape_of(scenes[i], 5 * TRIANGLES, 3);
        const htree_mesh mesh = mesh_of(&s);
        htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
        htree *const other = tree_of_kind(&mesh, HTREE_WIDE);
        turn_nodes(other);
        stretch(&s, 1.25f);
        const double quality = refit(tree, &mesh);
        assert_true(fabs(refit(other, &mesh) - quality) < 1e-9);
        turn_nodes(other);
        assert_same_bytes(other, tree);
        htree_free(other);
        htree_free(tree);
        shape_free(&s);
    }
}

/* ---- What refits refuse --------------------------------------------------------------------- */

/* A vertex just beyond what is allowed, and just not. */
static void coordinates_out_of_range_are_noticed(void **state) {
    shape s = shape_of("knot", TRIANGLES, 3);
    const htree_mesh mesh = mesh_of(&s);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    const void *const nodes = tree->nodes;
    float *const x = s.positions + 3 * s.indices[300];
    (void)state;
    *x = HTREE_COORDINATE_MAX;
    refit(tree, &mesh);
    assert_ptr_equal(tree->nodes, nodes);
    assert_int_equal(stats_of(tree).invalid, 0);
    *x = nudged(HTREE_COORDINATE_MAX, 1);
    assert_true(refit(tree, &mesh) == 1);
    assert_true(stats_of(tree).invalid > 0);
    oracle_compare(tree, &mesh, RAYS, 1);
    htree_free(tree);
    shape_free(&s);
}

/* Triangles without area are left out, and what was left out is listed by the first refit. */
static void without_memory_the_tree_is_as_it_was(void **state) {
    ledger books;
    shape s = shape_of("knot", TRIANGLES, 3), moved = shape_of("knot", TRIANGLES, 3);
    const htree_mesh mesh = mesh_of(&s), is = mesh_of(&moved);
    htree_options options = options_of(HTREE_WIDE);
    uint64_t failures = 0;
    (void)state;
    s.indices[31] = s.indices[30];
    moved.indices[31] = moved.indices[30];
    stretch(&moved, 1.25f);
    ledger_init(&books);
    options.allocator = ledger_allocator(&books);
    options.threads = 1;
    htree *const tree = tree_of(&mesh, &options), *const should = tree_of(&mesh, &options);
    htree_status status = HTREE_ERROR_MEMORY;
    for (uint64_t k = 1; status != HTREE_OK; ++k) {
        ledger_fail(&books, k, true);
        status = htree_update(tree, &is, HTREE_REFIT, NULL);
        ledger_fail(&books, 0, false);
        if (status == HTREE_OK) break;
        assert_int_equal(status, HTREE_ERROR_MEMORY);
        assert_same_bytes(tree, should);
        ++failures;
    }
    assert_true(failures >= 3);
    refit(should, &is);
    assert_same_bytes(tree, should);
    htree_free(should);
    htree_free(tree);
    ledger_assert_balanced(&books);
    ledger_free(&books);
    shape_free(&moved);
    shape_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_path_refits_to_the_same_bytes),
        cmocka_unit_test(nodes_may_come_in_any_order),
        cmocka_unit_test(coordinates_out_of_range_are_noticed),
        cmocka_unit_test(without_memory_the_tree_is_as_it_was),
    };
    return cmocka_run_group_tests_name("refit", tests, NULL, NULL);
}
