/* test_check.c: htree_check finds what is broken, and htree_get_view shows what is there. White-box:
 * the arrays of a view are written to. */
#include "oracle.h"
#include "rays.h"

#include "tree/layout.h"

enum { TRIANGLES = 300, RAYS = 300 };

typedef struct patient {
    shape mesh;
    htree_mesh input;
    htree *tree;
    htree_view view;
    htree_ray rays[RAYS];
    htree_hit truth[RAYS];
    uint64_t found, harmless, wrong;
} patient;

static void patient_begin(patient *p, const char *name, htree_kind kind) {
    htree_options options = options_of(kind);
    memset(p, 0, sizeof *p);
    p->mesh = shape_of(name, TRIANGLES, 3);
    p->input = mesh_of(&p->mesh);
    options.threads = 1;
    if (kind == HTREE_H || kind == HTREE_AH) options.flags = HTREE_ANY_PLANES;
    p->tree = tree_of(&p->input, &options);
    p->view = view_of(p->tree);
    const ray_target target = ray_target_of(&p->input);
    dice d = {11};
    rays_make_mixed(&target, &d, p->rays, RAYS);
    oracle o = oracle_of(&p->input);
    (void)oracle_batch(&o, p->rays, RAYS, p->truth);
    oracle_free(&o);
}

static void patient_end(patient *p) {
    htree_free(p->tree);
    shape_free(&p->mesh);
}

/* A tree that is proved sound must answer soundly. */
static void examine(patient *p) {
    htree_hit hits[RAYS];
    const htree_status status = htree_check(p->tree);
    if (status == HTREE_ERROR_CORRUPT) {
        ++p->found;
        return;
    }
    assert_int_equal(status, HTREE_OK);
    assert_int_equal(htree_intersect(p->tree, p->rays, RAYS, hits, NULL), HTREE_OK);
    if (hits_differ(hits, p->truth, RAYS) == 0)
        ++p->harmless;
    else
        ++p->wrong;
}

/* Breaks words of the arrays one by one, by a bit, by another word, or at random. */
static void break_words(patient *p, const void *array, uint64_t bytes, uint64_t times, dice *d) {
    uint32_t *const words = (uint32_t *)(uintptr_t)array;
    const uint32_t count = (uint32_t)(bytes / 4);
    for (uint64_t i = 0; count > 0 && i < times; ++i) {
        uint32_t *const word = &words[dice_below(d, count)];
        const uint32_t was = *word;
        switch (dice_below(d, 4)) {
        case 0: *word ^= 1u << dice_below(d, 32); break;
        case 1: *word = words[dice_below(d, count)]; break;
        case 2: *word += dice_below(d, 2) ? 1 : UINT32_MAX; break;
        default: *word = dice_u32(d); break;
        }
        if (*word != was) examine(p);
        *word = was;
    }
    assert_int_equal(htree_check(p->tree), HTREE_OK);
}

/* The corners in the leaves of a wide tree are all there is of the mesh: only prims can be wrong. */
static void break_leaves(patient *p, uint64_t times, dice *d) {
    const ht_wide_leaf *const leaves = (const ht_wide_leaf *)p->view.leaves;
    if (p->view.kind != HTREE_WIDE) {
        break_words(p, p->view.leaves, p->view.leaf_bytes, times, d);
        return;
    }
    const uint64_t count = p->view.leaf_bytes / sizeof *leaves;
    for (uint64_t i = 0; i < count; ++i)
        break_words(p, leaves[i].prim, sizeof leaves[i].prim, times / count + 1, d);
}

/* The leaves of kd-trees and grids may lose one of several references without a trace, so what is
 * promised of a proved tree is promised of the others. */
static void what_check_passes_answers_right(void **state) {
    static const char *const names[] = {"knot", "soup", "city"};
    dice d = {5};
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        uint64_t found = 0, harmless = 0;
        for (uint32_t i = 0; i < COUNT_OF(names); ++i) {
            patient p;
            patient_begin(&p, names[i], kind);
            break_words(&p, p.view.nodes, p.view.node_bytes, scaled(3000), &d);
            break_leaves(&p, scaled(1000), &d);
            if (kind != HTREE_KD && kind != HTREE_UG) assert_int_equal(p.wrong, 0);
            found += p.found;
            harmless += p.harmless;
            patient_end(&p);
        }
        say("%s: %llu breaks found, %llu harmless", htree_kind_name(kind),
            (unsigned long long)found, (unsigned long long)harmless);
        assert_true(found > harmless / 4);
    }
}

/* ---- Views ---------------------------------------------------------------------------------- */

static uint64_t slot_bytes(htree_kind kind) {
    static const uint64_t bytes[] = {0, 4, 8, 32, 32, 16, 16, 16, 256};
    return bytes[kind];
}

