/* test_cl_faults.c: every OpenCL call that libhtree_cl makes may fail, with any code, once or
 * for good; so may every allocation. It says what is wrong, leaks nothing, and works on unless
 * the device is lost. On the mock. */
#include "bench.h"

static uint64_t calls_failed, calls_survived, allocations_failed, losses;

/* What an operation allocates and can do without: the compiler's log; and, in a build with
 * assertions, the check that a tree makes of itself. */
#ifdef NDEBUG
enum { most_survivors = 1 };
#else
enum { most_survivors = 100 };
#endif

static const char *const group_names[] = {"devices", "uploads", "queries", "the caller's buffers"};

/* ---- What should come of it ----------------------------------------------------------------- */

/* What htree_cl.h says of OpenCL's codes; all others are DEVICE. */
static htree_status meaning_of(cl_int code) {
    switch (code) {
    case CL_DEVICE_NOT_FOUND:
    case -1001: return HTREE_ERROR_NO_DEVICE;
    case CL_DEVICE_NOT_AVAILABLE: return HTREE_ERROR_DEVICE_LOST;
    case CL_COMPILER_NOT_AVAILABLE:
    case CL_BUILD_PROGRAM_FAILURE:
    case CL_INVALID_BUILD_OPTIONS:
    case CL_INVALID_BINARY:
    case CL_INVALID_PROGRAM_EXECUTABLE:
    case CL_INVALID_KERNEL_NAME: return HTREE_ERROR_KERNEL;
    case CL_MEM_OBJECT_ALLOCATION_FAILURE:
    case CL_OUT_OF_RESOURCES:
    case CL_OUT_OF_HOST_MEMORY:
    case CL_INVALID_BUFFER_SIZE: return HTREE_ERROR_MEMORY;
    default: return HTREE_ERROR_DEVICE;
    }
}

static const cl_int codes[] = {
    CL_DEVICE_NOT_FOUND,
    CL_COMPILER_NOT_AVAILABLE,
    CL_MEM_OBJECT_ALLOCATION_FAILURE,
    CL_OUT_OF_RESOURCES,
    CL_OUT_OF_HOST_MEMORY,
    CL_BUILD_PROGRAM_FAILURE,
    CL_MAP_FAILURE,
    CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST,
    CL_INVALID_VALUE,
    CL_INVALID_DEVICE,
    CL_INVALID_CONTEXT,
    CL_INVALID_COMMAND_QUEUE,
    CL_INVALID_MEM_OBJECT,
    CL_INVALID_BINARY,
    CL_INVALID_BUILD_OPTIONS,
    CL_INVALID_PROGRAM_EXECUTABLE,
    CL_INVALID_KERNEL_NAME,
    CL_INVALID_KERNEL_ARGS,
    CL_INVALID_WORK_GROUP_SIZE,
    CL_INVALID_BUFFER_SIZE,
    -1001 /* CL_PLATFORM_NOT_FOUND_KHR */,
    -9999 /* what a well-known driver says of a kernel that left its buffers */,
    CL_DEVICE_NOT_AVAILABLE,
};

enum { TRACED = 1000 };
typedef struct call {
    const char *name;
    uint64_t detail;
} call;
static call trace[TRACED + 1]; /* of a run in which nothing fails, from 1 */
static uint64_t call_count;

static bool is(uint64_t k, const char *name) {
    return strcmp(trace[k].name, name) == 0;
}

/* What a query can do without: times, logs, and an end; and what is asked of a device's arithmetic,
 * where no answer is no promise. */
static bool is_harmless(uint64_t k) {
    const bool of_floats =
        is(k, "clGetDeviceInfo") && (trace[k].detail == CL_DEVICE_SINGLE_FP_CONFIG ||
                                     (trace[k].detail == CL_DEVICE_DOUBLE_FP_CONFIG &&
                                      trace[k - 1].detail == CL_DEVICE_SINGLE_FP_CONFIG));
    return of_floats || strncmp(trace[k].name, "clRelease", 9) == 0 ||
           is(k, "clGetEventProfilingInfo") || is(k, "clGetProgramBuildInfo");
}

/* Batches of many rays are tried again with fewer when memory is short; the known answers that
 * prove a kernel are one. */
