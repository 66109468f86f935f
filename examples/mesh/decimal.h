/* decimal.h: numbers in text, the same under every locale. */
#ifndef EXAMPLES_DECIMAL_H
#define EXAMPLES_DECIMAL_H

/* Reads one number (12, -.5, 1e-3, nan, inf, infinity) that starts at `at` and ends before `end`.
 * Returns the first character after it, or NULL if there is none. Correctly rounded for up to 15
 * digits with exponents within 22; beyond that, off by a few units in the last place of a double.
 */
const char *decimal_parse(const char *at, const char *end, double *value);

#endif
