/* test_api_mesh.c: htree_build refuses every bad mesh, says why, and leaves nothing behind. */
#include "refuse.h"

static void build_refuses_null_and_unknown_kinds(void **state) {
    const htree_mesh mesh = good_mesh();
    htree_options options = options_of(HTREE_H);
    (void)state;
    set_error_text();
    assert_refused(htree_build(NULL, &mesh, &options), HTREE_ERROR_ARGUMENT);
    assert_not_built(NULL, &options, HTREE_ERROR_ARGUMENT);
    for (htree_kind kind = HTREE_UG; kind <= HTREE_WIDE; ++kind) {
        htree_kind here = 0;
        do here = next_kind(here);
        while (here != 0 && here != kind);
        if (here == kind) continue;
        options.kind = kind;
        assert_not_built(&mesh, &options, HTREE_ERROR_UNSUPPORTED);
    }
}

static void build_refuses_bad_strides(void **state) {
    static const uint64_t strides[] = {1, 2, 3, 4, 8, 11, 13, 14, 15, 17, 18, 1001};
    static const uint64_t fine[] = {0, 12, 16, 20, 1000};
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(strides); ++i) {
        htree_mesh mesh = good_mesh();
        mesh.position_stride = strides[i];
        assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
        mesh.vertex_count = mesh.triangle_count = 0;
        assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
    }
    for (uint32_t i = 0; i < COUNT_OF(fine); ++i) {
        static float wide[1000];
        htree_mesh mesh = good_mesh();
        mesh.positions = wide;
        mesh.position_stride = fine[i];
        htree_free(tree_of(&mesh, NULL));
    }
}

static void build_refuses_bad_pointers_and_reserved_words(void **state) {
    htree_mesh mesh = good_mesh();
    (void)state;
    mesh.positions = NULL;
    assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
    for (uint32_t i = 0; i < 2; ++i) {
        mesh = good_mesh();
        mesh.reserved[i] = 1;
        assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
        mesh.reserved[i] = (uint64_t)1 << 63;
        assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
    }
}

static void build_refuses_indices_outside_the_vertices(void **state) {
    static const uint32_t wrong[] = {3, 4, 0x7fffffff, 0x80000000u, UINT32_MAX};
    uint32_t indices[3];
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        const htree_options options = options_of(kind);
        for (uint32_t i = 0; i < 3 * COUNT_OF(wrong); ++i) {
            htree_mesh mesh = good_mesh();
            mesh.indices = indices;
            indices[0] = indices[1] = indices[2] = 0;
            indices[i % 3] = wrong[i / 3];
            assert_not_built(&mesh, &options, HTREE_ERROR_GEOMETRY);
        }
    }
    htree_mesh mesh = good_mesh();
    mesh.vertex_count = 2; /* three vertices a triangle without indices */
    assert_not_built(&mesh, NULL, HTREE_ERROR_GEOMETRY);
    mesh.vertex_count = 0;
    assert_not_built(&mesh, NULL, HTREE_ERROR_GEOMETRY);
}

static void build_refuses_strides_beyond_memory_and_odd_addresses(void **state) {
    htree_mesh mesh = good_mesh();
    (void)state;
    mesh.vertex_count = UINT64_MAX / 12 + 1;
    assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
    mesh.position_stride = 64;
    mesh.vertex_count = UINT64_MAX / 64 + 1;
    assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
    mesh = good_mesh();
    mesh.positions = (const float *)(const void *)((const char *)mesh.positions + 2);
    assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
    mesh = good_mesh();
    mesh.indices = (const uint32_t *)(uintptr_t)1;
    assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
}

static void assert_counts_refused(uint64_t triangles, uint64_t objects, bool indexed) {
    static const uint32_t indices[3] = {0, 1, 2};
    const htree_box box = {{0, 0, 0}, {1, 1, 1}};
    const htree_objects some = {&box, objects, never_hit, NULL};
    htree_mesh mesh = good_mesh();
    mesh.triangle_count = triangles;
    if (indexed)
        mesh.indices = indices;
    else
        mesh.vertex_count = UINT64_MAX / 12;
    mesh.objects = &some;
    assert_not_built(&mesh, NULL, HTREE_ERROR_LIMIT);
}

