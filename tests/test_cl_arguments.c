/* test_cl_arguments.c: every function of htree_cl.h refuses every bad argument, says why, and
 * writes nothing. On the mock. */
#include "rig.h"

enum { RAYS = 100 };

static rig r;
static uint64_t refusals;

/* What every test starts from. */
static htree_cl *device;
static htree_cl_tree *tree;
static cl_context context;
static cl_device_id id;
static cl_command_queue queue;

#define refused(status, call)            refused_at(status, 0, call, __FILE__, __LINE__)
#define refused_with(status, code, call) refused_at(status, code, call, __FILE__, __LINE__)
static void refused_at(htree_status should, int32_t code, htree_status is, const char *file,
                       int line) {
    ++refusals;
    if (is == should && htree_cl_error_code() == code && strlen(htree_cl_error_text()) > 8) return;
    print_error("%s:%d: %s, %d: %s\n", file, line, htree_status_name(is),
                (int)htree_cl_error_code(), htree_cl_error_text());
    fail();
}

static const htree_status wrong = HTREE_ERROR_ARGUMENT;

/* ---- Structs that say their size ------------------------------------------------------------ */

static void structs_of_another_size_are_refused(void **state) {
    static const uint64_t sizes[] = {0, 1, 4, 65537, UINT32_MAX, UINT64_MAX};
    htree_cl_options options = cl_options(), old_options;
    htree_cl_query query, old_query;
    htree_cl_info info, old_info;
    (void)state;
    assert_cl_ok(htree_cl_query_init(&query, sizeof query));
    memset(&info, 0x5a, sizeof info);
    memset(&options, 0x5a, sizeof options);
    memset(&query, 0x5a, sizeof query);
    old_options = options;
    old_query = query;
    refused(wrong, htree_cl_options_init(NULL, sizeof options));
    refused(wrong, htree_cl_query_init(NULL, sizeof query));
    refused(wrong, htree_cl_get_device_info(0, NULL));
    refused(wrong, htree_cl_get_info(device, NULL));
    refused(wrong, htree_cl_get_info(NULL, &info));
    for (uint32_t i = 0; i < COUNT_OF(sizes); ++i) {
        refused(wrong, htree_cl_options_init(&options, sizes[i]));
        refused(wrong, htree_cl_query_init(&query, sizes[i]));
        info.size = (uint32_t)sizes[i];
        old_info = info;
        refused(wrong, htree_cl_get_info(device, &info));
        refused(wrong, htree_cl_get_device_info(0, &info));
        assert_memory_equal(&info, &old_info, sizeof info);
        assert_memory_equal(&options, &old_options, sizeof options);
        assert_memory_equal(&query, &old_query, sizeof query);
    }
}

/* A later version's struct is larger: what is beyond must be 0 where it is read, and is written
 * 0. */
static void structs_of_a_later_version_are_understood(void **state) {
    struct later_info {
        htree_cl_info info;
        uint64_t more;
    } info;
    struct later_options {
        htree_cl_options options;
        uint64_t more;
    } options;
    struct later_query {
        htree_cl_query query;
        uint64_t more;
    } query;
    htree_cl *other = NULL;
    (void)state;
    memset(&info, 0x5a, sizeof info);
    info.info.size = sizeof info;
    assert_cl_ok(htree_cl_get_info(device, &info.info));
    assert_true(info.more == 0 && info.info.size == sizeof info);
    memset(&info, 0x5a, sizeof info);
    info.info.size = sizeof info;
    assert_cl_ok(htree_cl_get_device_info(0, &info.info));
    assert_true(info.more == 0 && info.info.size == sizeof info);
    assert_cl_ok(htree_cl_options_init(&options.options, sizeof options));
    assert_int_equal(options.more, 0);
    assert_cl_ok(htree_cl_open(&other, NULL, &options.options));
    htree_cl_close(other);
    options.more = 1;
    refused(wrong, htree_cl_open(&other, NULL, &options.options));
    assert_null(other);
    assert_cl_ok(htree_cl_query_init(&query.query, sizeof query));
    assert_cl_ok(htree_cl_intersect(tree, r.rays, r.count, r.hits, &query.query));
    query.more = 1;
    refused(wrong, htree_cl_intersect(tree, r.rays, r.count, r.hits, &query.query));
    refused(wrong, htree_cl_occluded(tree, r.rays, r.count, r.any, &query.query));
}

