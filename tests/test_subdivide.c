/* test_subdivide.c: Loop subdivision makes four triangles of one and one vertex per edge, keeps
 * closed meshes closed, opens no crack where a mesh is no plain surface, and has known limits. */
#include "subdivide.h"
#include "suite.h"

#include <math.h>

typedef struct edge_count {
    uint64_t edges, open, many; /* all; with one triangle; with more than two */
} edge_count;

static int compare_edges(const void *a, const void *b) {
    const uint32_t *x = (const uint32_t *)a, *y = (const uint32_t *)b;
    if (x[0] != y[0]) return x[0] < y[0] ? -1 : 1;
    return (x[1] > y[1]) - (x[1] < y[1]);
}

static edge_count count_edges(const shape *s) {
    const uint64_t count = 3 * s->triangle_count;
    uint32_t(*ends)[2] = (uint32_t(*)[2])take(count * sizeof *ends);
    edge_count found = {0, 0, 0};
    for (uint64_t i = 0; i < count; ++i) {
        const uint32_t a = s->indices[i], b = s->indices[i - i % 3 + (i + 1) % 3];
        ends[i][0] = a < b ? a : b;
        ends[i][1] = a < b ? b : a;
    }
    qsort(ends, count, sizeof *ends, compare_edges);
    for (uint64_t i = 0, end; i < count; i = end) {
        for (end = i; end < count && compare_edges(ends[i], ends[end]) == 0; ++end) {
        }
        ++found.edges;
        found.open += end - i == 1;
        found.many += end - i > 2;
    }
    free(ends);
    return found;
}

static shape made(const char *name, uint64_t triangles) {
    shape s;
    assert_true(shape_make(&s, name, triangles, 1));
    return s;
}

static shape copied(const float *positions, uint64_t vertices, const uint32_t *indices,
                    uint64_t triangles) {
    shape s = {(float *)take(vertices * 12), (uint32_t *)take(triangles * 12), vertices, triangles};
    memcpy(s.positions, positions, vertices * 12);
    memcpy(s.indices, indices, triangles * 12);
    return s;
}

static void counts_grow_fourfold_and_edges_become_vertices(void **state) {
    static const char *const names[] = {"sphere", "knot", "waves", "city", "soup", "slivers"};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(names); ++i) {
        shape s = made(names[i], 500);
        for (int level = 0; level < 3; ++level) {
            const edge_count before = count_edges(&s);
            const uint64_t triangles = s.triangle_count, vertices = s.vertex_count;
            assert_true(subdivide_loop(&s, 1));
            const edge_count after = count_edges(&s);
            assert_int_equal(s.triangle_count, 4 * triangles);
            assert_int_equal(s.vertex_count, vertices + before.edges);
            assert_int_equal(after.edges, 2 * before.edges + 3 * triangles);
            assert_int_equal(after.open, 2 * before.open);
            assert_int_equal(after.many, 0);
        }
        shape_free(&s);
    }
}

static void closed_meshes_stay_closed(void **state) {
    static const char *const names[] = {"sphere", "knot", "far"};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(names); ++i) {
        shape s = made(names[i], 300);
        assert_true(subdivide_loop(&s, 3));
        const edge_count after = count_edges(&s);
        assert_int_equal(after.open, 0);
        assert_int_equal(after.many, 0);
        shape_free(&s);
    }
}

/* All weights are positive and add up to 1: no point leaves the plane or the hull. */
static void planes_stay_flat_and_within_their_outline(void **state) {
    static const float corner[] = {0, 0, 2, 4, 0, 2, 4, 4, 2, 0, 4, 2};
    static const uint32_t quad[] = {0, 1, 2, 0, 2, 3};
    (void)state;
    shape s = copied(corner, 4, quad, 2);
    assert_true(subdivide_loop(&s, 4));
    for (uint64_t i = 0; i < s.vertex_count; ++i) {
        const float *p = s.positions + 3 * i;
        assert_true(p[2] == 2);
        assert_true(p[0] >= 0 && p[0] <= 4 && p[1] >= 0 && p[1] <= 4);
    }
    shape_free(&s);
}

/* Three sheets at an edge, and two cones at a point: the edge stays straight, the point stays. */
static void what_is_no_surface_keeps_its_place(void **state) {
    static const float fan[] = {0, 0, 0, 0, 0, 4, 4, 0, 2, -4, 1, 2, 0, 4, 2};
    static const uint32_t sheets[] = {0, 1, 2, 0, 1, 3, 1, 0, 4};
    static const float tips[] = {0, 0, 0,  1, 1,  0,  -1, 1, 0,  0, 1,
                                 1, 1, -1, 0, -1, -1, 0,  0, -1, 1};
    static const uint32_t cones[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 0, 4, 5, 0, 5, 6, 0, 6, 4};
    (void)state;
    shape s = copied(fan, 5, sheets, 3);
    assert_true(subdivide_loop(&s, 1));
    for (uint64_t i = 0; i < 2; ++i) assert_memory_equal(s.positions + 3 * i, fan + 3 * i, 12);
    shape_free(&s);
    s = copied(tips, 7, cones, 6);
    assert_true(subdivide_loop(&s, 2));
    assert_memory_equal(s.positions, tips, 12);
    shape_free(&s);
}

static void spheres_converge_to_a_sphere(void **state) {
    (void)state;
    shape s = made("sphere", 4000);
    assert_true(subdivide_loop(&s, 2));
    for (uint64_t i = 0; i < s.vertex_count; ++i) {
        const float *p = s.positions + 3 * i;
        const double r = sqrt((double)p[0] * p[0] + (double)p[1] * p[1] + (double)p[2] * p[2]);
        if (!(r > 0.98 && r < 1.001)) fail_msg("a vertex at distance %g", r);
    }
    shape_free(&s);
}

static void nothing_and_degenerate_triangles_are_fine(void **state) {
    static const float point[] = {1, 2, 3, 4, 5, 6};
    static const uint32_t corners[] = {0, 0, 0, 0, 0, 1, 1, 0, 1};
    (void)state;
    shape none = made("none", 0);
    assert_true(subdivide_loop(&none, 3));
    assert_int_equal(none.triangle_count, 0);
    shape_free(&none);
    shape s = copied(point, 2, corners, 3);
    assert_true(subdivide_loop(&s, 2));
    assert_int_equal(s.triangle_count, 48);
    for (uint64_t i = 0; i < 3 * s.triangle_count; ++i) assert_true(s.indices[i] < s.vertex_count);
    for (uint64_t i = 0; i < 3 * s.vertex_count; ++i) assert_true(isfinite(s.positions[i]));
    shape_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_grow_fourfold_and_edges_become_vertices),
        cmocka_unit_test(closed_meshes_stay_closed),
        cmocka_unit_test(planes_stay_flat_and_within_their_outline),
        cmocka_unit_test(what_is_no_surface_keeps_its_place),
        cmocka_unit_test(spheres_converge_to_a_sphere),
        cmocka_unit_test(nothing_and_degenerate_triangles_are_fine),
    };
    return cmocka_run_group_tests_name("subdivide", tests, NULL, NULL);
}
