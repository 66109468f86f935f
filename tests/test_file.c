/* test_file.c: a tree that is saved and loaded is the same tree. */
#include "ledger.h"
#include "saved.h"

/* ---- Same tree ------------------------------------------------------------------------------ */

static void assert_same_hits(const htree *a, const htree *b, const ray_target *target,
                             uint64_t count) {
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    htree_hit *const hits = (htree_hit *)take(2 * count * sizeof *hits);
    uint8_t *const any = (uint8_t *)take(2 * count);
    dice d = {count};
    rays_make_mixed(target, &d, rays, count);
    assert_int_equal(htree_intersect(a, rays, count, hits, NULL), HTREE_OK);
    assert_int_equal(htree_intersect(b, rays, count, hits + count, NULL), HTREE_OK);
    assert_int_equal(hits_differ(hits, hits + count, count), 0);
    assert_int_equal(htree_occluded(a, rays, count, any, NULL), HTREE_OK);
    assert_int_equal(htree_occluded(b, rays, count, any + count, NULL), HTREE_OK);
    assert_memory_equal(any, any + count, count);
    free(rays);
    free(hits);
    free(any);
}

static void assert_same_tree(const htree *a, const htree *b, const seed_scene *scene,
                             uint64_t rays) {
    htree_stats sa = stats_of(a), sb = stats_of(b);
    sa.bytes = sb.bytes = sa.peak_bytes = sb.peak_bytes = 0;
    sa.build_seconds = sb.build_seconds = 0;
    assert_memory_equal(&sa, &sb, sizeof sa);
    htree_box box_a, box_b;
    assert_int_equal(htree_get_bounds(a, &box_a), HTREE_OK);
    assert_int_equal(htree_get_bounds(b, &box_b), HTREE_OK);
    assert_memory_equal(&box_a, &box_b, sizeof box_a);
    assert_same_hits(a, b, &scene->target, rays);
    saved fa = saved_of(a), fb = saved_of(b);
    assert_int_equal(fa.size, fb.size);
    assert_memory_equal(fa.bytes, fb.bytes, fa.size);
    saved_free(&fa);
    saved_free(&fb);
}

/* Loads the file three ways: copied, copied from an odd address, and in place. */
static void load_and_compare(const htree *tree, const seed_scene *scene, uint64_t rays) {
    saved file = saved_of(tree);
    saved moved = saved_copy(NULL, file.size + 1);
    memcpy(moved.bytes + 1, file.bytes, file.size);
    htree_load_options options = seed_load_options(scene);
    const void *const from[] = {file.bytes, moved.bytes + 1, file.bytes};
    for (uint32_t i = 0; i < COUNT_OF(from); ++i) {
        htree *back = NULL;
        options.flags = i == 2 ? HTREE_BORROW : 0;
        if (htree_load(&back, from[i], file.size, &options) != HTREE_OK)
            fail_msg("load: %s", htree_error_text());
        if (i != 2) memset((void *)(uintptr_t)from[i], 0x5a, file.size);
        if (i == 0) memcpy(file.bytes, moved.bytes + 1, file.size);
        assert_same_tree(tree, back, scene, rays);
        htree_free(back);
    }
    saved_free(&file);
    saved_free(&moved);
}

static void a_saved_tree_comes_back(void **state) {
    uint64_t trees = 0;
    (void)state;
    for (htree_kind kind = next_seed_kind(0); kind != 0; kind = next_seed_kind(kind)) {
        for (int which = 0; which < SEED_SCENES; ++which) {
            for (uint64_t triangles = 1; triangles <= scaled(40000); triangles *= 10) {
                seed_scene scene;
                seed_scene_make(&scene, which, triangles);
                htree *const tree = seed_tree(&scene, kind);
                load_and_compare(tree, &scene, 500);
                htree_free(tree);
                seed_scene_free(&scene);
                ++trees;
            }
        }
    }
    say("trees saved and loaded: %llu", (unsigned long long)trees);
}

