/* cl_suite.c: a device for a test, and a kernel cache that no other process shares: PoCL's may be
 * corrupted when two write it at once. */
#define _XOPEN_SOURCE 700 /* nftw */
#include "cl_suite.h"

#include <ftw.h>
#include <sys/stat.h>

void assert_cl_ok_at(htree_status status, const char *file, int line) {
    if (status == HTREE_OK) return;
    print_error("%s:%d: %s: %s (%d)\n", file, line, htree_status_name(status),
                htree_cl_error_text(), (int)htree_cl_error_code());
    fail();
}

htree_cl_options cl_options(void) {
    htree_cl_options options;
    assert_cl_ok(htree_cl_options_init(&options, sizeof options));
    return options;
}

htree_cl *open_device(const htree_cl_options *options) {
    htree_cl *device = NULL;
    assert_cl_ok(htree_cl_open(&device, NULL, options));
    assert_non_null(device);
    return device;
}

htree_cl_tree *upload(htree_cl *device, const htree *tree) {
    htree_cl_tree *uploaded = NULL;
    assert_cl_ok(htree_cl_upload(&uploaded, device, tree));
    assert_non_null(uploaded);
    return uploaded;
}

/* ---- A process of its own ------------------------------------------------------------------- */

static void skipped(void **state) {
    const char *const required = getenv("HTREE_REQUIRE_ALL");
    (void)state;
    say("skipped: %s", htree_cl_error_text());
    if (required != NULL && strcmp(required, "1") == 0)
        fail_msg("HTREE_REQUIRE_ALL is set, and there is no OpenCL device");
}

static int remove_one(const char *path, const struct stat *info, int type, struct FTW *ftw) {
    (void)info;
    (void)type;
    (void)ftw;
    return remove(path);
}

int run_on_device(const char *group, const struct CMUnitTest *tests, size_t count,
                  CMFixtureFunction begin, CMFixtureFunction end) {
    char cache[] = "/tmp/htree-test-cl-XXXXXX";
    const struct CMUnitTest none[] = {cmocka_unit_test(skipped)};
    uint32_t devices = 0;
    if (mkdtemp(cache) == NULL || setenv("POCL_CACHE_DIR", cache, 1) != 0) {
        printf("cannot make a folder in /tmp\n");
        return 1;
    }
    const bool here = htree_cl_get_device_count(&devices) == HTREE_OK;
    const int failed = here ? _cmocka_run_group_tests(group, tests, count, begin, end)
                            : _cmocka_run_group_tests(group, none, 1, NULL, NULL);
    (void)nftw(cache, remove_one, 16, FTW_DEPTH | FTW_PHYS);
    return failed;
}
