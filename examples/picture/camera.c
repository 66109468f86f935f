/* camera.c: framing is exact: the eye goes to the nearest point from which every vertex lies
 * between the four sides of the view, which takes the extremes of four linear functions over the
 * vertices. */
#include "camera.h"

#include "decimal.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* ---- Parsing -------------------------------------------------------------------------------- */

bool camera_parse(camera_wish *wish, const char *text) {
    double numbers[7] = {0};
    int count = 0;
    if (strcmp(text, "inside") == 0) return wish->mode = CAMERA_INSIDE, true;
    if (strcmp(text, "outside") == 0) return wish->mode = CAMERA_OUTSIDE, true;
    const char *end = text + strlen(text);
    for (;; ++text) {
        text = count < 7 ? decimal_parse(text, end, &numbers[count]) : NULL;
        if (!text || !(fabs(numbers[count++]) < 1e18)) return false;
        if (*text != ',') break;
    }
    if (*text || count < 6 || numbers[6] < 0 || numbers[6] >= 179) return false;
    wish->mode = CAMERA_GIVEN;
    memcpy(wish->eye, numbers, sizeof wish->eye);
    memcpy(wish->look, numbers + 3, sizeof wish->look);
    wish->fov = numbers[6];
    return memcmp(wish->eye, wish->look, sizeof wish->eye) != 0;
}

/* ---- Vectors -------------------------------------------------------------------------------- */

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static bool normalise(double *v) {
    const double length = sqrt(dot(v, v));
    if (!(length > 1e-12)) return false;
    for (int i = 0; i < 3; ++i) v[i] /= length;
    return true;
}

/* An upright basis around c->forward; a view straight up or down takes another axis for up. */
static void make_basis(camera *c, int up_axis) {
    double up[3] = {0, 0, 0};
    up[up_axis] = 1;
    if (!normalise(c->forward)) c->forward[2] = -1;
    cross(c->forward, up, c->right);
    if (!normalise(c->right)) {
        double other[3] = {0, 0, 0};
        other[(up_axis + 1) % 3] = 1;
        cross(c->forward, other, c->right);
        normalise(c->right);
    }
    cross(c->right, c->forward, c->up);
}

/* ---- Framing -------------------------------------------------------------------------------- */

/* Corner i of the triangles, or NULL if a coordinate is not finite. */
static const float *finite_corner(const shape *mesh, uint64_t i) {
    const float *p = mesh->positions + 3 * (uint64_t)mesh->indices[i];
    for (int k = 0; k < 3; ++k)
        if (!(fabsf(p[k]) <= HTREE_COORDINATE_MAX)) return NULL;
    return p;
}

htree_box mesh_bounds(const shape *mesh) {
    htree_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    static const htree_box unit = {{0, 0, 0}, {1, 1, 1}};
    for (uint64_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const float *p = finite_corner(mesh, i);
        for (int k = 0; p && k < 3; ++k) {
            if (p[k] < box.lo[k]) box.lo[k] = p[k];
            if (p[k] > box.hi[k]) box.hi[k] = p[k];
        }
    }
    return box.lo[0] <= box.hi[0] ? box : unit;
}

/* With a, b, c the coordinates of a vertex along right, up, forward, and e those of the eye, the
 * view holds the vertex if |a - e_a| <= slope_x (c - e_c) and |b - e_b| <= slope_y (c - e_c). */
static void frame(camera *c, const shape *mesh) {
    double side[4] = {-INFINITY, -INFINITY, -INFINITY, -INFINITY};
    for (uint64_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const float *p = finite_corner(mesh, i);
        if (!p) continue;
        const double v[3] = {(double)p[0], (double)p[1], (double)p[2]};
        const double a = dot(v, c->right), b = dot(v, c->up), depth = dot(v, c->forward);
        side[0] = fmax(side[0], a - c->slope_x * depth);
        side[1] = fmax(side[1], -a - c->slope_x * depth);
        side[2] = fmax(side[2], b - c->slope_y * depth);
        side[3] = fmax(side[3], -b - c->slope_y * depth);
    }
    if (side[0] == -INFINITY) return;
    const double a = (side[0] - side[1]) / 2, b = (side[2] - side[3]) / 2;
    const double depth =
        fmin(-(side[0] + side[1]) / (2 * c->slope_x), -(side[2] + side[3]) / (2 * c->slope_y));
    for (int i = 0; i < 3; ++i) c->eye[i] = a * c->right[i] + b * c->up[i] + depth * c->forward[i];
}

/* The fit touches two opposite sides. Slide the eye until the other pair has equal margins too,
 * then let the wider pair set the slopes. Perspective makes this an iteration; three steps
 * settle it. */