/* ---- Devices -------------------------------------------------------------------------------- */

static void refuse_options(htree_cl_options options) {
    htree_cl *other = (htree_cl *)(uintptr_t)8;
    refused(wrong, htree_cl_open(&other, NULL, &options));
    assert_null(other);
    other = (htree_cl *)(uintptr_t)8;
    refused(wrong, htree_cl_open_context(&other, context, id, queue, &options));
    assert_null(other);
}

static void devices_refuse_bad_arguments(void **state) {
    const htree_cl_options good = cl_options();
    htree_cl_options options;
    htree_cl *other = (htree_cl *)(uintptr_t)8;
    htree_cl_info info;
    (void)state;
    info.size = sizeof info;
    refused(wrong, htree_cl_get_device_count(NULL));
    refused(wrong, htree_cl_get_device_info(1, &info));
    refused(wrong, htree_cl_get_device_info(HTREE_NONE, &info));
    refused(wrong, htree_cl_open(NULL, NULL, NULL));
    refused(wrong, htree_cl_open_context(NULL, context, id, queue, NULL));
    refused(wrong, htree_cl_open_context(&other, NULL, id, queue, NULL));
    assert_null(other);
    other = (htree_cl *)(uintptr_t)8;
    refused(wrong, htree_cl_open_context(&other, context, NULL, queue, NULL));
    assert_null(other);
    refused(wrong, htree_cl_get_objects(NULL, NULL, NULL, NULL));
    assert_cl_ok(htree_cl_get_objects(device, NULL, NULL, NULL));
    for (uint32_t bit = 1; bit < 32; ++bit) {
        options = good;
        options.flags = 1u << bit;
        refuse_options(options);
    }
    for (uint32_t size = 0; size < sizeof options; size += 4) {
        options = good;
        options.size = size;
        refuse_options(options);
    }
    options = good;
    options.allocator.allocate = ledger_allocator(&r.books).allocate;
    refuse_options(options);
    options = good;
    options.allocator.release = ledger_allocator(&r.books).release;
    refuse_options(options);
}

/* OpenCL knows them, and its code says what they are. */
static void objects_of_another_context_are_refused(void **state) {
    htree_cl *other = (htree_cl *)(uintptr_t)8;
    cl_context second = clCreateContext(NULL, 1, &id, NULL, NULL, NULL);
    cl_command_queue foreign = clCreateCommandQueue(second, id, 0, NULL);
    cl_mem buffer = clCreateBuffer(second, CL_MEM_READ_WRITE, RAYS * 32, NULL, NULL);
    cl_mem mine = clCreateBuffer(context, CL_MEM_READ_WRITE, RAYS * 32, NULL, NULL);
    cl_event event = (cl_event)(uintptr_t)8;
    (void)state;
    refused_with(wrong, CL_INVALID_CONTEXT,
                 htree_cl_open_context(&other, context, id, foreign, NULL));
    assert_null(other);
    refused_with(HTREE_ERROR_DEVICE, CL_INVALID_CONTEXT,
                 htree_cl_enqueue_intersect(tree, foreign, mine, RAYS, mine, 0, NULL, &event));
    assert_null(event);
    refused_with(HTREE_ERROR_DEVICE, CL_INVALID_CONTEXT,
                 htree_cl_enqueue_intersect(tree, queue, buffer, RAYS, mine, 0, NULL, &event));
    assert_null(event);
    clReleaseMemObject(buffer);
    clReleaseMemObject(mine);
    clReleaseCommandQueue(foreign);
    clReleaseContext(second);
}

/* ---- Trees ---------------------------------------------------------------------------------- */

