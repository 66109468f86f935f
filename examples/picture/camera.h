/* camera.h: a pinhole camera, placed by hand or so that it frames a mesh. */
#ifndef EXAMPLES_CAMERA_H
#define EXAMPLES_CAMERA_H

#include "htree.h"
#include "shapes.h"

typedef enum camera_mode { CAMERA_OUTSIDE, CAMERA_INSIDE, CAMERA_GIVEN } camera_mode;

/* What the user asked for. */
typedef struct camera_wish {
    camera_mode mode;
    double eye[3], look[3], fov; /* CAMERA_GIVEN; fov in degrees, 0: the default */
    int up;                      /* axis: 0 x, 1 y, 2 z */
} camera_wish;

typedef struct camera {
    double eye[3];
    double right[3], up[3], forward[3]; /* unit vectors */
    double slope_x, slope_y;            /* half the picture's width and height at distance 1 */
} camera;

/* Reads "inside", "outside" or "ex,ey,ez,lx,ly,lz[,fov]" into *wish, whose `up` it leaves alone. */
bool camera_parse(camera_wish *wish, const char *text);

/* Outside: a three-quarter view in which the mesh fills the picture. Inside: from near one end
 * of the bounds along their length. A mesh without a finite vertex counts as the unit box. */
camera camera_place(const camera_wish *wish, const shape *mesh, uint32_t width, uint32_t height);

/* Looks from `eye` along `forward`, upright by `up`; vectors of any length. `fov` is the angle in
 * degrees between the lower and the upper edge, `aspect` is width / height. */
void camera_look(camera *out, const double *eye, const double *forward, const double *up,
                 double fov, double aspect);

/* The ray through (x, y) in pixels from the top left corner. t is distance along `forward`. */
htree_ray camera_ray(const camera *c, double x, double y, uint32_t width, uint32_t height);

/* Bounds of the vertices that triangles refer to; the unit box if none is finite. */
htree_box mesh_bounds(const shape *mesh);

#endif
