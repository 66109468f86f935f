/* test_cl_api.c: the OpenCL backend beside the caller's own OpenCL: contexts, queues, buffers and
 * events; the order in which things end; what it says of devices. */
#include "cl_suite.h"
#include "rays.h"

#include "opencl/cl.h"

enum { RAYS = 3000 };

typedef struct scene {
    ht_cl_api cl;
    htree_cl *device;
    cl_context context;
    cl_device_id id;
    cl_command_queue queue;
    shape mesh;
    htree *tree;
    htree_cl_tree *uploaded;
    htree_ray rays[RAYS];
    htree_hit truth[RAYS];
} scene;

static int begin(void **state) {
    scene *const s = (scene *)take(sizeof *s);
    memset(s, 0, sizeof *s);
    s->mesh = shape_of("knot", 3000, 4);
    const htree_mesh mesh = mesh_of(&s->mesh);
    const ray_target target = ray_target_of(&mesh);
    dice d = {7};
    rays_make_mixed(&target, &d, s->rays, RAYS);
    s->tree = tree_of_kind(&mesh, HTREE_WIDE);
    assert_int_equal(htree_intersect(s->tree, s->rays, RAYS, s->truth, NULL), HTREE_OK);
    assert_cl_ok(ht_cl_load(&s->cl));
    s->device = open_device(NULL);
    s->uploaded = upload(s->device, s->tree);
    assert_cl_ok(htree_cl_get_objects(s->device, &s->context, &s->id, &s->queue));
    *state = s;
    return 0;
}

static int end(void **state) {
    scene *const s = (scene *)*state;
    htree_cl_free(s->uploaded);
    htree_cl_close(s->device);
    htree_free(s->tree);
    shape_free(&s->mesh);
    free(s);
    return 0;
}

static cl_mem buffer_of(const scene *s, cl_context context, cl_mem_flags flags, size_t bytes,
                        void *from) {
    cl_int code = CL_SUCCESS;
    const cl_mem buffer = s->cl.CreateBuffer(context, flags, bytes, from, &code);
    assert_int_equal(code, CL_SUCCESS);
    return buffer;
}

static uint64_t answers_differ(const scene *s, const htree_hit *hits, const uint8_t *any) {
    uint64_t differences = hits_differ(hits, s->truth, RAYS);
    for (uint32_t i = 0; i < RAYS; ++i) differences += any[i] != (s->truth[i].prim != HTREE_NONE);
    return differences;
}

/* Write, intersect, occluded, read: four commands that only events keep in order. */
static void trace_on_queue(scene *s, const htree_cl_tree *tree, cl_context context,
                           cl_command_queue queue) {
    static htree_hit hits[RAYS];
    static uint8_t any[RAYS];
    cl_event written, closest, both;
    memset(hits, 0x5a, sizeof hits);
    memset(any, 0x5a, sizeof any);
    const cl_mem rays = buffer_of(s, context, CL_MEM_READ_ONLY, sizeof s->rays, NULL);
    const cl_mem out = buffer_of(s, context, CL_MEM_WRITE_ONLY, sizeof hits, NULL);
    const cl_mem out_any = buffer_of(s, context, CL_MEM_WRITE_ONLY, sizeof any, NULL);
    assert_int_equal(s->cl.EnqueueWriteBuffer(queue, rays, CL_FALSE, 0, sizeof s->rays, s->rays, 0,
                                              NULL, &written),
                     CL_SUCCESS);
    assert_cl_ok(htree_cl_enqueue_intersect(tree, queue, rays, RAYS, out, 1, &written, &closest));
    assert_cl_ok(htree_cl_enqueue_occluded(tree, queue, rays, RAYS, out_any, 1, &closest, &both));
    assert_int_equal(
        s->cl.EnqueueReadBuffer(queue, out, CL_TRUE, 0, sizeof hits, hits, 1, &closest, NULL),
        CL_SUCCESS);
    assert_int_equal(
        s->cl.EnqueueReadBuffer(queue, out_any, CL_TRUE, 0, sizeof any, any, 1, &both, NULL),
        CL_SUCCESS);
    assert_int_equal(answers_differ(s, hits, any), 0);
    const cl_event events[] = {written, closest, both};
    const cl_mem buffers[] = {rays, out, out_any};
    for (int i = 0; i < 3; ++i) {
        s->cl.ReleaseEvent(events[i]);
        s->cl.ReleaseMemObject(buffers[i]);
    }
}

