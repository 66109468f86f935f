/* progress.h: a progress bar on stderr. Silent unless stderr is a terminal. */
#ifndef EXAMPLES_PROGRESS_H
#define EXAMPLES_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct progress {
    const char *label;
    bool shown;
    int32_t percent; /* that is on the screen */
} progress;

/* `quiet` keeps it silent on terminals too. */
progress progress_start(const char *label, bool quiet);

/* Draws the bar at 0 <= fraction <= 1. Fits htree_progress.report with a progress as its user. */
int32_t progress_report(void *user, double fraction);

/* Clears the line. */
void progress_end(progress *bar);

#endif
