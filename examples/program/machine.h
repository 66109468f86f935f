/* machine.h: what figures were measured on. */
#ifndef EXAMPLES_MACHINE_H
#define EXAMPLES_MACHINE_H

#include <stddef.h>

/* One line: processor, cores, system, compiler. Parts that cannot be found out are left out. */
void machine_describe(char *out, size_t size);

/* The command line as it could be typed again; arguments with other than plain characters get
 * quotes. Cut off at `size`. Paths lose their folders, which say nothing on another machine. */
void machine_command(char *out, size_t size, int argc, char *const *argv);

#endif
