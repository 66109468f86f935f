/* aff_lexer.c: a file is read whole, so that words are slices of it and need no memory. */
#include "aff_lexer.h"

#include "decimal.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A file beyond this is no AFF text; BART's largest has one megabyte. */
enum { FILE_LIMIT = 1 << 28 };

/* ---- Errors --------------------------------------------------------------------------------- */

bool aff_fail(aff_lexer *lexer, const char *format, ...) {
    aff_error *error = lexer->error;
    if (error->text[0] || error->size == 0) return false;
    snprintf(error->text, error->size, "%s:%u: ", lexer->path, (unsigned)lexer->line);
    const size_t used = strlen(error->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text + used, error->size - used, format, arguments);
    va_end(arguments);
    /* Words of a broken file may hold anything; the error is one line that a terminal can show. */
    for (char *c = error->text; *c; ++c)
        if ((unsigned char)*c < ' ' || (unsigned char)*c > '~') *c = '?';
    return false;
}

static bool fail_word(aff_lexer *lexer, aff_word word, const char *what) {
    if (word.length == 0) return aff_fail(lexer, "the file ends where %s should be", what);
    return aff_fail(lexer, "'%.*s' where %s should be", (int)(word.length < 32 ? word.length : 32),
                    word.start, what);
}

/* ---- Files ---------------------------------------------------------------------------------- */

static bool slurp(FILE *file, aff_lexer *out) {
    size_t room = 1 << 16;
    out->text = (char *)malloc(room);
    while (out->text) {
        out->length += fread(out->text + out->length, 1, room - out->length, file);
        if (out->length < room) return ferror(file) == 0;
        if (room >= FILE_LIMIT) return errno = EFBIG, false;
        char *larger = (char *)realloc(out->text, 2 * room);
        if (!larger) break;
        out->text = larger;
        room *= 2;
    }
    errno = ENOMEM;
    return false;
}

bool aff_open(aff_lexer *lexer, const char *path, aff_error *error) {
    memset(lexer, 0, sizeof *lexer);
    lexer->path = path;
    lexer->error = error;
    lexer->line = 1;
    FILE *file = fopen(path, "rb");
    const bool ok = file && slurp(file, lexer);
    const int reason = errno;
    if (!ok) aff_close(lexer);
    if (file) fclose(file);
    errno = reason;
    return ok;
}

void aff_close(aff_lexer *lexer) {
    free(lexer->text);
    lexer->text = NULL;
}

/* ---- Words ---------------------------------------------------------------------------------- */

static bool is_space(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r') || c == 0;
}

static bool is_brace(char c) {
    return c == '{' || c == '}';
}

static bool is_comment(char c) {
    return c == '#' || c == '%';
}

static void skip_blanks(aff_lexer *lexer) {
    const char *text = lexer->text;
    for (; lexer->at < lexer->length; ++lexer->at) {
        if (is_comment(text[lexer->at]))
            while (lexer->at < lexer->length && text[lexer->at] != '\n') ++lexer->at;
        if (lexer->at == lexer->length || !is_space(text[lexer->at])) return;
        lexer->line += text[lexer->at] == '\n';
    }
}

aff_word aff_peek(aff_lexer *lexer) {
    skip_blanks(lexer);
    const char *start = lexer->text + lexer->at, *end = lexer->text + lexer->length;
    aff_word word = {start, 0};
    if (start != end && is_brace(*start)) return word.length = 1, word;
    for (const char *c = start; c != end; ++c, ++word.length)
        if (is_space(*c) || is_brace(*c) || is_comment(*c)) break;
    return word;
}

aff_word aff_next(aff_lexer *lexer) {
    const aff_word word = aff_peek(lexer);
    lexer->at += word.length;
    return word;
}

bool aff_is(aff_word word, const char *text) {
    return word.length == strlen(text) && memcmp(word.start, text, word.length) == 0;
}

static bool read_number(aff_word word, double *out) {
    const char *end = word.start + word.length;
    return decimal_parse(word.start, end, out) == end && word.length > 0 && isfinite(*out);
}

bool aff_is_number(aff_word word) {
    double ignored;
    return read_number(word, &ignored);
}

bool aff_expect(aff_lexer *lexer, const char *text, const char *what) {
    const aff_word word = aff_next(lexer);
    return aff_is(word, text) || fail_word(lexer, word, what);
}

bool aff_numbers(aff_lexer *lexer, double *out, uint32_t count, const char *what) {
    for (uint32_t i = 0; i < count; ++i) {
        const aff_word word = aff_next(lexer);
        if (!read_number(word, &out[i])) return fail_word(lexer, word, what);
    }
    return true;
}

bool aff_whole(aff_lexer *lexer, uint32_t least, uint32_t most, uint32_t *out, const char *what) {
    double x;
    const aff_word word = aff_next(lexer);
    if (!read_number(word, &x) || x < least || x > most || x != floor(x))
        return fail_word(lexer, word, what);
    *out = (uint32_t)x;
    return true;
}
