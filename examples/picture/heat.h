/* heat.h: pictures of a number per pixel: a colour map, its scale, and a legend. */
#ifndef EXAMPLES_HEAT_H
#define EXAMPLES_HEAT_H

#include "picture.h"

typedef struct heat_scale {
    const char *title; /* of the legend */
    double lo, hi;     /* values of the first and the last colour; hi > lo */
    double mean, max;  /* of all values, for the legend */
    bool whole;        /* values are whole numbers */
} heat_scale;

/* Dark blue at 0 over magenta to pale yellow at 1. Lightness rises evenly, so that the map also
 * reads in grey and for the colour-blind. */
colour heat_colour(double x);

/* The scale of `count` values, without the NaNs among them: from their least (0 if whole) to
 * `fixed`, or, if that is 0, to what all but the hottest 0.5 % stay below: a few outliers must not
 * leave the rest in the dark. Needs memory for a copy; false if there is none. */
bool heat_measure(heat_scale *out, const char *title, bool whole, const float *values,
                  uint64_t count, double fixed);

/* Paints values, row by row, and the legend below them if the picture has room. NaN is grey. */
void heat_paint(picture *p, const heat_scale *scale, const float *values);

#endif
