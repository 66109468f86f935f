/* pictures.h: batches as cameras make them: rays that agree with their neighbours, row by row. */
#ifndef PICTURES_H
#define PICTURES_H

#include "rays.h"

/* A picture: whole rows, and `more` rays of one that is not. */
typedef struct picture {
    uint32_t width, height, more;
    uint64_t count;
    htree_ray *rays;
} picture;

picture picture_of(uint32_t width, uint32_t height, uint32_t more); /* rays unwritten */

/* Looks from `eye` along `forward`, through the middle of every pixel. */
picture picture_pinhole(uint32_t width, uint32_t height, uint32_t more, const float *eye,
                        const float *forward, float step);

/* All rays along `forward`, from a plane through `eye`. */
picture picture_parallel(uint32_t width, uint32_t height, const float *eye, const float *forward,
                         float step);

/* From what a picture's rays hit to a light. */
picture picture_shadows(const htree *tree, const picture *seen, const float *light);

/* A point outside of the box, and the way to its middle; the dice turn it. */
void picture_view(const ray_target *target, dice *d, float *eye, float *forward);

/* Brings the rays into square cells, row by row of them, and row by row in each; their side divides
 * width and height. */
void picture_cells(picture *p, uint32_t side);

/* Puts the rays into any order. */
void picture_shuffle(picture *p, dice *d);

/* Some rays lose a number, many have limits of their own. */
void picture_disturb(picture *p, dice *d);

#endif
