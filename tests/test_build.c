/* test_build.c: builders on every small size, on every input that breaks builders, and on every
 * layout of the arrays. The trees are proved by htree_check and by rays against the oracle. */
#include "oracle.h"
#include "rays.h"

#include <math.h>
#include <pthread.h>

static uint64_t trees_built, rays_compared;

/* Rays through a mesh, and what every tree over it must answer. */
typedef struct exam {
    const htree_mesh *mesh;
    oracle truth;
    htree_box bounds;
    uint64_t count;
    htree_ray *rays;
    htree_hit *should, *hits;
} exam;

static exam exam_of(const htree_mesh *mesh, uint64_t count, uint64_t seed) {
    const ray_target target = ray_target_of(mesh);
    dice d = {seed};
    exam e;
    e.mesh = mesh;
    e.truth = oracle_of(mesh);
    e.bounds = oracle_bounds(&e.truth);
    e.count = count;
    e.rays = (htree_ray *)take(count * sizeof *e.rays);
    e.should = (htree_hit *)take(count * sizeof *e.should);
    e.hits = (htree_hit *)take(count * sizeof *e.hits);
    rays_make_mixed(&target, &d, e.rays, count);
    (void)oracle_batch(&e.truth, e.rays, count, e.should);
    return e;
}

static void exam_free(exam *e) {
    oracle_free(&e->truth);
    free(e->rays);
    free(e->should);
    free(e->hits);
}

/* Builds, proves, compares with the oracle, and returns the statistics. */
static htree_stats prove(const exam *e, const htree_options *options) {
    htree *const tree = tree_of(e->mesh, options);
    const htree_stats stats = stats_of(tree);
    htree_box box;
    assert_int_equal(htree_intersect(tree, e->rays, e->count, e->hits, NULL), HTREE_OK);
    assert_int_equal(hits_differ(e->hits, e->should, e->count), 0);
    assert_int_equal(htree_get_bounds(tree, &box), HTREE_OK);
    for (int k = 0; k < 3; ++k)
        assert_true(box.lo[k] == e->bounds.lo[k] && box.hi[k] == e->bounds.hi[k]);
    assert_int_equal(stats.triangles, e->mesh->triangle_count);
    assert_int_equal(stats.invalid, e->truth.invalid);
    assert_int_equal(stats.degenerate, e->truth.degenerate);
    htree_free(tree);
    ++trees_built;
    rays_compared += e->count;
    return stats;
}

static void prove_all_kinds(const htree_mesh *mesh, uint64_t rays, uint64_t seed) {
    exam e = exam_of(mesh, rays, seed);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree_options options = options_of(kind);
        options.threads = 1;
        (void)prove(&e, &options);
    }
    exam_free(&e);
}

static void report(const char *what) {
    say("%s: %llu trees proved, %llu rays equal to the oracle's", what,
        (unsigned long long)trees_built, (unsigned long long)rays_compared);
    tally("small trees", trees_built);
    tally("oracle rays", rays_compared);
    trees_built = rays_compared = 0;
}

/* ---- Small trees ---------------------------------------------------------------------------- */

enum { DISTRIBUTIONS = 6 };

/* One coordinate of a vertex: uniform, flat, on a line, on a small lattice, clustered, all
 * equal. */
static float coordinate(uint32_t distribution, uint64_t triangle, uint32_t axis, dice *d) {
    const float spread = dice_between(d, -0.1f, 0.1f);
    switch (distribution) {
    case 0: return dice_between(d, -1, 1);
    case 1: return axis == 2 ? 0 : dice_between(d, -1, 1);
    case 2: return (axis == 0 ? (float)triangle : 0) + spread;
    case 3: return (float)dice_below(d, 4);
    case 4: return triangle == 0 ? 1e6f + spread : spread;
    default: return (float)((axis * 7 + triangle * 0) % 3) + (axis == 1 ? 0.5f : 0) + spread * 0;
    }
}

