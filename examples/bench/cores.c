/* cores.c: affinity is no part of POSIX; elsewhere than on Linux the text says that there is none. */
#ifdef __linux__
#define _GNU_SOURCE
#include <sched.h>
#endif

#include "cores.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef __linux__

/* The first of those that the process may run on. */
static uint32_t pin(uint32_t threads) {
    cpu_set_t may, chosen;
    uint32_t count = 0;
    CPU_ZERO(&chosen);
    if (sched_getaffinity(0, sizeof may, &may) != 0) return 0;
    for (size_t core = 0; core < CPU_SETSIZE && count < threads; ++core) {
        if (!CPU_ISSET(core, &may)) continue;
        CPU_SET(core, &chosen);
        ++count;
    }
    return sched_setaffinity(0, sizeof chosen, &chosen) == 0 ? count : 0;
}

#else

static uint32_t pin(uint32_t threads) {
    (void)threads;
    return 0;
}

#endif

void cores_take(uint32_t threads, char *text, size_t size) {
    char number[16];
    const uint32_t cores = pin(threads);
    snprintf(number, sizeof number, "%u", threads);
    setenv("POCL_MAX_PTHREAD_COUNT", number, 0);
    if (cores)
        snprintf(text, size, "%u thread%s on %u core%s", threads, threads == 1 ? "" : "s", cores,
                 cores == 1 ? "" : "s");
    else
        snprintf(text, size, "%u thread%s, not kept to cores", threads, threads == 1 ? "" : "s");
}
