/* test_cl_processes.c: processes in every environment that OpenCL may have on a machine: no
 * loader, a broken one, no driver, and PoCL with its knobs turned. Each is a child of its own,
 * which ends with the CPU's answers or with an htree error; only where PoCL finds its own cache
 * broken may it die. */
#define _XOPEN_SOURCE 700 /* nftw */
#include "cl_suite.h"
#include "rays.h"

#include <ftw.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { RAYS = 3000, SECONDS = 240, VARIABLES = 3 };

/* ---- The child ------------------------------------------------------------------------------ */

/* How a child ends, beside the signals that it may die of; a failed call adds its status. */
enum { EXACT = 0, DIFFERENT = 100, FAILED = 120 };

static int child_failed(const char *what, htree_status status) {
    printf("%s: %s: %s (%d)\n", what, htree_status_name(status), htree_cl_error_text(),
           (int)htree_cl_error_code());
    return FAILED + (int)status;
}

static int compare_on(htree_cl *device, const htree *tree, const htree_ray *rays) {
    static htree_hit hits[RAYS], truth[RAYS];
    static uint8_t any[RAYS];
    htree_cl_tree *uploaded = NULL;
    assert_int_equal(htree_intersect(tree, rays, RAYS, truth, NULL), HTREE_OK);
    htree_status status = htree_cl_upload(&uploaded, device, tree);
    if (status == HTREE_OK) status = htree_cl_intersect(uploaded, rays, RAYS, hits, NULL);
    if (status == HTREE_OK) status = htree_cl_occluded(uploaded, rays, RAYS, any, NULL);
    htree_cl_free(uploaded);
    if (status != HTREE_OK) return child_failed("tree", status);
    uint64_t differences = hits_differ(hits, truth, RAYS);
    for (uint32_t i = 0; i < RAYS; ++i) differences += any[i] != (truth[i].prim != HTREE_NONE);
    if (differences) printf("%lu differences\n", (unsigned long)differences);
    return differences ? DIFFERENT : EXACT;
}

/* Opens the first device and compares `kinds` ("all", or the name of one) with the CPU. */
static int child(const char *kinds) {
    static htree_ray rays[RAYS];
    shape s = shape_of("knot", 2000, 1);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    dice d = {5};
    htree_cl *device = NULL;
    int result = EXACT;
    rays_make_mixed(&target, &d, rays, RAYS);
    const htree_status status = htree_cl_open(&device, NULL, NULL);
    if (status != HTREE_OK) result = child_failed("open", status);
    for (htree_kind kind = next_kind(0); kind != 0 && result == EXACT; kind = next_kind(kind)) {
        if (strcmp(kinds, "all") != 0 && strcmp(kinds, htree_kind_name(kind)) != 0) continue;
        htree *const tree = tree_of_kind(&mesh, kind);
        result = compare_on(device, tree, rays);
        htree_free(tree);
    }
    htree_cl_close(device);
    shape_free(&s);
    return result;
}

/* ---- The parent ----------------------------------------------------------------------------- */

static char folder[] = "/tmp/htree-test-cl-XXXXXX"; /* of all that the children use */
static uint64_t children, exact, refused, died;
static bool has_device;

typedef struct environment {
    const char *name;
    struct {
        const char *name, *value; /* @ in a value is the folder */
    } set[VARIABLES];
    const char *kinds; /* NULL: bvh-sah */
} environment;

typedef struct outcome {
    int status;      /* as waitpid gives it */
    char text[2048]; /* the first that it printed */
} outcome;

/* `text` with the folder for every @. */
static const char *expand(char *out, size_t size, const char *text) {
    size_t length = 0;
    for (; *text && length + sizeof folder < size; ++text) {
        if (*text == '@') {
            memcpy(out + length, folder, sizeof folder - 1);
            length += sizeof folder - 1;
        } else {
            out[length++] = *text;
        }
    }
    out[length] = 0;
    return out;
}