static void every_small_tree_of(uint32_t distribution, uint64_t most) {
    dice d = {1000 + distribution};
    const uint64_t step = scaled(100) < 10 ? 3 : 1; /* the slowest builds skip some */
    for (uint64_t n = 0; n <= most; n += n < 32 ? 1 : step) {
        float *const xyz = (float *)take(n * 9 * sizeof *xyz);
        for (uint64_t i = 0; i < 9 * n; ++i)
            xyz[i] = coordinate(distribution, i / 9, (uint32_t)(i % 3), &d);
        if (distribution == 5) { /* the same triangle, and not a point */
            for (uint64_t i = 0; i < n; ++i) xyz[9 * i] += 1, xyz[9 * i + 4] += 1;
        }
        htree_mesh mesh;
        memset(&mesh, 0, sizeof mesh);
        mesh.positions = xyz;
        mesh.vertex_count = 3 * n;
        mesh.triangle_count = n;
        prove_all_kinds(&mesh, 64, n);
        free(xyz);
    }
}

/* Exact-size arrays: under AddressSanitizer a read past an end is a failure. */
static void every_size_up_to_1024_equals_oracle(void **state) {
    const uint64_t most = scaled(100) < 100 ? 256 : 1024;
    (void)state;
    for (uint32_t i = 0; i < DISTRIBUTIONS; ++i) every_small_tree_of(i, most);
    report(most == 1024 ? "N = 0 to 1024, 6 distributions" : "N = 0 to 256, 6 distributions");
}

static void bvh_sah_and_h_are_built(void **state) {
    bool bvh_sah = false, h = false;
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        bvh_sah = bvh_sah || kind == HTREE_BVH_SAH;
        h = h || kind == HTREE_H;
    }
    assert_true(bvh_sah && h);
}

/* ---- Inputs that are no triangles ----------------------------------------------------------- */

/* Spoils every third triangle with a bad number, every seventh by removing its area. */
static void spoil(float *xyz, uint64_t triangles, dice *d) {
    static const float bad[] = {NAN, -NAN, INFINITY, -INFINITY, 3.4e38f, -1.2e18f, 2e18f, 1e30f};
    for (uint64_t i = 0; i < triangles; ++i) {
        float *const p = xyz + 9 * i;
        if (i % 3 == 0) p[dice_below(d, 9)] = bad[dice_below(d, COUNT_OF(bad))];
        if (i % 7 == 1) memcpy(p + 3 * dice_below(d, 2), p + 6, 3 * sizeof *p);
        if (i % 7 == 2) {
            for (int k = 0; k < 3; ++k) p[6 + k] = 0.5f * p[k] + 0.5f * p[3 + k];
        }
    }
}

static void bad_triangles_are_skipped_and_counted(void **state) {
    enum { N = 300 };
    (void)state;
    float *const xyz = (float *)take(N * 9 * sizeof *xyz);
    htree_mesh mesh = {0};
    mesh.positions = xyz;
    mesh.vertex_count = 3 * N;
    for (uint32_t seed = 0; seed < 40; ++seed) {
        dice d = {seed};
        for (uint32_t i = 0; i < 9 * N; ++i) xyz[i] = (float)dice_below(&d, 64) - 32;
        spoil(xyz, N, &d);
        mesh.triangle_count = seed < 20 ? seed : N; /* also nothing but bad ones */
        prove_all_kinds(&mesh, 500, seed);
    }
    free(xyz);
    report("bad triangles");
}

/* Several threads read it, and what each of them skips leaves gaps. */
static void bad_triangles_of_a_large_mesh_are_skipped(void **state) {
    shape s = shape_of("soup", 20000, 3);
    const htree_mesh indexed = mesh_of(&s);
    float *const xyz = (float *)take(9 * s.triangle_count * sizeof *xyz);
    dice d = {5};
    (void)state;
    for (uint64_t i = 0; i < 3 * s.triangle_count; ++i)
        memcpy(xyz + 3 * i, mesh_corner(&indexed, i / 3, (uint32_t)(i % 3)), 3 * sizeof *xyz);
    spoil(xyz, s.triangle_count, &d);
    const htree_mesh mesh = plain_mesh(xyz, s.triangle_count);
    exam e = exam_of(&mesh, 100, 6);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree_options options = options_of(kind);
        options.threads = 3;
        (void)prove(&e, &options);
    }
    exam_free(&e);
    free(xyz);
    shape_free(&s);
}

