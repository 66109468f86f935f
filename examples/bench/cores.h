/* cores.h: every contender gets the same cores. */
#ifndef EXAMPLES_CORES_H
#define EXAMPLES_CORES_H

#include <stddef.h>
#include <stdint.h>

/* Keeps the process, and every thread it will start, to as many cores as there are to be threads,
 * and tells the OpenCL driver of the CPU (PoCL) their number unless the environment already does.
 * To be called before there are threads. Writes what was done, for the head of a table. */
void cores_take(uint32_t threads, char *text, size_t size);

#endif
