/* cone.c: an affine map takes the ray into the cone's frame and leaves t as it is, so that every
 * cone, however it is scaled, is the same quadratic equation. */
#include "cone.h"

#include <string.h>

/* A unit vector across `axis`, and the one across both. */
static void make_frame(const double *axis, double length, double *u, double *v) {
    int k = 0;
    for (int i = 1; i < 3; ++i)
        if (fabs(axis[i]) < fabs(axis[k])) k = i;
    const double a = axis[(k + 1) % 3] / length, b = axis[(k + 2) % 3] / length;
    const double scale = 1 / sqrt(a * a + b * b);
    u[k] = 0;
    u[(k + 1) % 3] = -b * scale;
    u[(k + 2) % 3] = a * scale;
    for (int i = 0; i < 3; ++i) {
        const int r = (i + 1) % 3, s = (i + 2) % 3;
        v[i] = (axis[r] * u[s] - axis[s] * u[r]) / length;
    }
}

/* The box of both discs; a disc reaches radius * |(a, b)| along an axis to which its two radii have
 * the components a and b. Widened by a few float steps, as the library rounds nothing for us. */
static void bound(htree_box *box, const affine *m, double radius, double growth) {
    for (int i = 0; i < 3; ++i) {
        const double wide = sqrt(m->m[i][0] * m->m[i][0] + m->m[i][1] * m->m[i][1]);
        const double low = m->m[i][3], high = low + m->m[i][2];
        const double r0 = wide * radius, r1 = wide * (radius + growth);
        const double lo = fmin(low - r0, high - r1), hi = fmax(low + r0, high + r1);
        const double slack = 4e-7 * fmax(fabs(lo), fabs(hi));
        box->lo[i] = (float)(lo - slack);
        box->hi[i] = (float)(hi + slack);
    }
}

bool cone_place(cone *out, htree_box *box, const affine *world, const double *base,
                double base_radius, const double *top, double top_radius) {
    static const htree_box empty = {{1, 1, 1}, {-1, -1, -1}};
    double axis[3], u[3], v[3];
    for (int i = 0; i < 3; ++i) axis[i] = top[i] - base[i];
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    memset(out, 0, sizeof *out);
    out->radius = -1;
    *box = empty;
    if (!(length > 0)) return false;
    make_frame(axis, length, u, v);
    affine frame;
    for (int i = 0; i < 3; ++i) {
        frame.m[i][0] = u[i];
        frame.m[i][1] = v[i];
        frame.m[i][2] = axis[i];
        frame.m[i][3] = base[i];
    }
    const affine place = affine_multiply(world, &frame);
    if (!affine_invert(&place, &out->inverse)) return false;
    out->radius = base_radius;
    out->growth = top_radius - base_radius;
    bound(box, &place, out->radius, out->growth);
    return true;
}

int32_t cone_intersect(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    const cone *c = (const cone *)user + object;
    if (c->radius < 0) return 0;
    double o[3], d[3];
    for (int i = 0; i < 3; ++i) {
        o[i] = (double)ray->org[i];
        d[i] = (double)ray->dir[i];
    }
    double org[3], dir[3];
    affine_point(&c->inverse, o, org);
    affine_direction(&c->inverse, d, dir);
    /* x^2 + y^2 = r(z)^2, with r and its change along the ray. */
    const double r = c->radius + c->growth * org[2], dr = c->growth * dir[2];
    const double a = dir[0] * dir[0] + dir[1] * dir[1] - dr * dr;
    const double b = org[0] * dir[0] + org[1] * dir[1] - r * dr;
    const double k = org[0] * org[0] + org[1] * org[1] - r * r;
    const double square = b * b - a * k;
    if (!(square >= 0)) return 0;
    /* No difference of near numbers in either root; a zero gives an infinity or a NaN, which the
     * comparisons below refuse. */
    const double q = -(b + (b < 0 ? -sqrt(square) : sqrt(square)));
    const double x = k / q, y = q / a, first = x < y || y != y ? x : y;
    for (int i = 0; i < 2; ++i) {
        const double t = i == 0 ? first : first == x ? y : x, z = org[2] + t * dir[2];
        if (!(t >= (double)ray->tmin && t <= (double)ray->tmax && z >= 0 && z <= 1)) continue;
        hit->t = (float)t;
        hit->u = (float)z;
        hit->v = 0;
        return 1;
    }
    return 0;
}

void cone_normal(const cone *c, const double *point, double *normal) {
    double p[3];
    affine_point(&c->inverse, point, p);
    const double slope[3] = {p[0], p[1], -c->growth * (c->radius + c->growth * p[2])};
    for (int i = 0; i < 3; ++i)
        normal[i] = slope[0] * c->inverse.m[0][i] + slope[1] * c->inverse.m[1][i] +
                    slope[2] * c->inverse.m[2][i];
}