static void a_view_shows_the_arrays_of_the_tree(void **state) {
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        patient p;
        patient_begin(&p, "knot", kind);
        const htree_view *const v = &p.view;
        const htree_stats stats = stats_of(p.tree);
        htree_box bounds;
        assert_int_equal(htree_get_bounds(p.tree, &bounds), HTREE_OK);
        assert_memory_equal(&bounds, &v->bounds, sizeof bounds);
        assert_int_equal(v->kind, kind);
        assert_int_equal(v->triangle_count, p.input.triangle_count);
        assert_int_equal(v->prims + stats.invalid + stats.degenerate, v->triangle_count);
        assert_int_equal(v->object_count, 0);
        assert_int_equal(v->stack, stats.stack);
        assert_int_equal(v->node_bytes % slot_bytes(kind), 0);
        assert_true(v->node_bytes > 0 && (uintptr_t)v->nodes % 64 == 0);
        assert_int_equal(v->triangles == NULL, kind == HTREE_WIDE);
        for (uint64_t i = 0; v->triangles && i < v->triangle_count; ++i) {
            for (uint32_t k = 0; k < 3; ++k)
                assert_memory_equal(v->triangles + 9 * i + 3 * k, mesh_corner(&p.input, i, k), 12);
        }
        const bool has_leaves = kind == HTREE_UG || kind == HTREE_KD || kind == HTREE_WIDE;
        assert_int_equal(v->leaves != NULL, has_leaves);
        assert_int_equal(v->grid != NULL, kind == HTREE_UG);
        assert_int_equal(v->grid_bytes, kind == HTREE_UG ? sizeof(ht_ug_grid) : 0);
        assert_int_equal(v->leaf_bytes % (kind == HTREE_WIDE ? sizeof(ht_wide_leaf) : 4), 0);
        patient_end(&p);
    }
}

/* The bytes of a tree follow from its input, not from who built it. */
static void threads_build_the_same_bytes(void **state) {
    static const uint32_t threads[] = {2, 3, 8, 0};
    static const char *const names[] = {"knot", "city", "same"};
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        for (uint32_t n = 0; n < COUNT_OF(names); ++n) {
            shape s = shape_of(names[n], scaled(30000) + 6000, 5);
            const htree_mesh mesh = mesh_of(&s);
            htree *const one = tree_of_kind(&mesh, kind);
            const htree_view should = view_of(one);
            for (uint32_t i = 0; i < COUNT_OF(threads); ++i) {
                htree_options options = options_of(kind);
                options.threads = threads[i];
                htree *const many = tree_of(&mesh, &options);
                const htree_view is = view_of(many);
                assert_int_equal(is.node_bytes, should.node_bytes);
                assert_int_equal(is.leaf_bytes, should.leaf_bytes);
                assert_memory_equal(is.nodes, should.nodes, (size_t)is.node_bytes);
                if (is.leaves) assert_memory_equal(is.leaves, should.leaves, (size_t)is.leaf_bytes);
                htree_free(many);
            }
            htree_free(one);
            shape_free(&s);
        }
    }
}

static void a_view_of_nothing_is_empty(void **state) {
    htree_mesh mesh;
    (void)state;
    memset(&mesh, 0, sizeof mesh);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&mesh, kind);
        const htree_view view = view_of(tree);
        assert_true(view.prims == 0 && view.nodes == NULL && view.node_bytes == 0);
        assert_true(view.leaves == NULL && view.leaf_bytes == 0 && view.grid == NULL);
        htree_free(tree);
    }
}

/* Eight lanes are worth their price only if most are in use. */
static void wide_leaves_are_full(void **state) {
    shape s = shape_of("knot", 20000, 3);
    const htree_mesh mesh = mesh_of(&s);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    const htree_stats stats = stats_of(tree);
    const double filled = (double)stats.references / (double)stats.leaves;
    const double children = (double)(stats.nodes - 1) / (double)(stats.nodes - stats.leaves);
    (void)state;
    say("wide tree: %.2f triangles a leaf, %.2f children a node", filled, children);
    assert_true(filled > 5.5 && filled <= 8);
    assert_true(children > 4 && children <= 8);
    htree_free(tree);
    shape_free(&s);
}

static void views_refuse_bad_arguments(void **state) {
    const htree_mesh mesh = {0};
    htree *const tree = tree_of_kind(&mesh, HTREE_H);
    htree_view view;
    (void)state;
    for (uint32_t size = 0; size < sizeof view; ++size) {
        memset(&view, 0x5a, sizeof view);
        view.size = size;
        assert_int_equal(htree_get_view(tree, &view), HTREE_ERROR_ARGUMENT);
        assert_int_equal(view.kind, 0x5a5a5a5a);
    }
    view.size = sizeof view;
    assert_int_equal(htree_get_view(NULL, &view), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_get_view(tree, NULL), HTREE_ERROR_ARGUMENT);
    htree_free(tree);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_check_passes_answers_right),
        cmocka_unit_test(a_view_shows_the_arrays_of_the_tree),
        cmocka_unit_test(threads_build_the_same_bytes),
        cmocka_unit_test(a_view_of_nothing_is_empty),
        cmocka_unit_test(wide_leaves_are_full),
        cmocka_unit_test(views_refuse_bad_arguments),
    };
    return cmocka_run_group_tests_name("check", tests, NULL, NULL);
}
