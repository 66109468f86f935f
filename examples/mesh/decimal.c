/* decimal.c: digits go into an integer, and one multiplication or division by a power of ten, exact
 * up to 10^22, makes the double. strtod would read a comma or a point by the user's locale. */
#include "decimal.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

static bool match_word(const char **at, const char *end, const char *word) {
    const char *p = *at;
    for (; *word; ++p, ++word)
        if (p == end || (*p | 0x20) != *word) return false;
    *at = p;
    return true;
}

static double scale_by_ten(double x, int exponent) {
    static const double power[23] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                     1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                     1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    for (; exponent > 22; exponent -= 22) x *= power[22];
    for (; exponent < -22; exponent += 22) x /= power[22];
    return exponent < 0 ? x / power[-exponent] : x * power[exponent];
}

/* Exponents saturate: past 9999 the result is 0 or infinity whatever the digits are. */
static const char *parse_exponent(const char *at, const char *end, int *exponent) {
    const char *p = at;
    if (p == end || (*p | 0x20) != 'e') return at;
    const bool negative = ++p != end && *p == '-';
    if (p != end && (*p == '-' || *p == '+')) ++p;
    if (p == end || *p < '0' || *p > '9') return at;
    int value = 0;
    for (; p != end && *p >= '0' && *p <= '9'; ++p)
        if (value < 9999) value = 10 * value + (*p - '0');
    *exponent += negative ? -value : value;
    return p;
}

const char *decimal_parse(const char *at, const char *end, double *value) {
    const bool negative = at != end && *at == '-';
    if (at != end && (*at == '-' || *at == '+')) ++at;
    if (match_word(&at, end, "nan")) return *value = NAN, at;
    if (match_word(&at, end, "inf")) {
        match_word(&at, end, "inity");
        return *value = negative ? -INFINITY : INFINITY, at;
    }
    uint64_t digits = 0;
    int exponent = 0;
    bool point = false, any = false;
    for (; at != end; ++at) {
        if (*at == '.' && !point) {
            point = true;
        } else if (*at >= '0' && *at <= '9') {
            /* 18 digits fit for sure; later ones only move the point. */
            const bool room = digits < UINT64_C(100000000000000000);
            if (room) digits = 10 * digits + (uint64_t)(*at - '0');
            if (exponent > -9999 && exponent < 9999) exponent += (int)!room - (int)point;
            any = true;
        } else {
            break;
        }
    }
    if (!any) return NULL;
    at = parse_exponent(at, end, &exponent);
    const double magnitude = digits ? scale_by_ten((double)digits, exponent) : 0;
    *value = negative ? -magnitude : magnitude;
    return at;
}
