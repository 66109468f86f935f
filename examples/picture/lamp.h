/* lamp.h: where the one lamp of a scene stands. */
#ifndef EXAMPLES_LAMP_H
#define EXAMPLES_LAMP_H

#include "camera.h"

/* From the eye, ahead and upwards: how far it gets (t) is the `ceiling` of lamp_place, infinite if it
 * leaves the scene. */
htree_ray lamp_probe(const camera *view);

/* Outdoors the lamp stands at the viewer's upper left, far away. Indoors walls would hide it there,
 * so it hangs on the way to the ceiling. Whether it is indoors: the eye is in the box, and there is a
 * ceiling. */
bool lamp_place(double *lamp, const camera *view, const htree_box *box, double ceiling);

/* The diagonal of a box. */
double lamp_diagonal(const htree_box *box);

#endif
