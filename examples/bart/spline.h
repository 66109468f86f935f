/* spline.h: values between keys in time: points on a Kochanek-Bartels spline, rotations on a spline
 * of quaternions with the same three dials. */
#ifndef EXAMPLES_SPLINE_H
#define EXAMPLES_SPLINE_H

#include <stdint.h>

/* value: x y z of a point, or w x y z of a unit quaternion. Tension, continuity and bias are 0 for
 * a Catmull-Rom spline. */
typedef struct spline_key {
    double time, value[4];
    double tension, continuity, bias;
} spline_key;

/* Four keys or more: the first and the last only bend the curve, which runs from the second key to
 * the last but one and rests before and after. With fewer the curve runs through all of them. Keys
 * should be in order of time; of segments that overlap in time the first one counts. */
typedef struct spline {
    spline_key *keys;
    uint32_t count; /* at least 1 for the functions below */
} spline;

void spline_point(const spline *s, double time, double *xyz);

/* The keys must come from spline_turn and have gone through spline_align. */
void spline_rotation(const spline *s, double time, double *wxyz);

/* Sets key->value to the quaternion of a turn about an axis of any length; an axis of length 0
 * turns nothing. */
void spline_turn(spline_key *key, const double *axis, double degrees);

/* Chooses of q and -q, which turn alike, the one nearer to the key before: the short way round. */
void spline_align(spline *s);

#endif
