/* test_fuzz.c: what `make fuzz` drives for as long as it is given, for a moment and without libFuzzer:
 * seeds, findings of old (tests/fuzz/found), and mutations of the seeds. */
#include "fuzz.h"
#include "suite.h"

#include <dirent.h>

/* ---- Findings ------------------------------------------------------------------------------- */

/* tests/fuzz/found/TARGET-*: from the folder that the tests run in, the root. */
static uint64_t replay_found(const fuzz_target *target) {
    static const char folder[] = "tests/fuzz/found";
    uint64_t count = 0;
    DIR *const listing = opendir(folder);
    if (listing == NULL) return 0;
    for (struct dirent *entry; (entry = readdir(listing)) != NULL;) {
        char path[600];
        const size_t length = strlen(target->name);
        if (strncmp(entry->d_name, target->name, length) != 0) continue;
        if (entry->d_name[length] != '-') continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        FILE *const file = fopen(path, "rb");
        assert_non_null(file);
        uint8_t *const bytes = (uint8_t *)take(FUZZ_MOST_BYTES);
        const size_t size = fread(bytes, 1, FUZZ_MOST_BYTES, file);
        fclose(file);
        fuzz_run(target, bytes, size);
        free(bytes);
        ++count;
    }
    closedir(listing);
    return count;
}

static void run_target(const fuzz_target *target, uint64_t mutations) {
    fuzz_corpus c;
    fuzz_corpus_make(&c, target);
    const uint64_t found = replay_found(target);
    uint8_t *const bytes = (uint8_t *)take(FUZZ_MOST_BYTES);
    dice d = {7};
    for (uint32_t i = 0; i < c.count; ++i) fuzz_run(target, c.bytes[i], c.size[i]);
    for (uint64_t i = 0; i < mutations; ++i) fuzz_run(target, bytes, fuzz_mutate(&c, &d, bytes));
    say("%s: %lu seeds, %llu findings, %llu mutations", target->name, (unsigned long)c.count,
        (unsigned long long)found, (unsigned long long)mutations);
    free(bytes);
    fuzz_corpus_free(&c);
}

static void readers_take_any_bytes(void **state) {
    (void)state;
    run_target(&fuzz_ply, scaled(30000));
    run_target(&fuzz_aff, scaled(30000));
}

static void files_of_trees_may_hold_any_bytes(void **state) {
    (void)state;
    run_target(&fuzz_tree, scaled(50000));
}

static void all_kinds_agree_on_any_scene(void **state) {
    (void)state;
    run_target(&fuzz_scene, scaled(20000));
}

static void calls_may_come_in_any_order(void **state) {
    (void)state;
    run_target(&fuzz_api, scaled(50000));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(readers_take_any_bytes),
        cmocka_unit_test(files_of_trees_may_hold_any_bytes),
        cmocka_unit_test(all_kinds_agree_on_any_scene),
        cmocka_unit_test(calls_may_come_in_any_order),
    };
    return cmocka_run_group_tests_name("fuzz", tests, NULL, NULL);
}