/* Whatever the memory held before, and whoever built the tree. */
static void a_tree_has_one_file(void **state) {
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        shape s = shape_of("city", 20000, 5);
        const htree_mesh mesh = mesh_of(&s);
        htree *const tree = tree_of_kind(&mesh, kind);
        saved file = saved_of(tree);
        for (uint32_t threads = 2; threads <= 8; threads *= 2) {
            ledger books;
            ledger_init(&books);
            htree_options options = options_of(kind);
            options.threads = threads;
            options.allocator = ledger_allocator(&books);
            htree *const other = tree_of(&mesh, &options);
            saved same = saved_of(other);
            assert_int_equal(same.size, file.size);
            assert_memory_equal(same.bytes, file.bytes, file.size);
            saved_free(&same);
            htree_free(other);
            ledger_assert_balanced(&books);
            ledger_free(&books);
        }
        saved_free(&file);
        htree_free(tree);
        shape_free(&s);
    }
}

/* A file that is borrowed is not written to: the tree gets arrays of its own. */
static void a_loaded_tree_can_be_updated(void **state) {
    (void)state;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        for (uint32_t i = 0; i < 4; ++i) {
            seed_scene scene;
            double quality = 0;
            htree *back = NULL;
            seed_scene_make(&scene, SEED_BOTH, 500);
            htree *const tree = seed_tree(&scene, kind);
            saved file = saved_of(tree), copy = saved_copy(file.bytes, file.size);
            htree_free(tree);
            htree_load_options options = seed_load_options(&scene);
            options.flags = i & 1 ? HTREE_BORROW : 0;
            assert_int_equal(htree_load(&back, file.bytes, file.size, &options), HTREE_OK);
            for (uint64_t k = 0; k < 3 * scene.mesh.vertex_count; ++k)
                scene.mesh.positions[k] = 2 * scene.mesh.positions[k] + 1;
            memcpy(&scene.mesh.positions[3], &scene.mesh.positions[0], 12); /* without area */
            const int32_t how = i & 2 ? HTREE_REFIT : HTREE_REBUILD;
            assert_int_equal(htree_update(back, &scene.input, how, &quality), HTREE_OK);
            assert_memory_equal(file.bytes, copy.bytes, file.size);
            assert_int_equal(htree_check(back), HTREE_OK);
            htree *const fresh = seed_tree(&scene, kind);
            assert_same_hits(back, fresh, &scene.target, 300);
            load_and_compare(back, &scene, 100);
            htree_free(fresh);
            htree_free(back);
            saved_free(&file);
            saved_free(&copy);
            seed_scene_free(&scene);
        }
    }
}

/* One of the ways to build a tree that are not the defaults of its kind; false after the last. */
static bool other_options(uint32_t number, htree_options *options) {
    static const struct {
        htree_kind kind;
        uint32_t flags;
    } ways[] = {
        {HTREE_FAST, 0},
        {HTREE_BEST, 0},
        {HTREE_BEST, HTREE_COMPACT | HTREE_STRICT},
        {HTREE_AH, HTREE_ANY_PLANES | HTREE_LOOSE_PLANES},
        {HTREE_AH, HTREE_COLLAPSE},
        {HTREE_KD, HTREE_COLLAPSE},
        {HTREE_WIDE, HTREE_COMPACT},
        {HTREE_WIDE, HTREE_LAZY},
        {HTREE_WIDE, HTREE_LAZY | HTREE_MORTON},
    };
    if (number >= COUNT_OF(ways)) return false;
    *options = options_of(ways[number].kind);
    options->flags |= ways[number].flags;
    options->threads = 1;
    options->buckets = 5 + number;
    options->axes = number % 2 ? 1 : 3;
    options->few_prims = 7 + number;
    options->cells_per_prim = 0.25f + (float)number;
    options->cost_intersect = 2;
    return true;
}

static void a_loaded_tree_is_rebuilt_as_it_was_built(void **state) {
    htree_options options;
    seed_scene scene;
    (void)state;
    seed_scene_make(&scene, SEED_KNOT, 3000);
    for (uint32_t number = 0; other_options(number, &options); ++number) {
        htree *const tree = tree_of(&scene.input, &options);
        assert_int_equal(htree_complete(tree), HTREE_OK);
        saved file = saved_of(tree);
        htree *back = NULL;
        const htree_load_options load = seed_load_options(&scene);
        assert_int_equal(htree_load(&back, file.bytes, file.size, &load), HTREE_OK);
        assert_int_equal(htree_update(back, &scene.input, HTREE_REBUILD, NULL), HTREE_OK);
        assert_int_equal(htree_complete(back), HTREE_OK);
        saved again = saved_of(back);
        assert_int_equal(again.size, file.size);
        assert_memory_equal(again.bytes, file.bytes, file.size);
        htree_free(back);
        htree_free(tree);
        saved_free(&file);
        saved_free(&again);
    }
    seed_scene_free(&scene);
}

