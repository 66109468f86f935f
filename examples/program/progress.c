/* progress.c: one line, redrawn in place whenever the percentage changes. */
#include "progress.h"

#include <stdio.h>
#include <unistd.h>

progress progress_start(const char *label, bool quiet) {
    const progress bar = {label, !quiet && isatty(STDERR_FILENO), -1};
    return bar;
}

int32_t progress_report(void *user, double fraction) {
    progress *bar = (progress *)user;
    const int32_t percent = fraction > 0 ? fraction < 1 ? (int32_t)(100 * fraction) : 100 : 0;
    if (!bar->shown || percent == bar->percent) return 0;
    bar->percent = percent;
    char cells[41];
    for (int i = 0; i < 40; ++i) cells[i] = 5 * i < 2 * percent ? '#' : '.';
    cells[40] = 0;
    fprintf(stderr, "\r%-8s [%s] %3d %%", bar->label, cells, (int)percent);
    fflush(stderr);
    return 0;
}

void progress_end(progress *bar) {
    if (bar->shown && bar->percent >= 0) fprintf(stderr, "\r%60s\r", "");
    bar->percent = -1;
}
