/* test_api.c: names, options and calibration: every function refuses every bad argument, says why, and
 * leaves nothing behind. */
#include "refuse.h"

#include <math.h>

/* ---- Names, version, text
 * ------------------------------------------------------------------------ */

static void the_version_is_that_of_the_header(void **state) {
    (void)state;
    assert_int_equal(htree_version(),
                     HTREE_VERSION_MAJOR * 10000 + HTREE_VERSION_MINOR * 100 + HTREE_VERSION_PATCH);
}

static void every_status_has_a_name_of_its_own(void **state) {
    (void)state;
    for (htree_status a = HTREE_OK; a <= HTREE_ERROR_KERNEL; ++a) {
        assert_true(strlen(htree_status_name(a)) > 0);
        for (htree_status b = HTREE_OK; b < a; ++b) {
            assert_string_not_equal(htree_status_name(a), htree_status_name(b));
        }
    }
    static const htree_status strange[] = {-1, 12, 1000, INT32_MAX, INT32_MIN};
    for (uint32_t i = 0; i < COUNT_OF(strange); ++i) assert_non_null(htree_status_name(strange[i]));
}

static void kind_names_go_there_and_back(void **state) {
    static const char *const names[] = {"ug",  "kd", "bvh-median", "bvh-sah",
                                        "skd", "h",  "ah",         "wide"};
    static const char *const strange[] = {"", "H", "h ", " h", "bvh", "bvh_sah", "htree", "\xff"};
    (void)state;
    for (htree_kind kind = HTREE_UG; kind <= HTREE_WIDE; ++kind) {
        assert_string_equal(htree_kind_name(kind), names[kind - HTREE_UG]);
        assert_int_equal(htree_kind_from_name(htree_kind_name(kind)), kind);
    }
    for (uint32_t i = 0; i < COUNT_OF(strange); ++i)
        assert_int_equal(htree_kind_from_name(strange[i]), 0);
    assert_int_equal(htree_kind_from_name(NULL), 0);
    assert_null(htree_kind_name(0));
    assert_null(htree_kind_name(HTREE_WIDE + 1));
    assert_null(htree_kind_name(-1));
    assert_null(htree_kind_name(INT32_MIN));
    assert_null(htree_kind_name(INT32_MAX));
}

static void success_does_not_touch_the_text(void **state) {
    const htree_mesh mesh = good_mesh();
    const htree_kind kind = next_kind(0);
    (void)state;
    set_error_text();
    char before[256];
    (void)snprintf(before, sizeof before, "%s", htree_error_text());
    htree_free(tree_of_kind(&mesh, kind));
    assert_string_equal(before, htree_error_text());
}

/* ---- Options
 * ------------------------------------------------------------------------------------- */

static void options_init_refuses_bad_arguments(void **state) {
    static const htree_kind strange[] = {0, -1, HTREE_WIDE + 1, INT32_MAX, INT32_MIN};
    htree_options options;
    (void)state;
    assert_refused(htree_options_init(NULL, sizeof options, HTREE_H), HTREE_ERROR_ARGUMENT);
    for (uint64_t size = 0; size < sizeof options; ++size) {
        memset(&options, 0x5a, sizeof options);
        assert_refused(htree_options_init(&options, size, HTREE_H), HTREE_ERROR_ARGUMENT);
        for (uint64_t i = 0; i < sizeof options; ++i)
            assert_int_equal(((const char *)&options)[i], 0x5a);
    }
    for (uint32_t i = 0; i < COUNT_OF(strange); ++i) {
        assert_refused(htree_options_init(&options, sizeof options, strange[i]),
                       HTREE_ERROR_ARGUMENT);
    }
    assert_refused(htree_options_init(&options, UINT64_MAX, HTREE_H), HTREE_ERROR_ARGUMENT);
}

static void options_init_writes_every_default(void **state) {
    (void)state;
    for (htree_kind kind = HTREE_UG; kind <= HTREE_WIDE; ++kind) {
        htree_options a, b;
        memset(&a, 0x00, sizeof a);
        memset(&b, 0xff, sizeof b);
        assert_int_equal(htree_options_init(&a, sizeof a, kind), HTREE_OK);
        assert_int_equal(htree_options_init(&b, sizeof b, kind), HTREE_OK);
        assert_memory_equal(&a, &b, sizeof a);
        assert_int_equal(a.size, sizeof a);
        assert_int_equal(a.kind, kind);
        assert_int_equal(a.flags, 0);
        assert_null((void *)(uintptr_t)a.allocator.allocate);
        assert_null((void *)(uintptr_t)a.tasks.run);
        assert_null((void *)(uintptr_t)a.progress.report);
    }
}

/* A program built against a later header has a longer struct: fine while the new part is zero. */
static void build_takes_longer_options_with_a_zero_tail_only(void **state) {
    enum { LONGER = 64 };
    union {
        htree_options options;
        unsigned char bytes[sizeof(htree_options) + LONGER];
    } u;
    const htree_mesh mesh = good_mesh();
    (void)state;
    for (uint32_t extra = 0; extra <= LONGER; extra += 4) {
        htree *tree = NULL;
        memset(&u, 0, sizeof u);
        u.options = options_of(next_kind(0));
        u.options.size = (uint32_t)sizeof u.options + extra;
        assert_int_equal(htree_build(&tree, &mesh, &u.options), HTREE_OK);
        htree_free(tree);
        if (extra == 0) continue;
        u.bytes[sizeof u.options + extra - 1] = 1;
        assert_not_built(&mesh, &u.options, HTREE_ERROR_ARGUMENT);
    }
    for (uint32_t size = 0; size < sizeof u.options; ++size) {
        u.options = options_of(next_kind(0));
        u.options.size = size;
        assert_not_built(&mesh, &u.options, HTREE_ERROR_ARGUMENT);
    }
}

