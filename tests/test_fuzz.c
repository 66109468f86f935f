/* test_fuzz.c: what `make fuzz` drives for as long as it is given, for a moment and without libFuzzer:
 * seeds, findings of old (tests/fuzz/found), and mutations of the seeds. */
#include "fuzz.h"
#include "suite.h"

#include <dirent.h>

enum { MOST_SEEDS = 200, MOST_BYTES = 1 << 16 };

typedef struct corpus {
    uint8_t *bytes[MOST_SEEDS];
    size_t size[MOST_SEEDS];
    uint32_t count;
} corpus;

static void keep(void *data, const void *bytes, size_t size) {
    corpus *const c = (corpus *)data;
    assert_true(c->count < MOST_SEEDS);
    c->bytes[c->count] = (uint8_t *)take(size + 1);
    memcpy(c->bytes[c->count], bytes, size);
    c->size[c->count++] = size;
}

static void corpus_free(corpus *c) {
    for (uint32_t i = 0; i < c->count; ++i) free(c->bytes[i]);
}

/* In memory of just its size, for AddressSanitizer. */
static void run_exactly(const fuzz_target *target, const uint8_t *bytes, size_t size) {
    uint8_t *const exact = (uint8_t *)take(size);
    memcpy(exact, bytes, size);
    target->run(exact, size);
    free(exact);
}

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
        uint8_t *const bytes = (uint8_t *)take(MOST_BYTES);
        const size_t size = fread(bytes, 1, MOST_BYTES, file);
        fclose(file);
        run_exactly(target, bytes, size);
        free(bytes);
        ++count;
    }
    closedir(listing);
    return count;
}

/* ---- Mutations ------------------------------------------------------------------------------ */

/* Changes bytes, cuts, repeats, and continues with another seed. */
static size_t mutate(const corpus *c, dice *d, uint8_t *out) {
    static const uint8_t telling[] = {0, 1, 2, 3, 7, 8, 0x7f, 0x80, 0xff, '-', '9', ' ', '\n'};
    const uint32_t from = dice_below(d, c->count), other = dice_below(d, c->count);
    size_t size = c->size[from];
    memcpy(out, c->bytes[from], size);
    for (uint32_t n = 1 + dice_below(d, 5); n > 0 && size > 0; --n) {
        const size_t at = dice_below(d, (uint32_t)size);
        switch (dice_below(d, 6)) {
        case 0: out[at] = (uint8_t)dice_u32(d); break;
        case 1: out[at] = telling[dice_below(d, sizeof telling)]; break;
        case 2: out[at] = (uint8_t)(out[at] ^ 1u << dice_below(d, 8)); break;
        case 3: size = at; break;
        case 4:
            if (2 * size - at > MOST_BYTES) break;
            memmove(out + size, out + at, size - at);
            size += size - at;
            break;
        default:
            if (c->size[other] <= at) break;
            memcpy(out + at, c->bytes[other] + at, c->size[other] - at);
            size = c->size[other];
            break;
        }
    }
    return size;
}

static void run_target(const fuzz_target *target, uint64_t mutations) {
    corpus c;
    memset(&c, 0, sizeof c);
    target->seed(keep, &c);
    const uint64_t found = replay_found(target);
    uint8_t *const bytes = (uint8_t *)take(MOST_BYTES);
    dice d = {7};
    for (uint32_t i = 0; i < c.count; ++i) run_exactly(target, c.bytes[i], c.size[i]);
    for (uint64_t i = 0; i < mutations; ++i) run_exactly(target, bytes, mutate(&c, &d, bytes));
    say("%s: %lu seeds, %llu findings, %llu mutations", target->name, (unsigned long)c.count,
        (unsigned long long)found, (unsigned long long)mutations);
    free(bytes);
    corpus_free(&c);
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