static void a_lazy_tree_is_saved_when_it_is_complete(void **state) {
    seed_scene scene;
    uint64_t size = 5;
    (void)state;
    seed_scene_make(&scene, SEED_KNOT, 3000);
    htree_options options = options_of(HTREE_WIDE);
    options.flags = HTREE_LAZY;
    htree *const tree = tree_of(&scene.input, &options);
    assert_int_equal(htree_save(tree, NULL, 0, &size), HTREE_ERROR_UNSUPPORTED);
    assert_int_equal(size, 5);
    assert_int_equal(htree_complete(tree), HTREE_OK);
    load_and_compare(tree, &scene, 100);
    htree_free(tree);
    seed_scene_free(&scene);
}

/* ---- Arguments ------------------------------------------------------------------------------ */

static void saving_needs_room(void **state) {
    seed_scene scene;
    uint64_t size = 0, bytes = 77;
    (void)state;
    seed_scene_make(&scene, SEED_BOTH, 20);
    htree *const tree = seed_tree(&scene, HTREE_H);
    assert_int_equal(htree_save(tree, NULL, 0, &size), HTREE_OK);
    saved file = saved_copy(NULL, size + 1);
    memset(file.bytes, 0x5a, size + 1);
    for (uint64_t room = 0; room < size; ++room)
        assert_int_equal(htree_save(tree, file.bytes, room, &bytes), HTREE_ERROR_ARGUMENT);
    assert_int_equal(bytes, 77);
    for (uint64_t i = 0; i < size; ++i) assert_int_equal(file.bytes[i], 0x5a);
    assert_int_equal(htree_save(tree, file.bytes, size + 1, &bytes), HTREE_OK);
    assert_int_equal(bytes, size);
    assert_int_equal(file.bytes[size], 0x5a);
    assert_int_equal(htree_save(NULL, file.bytes, size, &bytes), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_save(tree, file.bytes, size, NULL), HTREE_ERROR_ARGUMENT);
    saved_free(&file);
    htree_free(tree);
    seed_scene_free(&scene);
}

static void refuse(const void *file, uint64_t size, const htree_load_options *options) {
    htree *tree = (htree *)(uintptr_t)8;
    assert_int_equal(htree_load(&tree, file, size, options), HTREE_ERROR_ARGUMENT);
    assert_null(tree);
    assert_true(htree_error_text()[0] != 0);
}

static void give_back(void *user, void *memory, uint64_t bytes) {
    (void)user;
    (void)memory;
    (void)bytes;
}

static void loading_refuses_bad_arguments(void **state) {
    seed_scene scene;
    (void)state;
    seed_scene_make(&scene, SEED_BOTH, 20);
    htree *const tree = seed_tree(&scene, HTREE_KD);
    saved file = saved_of(tree);
    const htree_load_options good = seed_load_options(&scene);
    assert_int_equal(htree_load(NULL, file.bytes, file.size, &good), HTREE_ERROR_ARGUMENT);
    refuse(NULL, file.size, &good);
    refuse(file.bytes, file.size, NULL); /* it holds objects */
    htree_load_options bad = good;
    bad.intersect = NULL;
    refuse(file.bytes, file.size, &bad);
    for (uint32_t bit = 1; bit < 32; ++bit) {
        bad = good;
        bad.flags = 1u << bit;
        refuse(file.bytes, file.size, &bad);
    }
    bad = good;
    bad.reserved = 1;
    refuse(file.bytes, file.size, &bad);
    bad = good;
    bad.allocator.release = give_back;
    refuse(file.bytes, file.size, &bad);
    for (bad = good, bad.size = 0; bad.size < sizeof bad; ++bad.size)
        refuse(file.bytes, file.size, &bad);
    bad = good;
    bad.flags = HTREE_BORROW;
    for (uint64_t odd = 1; odd < 64; ++odd) refuse(file.bytes + odd, file.size - odd, &bad);
    assert_int_equal(htree_load_options_init(NULL, sizeof bad), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_load_options_init(&bad, sizeof bad - 1), HTREE_ERROR_ARGUMENT);
    assert_int_equal(htree_load_options_init(&bad, 65537), HTREE_ERROR_ARGUMENT);
    saved_free(&file);
    htree_free(tree);
    seed_scene_free(&scene);
}

