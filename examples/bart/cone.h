/* cone.h: open cones and cylinders as objects of the caller's own, each a box and a callback. */
#ifndef EXAMPLES_CONE_H
#define EXAMPLES_CONE_H

#include "affine.h"
#include "htree.h"

/* The side of a cone between two discs, in a frame of its own where the axis runs from (0, 0, 0) to
 * (0, 0, 1) and the discs are round. */
typedef struct cone {
    affine inverse;        /* from the world to the cone's frame */
    double radius, growth; /* at z = 0, and how much more at z = 1 */
} cone;

/* Places the cone between discs at `base` and `top`, whatever `world` does to it. False: flat, or
 * not finite; then *out hits nothing and *box is empty. */
bool cone_place(cone *out, htree_box *box, const affine *world, const double *base,
                double base_radius, const double *top, double top_radius);

/* An htree_object_intersect whose `user` is an array of cones: u is the height, 0 to 1, v is 0. */
int32_t cone_intersect(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit);

/* The outward normal at a point of the side, not normalised. */
void cone_normal(const cone *c, const double *point, double *normal);

#endif
