/* clock.h: wall-clock time, for T_C and for htree_calibrate; never for a decision about a tree. */
#ifndef HT_CLOCK_H
#define HT_CLOCK_H

#include <time.h>

static inline double ht_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#endif
