/* test_cl_threads.c: many threads on one device, and ends in any order while the device still
 * works. On the mock, which thread sanitizer sees whole. */
#include "rig.h"

#include <pthread.h>

enum { RAYS = 1200, THREADS = 8 };

static rig r;
static uint64_t batches_proved;

/* ---- Ends ----------------------------------------------------------------------------------- */

typedef struct work {
    cl_command_queue queue;
    cl_mem rays, hits;
    cl_event event;
} work;

/* Enqueues all rays on a queue of its own. */
static void begin_work(work *w, htree_cl *device, const htree_cl_tree *tree) {
    const size_t ray_bytes = (size_t)r.count * sizeof *r.rays;
    cl_context context;
    cl_device_id id;
    assert_cl_ok(htree_cl_get_objects(device, &context, &id, NULL));
    w->queue = clCreateCommandQueue(context, id, 0, NULL);
    w->rays =
        clCreateBuffer(context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, ray_bytes, r.rays, NULL);
    w->hits =
        clCreateBuffer(context, CL_MEM_WRITE_ONLY, (size_t)r.count * sizeof *r.hits, NULL, NULL);
    assert_cl_ok(
        htree_cl_enqueue_intersect(tree, w->queue, w->rays, r.count, w->hits, 0, NULL, &w->event));
}

/* Whether its hits are right. */
static bool end_work(work *w) {
    const size_t bytes = (size_t)r.count * sizeof *r.hits;
    htree_hit *const hits = (htree_hit *)malloc(bytes);
    bool right = hits != NULL && clWaitForEvents(1, &w->event) == CL_SUCCESS &&
                 clEnqueueReadBuffer(w->queue, w->hits, CL_TRUE, 0, bytes, hits, 1, &w->event,
                                     NULL) == CL_SUCCESS;
    right = right && hits_differ(hits, r.truth, r.count) == 0;
    free(hits);
    clReleaseEvent(w->event);
    clReleaseMemObject(w->rays);
    clReleaseMemObject(w->hits);
    clReleaseCommandQueue(w->queue);
    return right;
}

