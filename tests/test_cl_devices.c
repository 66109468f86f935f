/* test_cl_devices.c: devices as they may be: none, many, small, wrong, broken, lost. On the
 * mock. */

#include "rig.h"

enum { RAYS = 1500 };

static rig r;
static uint64_t devices_opened, batches_proved;

static htree_cl_info info_of(const htree_cl *device) {
    htree_cl_info info;
    info.size = sizeof info;
    assert_cl_ok(htree_cl_get_info(device, &info));
    return info;
}

static htree_cl *open_in(const mock_world *world, const htree_cl_options *options) {
    mock_set_world(world);
    ++devices_opened;
    return open_device(options);
}

static void prove_all_kinds(htree_cl *device) {
    for (uint32_t i = 0; i < r.kinds; ++i) {
        htree_cl_tree *const tree = upload(device, r.trees[i]);
        rig_prove(&r, tree);
        htree_cl_free(tree);
        batches_proved += 2;
    }
}

/* ---- Which devices there are ---------------------------------------------------------------- */

static void expect_no_device(const mock_world *world, int32_t code) {
    uint32_t count = 7;
    htree_cl *device = (htree_cl *)(uintptr_t)8;
    htree_cl_info info;
    info.size = sizeof info;
    mock_set_world(world);
    assert_int_equal(htree_cl_get_device_count(&count), HTREE_ERROR_NO_DEVICE);
    assert_int_equal(count, 0);
    assert_int_equal(htree_cl_error_code(), code);
    assert_true(strstr(htree_cl_error_text(), "install") != NULL);
    assert_int_equal(htree_cl_get_device_info(0, &info), HTREE_ERROR_NO_DEVICE);
    assert_int_equal(htree_cl_open(&device, NULL, NULL), HTREE_ERROR_NO_DEVICE);
    assert_null(device);
}

static void no_platform_and_no_device_are_said_to_be(void **state) {
    mock_world world = mock_usual_world();
    (void)state;
    world.devices = 0;
    expect_no_device(&world, CL_DEVICE_NOT_FOUND);
    world.platforms = 3;
    expect_no_device(&world, CL_DEVICE_NOT_FOUND);
    world.platforms = 0;
    expect_no_device(&world, -1001);
    rig_nothing_is_left(&r);
}

static void any_number_of_devices_is_found_by_index(void **state) {
    mock_world world = mock_usual_world();
    char name[8];
    (void)state;
    for (world.platforms = 1; world.platforms <= 4; ++world.platforms) {
        for (world.devices = 1; world.devices <= 4; ++world.devices) {
            const uint32_t all = world.platforms * world.devices;
            uint32_t count = 0;
            htree_cl *device = NULL;
            mock_set_world(&world);
            assert_cl_ok(htree_cl_get_device_count(&count));
            assert_int_equal(count, all);
            snprintf(name, sizeof name, "%u", all - 1);
            assert_cl_ok(htree_cl_open(&device, name, NULL));
            assert_int_equal(info_of(device).index, all - 1);
            htree_cl_close(device);
            snprintf(name, sizeof name, "%u", all);
            assert_int_equal(htree_cl_open(&device, name, NULL), HTREE_ERROR_NO_DEVICE);
            assert_null(device);
        }
    }
    rig_nothing_is_left(&r);
}

/* ---- What they are like --------------------------------------------------------------------- */

static void prove_group(mock_world world, uint32_t group_size, uint32_t launch_rays) {
    htree_cl_options options = rig_options(&r);
    options.group_size = group_size;
    options.launch_rays = launch_rays;
    htree_cl *const device = open_in(&world, &options);
    const htree_cl_info info = info_of(device);
    const size_t wanted = group_size ? group_size : 64;
    /* The last kind is the wide tree, whose rays on a CPU share one work-item a group. */
    const size_t wide = group_size ? group_size : world.type & CL_DEVICE_TYPE_CPU ? 512 : 64;
    assert_int_equal(info.exact, 1);
    assert_int_equal(info.shares_memory, world.unified);
    assert_int_equal(info.group_size, wanted < world.group_limit ? wanted : world.group_limit);
    const uint64_t shared = mock_shared_buffers();
    prove_all_kinds(device);
    assert_int_equal(mock_last_group(), wide < world.group_limit ? wide : world.group_limit);
    assert_true((mock_shared_buffers() > shared) == world.unified);
    htree_cl_close(device);
    rig_nothing_is_left(&r);
}

