/* option.h: what the command lines of the programs have in common. `program` begins every
 * message. */
#ifndef EXAMPLES_OPTION_H
#define EXAMPLES_OPTION_H

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

/* A built-in scene, NAME or NAME:N; `name` holds 32 bytes. False, and silent, if there is none. */
bool option_shape(const char *text, char *name, uint64_t *triangles);

/* For getopt_long's answers ':' and '?', with optind and optopt as it left them; long options have
 * values of 256 and more. */
void option_complain(const char *program, int answer, char **argv);

/* 0 is for all cores; the figures name the number that this comes to. */
uint32_t option_threads(uint32_t threads);

#endif