/* ---- The claims ----------------------------------------------------------------------------- */

static void buffers_and_events_of_the_caller_work(void **state) {
    scene *const s = (scene *)*state;
    trace_on_queue(s, s->uploaded, s->context, s->queue);
}

static void queues_of_the_caller_work_out_of_order_too(void **state) {
    static const cl_command_queue_properties properties[] = {
        0, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, CL_QUEUE_PROFILING_ENABLE};
    scene *const s = (scene *)*state;
    for (uint32_t i = 0; i < COUNT_OF(properties); ++i) {
        cl_int code = CL_SUCCESS;
        const cl_command_queue queue =
            s->cl.CreateCommandQueue(s->context, s->id, properties[i], &code);
        if (code != CL_SUCCESS) continue; /* out of order is optional */
        for (int k = 0; k < 5; ++k) trace_on_queue(s, s->uploaded, s->context, queue);
        s->cl.ReleaseCommandQueue(queue);
    }
}

/* Launches of a few rays are chained by events. */
static void many_launches_are_one_event(void **state) {
    scene *const s = (scene *)*state;
    htree_cl_options options = cl_options();
    htree_cl *device = NULL;
    cl_int code = CL_SUCCESS;
    const cl_command_queue queue =
        s->cl.CreateCommandQueue(s->context, s->id, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &code);
    options.launch_rays = 100;
    assert_cl_ok(htree_cl_open_context(&device, s->context, s->id, NULL, &options));
    htree_cl_tree *const uploaded = upload(device, s->tree);
    trace_on_queue(s, uploaded, s->context, code == CL_SUCCESS ? queue : s->queue);
    if (code == CL_SUCCESS) s->cl.ReleaseCommandQueue(queue);
    htree_cl_free(uploaded);
    htree_cl_close(device);
}

static void a_context_of_the_caller_is_retained(void **state) {
    static htree_hit hits[RAYS];
    scene *const s = (scene *)*state;
    cl_int code = CL_SUCCESS;
    const cl_context context = s->cl.CreateContext(NULL, 1, &s->id, NULL, NULL, &code);
    const cl_command_queue queue = s->cl.CreateCommandQueue(context, s->id, 0, &code);
    htree_cl *device = NULL;
    double seconds = -1;
    assert_cl_ok(htree_cl_open_context(&device, context, s->id, queue, NULL));
    s->cl.ReleaseCommandQueue(queue);
    s->cl.ReleaseContext(context);
    htree_cl_tree *const uploaded = upload(device, s->tree);
    trace_on_queue(s, uploaded, context, queue);
    htree_cl_query query;
    assert_cl_ok(htree_cl_query_init(&query, sizeof query));
    query.kernel_seconds = &seconds;
    assert_cl_ok(htree_cl_intersect(uploaded, s->rays, RAYS, hits, &query));
    assert_true(seconds >= 0); /* this queue keeps no times */
    assert_int_equal(hits_differ(hits, s->truth, RAYS), 0);
    htree_cl_free(uploaded);
    htree_cl_close(device);
}

