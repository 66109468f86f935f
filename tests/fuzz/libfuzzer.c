/* libfuzzer.c: one target for libFuzzer, -DFUZZ_TARGET=fuzz_tree; or, with FUZZ_SEEDS=folder in the
 * environment, writes the target's seeds there and ends. */
#include "fuzz.h"

#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerInitialize(int *count, char ***arguments);
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

static void write_seed(void *data, const void *bytes, size_t size) {
    int *const number = (int *)data;
    char path[512];
    snprintf(path, sizeof path, "%s/seed-%03d", getenv("FUZZ_SEEDS"), (*number)++);
    FILE *const file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file) != 0) exit(1);
}

int LLVMFuzzerInitialize(int *count, char ***arguments) {
    int number = 0;
    (void)count;
    (void)arguments;
    if (!getenv("FUZZ_SEEDS")) return 0;
    FUZZ_TARGET.seed(write_seed, &number);
    exit(0);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    FUZZ_TARGET.run(bytes, size);
    return 0;
}
