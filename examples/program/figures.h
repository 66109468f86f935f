/* figures.h: what several tables do with their numbers. */
#ifndef EXAMPLES_FIGURES_H
#define EXAMPLES_FIGURES_H

#include <stddef.h>
#include <stdint.h>

/* Of count >= 1 numbers, which it sorts. */
double figures_median(double *x, uint32_t count);

/* 69451 as "69,451". Returns `out`. */
const char *figures_commas(char *out, size_t size, uint64_t number);

#endif