/* The tree on the host, the device's handle, and the tree on the device: any order will do. */
static void things_end_in_any_order(void **state) {
    static const uint8_t orders[][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                        {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    static htree_hit hits[RAYS];
    scene *const s = (scene *)*state;
    const htree_mesh mesh = mesh_of(&s->mesh);
    for (uint32_t i = 0; i < COUNT_OF(orders); ++i) {
        htree *tree = tree_of_kind(&mesh, HTREE_H);
        htree_cl *device = open_device(NULL);
        htree_cl_tree *uploaded = upload(device, tree);
        for (int k = 0; k < 3; ++k) {
            if (orders[i][k] == 0) htree_free(tree);
            if (orders[i][k] == 1) htree_cl_close(device);
            if (orders[i][k] == 2) {
                assert_cl_ok(htree_cl_intersect(uploaded, s->rays, RAYS, hits, NULL));
                assert_int_equal(hits_differ(hits, s->truth, RAYS), 0);
                htree_cl_free(uploaded);
            }
        }
    }
    htree_cl_close(NULL);
    htree_cl_free(NULL);
}

static int32_t count_reports(void *user, double fraction) {
    double *const last = (double *)user;
    assert_true(fraction >= last[0] && fraction <= 1);
    last[0] = fraction;
    last[1] += 1;
    return last[2] > 0 && last[1] >= last[2];
}

static void progress_reports_and_cancels(void **state) {
    enum { MANY = 1 << 19 };
    scene *const s = (scene *)*state;
    htree_ray *const rays = (htree_ray *)take(MANY * sizeof *rays);
    htree_hit *const hits = (htree_hit *)take(MANY * sizeof *hits);
    double seen[3] = {0, 0, 0};
    double seconds = 0;
    htree_cl_query query;
    for (uint32_t i = 0; i < MANY; ++i) rays[i] = s->rays[i % RAYS];
    assert_cl_ok(htree_cl_query_init(&query, sizeof query));
    query.progress.report = count_reports;
    query.progress.user = seen;
    query.kernel_seconds = &seconds;
    assert_cl_ok(htree_cl_intersect(s->uploaded, rays, MANY, hits, &query));
    assert_true(seen[0] == 1 && seen[1] >= 3 && seconds > 0);
    for (uint32_t i = 0; i < MANY; ++i)
        assert_memory_equal(&hits[i], &s->truth[i % RAYS], sizeof hits[i]);
    seen[0] = seen[1] = 0;
    seen[2] = 2;
    assert_int_equal(htree_cl_intersect(s->uploaded, rays, MANY, hits, &query),
                     HTREE_ERROR_CANCELLED);
    assert_true(seen[1] >= 2 && seen[0] < 1);
    free(rays);
    free(hits);
}

static void user_objects_are_refused(void **state) {
    static const htree_box box = {{0, 0, 0}, {1, 1, 1}};
    scene *const s = (scene *)*state;
    const htree_objects objects = {&box, 1, (htree_object_intersect)(void (*)(void))count_reports,
                                   NULL};
    htree_mesh mesh;
    htree_cl_tree *uploaded = (htree_cl_tree *)s;
    memset(&mesh, 0, sizeof mesh);
    mesh.objects = &objects;
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    assert_int_equal(htree_cl_upload(&uploaded, s->device, tree), HTREE_ERROR_UNSUPPORTED);
    assert_null(uploaded);
    htree_free(tree);
}

static void devices_are_listed_and_found_by_name(void **state) {
    uint32_t count = 0;
    (void)state;
    assert_cl_ok(htree_cl_get_device_count(&count));
    assert_true(count > 0);
    for (uint32_t i = 0; i < count; ++i) {
        htree_cl_info info, opened;
        char index[16];
        info.size = opened.size = sizeof info;
        assert_cl_ok(htree_cl_get_device_info(i, &info));
        assert_true(info.index == i && info.memory_bytes > 0 && info.buffer_bytes > 0);
        assert_true(strlen(info.platform) > 0 && strlen(info.device) > 0);
        assert_true(info.exact == 0 && info.group_size == 0);
        snprintf(index, sizeof index, "%u", i);
        const char *const names[] = {index, info.device, info.platform};
        for (uint32_t k = 0; k < COUNT_OF(names); ++k) {
            htree_cl *device = NULL;
            assert_cl_ok(htree_cl_open(&device, names[k], NULL));
            assert_cl_ok(htree_cl_get_info(device, &opened));
            assert_true(opened.group_size > 0 && opened.compile_seconds > 0);
            assert_non_null(htree_cl_build_log(device));
            htree_cl_close(device);
        }
    }
}

static void unknown_names_are_refused(void **state) {
    static const char *const names[] = {"no such device", "99", "12345678901234567890", "-1"};
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(names); ++i) {
        htree_cl *device = (htree_cl *)state;
        assert_int_equal(htree_cl_open(&device, names[i], NULL), HTREE_ERROR_NO_DEVICE);
        assert_null(device);
        assert_true(strlen(htree_cl_error_text()) > 10);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(buffers_and_events_of_the_caller_work),
        cmocka_unit_test(queues_of_the_caller_work_out_of_order_too),
        cmocka_unit_test(many_launches_are_one_event),
        cmocka_unit_test(a_context_of_the_caller_is_retained),
        cmocka_unit_test(things_end_in_any_order),
        cmocka_unit_test(progress_reports_and_cancels),
        cmocka_unit_test(user_objects_are_refused),
        cmocka_unit_test(devices_are_listed_and_found_by_name),
        cmocka_unit_test(unknown_names_are_refused),
    };
    return run_on_device("cl_api", tests, COUNT_OF(tests), begin, end);
}
