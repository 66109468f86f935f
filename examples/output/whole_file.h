/* whole_file.h: files that are whole or not there: what is written goes to PATH.part, which takes the
 * name at the end, when nothing has failed. */
#ifndef EXAMPLES_WHOLE_FILE_H
#define EXAMPLES_WHOLE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef struct whole_file {
    FILE *file;       /* to write to */
    const char *path; /* borrowed */
    char *part;
    bool is_device; /* such as /dev/null, which is written to and never replaced */
} whole_file;

/* False writes one line to `error`. */
bool whole_file_open(whole_file *out, const char *path, char *error, size_t size);

/* Ends the file: it is there now if `good` and every write went well. Else nothing is left, and false is
 * returned; of a write that failed `error` gets a line, what else was not good the caller says. */
bool whole_file_close(whole_file *out, bool good, char *error, size_t size);

#endif