/* The rays are no multiple of any group, and neither is a launch. */
static void any_device_and_any_work_group_gives_the_same_hits(void **state) {
    static const size_t limits[] = {1, 2, 7, 64, 4096};
    static const uint32_t sizes[] = {0, 1, 3, 1000};
    static const uint32_t launches[] = {0, 1001};
    mock_world world = mock_usual_world();
    (void)state;
    const uint32_t step = scaled(100) < 100 ? 7 : 1;
    for (uint32_t i = 0; i < COUNT_OF(limits) * COUNT_OF(sizes) * COUNT_OF(launches); i += step) {
        const uint32_t launch = i / (COUNT_OF(limits) * COUNT_OF(sizes));
        world.group_limit = limits[i % COUNT_OF(limits)];
        world.unified = i % 2 == 0;
        world.type = i / 2 % 2 == 0 ? CL_DEVICE_TYPE_CPU : CL_DEVICE_TYPE_GPU;
        prove_group(world, sizes[i / COUNT_OF(limits) % COUNT_OF(sizes)], launches[launch]);
    }
}

/* On a GPU the stack is as small as a tree allows. */
static void deep_trees_have_the_stack_they_need(void **state) {
    static const char *const shapes[] = {"same", "slivers", "stack", "city"};
    mock_world world = mock_usual_world();
    uint32_t deepest = 0;
    (void)state;
    world.type = CL_DEVICE_TYPE_GPU;
    for (uint32_t i = 0; i < COUNT_OF(shapes); ++i) {
        rig other;
        rig_begin(&other, shapes[i], 1000 + scaled(19000), 200 + scaled(RAYS));
        htree_cl *const device = open_in(&world, NULL);
        for (uint32_t k = 0; k < other.kinds; ++k) {
            const uint32_t stack = stats_of(other.trees[k]).stack;
            if (stack > deepest) deepest = stack;
            htree_cl_tree *const tree = upload(device, other.trees[k]);
            rig_prove(&other, tree);
            htree_cl_free(tree);
            batches_proved += 2;
        }
        htree_cl_close(device);
        rig_end(&other);
    }
    rig_nothing_is_left(&r);
    say("stacks of up to %u entries on a GPU", deepest);
    assert_true(deepest >= 32);
}

static void small_memory_means_small_launches(void **state) {
    const htree_cl_options options = rig_options(&r);
    mock_world world = mock_usual_world();
    htree_cl_tree *tree;
    (void)state;
    htree_cl *device = open_in(&world, &options);
    tree = upload(device, r.trees[0]);
    /* 1500 rays and their hits are 72,000 bytes: half of them fit. */
    world.memory_bytes = mock_live_bytes() + 50000;
    mock_set_world(&world);
    rig_prove(&r, tree);
    world.memory_bytes = mock_live_bytes() + 100;
    mock_set_world(&world);
    assert_int_equal(htree_cl_intersect(tree, r.rays, r.count, r.hits, NULL), HTREE_ERROR_MEMORY);
    assert_int_equal(htree_cl_error_code(), CL_MEM_OBJECT_ALLOCATION_FAILURE);
    htree_cl_free(tree);
    htree_cl_close(device);
    /* Buffers of no more than this hold the known answers, but not all rays at once. */
    world = mock_usual_world();
    world.buffer_bytes = 200000;
    device = open_in(&world, &options);
    prove_all_kinds(device);
    rig other;
    rig_begin(&other, "knot", 20000, 10000);
    assert_int_equal(htree_cl_upload(&tree, device, other.trees[0]), HTREE_ERROR_LIMIT);
    assert_null(tree);
    assert_int_equal(htree_cl_error_code(), 0);
    rig_end(&other);
    htree_cl_close(device);
    rig_nothing_is_left(&r);
}

/* ---- Devices that are wrong ----------------------------------------------------------------- */