static void become(const environment *e) {
    char value[512];
    char *arguments[] = {(char *)(uintptr_t) "child", NULL, NULL};
    arguments[1] = (char *)(uintptr_t)(e->kinds ? e->kinds : "bvh-sah");
    setenv("POCL_CACHE_DIR", expand(value, sizeof value, "@/cache"), 1);
    /* What drivers keep until the end is no leak of ours. */
    setenv("ASAN_OPTIONS", "detect_leaks=0:allocator_may_return_null=1", 1);
    for (int i = 0; i < VARIABLES && e->set[i].name; ++i)
        setenv(e->set[i].name, expand(value, sizeof value, e->set[i].value), 1);
    alarm(SECONDS);
    execv("/proc/self/exe", arguments);
    _exit(127);
}

static outcome run(const environment *e) {
    outcome result;
    int ends[2];
    size_t length = 0;
    memset(&result, 0, sizeof result);
    assert_int_equal(pipe(ends), 0);
    fflush(NULL);
    const pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        dup2(ends[1], 1);
        dup2(ends[1], 2);
        close(ends[0]);
        close(ends[1]);
        become(e);
    }
    close(ends[1]);
    for (;;) {
        char rest[256];
        const bool full = length + 1 >= sizeof result.text;
        const ssize_t got =
            full ? read(ends[0], rest, sizeof rest)
                 : read(ends[0], result.text + length, sizeof result.text - 1 - length);
        if (got <= 0) break;
        if (!full) length += (size_t)got;
    }
    close(ends[0]);
    assert_int_equal(waitpid(pid, &result.status, 0), pid);
    ++children;
    return result;
}

static bool ended_with(const outcome *o, int code) {
    return WIFEXITED(o->status) && WEXITSTATUS(o->status) == code;
}

static bool ended_with_an_error(const outcome *o) {
    return WIFEXITED(o->status) && WEXITSTATUS(o->status) > FAILED &&
           WEXITSTATUS(o->status) <= FAILED + HTREE_ERROR_KERNEL;
}

static void complain(const environment *e, const outcome *o) {
    fail_msg("%s: %s %d: %s", e->name, WIFSIGNALED(o->status) ? "signal" : "exit status",
             WIFSIGNALED(o->status) ? WTERMSIG(o->status) : WEXITSTATUS(o->status), o->text);
}

static void expect_status(const environment *e, htree_status status, const char *text) {
    const outcome o = run(e);
    if (!ended_with(&o, FAILED + (int)status) || !strstr(o.text, text)) complain(e, &o);
    ++refused;
}

/* ---- No OpenCL, or a broken one ------------------------------------------------------------- */