static bool is_in_batch(uint64_t k) {
    static const char *const names[] = {"clEnqueueWriteBuffer",   "clSetKernelArg",
                                        "clEnqueueNDRangeKernel", "clEnqueueReadBuffer",
                                        "clEnqueueMapBuffer",     "clEnqueueUnmapMemObject",
                                        "clWaitForEvents"};
    if (bench_op->group == BENCH_BUFFERS || bench_op->rays == BENCH_FEW) return false;
    bool in = is(k, "clCreateBuffer") && !(trace[k].detail & CL_MEM_COPY_HOST_PTR);
    for (size_t i = 0; i < COUNT_OF(names); ++i) in = in || is(k, names[i]);
    return in;
}

/* The status, and the call that it is due to, 0 if none. */
static htree_status expected(uint64_t k, cl_int code, bool for_good, uint64_t *cause) {
    *cause = 0;
    while (k <= call_count && is_harmless(k)) {
        if (!for_good) return HTREE_OK;
        ++k;
    }
    if (k > call_count) return HTREE_OK;
    const htree_status status = meaning_of(code);
    if (status == HTREE_ERROR_MEMORY && !for_good && is_in_batch(k)) return HTREE_OK;
    *cause = k;
    if (is(k, "clGetMemObjectInfo") && code == CL_INVALID_MEM_OBJECT) return HTREE_ERROR_ARGUMENT;
    return status;
}

/* ---- Failing calls -------------------------------------------------------------------------- */

static void record_trace(bench *b) {
    bench_op->prepare(b);
    mock_fail(0, CL_SUCCESS, false);
    assert_cl_ok(bench_op->act(b));
    call_count = mock_calls();
    assert_true(call_count > 0 && call_count <= TRACED);
    for (uint64_t k = 1; k <= call_count; ++k) trace[k].name = mock_call(k, &trace[k].detail);
    assert_true(bench_op->done(b));
    bench_close(b);
}

static void say_where(uint64_t k, cl_int code, bool for_good) {
    print_error("%s: call %llu (%s, %llu) fails with %ld%s: ", bench_op->name,
                (unsigned long long)k, trace[k].name, (unsigned long long)trace[k].detail,
                (long)code, for_good ? " for good" : "");
}

/* The text names the call, or says in words what a wrong argument or a lack of devices is. */
static bool text_is_right(uint64_t cause, cl_int code, bool for_good) {
    const char *const text = htree_cl_error_text();
    if (is(cause, "clGetMemObjectInfo") && code == CL_INVALID_MEM_OBJECT)
        return strstr(text, "is no buffer") != NULL;
    if (is(cause, "clGetDeviceIDs") && code == CL_DEVICE_NOT_FOUND)
        return strstr(text, "no device") != NULL;
    /* A second try with fewer rays fails earlier. */
    if (for_good && is_in_batch(cause) && strstr(text, "clCreateBuffer")) return true;
    return strstr(text, trace[cause].name) != NULL;
}

static void fail_one(bench *b, uint64_t k, cl_int code, bool for_good) {
    uint64_t cause;
    bench_op->prepare(b);
    const uint64_t programs = mock_live(MOCK_PROGRAM);
    const htree_status should = expected(k, code, for_good, &cause);
    mock_fail(k, code, for_good);
    const htree_status status = bench_op->act(b);
    const uint64_t pending = mock_pending();
    mock_fail(0, CL_SUCCESS, false);
    ++calls_failed;
    if (status != should) {
        say_where(k, code, for_good);
        fail_msg("%s: %s", htree_status_name(status), htree_cl_error_text());
    }
    if (status == HTREE_OK) {
        ++calls_survived;
        assert_true(bench_op->done(b));
        return;
    }
    assert_int_equal(htree_cl_error_code(), code);
    if (!text_is_right(cause, code, for_good)) {
        say_where(k, code, for_good);
        fail_msg("the text is: %s", htree_cl_error_text());
    }
    assert_true(bench_op->undone(b));
    /* A blocking query that failed leaves nothing that would write to its arrays later. */
    if (bench_op->group == BENCH_QUERIES && !for_good) assert_int_equal(pending, 0);
    if (status == HTREE_ERROR_DEVICE_LOST && b->device) {
        ++losses;
        assert_true(bench_says_lost(b));
        bench_close(b);
    } else if (mock_live(MOCK_PROGRAM) != programs) {
        bench_close(
            b); /* the device has learnt a program: the next upload would make fewer calls */
    }
}

/* Every code at call k, once and for good; then it works, and at the end nothing is left. A
 * short run takes the codes in turn. */
