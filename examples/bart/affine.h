/* affine.h: maps x -> A x + b of space, and the vectors they move, in double. */
#ifndef EXAMPLES_AFFINE_H
#define EXAMPLES_AFFINE_H

#include <math.h>
#include <stdbool.h>

typedef struct affine {
    double m[3][4]; /* columns 0 to 2 are A, column 3 is b */
} affine;

static inline affine affine_identity(void) {
    const affine one = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    return one;
}

static inline void affine_direction(const affine *a, const double *v, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = a->m[i][0] * v[0] + a->m[i][1] * v[1] + a->m[i][2] * v[2];
}

static inline void affine_point(const affine *a, const double *p, double *out) {
    affine_direction(a, p, out);
    for (int i = 0; i < 3; ++i) out[i] += a->m[i][3];
}

/* First b, then a. */
static inline affine affine_multiply(const affine *a, const affine *b) {
    affine out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j)
            out.m[i][j] =
                a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j];
        out.m[i][3] += a->m[i][3];
    }
    return out;
}

/* Scale, then turn by the unit quaternion w x y z, then move. */
static inline affine affine_from(const double *scale, const double *q, const double *move) {
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    affine out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out.m[i][j] = r[i][j] * scale[j];
        out.m[i][3] = move[i];
    }
    return out;
}

/* The inverse by cofactors; false if the map flattens space. */
static inline bool affine_invert(const affine *a, affine *out) {
    double det = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const int r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            out->m[i][j] = a->m[r][c] * a->m[s][d] - a->m[r][d] * a->m[s][c];
        }
    }
    for (int k = 0; k < 3; ++k) det += a->m[0][k] * out->m[k][0];
    if (!(fabs(det) > 0) || !isfinite(1 / det)) return false;
    const double move[3] = {a->m[0][3], a->m[1][3], a->m[2][3]};
    for (int i = 0; i < 3; ++i) {
        double moved[3];
        for (int j = 0; j < 3; ++j) out->m[i][j] /= det;
        for (int j = 0; j < 3; ++j) moved[j] = out->m[i][j] * move[j];
        out->m[i][3] = -(moved[0] + moved[1] + moved[2]);
    }
    return true;
}

#endif