/* A bounding node for nearly every other. */
static void trees_of_bounding_nodes_equal_oracle(void **state) {
    shape s = shape_of("soup", 20000, 4);
    const htree_mesh mesh = mesh_of(&s);
    exam e = exam_of(&mesh, 100, 7);
    (void)state;
    for (htree_kind kind = HTREE_H; kind <= HTREE_AH; ++kind) {
        htree_options options = options_of(kind);
        options.cost_skd = 1000;
        options.cost_bv2 = 1e6f;
        options.cost_bv6 = 0.001f;
        const htree_stats stats = prove(&e, &options);
        assert_true(stats.bv6_nodes > mesh.triangle_count / 2);
    }
    exam_free(&e);
    shape_free(&s);
}

/* Any 32 bits are a coordinate. */
static void random_bit_patterns_are_geometry(void **state) {
    enum { N = 200 };
    (void)state;
    uint32_t *const bits = (uint32_t *)take(N * 9 * sizeof *bits);
    float *const xyz = (float *)take(N * 9 * sizeof *xyz);
    htree_mesh mesh = {0};
    mesh.positions = xyz;
    mesh.vertex_count = 3 * N;
    mesh.triangle_count = N;
    for (uint32_t seed = 0; seed < scaled(100); ++seed) {
        dice d = {seed};
        const uint32_t mask = seed % 2 != 0 ? 0xffffffffu : 0xdfffffffu; /* all, or below 2 */
        for (uint32_t i = 0; i < 9 * N; ++i) bits[i] = dice_u32(&d) & mask;
        memcpy(xyz, bits, N * 9 * sizeof *xyz);
        prove_all_kinds(&mesh, 300, seed);
    }
    free(bits);
    free(xyz);
    report("random bit patterns");
}

static void strict_builds_refuse_bad_numbers_only(void **state) {
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1.2e18f, -3e38f};
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree_options options = options_of(kind);
        options.flags = HTREE_STRICT;
        for (uint32_t i = 0; i < 18 * COUNT_OF(bad); ++i) {
            float xyz[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 5, 5, 5, 5, 5, 5, 5};
            htree_mesh mesh = {0};
            htree *tree = (htree *)(uintptr_t)8;
            mesh.positions = xyz;
            mesh.vertex_count = 6;
            mesh.triangle_count = 2;
            htree_free(tree_of(&mesh, &options)); /* no area is no offence */
            xyz[i % 18] = bad[i / 18];
            assert_int_equal(htree_build(&tree, &mesh, &options), HTREE_ERROR_GEOMETRY);
            assert_null(tree);
            assert_true(strlen(htree_error_text()) > 5);
        }
    }
}

static void the_largest_coordinate_is_valid(void **state) {
    const float c = HTREE_COORDINATE_MAX, over = nextafterf(c, INFINITY);
    float xyz[18] = {-c, -c, -c, c, -c, c, c, c, -c, -c, -c, c, c, c, c, -c, c, over};
    htree_mesh mesh = {0};
    (void)state;
    mesh.positions = xyz;
    mesh.vertex_count = 6;
    mesh.triangle_count = 2;
    exam e = exam_of(&mesh, 2000, 5);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        const htree_options options = options_of(kind);
        assert_int_equal(prove(&e, &options).invalid, 1);
    }
    exam_free(&e);
}

/* ---- Layouts of the arrays ------------------------------------------------------------------ */

