/* loop.h: a parallel loop as the library's own: threads for the length of a call, blocks claimed one
 * by one. */
#ifndef EXAMPLES_LOOP_H
#define EXAMPLES_LOOP_H

#include <stdint.h>

/* Calls task(data, first, end) for runs of at most 512 that together are 0 to count - 1, and returns
 * when all are done. */
void loop_run(uint32_t threads, uint64_t count,
              void (*task)(void *data, uint64_t first, uint64_t end), void *data);

#endif
