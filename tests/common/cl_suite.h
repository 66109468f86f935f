/* cl_suite.h: what tests on OpenCL devices start from: a device, or one line that says why there is
 * none. Include it instead of suite.h. */
#ifndef CL_SUITE_H
#define CL_SUITE_H

#include "suite.h"

#include "htree_cl.h"

#define assert_cl_ok(call) assert_cl_ok_at(call, __FILE__, __LINE__)
void assert_cl_ok_at(htree_status status, const char *file, int line);

htree_cl_options cl_options(void);

/* The first device, as NULL opens it; fails the test if it cannot be opened. */
htree_cl *open_device(const htree_cl_options *options);
htree_cl_tree *upload(htree_cl *device, const htree *tree);

/* cmocka_run_group_tests in a process of its own kernel cache, which is removed afterwards. Where
 * there is no device the group passes with one test, which says so; with HTREE_REQUIRE_ALL=1 it
 * fails. */
int run_on_device(const char *group, const struct CMUnitTest *tests, size_t count,
                  CMFixtureFunction begin, CMFixtureFunction end);

#endif