static htree_status status_of(bool fp64, mock_wrong wrong, const char *file, htree_kind kind) {
    mock_world world = mock_usual_world();
    htree_cl *device = NULL;
    htree_cl_tree *tree = NULL;
    const htree_cl_options options = rig_options(&r);
    world.fp64 = fp64;
    world.wrong = wrong;
    world.wrong_file = file;
    mock_set_world(&world);
    ++devices_opened;
    htree_status status = htree_cl_open(&device, NULL, &options);
    if (status == HTREE_OK) {
        const htree_cl_info info = info_of(device);
        const bool probe_is_off = strcmp(file, "probe") == 0 && wrong != MOCK_RIGHT;
        assert_int_equal(info.exact, fp64 && !probe_is_off);
        assert_true(info.t_error >= 0 && info.t_error <= HTREE_CL_T_ERROR);
        assert_true(!probe_is_off || info.t_error > 0);
        status = htree_cl_upload(&tree, device, r.trees[kind - 1]);
    }
    if (status != HTREE_OK) {
        assert_null(tree);
        assert_int_equal(htree_cl_error_code(), 0);
        assert_true(device == NULL || strstr(htree_cl_error_text(), "Mock Device") != NULL);
    }
    htree_cl_free(tree);
    htree_cl_close(device);
    rig_nothing_is_left(&r);
    return status;
}

static void wrong_kernels_are_refused(void **state) {
    static const struct {
        const char *file;
        htree_kind kind;
    } files[] = {{"probe", HTREE_H}, {"bvh", HTREE_BVH_MEDIAN}, {"h", HTREE_SKD},
                 {"kd", HTREE_KD},   {"ug", HTREE_UG},          {"wide", HTREE_WIDE}};
    static const mock_wrong wrongs[] = {MOCK_WRONG_MISS, MOCK_WRONG_NAN, MOCK_WRONG_OCCLUDED};
    uint64_t refused = 0;
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(files); ++i) {
        const char *const file = files[i].file;
        const htree_kind kind = files[i].kind;
        for (int fp64 = 0; fp64 < 2; ++fp64) {
            assert_int_equal(status_of(fp64, MOCK_RIGHT, file, kind), HTREE_OK);
            for (uint32_t k = 0; k < COUNT_OF(wrongs); ++k, ++refused)
                assert_int_equal(status_of(fp64, wrongs[k], file, kind), HTREE_ERROR_KERNEL);
        }
        /* One step off is wrong for who promised every bit, and fine for who did not. */
        assert_int_equal(status_of(true, MOCK_WRONG_ULP, file, kind),
                         i == 0 ? HTREE_OK : HTREE_ERROR_KERNEL);
        assert_int_equal(status_of(false, MOCK_WRONG_ULP, file, kind), HTREE_OK);
    }
    say("%llu wrong kernels refused", (unsigned long long)refused);
}

static void what_the_compiler_says_is_kept(void **state) {
    mock_world world = mock_usual_world();
    htree_cl_tree *tree;
    htree_cl *device = (htree_cl *)(uintptr_t)8;
    (void)state;
    world.build_fails = true;
    world.build_log = "line 3: no";
    mock_set_world(&world);
    assert_int_equal(htree_cl_open(&device, NULL, NULL), HTREE_ERROR_KERNEL);
    assert_null(device);
    assert_int_equal(htree_cl_error_code(), CL_BUILD_PROGRAM_FAILURE);
    assert_string_equal(htree_cl_build_log(NULL), "");
    world.build_fails = false;
    world.build_log = "first";
    const htree_cl_options options = rig_options(&r);
    device = open_in(&world, &options);
    const char *const first = htree_cl_build_log(device);
    assert_string_equal(first, "first");
    world.build_fails = true;
    world.build_log = "second";
    mock_set_world(&world);
    assert_int_equal(htree_cl_upload(&tree, device, r.trees[0]), HTREE_ERROR_KERNEL);
    assert_null(tree);
    assert_string_equal(htree_cl_build_log(device), "second");
    assert_string_equal(first, "first");
    world.build_fails = false;
    world.build_log = NULL;
    mock_set_world(&world);
    prove_all_kinds(device);
    assert_string_equal(htree_cl_build_log(device), "second");
    htree_cl_close(device);
    rig_nothing_is_left(&r);
}

/* ---- Devices that break --------------------------------------------------------------------- */

