#include "surface.h"

#include "numbers.h"

#include <math.h>
#include <stddef.h>

static void normalise(double *v) {
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; ++i) v[i] = length > 0 ? v[i] / length : 0;
}

static void cross(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

double surface_lift(double diagonal) {
    return diagonal * 2e-6;
}

void surface_find(surface *out, const shape *mesh, const htree_hit *hit, const htree_ray *ray,
                  double lift) {
    double corner[3][3], a[3], b[3], along = 0, largest = 0;
    for (int k = 0; k < 3; ++k) {
        const float *v =
            mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)hit->prim + (size_t)k];
        for (int i = 0; i < 3; ++i) corner[k][i] = (double)v[i];
    }
    for (int i = 0; i < 3; ++i) {
        a[i] = corner[1][i] - corner[0][i];
        b[i] = corner[2][i] - corner[0][i];
        out->point[i] = corner[0][i] + (double)hit->u * a[i] + (double)hit->v * b[i];
        largest = fmax(largest, fabs(out->point[i]));
    }
    cross(a, b, out->normal);
    normalise(out->normal);
    for (int i = 0; i < 3; ++i) along += out->normal[i] * (double)ray->dir[i];
    /* Rays go on from beyond the rounding of the coordinates. */
    lift += largest * 1e-6;
    for (int i = 0; i < 3; ++i) {
        if (along > 0) out->normal[i] = -out->normal[i];
        out->point[i] += lift * out->normal[i];
    }
    out->prim = hit->prim;
}

htree_ray surface_ray(const surface *s, const double *direction, double tmax) {
    htree_ray ray;
    for (int i = 0; i < 3; ++i) {
        ray.org[i] = (float)s->point[i];
        ray.dir[i] = (float)direction[i];
    }
    ray.tmin = 0;
    ray.tmax = (float)tmax;
    return ray;
}

void surface_cosine(const surface *s, double area, double turn, double *direction) {
    double side[3] = {0, 0, 0}, t[3], b[3];
    side[fabs(s->normal[0]) < 0.6 ? 0 : 1] = 1;
    cross(s->normal, side, t);
    normalise(t);
    cross(s->normal, t, b);
    const double r = sqrt(area), x = r * cos_turns(turn), y = r * sin_turns(turn);
    const double z = sqrt(1 - area);
    for (int k = 0; k < 3; ++k) direction[k] = x * t[k] + y * b[k] + z * s->normal[k];
}
