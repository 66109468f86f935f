/* bench.c: the operations of bench.h. */
#include "bench.h"

enum { LAUNCH = 600 };

rig bench_rig;
const operation *bench_op;

static void open_bench(bench *b) {
    mock_set_world(&b->world);
    const htree_cl_options options = rig_options(&bench_rig);
    if (!b->device) b->device = open_device(&options);
}

void bench_close(bench *b) {
    htree_cl_free(b->tree);
    htree_cl_close(b->device);
    if (b->wait) clReleaseEvent(b->wait);
    if (b->event) clReleaseEvent(b->event);
    if (b->rays) clReleaseMemObject(b->rays);
    if (b->answers) clReleaseMemObject(b->answers);
    if (b->queue) clReleaseCommandQueue(b->queue);
    if (b->context) clReleaseContext(b->context);
    const mock_world world = b->world;
    memset(b, 0, sizeof *b);
    b->world = world;
    rig_nothing_is_left(&bench_rig);
}

/* Devices. */

static void prepare_nothing(bench *b) {
    mock_set_world(&b->world);
    b->count = 77;
    b->info.size = sizeof b->info;
}

static htree_status act_count(bench *b) {
    return htree_cl_get_device_count(&b->count);
}

static bool done_count(bench *b) {
    return b->count == 1;
}

static bool undone_count(const bench *b) {
    return b->count == 0;
}

static htree_status act_info(bench *b) {
    return htree_cl_get_device_info(0, &b->info);
}

static bool done_info(bench *b) {
    const bool right = strcmp(b->info.device, "Mock Device") == 0 && b->info.fp64 == 1;
    memset(&b->info, 0, sizeof b->info);
    b->info.size = sizeof b->info;
    return right;
}

static bool undone_info(const bench *b) {
    return b->info.device[0] == 0;
}

static htree_status act_open(bench *b) {
    const htree_cl_options options = rig_options(&bench_rig);
    b->device = (htree_cl *)(uintptr_t)8;
    return htree_cl_open(&b->device, bench_op->kind ? "mock" : NULL, &options);
}

static bool done_open(bench *b) {
    htree_cl_info info;
    info.size = sizeof info;
    const bool right = htree_cl_get_info(b->device, &info) == HTREE_OK && info.group_size == 64;
    htree_cl_close(b->device);
    b->device = NULL;
    return right;
}

static bool undone_open(const bench *b) {
    return b->device == NULL;
}

static void prepare_context(bench *b) {
    cl_platform_id platform;
    mock_set_world(&b->world);
    if (b->context) return;
    assert_int_equal(clGetPlatformIDs(1, &platform, NULL), CL_SUCCESS);
    assert_int_equal(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &b->id, NULL), CL_SUCCESS);
    b->context = clCreateContext(NULL, 1, &b->id, NULL, NULL, NULL);
    b->queue = clCreateCommandQueue(b->context, b->id, 0, NULL);
}

static htree_status act_open_context(bench *b) {
    const htree_cl_options options = rig_options(&bench_rig);
    b->device = (htree_cl *)(uintptr_t)8;
    return htree_cl_open_context(&b->device, b->context, b->id, bench_op->kind ? b->queue : NULL,
                                 &options);
}

/* Trees. */

static htree_status act_upload(bench *b) {
    b->tree = (htree_cl_tree *)(uintptr_t)8;
    return htree_cl_upload(&b->tree, b->device, bench_rig.trees[bench_op->kind]);
}

/* Once a program is compiled, no upload compiles it again: a fresh device does. */
static bool done_upload(bench *b) {
    rig_prove(&bench_rig, b->tree);
    bench_close(b);
    return true;
}

static bool undone_upload(const bench *b) {
    return b->tree == NULL;
}

/* Queries. */

static void prepare_tree(bench *b) {
    b->world.unified = !bench_op->copies;
    open_bench(b);
    if (!b->tree) b->tree = upload(b->device, bench_rig.trees[bench_op->kind]);
    rig_spoil(&bench_rig);
    b->seconds = 7;
}

static htree_status act_intersect(bench *b) {
    htree_cl_query query;
    (void)htree_cl_query_init(&query, sizeof query);
    query.kernel_seconds = &b->seconds;
    return htree_cl_intersect(b->tree, bench_rig.rays, bench_op->rays, bench_rig.hits, &query);
}

static bool done_intersect(bench *b) {
    return rig_hits_are_right(&bench_rig, bench_op->rays) && b->seconds < 7;
}

static htree_status act_occluded(bench *b) {
    return htree_cl_occluded(b->tree, bench_rig.rays, bench_op->rays, bench_rig.any, NULL);
}

static bool done_occluded(bench *b) {
    (void)b;
    return rig_any_is_right(&bench_rig, bench_op->rays);
}

/* What a failed batch leaves in the answers is unspecified; but no command may write there
 * later. */
static bool undone_query(const bench *b) {
    (void)b;
    return true;
}

/* Buffers of the caller's: a batch waits for the event that its rays are there. */
static void prepare_buffers(bench *b) {
    if (!b->device) {
        htree_cl_options options = rig_options(&bench_rig);
        options.launch_rays = LAUNCH;
        b->device = open_device(&options);
    }
    prepare_tree(b);
    cl_context context;
    cl_device_id id;
    cl_int code;
    assert_cl_ok(htree_cl_get_objects(b->device, &context, &id, NULL));
    if (!b->queue) {
        const size_t bytes = (size_t)bench_op->rays * sizeof(htree_ray);
        b->queue = clCreateCommandQueue(context, id, 0, NULL);
        b->rays = clCreateBuffer(context, CL_MEM_READ_ONLY, bytes, NULL, NULL);
        b->answers =
            clCreateBuffer(context, CL_MEM_WRITE_ONLY, (size_t)bench_op->rays * 16, NULL, NULL);
        code = clEnqueueWriteBuffer(b->queue, b->rays, CL_FALSE, 0, bytes, bench_rig.rays, 0, NULL,
                                    &b->wait);
        assert_int_equal(code, CL_SUCCESS);
    }
    b->event = (cl_event)(uintptr_t)8;
}