static void write_file(const char *path, const char *text) {
    char real[512];
    FILE *const file = fopen(expand(real, sizeof real, path), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void make_folder(const char *path) {
    char real[512];
    assert_int_equal(mkdir(expand(real, sizeof real, path), 0700), 0);
}

/* The folder of the mock, beside this program. */
static const char *beside(char *out, size_t size, const char *name) {
    const ssize_t length = readlink("/proc/self/exe", out, size - 1);
    assert_true(length > 0);
    out[length] = 0;
    char *const slash = strrchr(out, '/');
    snprintf(slash, size - (size_t)(slash - out), "/mock/%s", name);
    return out;
}

static void a_machine_without_opencl_has_no_device(void **state) {
    static const environment empty = {"an empty library", {{"LD_LIBRARY_PATH", "@/empty"}}, NULL};
    static const environment text = {"a library of text", {{"LD_LIBRARY_PATH", "@/text"}}, NULL};
    static const environment none = {"no driver", {{"OCL_ICD_VENDORS", "@/vendors"}}, NULL};
    static const environment gone = {
        "a driver that is gone", {{"OCL_ICD_VENDORS", "@/gone"}}, NULL};
    (void)state;
    make_folder("@/empty");
    make_folder("@/text");
    make_folder("@/vendors");
    make_folder("@/gone");
    write_file("@/empty/libOpenCL.so.1", "");
    write_file("@/empty/libOpenCL.so", "");
    write_file("@/text/libOpenCL.so.1", "INPUT(libOpenCL.so.2)\n");
    write_file("@/text/libOpenCL.so", "INPUT(libOpenCL.so.2)\n");
    write_file("@/gone/gone.icd", "libgone-opencl.so.1\n");
    expect_status(&empty, HTREE_ERROR_NO_DEVICE, "no OpenCL on this machine");
    expect_status(&text, HTREE_ERROR_NO_DEVICE, "no OpenCL on this machine");
    if (!has_device) return;
    expect_status(&none, HTREE_ERROR_NO_DEVICE, "no OpenCL driver");
    expect_status(&gone, HTREE_ERROR_NO_DEVICE, "no OpenCL driver");
}

static void the_library_is_found_by_its_name(void **state) {
    char path[512];
    environment e = {"a library that lacks functions", {{"LD_LIBRARY_PATH", path}}, NULL};
    (void)state;
    beside(path, sizeof path, "lacking");
    expect_status(&e, HTREE_ERROR_NO_DEVICE, "lacks clGetPlatformInfo");
    if (access(beside(path, sizeof path, "libOpenCL.so.1"), R_OK) != 0) return;
    *strrchr(path, '/') = 0;
    e.name = "the mock";
    const outcome o = run(&e);
    if (!ended_with(&o, EXACT)) complain(&e, &o);
    ++exact;
}

/* ---- PoCL's knobs --------------------------------------------------------------------------- */

static int look_for_a_device(void **state) {
    static const environment usual = {"as usual", {{NULL, NULL}}, "all"};
    const char *const required = getenv("HTREE_REQUIRE_ALL");
    const outcome o = run(&usual);
    (void)state;
    has_device = ended_with(&o, EXACT);
    exact += has_device;
    if (has_device) return 0;
    if (!ended_with(&o, FAILED + HTREE_ERROR_NO_DEVICE)) {
        printf("%s: %d: %s\n", usual.name, o.status, o.text);
        return 1;
    }
    say("skipped all that needs a device: %s", o.text);
    return required && strcmp(required, "1") == 0;
}

static const environment knobs[] = {
    {"basic", {{"POCL_DEVICES", "basic"}}, "all"},
    {"pthread", {{"POCL_DEVICES", "pthread"}}, NULL},
    {"two devices", {{"POCL_DEVICES", "basic pthread"}}, NULL},
    {"no such device", {{"POCL_DEVICES", "none"}}, NULL},
    {"work-groups of 1", {{"POCL_MAX_WORK_GROUP_SIZE", "1"}}, "all"},
    {"work-groups of 2", {{"POCL_MAX_WORK_GROUP_SIZE", "2"}}, NULL},
    {"work-groups of 7", {{"POCL_MAX_WORK_GROUP_SIZE", "7"}}, "wide"},
    {"work-groups of 64", {{"POCL_MAX_WORK_GROUP_SIZE", "64"}}, NULL},
    {"1 thread", {{"POCL_MAX_PTHREAD_COUNT", "1"}}, NULL},
    {"2 threads", {{"POCL_MAX_PTHREAD_COUNT", "2"}}, NULL},
    {"3 threads", {{"POCL_MAX_PTHREAD_COUNT", "3"}}, NULL},
    {"1 GiB", {{"POCL_MEMORY_LIMIT", "1"}}, NULL},
    {"loops", {{"POCL_WORK_GROUP_METHOD", "loops"}}, "all"},
    {"loopvec", {{"POCL_WORK_GROUP_METHOD", "loopvec"}}, "all"},
    {"cbs", {{"POCL_WORK_GROUP_METHOD", "cbs"}}, "all"},
    {"no cache", {{"POCL_KERNEL_CACHE", "0"}}, NULL},
    {"a cache in no folder", {{"POCL_CACHE_DIR", "/dev/null/cache"}}, NULL},
    {"a cache in a folder that takes no files", {{"POCL_CACHE_DIR", "/proc"}}, NULL},
};

static void any_knob_gives_the_same_hits_or_an_error(void **state) {
    (void)state;
    if (!has_device) return;
    const uint32_t step = scaled(100) < 100 ? 4 : 1;
    for (uint32_t i = 0; i < COUNT_OF(knobs); i += step) {
        const environment *const e = &knobs[i];
        const outcome o = run(e);
        const bool of_cache = strncmp(e->name, "a cache", 7) == 0;
        if (ended_with(&o, EXACT)) {
            ++exact;
        } else if (ended_with_an_error(&o)) {
            ++refused;
            say("%s: %.*s", e->name, (int)strcspn(o.text, "\n"), o.text);
        } else if (of_cache && WIFSIGNALED(o.status)) {
            ++died;
            say("known: PoCL dies of signal %d in %s", WTERMSIG(o.status), e->name);
        } else {
            complain(e, &o);
        }
    }
}

static int cut_in_half(const char *path, const struct stat *info, int type, struct FTW *ftw) {
    (void)ftw;
    return type == FTW_F && info->st_size > 1 ? truncate(path, info->st_size / 2) : 0;
}

static int empty_out(const char *path, const struct stat *info, int type, struct FTW *ftw) {
    (void)info;
    (void)ftw;
    return type == FTW_F ? truncate(path, 0) : 0;
}

/* A machine that was switched off while PoCL wrote. */
static void a_broken_cache_is_an_error_or_the_end(void **state) {
    static const environment e = {"a broken cache", {{"POCL_CACHE_DIR", "@/broken"}}, "bvh-sah"};
    int (*const breaks[])(const char *, const struct stat *, int, struct FTW *) = {cut_in_half,
                                                                                   empty_out};
    char path[512];
    (void)state;
    if (!has_device) return;
    make_folder("@/broken");
    for (uint32_t i = 0; i < COUNT_OF(breaks); ++i) {
        outcome o = run(&e);
        assert_int_equal(nftw(expand(path, sizeof path, "@/broken"), breaks[i], 16, FTW_PHYS), 0);
        o = run(&e);
        if (ended_with(&o, DIFFERENT) || ended_with(&o, 127)) complain(&e, &o);
        exact += ended_with(&o, EXACT);
        refused += ended_with_an_error(&o);
        if (ended_with(&o, EXACT) || ended_with_an_error(&o)) continue;
        ++died;
        say("known: PoCL dies of %s: %s %d", e.name, WIFSIGNALED(o.status) ? "signal" : "exit",
            WIFSIGNALED(o.status) ? WTERMSIG(o.status) : WEXITSTATUS(o.status));
    }
}

static int remove_one(const char *path, const struct stat *info, int type, struct FTW *ftw) {
    (void)info;
    (void)type;
    (void)ftw;
    return remove(path);
}

int main(int count, char **arguments) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_machine_without_opencl_has_no_device),
        cmocka_unit_test(the_library_is_found_by_its_name),
        cmocka_unit_test(any_knob_gives_the_same_hits_or_an_error),
        cmocka_unit_test(a_broken_cache_is_an_error_or_the_end),
    };
    if (count == 2 && strcmp(arguments[0], "child") == 0) return child(arguments[1]);
    if (mkdtemp(folder) == NULL) return 1;
    make_folder("@/cache");
    const int failed = cmocka_run_group_tests_name("cl_processes", tests, look_for_a_device, NULL);
    say("%llu processes: %llu exact, %llu with an error, %llu died", (unsigned long long)children,
        (unsigned long long)exact, (unsigned long long)refused, (unsigned long long)died);
    (void)nftw(folder, remove_one, 16, FTW_DEPTH | FTW_PHYS);
    return failed;
}
