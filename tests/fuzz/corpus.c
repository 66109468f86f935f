/* corpus.c: seeds of a target and plain mutations of them. */
#include "fuzz.h"
#include "suite.h"

static void keep(void *data, const void *bytes, size_t size) {
    fuzz_corpus *const c = (fuzz_corpus *)data;
    assert_true(c->count < FUZZ_MOST_SEEDS && size <= FUZZ_MOST_BYTES);
    c->bytes[c->count] = (uint8_t *)take(size + 1);
    memcpy(c->bytes[c->count], bytes, size);
    c->size[c->count++] = size;
}

void fuzz_corpus_make(fuzz_corpus *c, const fuzz_target *target) {
    memset(c, 0, sizeof *c);
    target->seed(keep, c);
}

void fuzz_corpus_free(fuzz_corpus *c) {
    for (uint32_t i = 0; i < c->count; ++i) free(c->bytes[i]);
    c->count = 0;
}

void fuzz_run(const fuzz_target *target, const uint8_t *bytes, size_t size) {
    uint8_t *const exact = (uint8_t *)take(size);
    memcpy(exact, bytes, size);
    target->run(exact, size);
    free(exact);
}

static size_t change(const fuzz_corpus *c, dice *d, uint8_t *out, size_t size) {
    static const uint8_t telling[] = {0, 1, 2, 3, 7, 8, 0x7f, 0x80, 0xff, '-', '9', ' ', '\n'};
    const size_t at = dice_below(d, (uint32_t)size);
    const uint32_t other = dice_below(d, c->count);
    switch (dice_below(d, 6)) {
    case 0: out[at] = (uint8_t)dice_u32(d); return size;
    case 1: out[at] = telling[dice_below(d, sizeof telling)]; return size;
    case 2: out[at] = (uint8_t)(out[at] ^ 1u << dice_below(d, 8)); return size;
    case 3: return at;
    case 4:
        if (2 * size - at > FUZZ_MOST_BYTES) return size;
        memmove(out + size, out + at, size - at);
        return 2 * size - at;
    default:
        if (c->size[other] <= at) return size;
        memcpy(out + at, c->bytes[other] + at, c->size[other] - at);
        return c->size[other];
    }
}

size_t fuzz_mutate(const fuzz_corpus *c, dice *d, uint8_t *out) {
    const uint32_t from = dice_below(d, c->count);
    size_t size = c->size[from];
    memcpy(out, c->bytes[from], size);
    for (uint32_t n = 1 + dice_below(d, 5); n > 0 && size > 0; --n) size = change(c, d, out, size);
    return size;
}