static void centre(camera *c, const shape *mesh) {
    const double aspect = c->slope_x / c->slope_y;
    for (int step = 0; step < 4; ++step) {
        double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY}, far = 0;
        for (uint64_t i = 0; i < 3 * mesh->triangle_count; ++i) {
            const float *p = finite_corner(mesh, i);
            if (!p) continue;
            const double v[3] = {(double)p[0] - c->eye[0], (double)p[1] - c->eye[1],
                                 (double)p[2] - c->eye[2]};
            const double depth = dot(v, c->forward);
            const double at[2] = {dot(v, c->right) / depth, dot(v, c->up) / depth};
            for (int k = 0; k < 2; ++k) {
                lo[k] = fmin(lo[k], at[k]);
                hi[k] = fmax(hi[k], at[k]);
            }
            far = fmax(far, depth);
        }
        if (!(far > 0 && far < INFINITY)) return;
        if (step == 3) {
            const double a = fmax(hi[0], -lo[0]), b = fmax(hi[1], -lo[1]);
            c->slope_y = fmax(fmax(a / aspect, b), 1e-6);
            c->slope_x = c->slope_y * aspect;
            return;
        }
        for (int k = 0; k < 3; ++k)
            c->eye[k] += 0.4 * far * ((lo[0] + hi[0]) * c->right[k] + (lo[1] + hi[1]) * c->up[k]);
    }
}

static void set_slopes(camera *c, double fov, uint32_t width, uint32_t height) {
    c->slope_y = tan(fov * pi / 360);
    c->slope_x = c->slope_y * width / height;
}

static camera place_outside(const htree_box *box, const shape *mesh, int up, uint32_t width,
                            uint32_t height) {
    camera c = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 1, 1};
    const int side = up == 0 ? 1 : 0, front = 3 - up - side;
    const double tall = (double)box->hi[up] - (double)box->lo[up];
    const double wide = fmax((double)box->hi[side] - (double)box->lo[side],
                             (double)box->hi[front] - (double)box->lo[front]);
    /* Flat things are seen from higher up, where there is more of them to see. */
    const double flat = wide > 0 ? fmax(0, 1 - tall / wide) : 0;
    c.forward[up] = -0.28 - 0.45 * flat * flat;
    c.forward[side] = -0.35;
    c.forward[front] = up == 2 ? 1 : -1;
    make_basis(&c, up);
    set_slopes(&c, 36, width, height);
    frame(&c, mesh);
    centre(&c, mesh);
    /* Corners of the frame are empty around most shapes: come closer than the exact fit. */
    c.slope_x /= 1.07;
    c.slope_y /= 1.07;
    return c;
}

/* A person's view down the length of a room, from near one end and a little aside. */
static void stand_inside(const htree_box *box, int up, double *eye, double *look) {
    double extent[3];
    for (int i = 0; i < 3; ++i) extent[i] = (double)box->hi[i] - (double)box->lo[i];
    const int a = (up + 1) % 3, b = (up + 2) % 3, along = extent[a] > extent[b] ? a : b;
    for (int i = 0; i < 3; ++i) {
        const double from = i == up ? 0.42 : i == along ? 0.25 : 0.36;
        const double to = i == up ? 0.32 : i == along ? 0.7 : 0.56;
        eye[i] = (double)box->lo[i] + from * extent[i];
        look[i] = (double)box->lo[i] + to * extent[i];
    }
}

camera camera_place(const camera_wish *wish, const shape *mesh, uint32_t width, uint32_t height) {
    const htree_box box = mesh_bounds(mesh);
    if (wish->mode == CAMERA_OUTSIDE) return place_outside(&box, mesh, wish->up, width, height);
    camera c = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 1, 1};
    double look[3], fov = wish->fov > 0 ? wish->fov : 45;
    memcpy(c.eye, wish->eye, sizeof c.eye);
    memcpy(look, wish->look, sizeof look);
    if (wish->mode == CAMERA_INSIDE) {
        stand_inside(&box, wish->up, c.eye, look);
        fov = 70;
    }
    for (int i = 0; i < 3; ++i) c.forward[i] = look[i] - c.eye[i];
    make_basis(&c, wish->up);
    set_slopes(&c, fov, width, height);
    return c;
}

void camera_look(camera *out, const double *eye, const double *forward, const double *up,
                 double fov, double aspect) {
    memcpy(out->eye, eye, sizeof out->eye);
    memcpy(out->forward, forward, sizeof out->forward);
    make_basis(out, 1);
    double right[3];
    cross(out->forward, up, right);
    if (normalise(right)) {
        memcpy(out->right, right, sizeof right);
        cross(right, out->forward, out->up);
    }
    out->slope_y = tan(fov * pi / 360);
    out->slope_x = out->slope_y * aspect;
}

htree_ray camera_ray(const camera *c, double x, double y, uint32_t width, uint32_t height) {
    const double a = c->slope_x * (2 * x / width - 1), b = c->slope_y * (1 - 2 * y / height);
    htree_ray ray;
    for (int i = 0; i < 3; ++i) {
        ray.org[i] = (float)c->eye[i];
        ray.dir[i] = (float)(c->forward[i] + a * c->right[i] + b * c->up[i]);
    }
    ray.tmin = 0;
    ray.tmax = INFINITY;
    return ray;
}
