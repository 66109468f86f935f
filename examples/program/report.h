/* report.h: what a run measured, in the paper's names, as a table and as JSON. */
#ifndef EXAMPLES_REPORT_H
#define EXAMPLES_REPORT_H

#include "htree.h"
#include "primary.h"

#include <stddef.h>
#include <stdio.h>

typedef struct report {
    const char *scene;
    const char *device; /* that traced the rays; NULL: the CPU */
    uint32_t threads;
    htree_stats stats;
    const primary *rays;
} report;

/* A table with a line on each name, to stdout. */
void report_print(const report *r);

/* Text as a JSON string, quotes and all. */
void report_write_string(FILE *file, const char *text);

/* One flat object; times in seconds. False writes one line to `error`. */
bool report_write_json(const report *r, const char *path, char *error, size_t size);

#endif
