/* fuzz.h: what is fuzzed. A target takes any bytes and must not be harmed by them; where it fails, it
 * ends the process or the test. libFuzzer drives one at a time (libfuzzer.c), test_fuzz.c replays all of
 * them with seeds, findings and plain mutations of both. */
#ifndef FUZZ_H
#define FUZZ_H

#include <stddef.h>
#include <stdint.h>

typedef void fuzz_emit(void *data, const void *bytes, size_t size);

typedef struct fuzz_target {
    const char *name;
    void (*run)(const uint8_t *bytes, size_t size);
    void (*seed)(fuzz_emit *emit, void *data); /* emits inputs to start from */
} fuzz_target;

extern const fuzz_target fuzz_ply, fuzz_aff, fuzz_tree, fuzz_scene, fuzz_api;

/* All of them, ending in NULL. */
extern const fuzz_target *const fuzz_targets[];

/* ---- Bytes as choices: 0 after the last ----------------------------------------------------- */

typedef struct fuzz_bytes {
    const uint8_t *at, *end;
} fuzz_bytes;

uint32_t fuzz_u8(fuzz_bytes *b);
uint32_t fuzz_u16(fuzz_bytes *b);
uint32_t fuzz_u32(fuzz_bytes *b);

/* Any bits; or, for a grid above 0, a multiple of 1 / grid in [-8, 8), from one byte. */
float fuzz_float(fuzz_bytes *b, int grid);

/* A file that holds the bytes, overwritten by the next call. */
const char *fuzz_file(const char *name, const uint8_t *bytes, size_t size);

#endif