static void *refuse_all(void *user, uint64_t bytes, uint64_t alignment) {
    (void)user;
    (void)bytes;
    (void)alignment;
    return NULL;
}

static void release_none(void *user, void *memory, uint64_t bytes) {
    (void)user;
    (void)memory;
    (void)bytes;
}

static void build_refuses_bad_numbers_in_options(void **state) {
    static const uint32_t buckets[] = {0, 1, 65, 1000, UINT32_MAX};
    static const uint32_t axes[] = {0, 2, 4, UINT32_MAX};
    static const htree_kind kinds[] = {0, -1, HTREE_WIDE + 1, INT32_MAX, INT32_MIN};
    const htree_mesh mesh = good_mesh();
    const htree_options good = options_of(next_kind(0));
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(buckets); ++i) {
        htree_options bad = good;
        bad.buckets = buckets[i];
        assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
    }
    for (uint32_t i = 0; i < COUNT_OF(axes); ++i) {
        htree_options bad = good;
        bad.axes = axes[i];
        assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
    }
    for (uint32_t i = 0; i < COUNT_OF(kinds); ++i) {
        htree_options bad = good;
        bad.kind = kinds[i];
        assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
    }
    const uint32_t known = HTREE_STRICT | HTREE_ANY_PLANES | HTREE_LOOSE_PLANES | HTREE_MORTON |
                           HTREE_LAZY | HTREE_COMPACT | HTREE_COLLAPSE;
    for (uint32_t bit = 0; bit < 32; ++bit) {
        htree_options bad = good;
        if ((known >> bit & 1) != 0) continue;
        bad.flags = 1u << bit;
        assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
        bad.flags |= HTREE_STRICT;
        assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
    }
}

static void build_refuses_bad_costs(void **state) {
    static const float costs[] = {NAN, -NAN, -1, -0.5f, INFINITY, -INFINITY};
    const htree_mesh mesh = good_mesh();
    (void)state;
    for (uint32_t i = 0; i < 4 * COUNT_OF(costs); ++i) {
        htree_options bad = options_of(next_kind(0));
        float *const field[4] = {&bad.cost_skd, &bad.cost_bv2, &bad.cost_bv6, &bad.cost_intersect};
        *field[i % 4] = costs[i / 4];
        assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
    }
}

static void build_refuses_bad_grids(void **state) {
    static const float cells[] = {NAN, 0, -1, INFINITY, 1.0f / 65, 65, 1e30f};
    static const uint32_t few[] = {0, (1u << 20) + 1, UINT32_MAX};
    const htree_mesh mesh = good_mesh();
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(cells); ++i) {
        htree_options bad = options_of(next_kind(0));
        bad.cells_per_prim = cells[i];
        assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
    }
    for (uint32_t i = 0; i < COUNT_OF(few); ++i) {
        htree_options bad = options_of(next_kind(0));
        bad.few_prims = few[i];
        assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
    }
}

static void build_refuses_half_an_allocator(void **state) {
    const htree_mesh mesh = good_mesh();
    htree_options bad = options_of(next_kind(0));
    (void)state;
    bad.allocator.allocate = refuse_all;
    assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
    bad.allocator.allocate = NULL;
    bad.allocator.release = release_none;
    assert_not_built(&mesh, &bad, HTREE_ERROR_ARGUMENT);
    bad.allocator.allocate = refuse_all;
    assert_not_built(&mesh, &bad, HTREE_ERROR_MEMORY);
}

static void calibration_refuses_options_of_no_size(void **state) {
    htree_options options = options_of(HTREE_H);
    (void)state;
    options.size = sizeof options - 1;
    assert_int_equal(htree_calibrate(&options), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_calibrate(NULL), HTREE_ERROR_ARGUMENT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_version_is_that_of_the_header),
        cmocka_unit_test(every_status_has_a_name_of_its_own),
        cmocka_unit_test(kind_names_go_there_and_back),
        cmocka_unit_test(success_does_not_touch_the_text),
        cmocka_unit_test(options_init_refuses_bad_arguments),
        cmocka_unit_test(options_init_writes_every_default),
        cmocka_unit_test(build_takes_longer_options_with_a_zero_tail_only),
        cmocka_unit_test(build_refuses_bad_numbers_in_options),
        cmocka_unit_test(build_refuses_bad_costs),
        cmocka_unit_test(build_refuses_bad_grids),
        cmocka_unit_test(build_refuses_half_an_allocator),
        cmocka_unit_test(calibration_refuses_options_of_no_size),
    };
    const int failed = cmocka_run_group_tests_name("api", tests, NULL, NULL);
    say("%llu bad calls refused", (unsigned long long)refusals());
    return failed;
}