static void a_kernel_that_breaks_is_an_error(void **state) {
    static const cl_int codes[] = {CL_OUT_OF_RESOURCES, -9999};
    mock_world world = mock_usual_world();
    const htree_cl_options options = rig_options(&r);
    (void)state;
    for (uint32_t i = 0; i < 4; ++i) {
        world.unified = i % 2 == 0;
        world.broken_kernel = 0;
        htree_cl *const device = open_in(&world, &options);
        htree_cl_tree *const tree = upload(device, r.trees[i]);
        world.broken_kernel = 1;
        world.broken_kernel_code = codes[i / 2];
        mock_set_world(&world);
        assert_int_equal(htree_cl_intersect(tree, r.rays, r.count, r.hits, NULL),
                         HTREE_ERROR_DEVICE);
        assert_int_equal(htree_cl_error_code(), CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST);
        rig_prove(&r, tree);
        htree_cl_free(tree);
        htree_cl_close(device);
        rig_nothing_is_left(&r);
    }
}

/* What a driver says of a device that is gone, in two ways. */
static void a_lost_device_says_so_until_it_is_closed(void **state) {
    mock_world world = mock_usual_world();
    const htree_cl_options options = rig_options(&r);
    htree_cl_tree *none;
    htree_cl *other = (htree_cl *)(uintptr_t)8;
    (void)state;
    htree_cl *const device = open_in(&world, &options);
    htree_cl_tree *const tree = upload(device, r.trees[1]);
    mock_fail(1, CL_OUT_OF_RESOURCES, false);
    assert_cl_ok(htree_cl_intersect(tree, r.rays, r.count, r.hits, NULL)); /* fewer at a time */
    world.available = false;
    mock_set_world(&world);
    mock_fail(1, CL_OUT_OF_RESOURCES, false);
    assert_int_equal(htree_cl_intersect(tree, r.rays, r.count, r.hits, NULL),
                     HTREE_ERROR_DEVICE_LOST);
    assert_int_equal(htree_cl_error_code(), CL_OUT_OF_RESOURCES);
    world.available = true; /* another one has come, but not what was on the first */
    mock_set_world(&world);
    assert_int_equal(htree_cl_occluded(tree, r.rays, 0, NULL, NULL), HTREE_ERROR_DEVICE_LOST);
    assert_int_equal(htree_cl_error_code(), CL_DEVICE_NOT_AVAILABLE);
    assert_int_equal(htree_cl_upload(&none, device, r.trees[0]), HTREE_ERROR_DEVICE_LOST);
    assert_null(none);
    assert_string_equal(info_of(device).device, "Mock Device");
    htree_cl_close(device);
    htree_cl_free(tree);
    world.available = false;
    mock_set_world(&world);
    assert_int_equal(htree_cl_open(&other, NULL, NULL), HTREE_ERROR_DEVICE_LOST);
    assert_null(other);
    rig_nothing_is_left(&r);
}

static int begin(void **state) {
    (void)state;
    rig_begin(&r, "knot", 500, RAYS);
    return 0;
}

static int end(void **state) {
    (void)state;
    rig_end(&r);
    return 0;
}

static int fresh(void **state) {
    (void)state;
    mock_reset();
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(no_platform_and_no_device_are_said_to_be, fresh),
        cmocka_unit_test_setup(any_number_of_devices_is_found_by_index, fresh),
        cmocka_unit_test_setup(any_device_and_any_work_group_gives_the_same_hits, fresh),
        cmocka_unit_test_setup(deep_trees_have_the_stack_they_need, fresh),
        cmocka_unit_test_setup(small_memory_means_small_launches, fresh),
        cmocka_unit_test_setup(wrong_kernels_are_refused, fresh),
        cmocka_unit_test_setup(what_the_compiler_says_is_kept, fresh),
        cmocka_unit_test_setup(a_kernel_that_breaks_is_an_error, fresh),
        cmocka_unit_test_setup(a_lost_device_says_so_until_it_is_closed, fresh),
    };
    const int failed = cmocka_run_group_tests_name("cl_devices", tests, begin, end);
    say("%llu devices opened, %llu batches equal to the CPU's", (unsigned long long)devices_opened,
        (unsigned long long)batches_proved);
    return failed;
}
