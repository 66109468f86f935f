/* fuzz.c: bytes as choices, and as files. */
#define _POSIX_C_SOURCE 200809L
#include "fuzz.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const fuzz_target *const fuzz_targets[] = {&fuzz_ply,   &fuzz_aff, &fuzz_tree,
                                           &fuzz_scene, &fuzz_api, NULL};

uint32_t fuzz_u8(fuzz_bytes *b) {
    return b->at < b->end ? *b->at++ : 0;
}

uint32_t fuzz_u16(fuzz_bytes *b) {
    const uint32_t low = fuzz_u8(b);
    return low | fuzz_u8(b) << 8;
}

uint32_t fuzz_u32(fuzz_bytes *b) {
    const uint32_t low = fuzz_u16(b);
    return low | fuzz_u16(b) << 16;
}

float fuzz_float(fuzz_bytes *b, int grid) {
    if (grid > 0) return (float)((int)fuzz_u8(b) - 128) * 0.0625f / (float)grid;
    const uint32_t bits = fuzz_u32(b);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static char folder[64], path[128];

static void remove_folder(void) {
    remove(path);
    rmdir(folder);
}

const char *fuzz_file(const char *name, const uint8_t *bytes, size_t size) {
    if (!folder[0]) {
        snprintf(folder, sizeof folder, "/tmp/htree-fuzz-XXXXXX");
        if (!mkdtemp(folder)) abort();
        atexit(remove_folder);
    }
    if (path[0]) remove(path);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    if (!file || (size > 0 && fwrite(bytes, 1, size, file) != size) || fclose(file) != 0) abort();
    return path;
}
