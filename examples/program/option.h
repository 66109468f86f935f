/* option.h: what the command lines of the programs have in common. `program` begins every
 * message. */
#ifndef EXAMPLES_OPTION_H
#define EXAMPLES_OPTION_H

#include "htree.h"

#include <stdbool.h>
#include <stdint.h>

/* Prints one line to stderr, and returns false. */
bool option_wrong(const char *program, const char *text, ...);

/* Reads digits, no sign and no blank, up to the character `stop`. Says nothing when it fails. */
bool option_number(const char *text, char stop, uint64_t lo, uint64_t hi, uint64_t *value);

/* The value of --`option`, a whole number from lo to hi. */
bool option_u32(const char *program, const char *option, const char *text, uint64_t lo, uint64_t hi,
                uint32_t *value);

/* The value of --size, WIDTHxHEIGHT. */
bool option_size(const char *program, const char *text, uint32_t *width, uint32_t *height);

/* The value of --kind or --method, the name of a structure. */
bool option_kind(const char *program, const char *option, const char *text, htree_kind *kind);

/* The same into a list that holds each kind once. */
bool option_kind_add(const char *program, const char *option, const char *text, htree_kind *kinds,
                     uint32_t *count, uint32_t most);

/* The value of --`option`, names with commas between them: calls `take` with each, up to the first
 * that it refuses. */
bool option_list(const char *program, const char *option, const char *text,
                 bool (*take)(void *user, const char *name), void *user);

/* A built-in scene, NAME or NAME:N; `name` holds 32 bytes. False, and silent, if there is none. */
bool option_shape(const char *text, char *name, uint64_t *triangles);

/* The same as the value of --scene. */
bool option_scene(const char *program, const char *text, char *name, uint64_t *triangles);

/* The value of --`option`, a file to be written at the end: its folder must be there, and open for us,
 * now. */
bool option_output(const char *program, const char *option, const char *text, const char **path);

typedef enum args_result { ARGS_RUN, ARGS_DONE, ARGS_WRONG } args_result;

/* What a program takes: `letters` and `options` as getopt_long wants them. */
typedef struct option_syntax {
    const char *program, *help, *letters;
    const struct option *options;
} option_syntax;

/* The next option that is the program's own, its value in optarg. -1 after the last, with
 * ARGS_RUN in *result; or after --help or --version, which are answered here, and after a wrong
 * one. */
int option_next(const option_syntax *syntax, int argc, char **argv, args_result *result);

/* At most one mesh after the options, and not beside --scene. Leaves *path as it is if there is
 * none. */
bool option_one_mesh(const char *program, int argc, char **argv, bool scene, const char **path);

/* 0 is for all cores; the figures name the number that this comes to. */
uint32_t option_threads(uint32_t threads);

#endif
