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

/* ---- Without libFuzzer ---------------------------------------------------------------------- */

enum { FUZZ_MOST_SEEDS = 200, FUZZ_MOST_BYTES = 1 << 16 };

typedef struct fuzz_corpus {
    uint8_t *bytes[FUZZ_MOST_SEEDS];
    size_t size[FUZZ_MOST_SEEDS];
    uint32_t count;
} fuzz_corpus;

/* The seeds of a target. */
void fuzz_corpus_make(fuzz_corpus *c, const fuzz_target *target);
void fuzz_corpus_free(fuzz_corpus *c);

/* One of the seeds with bytes changed, cut, repeated, or continued with another one: written to `out`,
 * which has room for FUZZ_MOST_BYTES. */
struct dice;
size_t fuzz_mutate(const fuzz_corpus *c, struct dice *d, uint8_t *out);

/* Runs the target on bytes in memory of just their size, for AddressSanitizer. */
void fuzz_run(const fuzz_target *target, const uint8_t *bytes, size_t size);

/* A file that holds the bytes, overwritten by the next call. */
const char *fuzz_file(const char *name, const uint8_t *bytes, size_t size);

#endif