/* 0 the tree of the host, 1 the device, 2 the tree on the device; what was enqueued is not done. */
static void things_end_in_any_order_while_work_waits(void **state) {
    static const uint8_t orders[][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                        {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const htree_cl_options options = rig_options(&r);
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(orders) * r.kinds; ++i) {
        htree *const tree = tree_of_kind(&r.mesh, (htree_kind)(1 + i % r.kinds));
        htree_cl *const device = open_device(&options);
        htree_cl_tree *const uploaded = upload(device, tree);
        htree_cl_tree *const second = upload(device, tree);
        work w;
        begin_work(&w, device, uploaded);
        assert_true(mock_pending() > 0);
        for (int k = 0; k < 3; ++k) {
            const uint8_t what = orders[i / r.kinds][k];
            if (what == 0) htree_free(tree);
            if (what == 1) htree_cl_close(device);
            if (what == 2) htree_cl_free(uploaded);
        }
        rig_prove(&r, second);
        htree_cl_free(second);
        assert_true(end_work(&w));
        rig_nothing_is_left(&r);
        ++batches_proved;
    }
}

/* ---- Threads -------------------------------------------------------------------------------- */

typedef struct worker {
    pthread_t thread;
    htree_cl *device;
    const htree_cl_tree *shared;
    uint32_t index;
    uint64_t batches, failures;
} worker;

/* Own answers, own queue, own tree, and a tree and a queue that all share. */
static void work_once(worker *w, uint32_t turn) {
    const htree *const tree = r.trees[(w->index + turn) % r.kinds];
    htree_hit *const hits = (htree_hit *)malloc((size_t)r.count * sizeof *hits);
    uint8_t *const any = (uint8_t *)malloc((size_t)r.count);
    htree_cl_tree *own = NULL;
    htree_cl_info info;
    info.size = sizeof info;
    w->failures += !hits || !any;
    w->failures += htree_cl_upload(&own, w->device, tree) != HTREE_OK;
    w->failures += htree_cl_get_info(w->device, &info) != HTREE_OK;
    w->failures += strcmp(htree_cl_build_log(w->device), "remark") != 0;
    const htree_cl_tree *const trees[] = {own, w->shared};
    for (int i = 0; hits && any && own && i < 2; ++i) {
        w->failures += htree_cl_intersect(trees[i], r.rays, r.count, hits, NULL) != HTREE_OK;
        w->failures += hits_differ(hits, r.truth, r.count) != 0;
        w->failures += htree_cl_occluded(trees[i], r.rays, r.count, any, NULL) != HTREE_OK;
        w->failures += memcmp(any, r.any_truth, (size_t)r.count) != 0;
        w->batches += 2;
    }
    free(hits);
    free(any);
    htree_cl_free(own);
    work mine;
    begin_work(&mine, w->device, w->shared);
    w->failures += !end_work(&mine);
    ++w->batches;
}

static void *worker_main(void *data) {
    worker *const w = (worker *)data;
    for (uint32_t turn = 0; turn < 2 + scaled(6); ++turn) work_once(w, turn);
    return NULL;
}

static void run_workers(htree_cl *device, const htree_cl_tree *shared) {
    worker workers[THREADS];
    for (uint32_t i = 0; i < THREADS; ++i) {
        worker *const w = &workers[i];
        memset(w, 0, sizeof *w);
        w->index = i;
        w->device = device;
        w->shared = shared;
        assert_int_equal(pthread_create(&w->thread, NULL, worker_main, w), 0);
    }
    for (uint32_t i = 0; i < THREADS; ++i) {
        assert_int_equal(pthread_join(workers[i].thread, NULL), 0);
        assert_int_equal(workers[i].failures, 0);
        batches_proved += workers[i].batches;
    }
}

/* Every thread needs a kernel that no one has compiled yet. */
static void threads_share_a_device(void **state) {
    mock_world world = mock_usual_world();
    const htree_cl_options options = rig_options(&r);
    (void)state;
    world.build_log = "remark";
    for (uint32_t round = 0; round < 4; ++round) {
        world.unified = round % 2 == 0;
        world.type = round < 2 ? CL_DEVICE_TYPE_CPU : CL_DEVICE_TYPE_GPU;
        mock_set_world(&world);
        htree_cl *const device = open_device(&options);
        htree_cl_tree *const shared = upload(device, r.trees[round]);
        run_workers(device, shared);
        htree_cl_free(shared);
        htree_cl_close(device);
        rig_nothing_is_left(&r);
    }
}

static void *opener_main(void *data) {
    worker *const w = (worker *)data;
    for (uint32_t turn = 0; turn < 1 + scaled(8); ++turn) {
        const htree_cl_options options = rig_options(&r);
        htree_cl *device = NULL;
        htree_cl_tree *tree = NULL;
        uint32_t count = 0;
        w->failures += htree_cl_get_device_count(&count) != HTREE_OK || count != 1;
        w->failures += htree_cl_open(&device, NULL, &options) != HTREE_OK;
        w->failures += htree_cl_upload(&tree, device, r.trees[w->index % r.kinds]) != HTREE_OK;
        htree_cl_close(device);
        htree_cl_free(tree);
        w->failures += htree_cl_open(&device, "99", NULL) != HTREE_ERROR_NO_DEVICE;
        w->failures += strstr(htree_cl_error_text(), "\"99\"") == NULL;
    }
    return NULL;
}

static void threads_open_devices_of_their_own(void **state) {
    worker workers[THREADS];
    (void)state;
    for (uint32_t i = 0; i < THREADS; ++i) {
        memset(&workers[i], 0, sizeof workers[i]);
        workers[i].index = i;
        assert_int_equal(pthread_create(&workers[i].thread, NULL, opener_main, &workers[i]), 0);
    }
    for (uint32_t i = 0; i < THREADS; ++i) {
        assert_int_equal(pthread_join(workers[i].thread, NULL), 0);
        assert_int_equal(workers[i].failures, 0);
    }
    rig_nothing_is_left(&r);
}

static void *launcher_main(void *data) {
    worker *const w = (worker *)data;
    work mine;
    begin_work(&mine, w->device, w->shared);
    w->failures += !end_work(&mine);
    return NULL;
}

/* More launches at once than kernels are kept. */
static void many_launches_at_once_leave_nothing(void **state) {
    enum { MANY = 20 };
    worker workers[MANY];
    const htree_cl_options options = rig_options(&r);
    (void)state;
    htree_cl *const device = open_device(&options);
    htree_cl_tree *const shared = upload(device, r.trees[0]);
    const uint64_t kernels = mock_live(MOCK_KERNEL);
    mock_meet(MANY);
    for (uint32_t i = 0; i < MANY; ++i) {
        memset(&workers[i], 0, sizeof workers[i]);
        workers[i].device = device;
        workers[i].shared = shared;
        assert_int_equal(pthread_create(&workers[i].thread, NULL, launcher_main, &workers[i]), 0);
    }
    for (uint32_t i = 0; i < MANY; ++i) {
        assert_int_equal(pthread_join(workers[i].thread, NULL), 0);
        assert_int_equal(workers[i].failures, 0);
    }
    assert_true(mock_live(MOCK_KERNEL) > kernels && mock_live(MOCK_KERNEL) < kernels + MANY);
    htree_cl_free(shared);
    htree_cl_close(device);
    rig_nothing_is_left(&r);
    batches_proved += MANY;
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
        cmocka_unit_test_setup(things_end_in_any_order_while_work_waits, fresh),
        cmocka_unit_test_setup(threads_share_a_device, fresh),
        cmocka_unit_test_setup(many_launches_at_once_leave_nothing, fresh),
        cmocka_unit_test_setup(threads_open_devices_of_their_own, fresh),
    };
    const int failed = cmocka_run_group_tests_name("cl_threads", tests, begin, end);
    say("%llu batches on %d threads", (unsigned long long)batches_proved, THREADS);
    return failed;
}