static void fail_call(bench *b, uint64_t k) {
    const uint64_t share = COUNT_OF(codes) / scaled(COUNT_OF(codes));
    for (uint32_t i = 0; i < COUNT_OF(codes); ++i) {
        if ((i + k) % share != 0) continue;
        fail_one(b, k, codes[i], false);
        fail_one(b, k, codes[i], true);
    }
    bench_op->prepare(b);
    assert_cl_ok(bench_op->act(b));
    assert_true(bench_op->done(b));
    bench_close(b);
}

static void fail_every_call(bench_group group) {
    bench b;
    memset(&b, 0, sizeof b);
    b.world = mock_usual_world();
    b.world.build_log = "a remark of the compiler's";
    const uint64_t failed = calls_failed, survived = calls_survived, lost = losses;
    for (uint32_t i = 0; i < BENCH_OPERATIONS; ++i) {
        if (bench_operations[i].group != group) continue;
        bench_op = &bench_operations[i];
        record_trace(&b);
        for (uint64_t k = 1; k <= call_count; ++k) fail_call(&b, k);
    }
    say("%s: %llu calls failed, %llu of them survived, %llu devices lost", group_names[group],
        (unsigned long long)(calls_failed - failed),
        (unsigned long long)(calls_survived - survived), (unsigned long long)(losses - lost));
}

static void any_call_may_fail_about_devices(void **state) {
    (void)state;
    fail_every_call(BENCH_DEVICES);
}

static void any_call_may_fail_in_an_upload(void **state) {
    (void)state;
    fail_every_call(BENCH_UPLOADS);
}

static void any_call_may_fail_in_a_query(void **state) {
    (void)state;
    fail_every_call(BENCH_QUERIES);
}

static void any_call_may_fail_in_the_callers_buffers(void **state) {
    (void)state;
    fail_every_call(BENCH_BUFFERS);
}

/* ---- Failing allocations -------------------------------------------------------------------- */

/* The compiler's log is the only thing that an operation can do without. */
static void fail_allocation(bench *b, uint64_t n, bool for_good, bool *survived) {
    bench_op->prepare(b);
    ledger_fail(&bench_rig.books, n, for_good);
    const htree_status status = bench_op->act(b);
    ledger_fail(&bench_rig.books, 0, false);
    ++allocations_failed;
    *survived = status == HTREE_OK;
    if (*survived) {
        assert_true(bench_op->done(b));
    } else {
        assert_int_equal(status, HTREE_ERROR_MEMORY);
        assert_int_equal(htree_cl_error_code(), 0);
        assert_true(strlen(htree_cl_error_text()) > 5);
        assert_true(bench_op->undone(b));
        bench_op->prepare(b);
        assert_cl_ok(bench_op->act(b));
        assert_true(bench_op->done(b));
    }
    bench_close(b);
}

static void any_allocation_may_fail(void **state) {
    bench b;
    (void)state;
    memset(&b, 0, sizeof b);
    b.world = mock_usual_world();
    b.world.build_log = "a remark of the compiler's";
    for (uint32_t i = 0; i < BENCH_OPERATIONS; ++i) {
        uint64_t survivors = 0;
        bench_op = &bench_operations[i];
        bench_op->prepare(&b);
        ledger_fail(&bench_rig.books, 0, false);
        assert_cl_ok(bench_op->act(&b));
        const uint64_t calls = bench_rig.books.calls;
        assert_true(bench_op->done(&b));
        bench_close(&b);
        for (uint64_t n = 1; n <= calls; ++n) {
            bool survived;
            fail_allocation(&b, n, true, &survived);
            assert_false(survived && n < calls);
            fail_allocation(&b, n, false, &survived);
            survivors += survived;
        }
        if (bench_op->group == BENCH_QUERIES || bench_op->group == BENCH_BUFFERS)
            assert_int_equal(calls, 0);
        /* A log is kept of each program that is compiled: at most one an operation but for the
         * self-check of builds with assertions. */
        assert_true(survivors <= most_survivors);
    }
}

static int begin(void **state) {
    (void)state;
    rig_begin(&bench_rig, "knot", 500, BENCH_MANY);
    return 0;
}

static int end(void **state) {
    (void)state;
    rig_end(&bench_rig);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_call_may_fail_about_devices),
        cmocka_unit_test(any_call_may_fail_in_an_upload),
        cmocka_unit_test(any_call_may_fail_in_a_query),
        cmocka_unit_test(any_call_may_fail_in_the_callers_buffers),
        cmocka_unit_test(any_allocation_may_fail),
    };
    const int failed = cmocka_run_group_tests_name("cl_faults", tests, begin, end);
    say("%llu allocation failures injected", (unsigned long long)allocations_failed);
    tally("allocation failures", allocations_failed);
    return failed;
}