static void build_refuses_counts_beyond_the_limit_before_it_reads(void **state) {
    static const uint64_t counts[] = {
        UINT32_MAX,         (uint64_t)UINT32_MAX + 1, (uint64_t)1 << 40,
        UINT64_MAX / 3 - 1, UINT64_MAX / 3 + 1,       UINT64_MAX / 12 + 1,
        UINT64_MAX / 36,    UINT64_MAX / 36 + 1,      UINT64_MAX};
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(counts); ++i) {
        assert_counts_refused(counts[i], 0, true);
        assert_counts_refused(counts[i], 0, false);
        assert_counts_refused(1, counts[i], true);
        assert_counts_refused(counts[i], counts[i], true);
        assert_counts_refused(counts[i], UINT64_MAX - counts[i] + 2, true);
    }
}

/* Arrays of three vertices, which nobody reads. */
static void build_refuses_more_than_a_kind_can_address(void **state) {
    static const struct {
        htree_kind kind;
        uint32_t flags;
        uint64_t most;
    } limits[] = {
        {HTREE_UG, 0, UINT32_MAX / 6},
        {HTREE_KD, 0, 1u << 27},
        {HTREE_BVH_MEDIAN, 0, INT32_MAX},
        {HTREE_BVH_SAH, 0, INT32_MAX},
        {HTREE_BVH_SAH, HTREE_COLLAPSE, (1u << 30) - 2},
        {HTREE_SKD, 0, (1u << 26) - (1u << 18)},
        {HTREE_H, 0, (1u << 26) - (1u << 18)},
        {HTREE_AH, 0, (1u << 26) - (1u << 18)},
        {HTREE_WIDE, 0, (1u << 30) - 2},
        {HTREE_WIDE, HTREE_LAZY, (1u << 30) - 2},
    };
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(limits); ++i) {
        htree_options options = options_of(limits[i].kind);
        htree_mesh mesh = good_mesh();
        options.flags = limits[i].flags;
        mesh.triangle_count = limits[i].most + 1;
        mesh.vertex_count = 3 * mesh.triangle_count;
        assert_not_built(&mesh, &options, HTREE_ERROR_LIMIT);
        assert_non_null(strstr(htree_error_text(), htree_kind_name(limits[i].kind)));
    }
}

static void build_refuses_bad_objects(void **state) {
    const htree_box box = {{0, 0, 0}, {1, 1, 1}};
    htree_objects objects = {NULL, 1, never_hit, NULL};
    htree_mesh mesh = good_mesh();
    (void)state;
    mesh.objects = &objects;
    assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
    objects.boxes = &box;
    objects.intersect = NULL;
    assert_not_built(&mesh, NULL, HTREE_ERROR_ARGUMENT);
    objects.intersect = never_hit;
    htree_free(tree_of(&mesh, NULL));
    memset(&objects, 0, sizeof objects);
    htree_free(tree_of(&mesh, NULL));
}

static void an_empty_mesh_may_have_no_arrays(void **state) {
    htree_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    (void)state;
    htree *const tree = tree_of(&mesh, NULL);
    const htree_ray ray = {{0, 0, 0}, 0, {0, 0, 1}, 1};
    htree_hit hit;
    assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
    assert_int_equal(hit.prim, HTREE_NONE);
    htree_free(tree);
    htree_free(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(build_refuses_null_and_unknown_kinds),
        cmocka_unit_test(build_refuses_bad_strides),
        cmocka_unit_test(build_refuses_bad_pointers_and_reserved_words),
        cmocka_unit_test(build_refuses_indices_outside_the_vertices),
        cmocka_unit_test(build_refuses_strides_beyond_memory_and_odd_addresses),
        cmocka_unit_test(build_refuses_counts_beyond_the_limit_before_it_reads),
        cmocka_unit_test(build_refuses_more_than_a_kind_can_address),
        cmocka_unit_test(build_refuses_bad_objects),
        cmocka_unit_test(an_empty_mesh_may_have_no_arrays),
    };
    const int failed = cmocka_run_group_tests_name("api_mesh", tests, NULL, NULL);
    say("%llu bad calls refused", (unsigned long long)refusals());
    return failed;
}
