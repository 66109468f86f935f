/* spline.c: D. Kochanek, R. Bartels, "Interpolating Splines with Local Tension, Continuity, and
 * Bias Control", 1984; for rotations, tangents in the logarithm of the quaternions and Shoemake's
 * quadrangle interpolation. Tangents are scaled for keys that are not evenly spaced. */
#include "spline.h"

#include <math.h>
#include <stdbool.h>

/* The segment around a time, and the keys that bend it. */
typedef struct segment {
    const spline_key *before, *from, *to, *after;
    double u; /* 0 at from, 1 at to */
} segment;

/* ---- Which segment, which tangents ---------------------------------------------------------- */

static segment find_segment(const spline *s, double time) {
    const bool phantoms = s->count >= 4;
    const uint32_t first = phantoms ? 1 : 0, last = s->count - (phantoms ? 2 : 1);
    uint32_t i = first;
    while (i < last && !(time < s->keys[i + 1].time)) ++i;
    const uint32_t next = i < last ? i + 1 : i;
    segment at = {&s->keys[i > 0 ? i - 1 : 0], &s->keys[i], &s->keys[next],
                  &s->keys[next + 1 < s->count ? next + 1 : next], 0};
    const double length = at.to->time - at.from->time;
    if (length > 0 && time > at.from->time) at.u = fmin((time - at.from->time) / length, 1);
    return at;
}

/* Weights of the step before a key and of the step after it in the tangent there. `out` is the
 * tangent of the segment that leaves the key; a and c are the times of the keys around it. */
static void tangent_weights(const spline_key *key, double a, double c, double length, bool out,
                            double *weight) {
    const double sign = out ? 1 : -1, span = c - a;
    const double scale = (span > 0 ? length / span : 0) * (1 - key->tension);
    weight[0] = scale * (1 + sign * key->continuity) * (1 + key->bias);
    weight[1] = scale * (1 - sign * key->continuity) * (1 - key->bias);
}

static void segment_weights(const segment *at, double *out, double *in) {
    const double length = at->to->time - at->from->time;
    tangent_weights(at->from, at->before->time, at->to->time, length, true, out);
    tangent_weights(at->to, at->from->time, at->after->time, length, false, in);
}

void spline_point(const spline *s, double time, double *xyz) {
    const segment at = find_segment(s, time);
    const double u = at.u;
    double out[2], in[2];
    segment_weights(&at, out, in);
    for (int i = 0; i < 3; ++i) {
        const double p = at.from->value[i], q = at.to->value[i], step = q - p;
        const double leave = out[0] * (p - at.before->value[i]) + out[1] * step;
        const double arrive = in[0] * step + in[1] * (at.after->value[i] - q);
        xyz[i] =
            p + u * (leave + u * (3 * step - 2 * leave - arrive + u * (leave + arrive - 2 * step)));
    }
}

/* ---- Quaternions ---------------------------------------------------------------------------- */

static double dot4(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

/* Half the turn from a to b, as axis times angle: the logarithm of a^-1 b. */
static void step_between(const double *a, const double *b, double *out) {
    const double x[3] = {a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
                         a[0] * b[2] - a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
                         a[0] * b[3] - a[3] * b[0] - a[1] * b[2] + a[2] * b[1]};
    const double length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    const double scale = length > 1e-12 ? atan2(length, dot4(a, b)) / length : 1;
    for (int i = 0; i < 3; ++i) out[i] = scale * x[i];
}

/* a, turned on by `step`: a exp(step). */
static void turned(const double *a, const double *step, double *out) {
    const double angle = sqrt(step[0] * step[0] + step[1] * step[1] + step[2] * step[2]);
    const double s = angle > 1e-12 ? sin(angle) / angle : 1, w = cos(angle);
    const double x = s * step[0], y = s * step[1], z = s * step[2];
    out[0] = a[0] * w - a[1] * x - a[2] * y - a[3] * z;
    out[1] = a[0] * x + a[1] * w + a[2] * z - a[3] * y;
    out[2] = a[0] * y + a[2] * w + a[3] * x - a[1] * z;
    out[3] = a[0] * z + a[3] * w + a[1] * y - a[2] * x;
}

static void slerp(const double *a, const double *b, double u, double *out) {
    double step[3];
    step_between(a, b, step);
    for (int i = 0; i < 3; ++i) step[i] *= u;
    turned(a, step, out);
}

void spline_rotation(const spline *s, double time, double *wxyz) {
    const segment at = find_segment(s, time);
    const double *p = at.from->value, *q = at.to->value;
    double out[2], in[2], before[3], here[3], after[3], leave[3], arrive[3];
    double a[4], b[4], ends[4], bends[4];
    segment_weights(&at, out, in);
    step_between(at.before->value, p, before);
    step_between(p, q, here);
    step_between(q, at.after->value, after);
    for (int i = 0; i < 3; ++i) {
        leave[i] = (out[0] * before[i] + out[1] * here[i] - here[i]) / 2;
        arrive[i] = (here[i] - in[0] * here[i] - in[1] * after[i]) / 2;
    }
    turned(p, leave, a);
    turned(q, arrive, b);
    slerp(p, q, at.u, ends);
    slerp(a, b, at.u, bends);
    slerp(ends, bends, 2 * at.u * (1 - at.u), wxyz);
    const double scale = 1 / sqrt(dot4(wxyz, wxyz));
    for (int i = 0; i < 4; ++i) wxyz[i] *= scale;
}

void spline_turn(spline_key *key, const double *axis, double degrees) {
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    const double half = length > 0 ? fmod(degrees, 720) * (3.14159265358979323846 / 360) : 0;
    key->value[0] = cos(half);
    for (int i = 0; i < 3; ++i) key->value[i + 1] = length > 0 ? sin(half) * axis[i] / length : 0;
}

void spline_align(spline *s) {
    for (uint32_t i = 1; i < s->count; ++i) {
        double *q = s->keys[i].value;
        if (dot4(s->keys[i - 1].value, q) >= 0) continue;
        for (int k = 0; k < 4; ++k) q[k] = -q[k];
    }
}
