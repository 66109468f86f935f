#include "lamp.h"

#include <math.h>

static double up_ahead(const camera *view, int axis) {
    return view->forward[axis] + 0.8 * view->up[axis] - 0.3 * view->right[axis];
}

htree_ray lamp_probe(const camera *view) {
    htree_ray ray = camera_ray(view, 0.5, 0.5, 1, 1);
    for (int i = 0; i < 3; ++i) ray.dir[i] = (float)up_ahead(view, i);
    return ray;
}

double lamp_diagonal(const htree_box *box) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double side = (double)box->hi[i] - (double)box->lo[i];
        sum += side * side;
    }
    return sqrt(sum);
}

bool lamp_place(double *lamp, const camera *view, const htree_box *box, double ceiling) {
    const double size = lamp_diagonal(box);
    bool inside = ceiling < INFINITY;
    for (int i = 0; i < 3; ++i)
        inside = inside && view->eye[i] > (double)box->lo[i] && view->eye[i] < (double)box->hi[i];
    for (int i = 0; i < 3; ++i) {
        const double middle = ((double)box->lo[i] + (double)box->hi[i]) / 2;
        const double toward = 0.6 * view->up[i] - 0.7 * view->right[i] - 0.4 * view->forward[i];
        lamp[i] =
            inside ? view->eye[i] + 0.7 * ceiling * up_ahead(view, i) : middle + 20 * size * toward;
    }
    return inside;
}
