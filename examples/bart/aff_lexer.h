/* aff_lexer.h: the words of an AFF file. Words are parted by white space and braces; # and % begin
 * comments that end with the line. */
#ifndef EXAMPLES_AFF_LEXER_H
#define EXAMPLES_AFF_LEXER_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The first error of a run, as one line: `file:line: what`. */
typedef struct aff_error {
    char *text; /* "" as long as all is well */
    size_t size;
} aff_error;

typedef struct aff_lexer {
    const char *path;
    char *text; /* the whole file */
    size_t length, at;
    uint32_t line; /* of the word last read, from 1 */
    aff_error *error;
} aff_lexer;

typedef struct aff_word {
    const char *start;
    size_t length; /* 0: the end of the file */
} aff_word;

/* Reads the file. False: errno says why, there is nothing to close, and the lexer serves aff_fail
 * alone. `path` must outlive it. */
bool aff_open(aff_lexer *lexer, const char *path, aff_error *error);
void aff_close(aff_lexer *lexer);

/* The next word, without taking it. */
aff_word aff_peek(aff_lexer *lexer);
aff_word aff_next(aff_lexer *lexer);

bool aff_is(aff_word word, const char *text);
bool aff_is_number(aff_word word);

/* Writes the error, unless there is one already. Always false. */
bool aff_fail(aff_lexer *lexer, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* These take the next word, or fail and say that it is not `what`. Numbers are finite. */
bool aff_expect(aff_lexer *lexer, const char *text, const char *what);
bool aff_numbers(aff_lexer *lexer, double *out, uint32_t count, const char *what);
bool aff_whole(aff_lexer *lexer, uint32_t least, uint32_t most, uint32_t *out, const char *what);

#endif
