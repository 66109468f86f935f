/* anim_check.c: T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
 *
 * A ray near an edge may hit or miss by rounding, so there are two answers: the closest triangle
 * that is hit for sure, and the closest that may be. The tree's t must lie between them, and the
 * triangle that it names must be one that may be hit, at that t. */
#include "anim_check.h"

#include <math.h>

static const double margin = 1e-4;    /* of barycentric coordinates: nearer to an edge is unsure */
static const double tolerance = 1e-3; /* of t, relative */

typedef enum answer { MISSED, UNSURE, SURE } answer;

static void difference(const float *a, const float *b, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = (double)a[i] - (double)b[i];
}

static void across(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static answer test_triangle(const film *f, const film_frame *frame, uint64_t i,
                            const htree_ray *ray, const double *dir, double *t) {
    const uint32_t *corner = f->indices + 3 * i;
    const float *a = frame->positions + 3 * (size_t)corner[0];
    double e[3], g[3], p[3], q[3], s[3];
    difference(frame->positions + 3 * (size_t)corner[1], a, e);
    difference(frame->positions + 3 * (size_t)corner[2], a, g);
    across(dir, g, p);
    const double det = dot(e, p);
    if (det == 0) return MISSED;
    difference(ray->org, a, s);
    const double u = dot(s, p) / det;
    if (!(u >= -margin && u <= 1 + margin)) return MISSED;
    across(s, e, q);
    const double v = dot(dir, q) / det, w = 1 - u - v;
    if (!(v >= -margin && w >= -margin)) return MISSED;
    *t = dot(g, q) / det;
    if (!(*t >= (double)ray->tmin && *t <= (double)ray->tmax)) return MISSED;
    /* Seen edge-on, the float test may round to no hit at all. */
    const double size = sqrt(dot(e, e) * dot(g, g) * dot(dir, dir));
    return u > margin && v > margin && w > margin && fabs(det) > 1e-6 * size ? SURE : UNSURE;
}

/* Cones are compared with their own callback: this is about what the tree leaves out. */
static answer test_item(const film *f, const film_frame *frame, uint64_t i, const htree_ray *ray,
                        const double *dir, double *t) {
    htree_hit hit;
    if (i < f->triangle_count) return test_triangle(f, frame, i, ray, dir, t);
    if (!cone_intersect(frame->cones, (uint32_t)(i - f->triangle_count), ray, &hit)) return MISSED;
    *t = (double)hit.t;
    return SURE;
}

static void check_ray(anim_verdict *sum, const film *f, const film_frame *frame,
                      const htree_ray *ray, const htree_hit *hit) {
    const double dir[3] = {(double)ray->dir[0], (double)ray->dir[1], (double)ray->dir[2]};
    const uint64_t items = f->triangle_count + f->cone_count;
    double sure = INFINITY, maybe = INFINITY, own = INFINITY, t = 0;
    for (uint64_t i = 0; i < items; ++i) {
        const answer found = test_item(f, frame, i, ray, dir, &t);
        if (found != MISSED) maybe = fmin(maybe, t);
        if (found == SURE) sure = fmin(sure, t);
        if (found != MISSED && i == hit->prim) own = t;
    }
    ++sum->rays;
    sum->hits += hit->prim != HTREE_NONE;
    const double given = hit->prim == HTREE_NONE ? INFINITY : (double)hit->t;
    const double slack = tolerance * (given < INFINITY ? given : 0);
    const bool between = given >= maybe - slack && (given <= sure + slack);
    const bool named = given == INFINITY || fabs(own - given) <= slack;
    if (!between || !named)
        ++sum->wrong;
    else if (fabs(sure - given) > slack)
        ++sum->edges;
}

void anim_check(anim_verdict *sum, const film *f, const film_frame *frame, const htree_ray *rays,
                const htree_hit *hits, uint64_t count, uint64_t step) {
    for (uint64_t i = 0; i < count; i += step) check_ray(sum, f, frame, &rays[i], &hits[i]);
}
