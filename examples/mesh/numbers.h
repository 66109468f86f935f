/* numbers.h: random numbers and a sine that give the same bits with every compiler and libm.
 *
 * Pictures and test scenes are compared byte by byte, so nothing here may depend on the platform:
 * integers, and double arithmetic of + - * / sqrt alone. */
#ifndef EXAMPLES_NUMBERS_H
#define EXAMPLES_NUMBERS_H

#include <math.h>
#include <stdint.h>

/* The output function of SplitMix64 (Steele, Lea, Flood 2014): consecutive x give independent bits.
 */
static inline uint64_t hash64(uint64_t x) {
    x = (x + 1) * UINT64_C(0x9E3779B97F4A7C15);
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return x ^ (x >> 31);
}

/* Two numbers into one seed; the order counts. */
static inline uint64_t hash_pair(uint64_t a, uint64_t b) {
    return hash64(hash64(a) ^ (b * UINT64_C(0xD1342543DE82EF95)));
}

/* The top 24 bits as a multiple of 2^-24 in [0, 1): exact as a float too. */
static inline double unit_from_bits(uint64_t bits) {
    return (double)(bits >> 40) * (1.0 / 16777216.0);
}

/* A stream of random numbers is a counter behind a hash. */
typedef struct random_stream {
    uint64_t counter;
} random_stream;

static inline random_stream random_start(uint32_t seed) {
    const random_stream stream = {hash64(seed)};
    return stream;
}

static inline double random_unit(random_stream *stream) {
    return unit_from_bits(hash64(stream->counter++));
}

static inline double random_range(random_stream *stream, double lo, double hi) {
    return lo + (hi - lo) * random_unit(stream);
}

/* sin(2 pi x): folded into a quarter turn, then the Taylor polynomial, whose error of 6e-12 is far
 * below what a float can hold. */
static inline double sin_turns(double x) {
    x -= floor(x + 0.5);
    if (x > 0.25) x = 0.5 - x;
    if (x < -0.25) x = -0.5 - x;
    const double y = 6.283185307179586 * x, q = y * y;
    double sum = -1.0 / 1307674368000.0;
    sum = sum * q + 1.0 / 6227020800.0;
    sum = sum * q - 1.0 / 39916800.0;
    sum = sum * q + 1.0 / 362880.0;
    sum = sum * q - 1.0 / 5040.0;
    sum = sum * q + 1.0 / 120.0;
    sum = sum * q - 1.0 / 6.0;
    return y * (1 + sum * q);
}

static inline double cos_turns(double x) {
    return sin_turns(x + 0.25);
}

#endif