/* ---- Faults --------------------------------------------------------------------------------- */

/* Fails every allocation in turn, once and for good. */
static void every_allocation_may_fail(void **state) {
    uint64_t failures = 0;
    (void)state;
    for (htree_kind kind = next_seed_kind(0); kind != 0; kind = next_seed_kind(kind)) {
        seed_scene scene;
        seed_scene_make(&scene, SEED_BOTH, 100);
        htree *const tree = seed_tree(&scene, kind);
        saved file = saved_of(tree);
        ledger books;
        ledger_init(&books);
        htree_load_options options = seed_load_options(&scene);
        options.allocator = ledger_allocator(&books);
        for (int mode = 0; mode < 4; ++mode) {
            options.flags = mode & 1 ? HTREE_BORROW : 0;
            for (uint64_t call = 1;; ++call) {
                htree *back = NULL;
                ledger_fail(&books, call, mode >= 2);
                const htree_status status = htree_load(&back, file.bytes, file.size, &options);
                const bool failed = books.calls >= call;
                assert_int_equal(status, failed ? HTREE_ERROR_MEMORY : HTREE_OK);
                assert_true((back != NULL) == !failed);
                htree_free(back);
                ledger_assert_balanced(&books);
                failures += failed;
                if (!failed) break;
            }
        }
        ledger_free(&books);
        saved_free(&file);
        htree_free(tree);
        seed_scene_free(&scene);
    }
    say("allocations failed: %llu", (unsigned long long)failures);
    tally("allocation failures", failures);
}

/* What is skipped takes no room in a wide tree, and the memory of a load keeps to the file's size. */
static void skipped_triangles_cost_no_memory(void **state) {
    enum { MANY = 200000 };
    float *const xyz = (float *)take(9 * MANY * sizeof *xyz);
    (void)state;
    memset(xyz, 0, 9 * MANY * sizeof *xyz);
    xyz[9 * 777 + 3] = xyz[9 * 777 + 7] = 1;
    const htree_mesh mesh = plain_mesh(xyz, MANY);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    saved file = saved_of(tree);
    ledger books;
    ledger_init(&books);
    htree_load_options options;
    assert_int_equal(htree_load_options_init(&options, sizeof options), HTREE_OK);
    options.allocator = ledger_allocator(&books);
    htree *back = NULL;
    assert_int_equal(htree_load(&back, file.bytes, file.size, &options), HTREE_OK);
    assert_true(books.peak_bytes <= 2 * file.size + 1024);
    const htree_ray ray = {{0.2f, 0.2f, 1}, 0, {0, 0, -1}, 9};
    htree_hit hit;
    assert_int_equal(htree_intersect(back, &ray, 1, &hit, NULL), HTREE_OK);
    assert_int_equal(hit.prim, 777);
    htree_free(back);
    ledger_assert_balanced(&books);
    ledger_free(&books);
    htree_free(tree);
    saved_free(&file);
    free(xyz);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_saved_tree_comes_back),
        cmocka_unit_test(a_tree_has_one_file),
        cmocka_unit_test(a_loaded_tree_can_be_updated),
        cmocka_unit_test(a_loaded_tree_is_rebuilt_as_it_was_built),
        cmocka_unit_test(saving_needs_room),
        cmocka_unit_test(loading_refuses_bad_arguments),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(a_lazy_tree_is_saved_when_it_is_complete),
        cmocka_unit_test(skipped_triangles_cost_no_memory),
    };
    return cmocka_run_group_tests_name("file", tests, NULL, NULL);
}