static void uploads_refuse_bad_arguments(void **state) {
    htree_cl_tree *none = (htree_cl_tree *)(uintptr_t)8;
    (void)state;
    refused(wrong, htree_cl_upload(NULL, device, r.trees[0]));
    refused(wrong, htree_cl_upload(&none, NULL, r.trees[0]));
    assert_null(none);
    none = (htree_cl_tree *)(uintptr_t)8;
    refused(wrong, htree_cl_upload(&none, device, NULL));
    assert_null(none);
}

/* ---- Queries -------------------------------------------------------------------------------- */

static void queries_refuse_bad_arguments(void **state) {
    htree_cl_query query;
    (void)state;
    assert_cl_ok(htree_cl_query_init(&query, sizeof query));
    rig_spoil(&r);
    refused(wrong, htree_cl_intersect(NULL, r.rays, RAYS, r.hits, NULL));
    refused(wrong, htree_cl_occluded(NULL, r.rays, RAYS, r.any, NULL));
    refused(wrong, htree_cl_intersect(tree, NULL, RAYS, r.hits, NULL));
    refused(wrong, htree_cl_occluded(tree, NULL, RAYS, r.any, NULL));
    refused(wrong, htree_cl_intersect(tree, r.rays, RAYS, NULL, NULL));
    refused(wrong, htree_cl_occluded(tree, r.rays, RAYS, NULL, NULL));
    refused(wrong, htree_cl_intersect(tree, r.rays, UINT64_MAX / 32 + 1, r.hits, NULL));
    refused(wrong, htree_cl_occluded(tree, r.rays, UINT64_MAX, r.any, NULL));
    for (uint32_t bit = 0; bit < 32; ++bit) {
        query.flags = 1u << bit;
        refused(wrong, htree_cl_intersect(tree, r.rays, RAYS, r.hits, &query));
        refused(wrong, htree_cl_occluded(tree, r.rays, RAYS, r.any, &query));
    }
    query.flags = 0;
    for (uint32_t size = 0; size < sizeof query; size += 4) {
        query.size = size;
        refused(wrong, htree_cl_intersect(tree, r.rays, RAYS, r.hits, &query));
        refused(wrong, htree_cl_occluded(tree, r.rays, RAYS, r.any, &query));
    }
    for (uint64_t i = 0; i < RAYS * sizeof *r.hits; ++i)
        assert_int_equal(((const uint8_t *)r.hits)[i], 0x5a);
    assert_cl_ok(htree_cl_intersect(tree, NULL, 0, NULL, NULL));
    assert_cl_ok(htree_cl_occluded(tree, NULL, 0, NULL, NULL));
}

typedef htree_status (*enqueue_function)(const htree_cl_tree *tree, cl_command_queue queue,
                                         cl_mem rays, uint64_t count, cl_mem answers,
                                         uint32_t wait_count, const cl_event *wait,
                                         cl_event *event);

