/* ratios.h: like against like over all scenes: what our configurations gain over the peer's. */
#ifndef EXAMPLES_RATIOS_H
#define EXAMPLES_RATIOS_H

#include "rows.h"

/* A table per number of threads against the peer, and one against it in its robust mode, as far as
 * there are rows; and one of every other number of threads against the least. Nothing without such
 * rows. */
void ratios_print(FILE *out, const bench_rows *rows);

#endif
