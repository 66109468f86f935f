/* cmocka.h: as much of cmocka as test_golden needs, for WebAssembly, which has neither cmocka nor
 * setjmp: the first check that fails ends the program. */
#ifndef WASM_CMOCKA_H
#define WASM_CMOCKA_H

#include <stdio.h>
#include <stdlib.h>

struct CMUnitTest {
    const char *name;
    void (*run)(void **state);
};

#define cmocka_unit_test(test)                                                                     \
    { #test, test }

#define print_error(...) fprintf(stderr, __VA_ARGS__)
#define fail_msg(...)                                                                              \
    do {                                                                                           \
        print_error("%s:%d: ", __FILE__, __LINE__);                                                \
        print_error(__VA_ARGS__);                                                                  \
        print_error("\n");                                                                         \
        exit(1);                                                                                   \
    } while (0)
#define assert_true(condition)                                                                     \
    do {                                                                                           \
        if (!(condition)) fail_msg("%s", #condition);                                              \
    } while (0)
#define assert_int_equal(a, b)   assert_true((a) == (b))
#define assert_non_null(pointer) assert_true((pointer) != NULL)

#define cmocka_run_group_tests_name(group, tests, setup, teardown)                                 \
    wasm_run_tests(tests, sizeof(tests) / sizeof((tests)[0]))

static inline int wasm_run_tests(const struct CMUnitTest *tests, size_t count) {
    void *state = NULL;
    for (size_t i = 0; i < count; ++i) {
        printf("[ RUN      ] %s\n", tests[i].name);
        tests[i].run(&state);
    }
    printf("[  PASSED  ] %d test(s).\n", (int)count);
    return 0;
}

#endif