static void refuse_enqueue(enqueue_function enqueue, size_t answer_size) {
    cl_mem rays = clCreateBuffer(context, CL_MEM_READ_WRITE, RAYS * sizeof(htree_ray), NULL, NULL);
    cl_mem answers = clCreateBuffer(context, CL_MEM_READ_WRITE, RAYS * answer_size, NULL, NULL);
    cl_mem short_rays =
        clCreateBuffer(context, CL_MEM_READ_WRITE, RAYS * sizeof(htree_ray) - 1, NULL, NULL);
    cl_mem short_answers =
        clCreateBuffer(context, CL_MEM_READ_WRITE, RAYS * answer_size - 1, NULL, NULL);
    cl_mem no_buffer = (cl_mem)(void *)&r;
    cl_event event = (cl_event)(uintptr_t)8;
    refused(wrong, enqueue(NULL, queue, rays, RAYS, answers, 0, NULL, &event));
    assert_null(event);
    refused(wrong, enqueue(tree, queue, NULL, RAYS, answers, 0, NULL, &event));
    refused(wrong, enqueue(tree, queue, rays, RAYS, NULL, 0, NULL, &event));
    refused(wrong, enqueue(tree, queue, rays, RAYS, answers, 1, NULL, &event));
    refused(wrong, enqueue(tree, queue, rays, UINT64_MAX / 32 + 1, answers, 0, NULL, &event));
    refused_with(wrong, CL_INVALID_BUFFER_SIZE,
                 enqueue(tree, queue, short_rays, RAYS, answers, 0, NULL, &event));
    refused_with(wrong, CL_INVALID_BUFFER_SIZE,
                 enqueue(tree, queue, rays, RAYS, short_answers, 0, NULL, NULL));
    refused_with(wrong, CL_INVALID_BUFFER_SIZE,
                 enqueue(tree, queue, rays, UINT64_MAX / 32, answers, 0, NULL, &event));
    refused_with(wrong, CL_INVALID_MEM_OBJECT,
                 enqueue(tree, queue, no_buffer, RAYS, answers, 0, NULL, &event));
    refused_with(wrong, CL_INVALID_MEM_OBJECT,
                 enqueue(tree, queue, rays, RAYS, no_buffer, 0, NULL, &event));
    refused_with(HTREE_ERROR_DEVICE, CL_INVALID_COMMAND_QUEUE,
                 enqueue(tree, (cl_command_queue)(void *)&r, rays, RAYS, answers, 0, NULL, &event));
    assert_null(event);
    assert_int_equal(mock_pending(), 0);
    assert_cl_ok(enqueue(tree, queue, rays, RAYS, answers, 0, NULL, &event));
    assert_cl_ok(enqueue(tree, NULL, rays, 0, answers, 1, &event, NULL));
    assert_int_equal(clFinish(queue), CL_SUCCESS);
    clReleaseEvent(event);
    clReleaseMemObject(rays);
    clReleaseMemObject(answers);
    clReleaseMemObject(short_rays);
    clReleaseMemObject(short_answers);
}

static void enqueues_refuse_bad_arguments(void **state) {
    (void)state;
    refuse_enqueue(htree_cl_enqueue_intersect, sizeof(htree_hit));
    refuse_enqueue(htree_cl_enqueue_occluded, 1);
}

static void names_that_are_no_device_are_refused(void **state) {
    static const char *const names[] = {"1", "00000000001", "-0", " 0", "0x0", "pocl", "mock  d"};
    static const char *const good[] = {"", "0", "000", "MOCK", "k d", "device"};
    char longest[5000];
    (void)state;
    memset(longest, 'm', sizeof longest);
    longest[sizeof longest - 1] = 0;
    for (uint32_t i = 0; i <= COUNT_OF(names); ++i) {
        htree_cl *other = (htree_cl *)(uintptr_t)8;
        refused_with(HTREE_ERROR_NO_DEVICE, CL_DEVICE_NOT_FOUND,
                     htree_cl_open(&other, i < COUNT_OF(names) ? names[i] : longest, NULL));
        assert_null(other);
    }
    for (uint32_t i = 0; i < COUNT_OF(good); ++i) {
        htree_cl *other = NULL;
        assert_cl_ok(htree_cl_open(&other, good[i], NULL));
        htree_cl_close(other);
    }
}

static int begin(void **state) {
    (void)state;
    mock_reset();
    rig_begin(&r, "knot", 500, RAYS);
    device = open_device(NULL);
    tree = upload(device, r.trees[0]);
    assert_cl_ok(htree_cl_get_objects(device, &context, &id, &queue));
    return 0;
}

static int end(void **state) {
    (void)state;
    rig_prove(&r, tree);
    htree_cl_free(tree);
    htree_cl_close(device);
    htree_cl_free(NULL);
    htree_cl_close(NULL);
    rig_nothing_is_left(&r);
    rig_end(&r);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(structs_of_another_size_are_refused),
        cmocka_unit_test(structs_of_a_later_version_are_understood),
        cmocka_unit_test(devices_refuse_bad_arguments),
        cmocka_unit_test(objects_of_another_context_are_refused),
        cmocka_unit_test(names_that_are_no_device_are_refused),
        cmocka_unit_test(uploads_refuse_bad_arguments),
        cmocka_unit_test(queries_refuse_bad_arguments),
        cmocka_unit_test(enqueues_refuse_bad_arguments),
    };
    const int failed = cmocka_run_group_tests_name("cl_arguments", tests, begin, end);
    say("%llu calls refused", (unsigned long long)refusals);
    return failed;
}
