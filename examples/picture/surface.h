/* surface.h: where a ray has hit a mesh, and the rays that go on from there. */
#ifndef EXAMPLES_SURFACE_H
#define EXAMPLES_SURFACE_H

#include "htree.h"
#include "shapes.h"

typedef struct surface {
    double point[3];  /* a little above the surface */
    double normal[3]; /* unit, towards where the ray came from */
    uint32_t prim;
} surface;

/* How far above, for a scene of this diagonal, beside the rounding of its coordinates. */
double surface_lift(double diagonal);

/* `hit` is no miss. */
void surface_find(surface *out, const shape *mesh, const htree_hit *hit, const htree_ray *ray,
                  double lift);

/* From the surface, tmin = 0. */
htree_ray surface_ray(const surface *s, const double *direction, double tmax);

/* A direction around the normal, cosine-weighted where area and turn are uniform in [0, 1): the
 * unit disk, lifted to the sphere. */
void surface_cosine(const surface *s, double area, double turn, double *direction);

#endif