/* The same triangles without indices and with a stride give the same hits and the same bounds. */
static void strides_and_indices_do_not_matter(void **state) {
    static const uint32_t strides[] = {12, 16, 20, 24, 64};
    (void)state;
    shape s = shape_of("knot", 300, 4);
    const htree_mesh indexed = mesh_of(&s);
    const ray_target target = ray_target_of(&indexed);
    enum { RAYS = 4000 };
    htree_ray *const rays = (htree_ray *)take(RAYS * sizeof *rays);
    htree_hit *const should = (htree_hit *)take(RAYS * sizeof *should);
    htree_hit *const hits = (htree_hit *)take(RAYS * sizeof *hits);
    dice d = {6};
    rays_make_mixed(&target, &d, rays, RAYS);
    for (uint32_t i = 0; i < COUNT_OF(strides); ++i) {
        const uint64_t step = strides[i] / 4, n = 3 * s.triangle_count;
        float *const xyz =
            (float *)take(((n - 1) * step + 3) * sizeof *xyz); /* ends with the last z */
        for (uint64_t v = 0; v < n; ++v) {
            memcpy(xyz + v * step, mesh_corner(&indexed, v / 3, (uint32_t)(v % 3)), 12);
        }
        htree_mesh plain = {0};
        plain.positions = xyz;
        plain.position_stride = strides[i];
        plain.vertex_count = n;
        plain.triangle_count = s.triangle_count;
        for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
            htree *const a = tree_of_kind(&indexed, kind), *const b = tree_of_kind(&plain, kind);
            assert_int_equal(htree_intersect(a, rays, RAYS, should, NULL), HTREE_OK);
            assert_int_equal(htree_intersect(b, rays, RAYS, hits, NULL), HTREE_OK);
            assert_int_equal(hits_differ(hits, should, RAYS), 0);
            htree_free(a);
            htree_free(b);
        }
        free(xyz);
    }
    free(rays);
    free(should);
    free(hits);
    shape_free(&s);
}

static void the_tree_keeps_no_pointer_into_the_mesh(void **state) {
    (void)state;
    shape s = shape_of("soup", 300, 4);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree_ray rays[500];
    htree_hit before[500], after[500];
    dice d = {6};
    rays_make_mixed(&target, &d, rays, 500);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        shape copy = shape_of("soup", 300, 4);
        const htree_mesh copied = mesh_of(&copy);
        htree *const tree = tree_of_kind(&copied, kind);
        assert_int_equal(htree_intersect(tree, rays, 500, before, NULL), HTREE_OK);
        memset(copy.positions, 0xff, (size_t)(copy.vertex_count * 12));
        memset(copy.indices, 0xff, (size_t)(copy.triangle_count * 12));
        shape_free(&copy);
        assert_int_equal(htree_intersect(tree, rays, 500, after, NULL), HTREE_OK);
        assert_int_equal(hits_differ(before, after, 500), 0);
        assert_int_equal(htree_check(tree), HTREE_OK);
        htree_free(tree);
    }
    shape_free(&s);
}

/* As the mesh of objects alone may be made from one of triangles. */
static void vertices_that_no_triangle_needs_may_be_missing(void **state) {
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree_mesh mesh = plain_mesh(NULL, 0);
        mesh.vertex_count = 1000;
        htree_free(tree_of_kind(&mesh, kind));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_size_up_to_1024_equals_oracle),
        cmocka_unit_test(bvh_sah_and_h_are_built),
        cmocka_unit_test(bad_triangles_are_skipped_and_counted),
        cmocka_unit_test(bad_triangles_of_a_large_mesh_are_skipped),
        cmocka_unit_test(trees_of_bounding_nodes_equal_oracle),
        cmocka_unit_test(random_bit_patterns_are_geometry),
        cmocka_unit_test(strict_builds_refuse_bad_numbers_only),
        cmocka_unit_test(the_largest_coordinate_is_valid),
        cmocka_unit_test(strides_and_indices_do_not_matter),
        cmocka_unit_test(the_tree_keeps_no_pointer_into_the_mesh),
        cmocka_unit_test(vertices_that_no_triangle_needs_may_be_missing),
    };
    return cmocka_run_group_tests_name("build", tests, NULL, NULL);
}