static htree_status act_enqueue_intersect(bench *b) {
    return htree_cl_enqueue_intersect(b->tree, b->queue, b->rays, bench_op->rays, b->answers, 1,
                                      &b->wait, &b->event);
}

static htree_status act_enqueue_occluded(bench *b) {
    return htree_cl_enqueue_occluded(b->tree, NULL, b->rays, bench_op->rays, b->answers, 1,
                                     &b->wait, &b->event);
}

static void fetch(bench *b, void *to, size_t bytes) {
    assert_int_equal(clWaitForEvents(1, &b->event), CL_SUCCESS);
    assert_int_equal(
        clEnqueueReadBuffer(b->queue, b->answers, CL_TRUE, 0, bytes, to, 1, &b->event, NULL),
        CL_SUCCESS);
    clReleaseEvent(b->event);
    b->event = NULL;
}

static bool done_enqueue_intersect(bench *b) {
    fetch(b, bench_rig.hits, (size_t)bench_op->rays * sizeof *bench_rig.hits);
    return rig_hits_are_right(&bench_rig, bench_op->rays);
}

static bool done_enqueue_occluded(bench *b) {
    fetch(b, bench_rig.any, (size_t)bench_op->rays);
    return rig_any_is_right(&bench_rig, bench_op->rays);
}

static bool undone_enqueue(const bench *b) {
    return b->event == NULL;
}

const operation bench_operations[BENCH_OPERATIONS] = {
    {BENCH_DEVICES, "count", prepare_nothing, act_count, done_count, undone_count, 0, 0, false},
    {BENCH_DEVICES, "info", prepare_nothing, act_info, done_info, undone_info, 0, 0, false},
    {BENCH_DEVICES, "open", prepare_nothing, act_open, done_open, undone_open, 0, 0, false},
    {BENCH_DEVICES, "open by name", prepare_nothing, act_open, done_open, undone_open, 1, 0, false},
    {BENCH_DEVICES, "open context", prepare_context, act_open_context, done_open, undone_open, 0, 0,
     false},
    {BENCH_DEVICES, "open queue", prepare_context, act_open_context, done_open, undone_open, 1, 0,
     false},
    {BENCH_UPLOADS, "upload ug", open_bench, act_upload, done_upload, undone_upload, 0, 0, false},
    {BENCH_UPLOADS, "upload kd", open_bench, act_upload, done_upload, undone_upload, 1, 0, false},
    {BENCH_UPLOADS, "upload bvh-median", open_bench, act_upload, done_upload, undone_upload, 2, 0,
     false},
    {BENCH_UPLOADS, "upload bvh-sah", open_bench, act_upload, done_upload, undone_upload, 3, 0,
     false},
    {BENCH_UPLOADS, "upload skd", open_bench, act_upload, done_upload, undone_upload, 4, 0, false},
    {BENCH_UPLOADS, "upload h", open_bench, act_upload, done_upload, undone_upload, 5, 0, false},
    {BENCH_UPLOADS, "upload ah", open_bench, act_upload, done_upload, undone_upload, 6, 0, false},
    {BENCH_UPLOADS, "upload wide", open_bench, act_upload, done_upload, undone_upload, 7, 0, false},
    {BENCH_QUERIES, "intersect few", prepare_tree, act_intersect, done_intersect, undone_query, 3,
     BENCH_FEW, false},
    {BENCH_QUERIES, "intersect", prepare_tree, act_intersect, done_intersect, undone_query, 5,
     BENCH_MANY, false},
    {BENCH_QUERIES, "intersect copies", prepare_tree, act_intersect, done_intersect, undone_query,
     7, BENCH_MANY, true},
    {BENCH_QUERIES, "occluded few", prepare_tree, act_occluded, done_occluded, undone_query, 1,
     BENCH_FEW, true},
    {BENCH_QUERIES, "occluded", prepare_tree, act_occluded, done_occluded, undone_query, 0,
     BENCH_MANY, false},
    {BENCH_QUERIES, "occluded copies", prepare_tree, act_occluded, done_occluded, undone_query, 6,
     BENCH_MANY, true},
    {BENCH_BUFFERS, "enqueue intersect", prepare_buffers, act_enqueue_intersect,
     done_enqueue_intersect, undone_enqueue, 4, BENCH_MANY, false},
    {BENCH_BUFFERS, "enqueue occluded", prepare_buffers, act_enqueue_occluded,
     done_enqueue_occluded, undone_enqueue, 2, BENCH_MANY, false},
};

bool bench_says_lost(bench *b) {
    htree_cl_tree *tree = (htree_cl_tree *)(uintptr_t)8;
    const htree_status lost = HTREE_ERROR_DEVICE_LOST;
    if (htree_cl_upload(&tree, b->device, bench_rig.trees[0]) != lost || tree) return false;
    if (b->tree && (act_intersect(b) != lost || act_occluded(b) != lost)) return false;
    return !b->rays || (act_enqueue_intersect(b) == lost && act_enqueue_occluded(b) == lost);
}
