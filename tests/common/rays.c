/* rays.c: one short function for each family, and the table of them. */
#include "rays.h"

#include <math.h>

/* ---- Targets and small tools ---------------------------------------------------------------- */

static bool is_finite_point(const float *p) {
    for (int i = 0; i < 3; ++i) {
        if (!(fabsf(p[i]) <= HTREE_COORDINATE_MAX)) return false;
    }
    return true;
}

ray_target ray_target_of(const htree_mesh *mesh) {
    ray_target target = {
        mesh, {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}}, 0};
    for (uint64_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const float *const p = mesh_corner(mesh, i / 3, (uint32_t)(i % 3));
        if (!is_finite_point(p)) continue;
        for (int k = 0; k < 3; ++k) {
            target.box.lo[k] = fminf(target.box.lo[k], p[k]);
            target.box.hi[k] = fmaxf(target.box.hi[k], p[k]);
        }
    }
    for (int k = 0; k < 3; ++k) {
        if (!(target.box.lo[k] <= target.box.hi[k])) {
            target.box.lo[k] = -1;
            target.box.hi[k] = 1;
        }
        target.size = fmaxf(target.size, target.box.hi[k] - target.box.lo[k]);
    }
    if (target.size == 0) target.size = 1;
    return target;
}

void random_unit(dice *d, float *out) {
    float square = 0;
    do {
        for (int k = 0; k < 3; ++k) out[k] = dice_between(d, -1, 1);
        square = out[0] * out[0] + out[1] * out[1] + out[2] * out[2];
    } while (square < 0.01f || square > 1);
    const float length = sqrtf(square);
    for (int k = 0; k < 3; ++k) out[k] /= length;
}

void random_in_box(const htree_box *box, float margin, dice *d, float *out) {
    for (int k = 0; k < 3; ++k) out[k] = dice_between(d, box->lo[k] - margin, box->hi[k] + margin);
}

/* The corners of a random triangle, or of the box if there is none. */
static void random_triangle(const ray_target *target, dice *d, const float *corner[3]) {
    const uint32_t i = dice_below(d, (uint32_t)target->mesh->triangle_count);
    for (uint32_t k = 0; k < 3; ++k) {
        const bool some = target->mesh->triangle_count > 0;
        corner[k] = some ? mesh_corner(target->mesh, i, k) : target->box.lo;
    }
}

static void random_on_triangle(const float *const corner[3], dice *d, float *out) {
    const float s = sqrtf(dice_unit(d));
    const float u = dice_unit(d) * s;
    for (int k = 0; k < 3; ++k) {
        out[k] = (1 - s) * corner[0][k] + (s - u) * corner[1][k] + u * corner[2][k];
    }
}

htree_ray ray_through(const float *org, const float *point) {
    htree_ray ray;
    for (int k = 0; k < 3; ++k) {
        ray.org[k] = org[k];
        ray.dir[k] = point[k] - org[k];
    }
    ray.tmin = 0;
    ray.tmax = INFINITY;
    return ray;
}

static int few_ulps(dice *d) {
    return (int)dice_below(d, 7) - 3;
}

static float signed_zero(dice *d) {
    return dice_below(d, 2) != 0 ? 0.0f : -0.0f;
}

/* ---- Families ------------------------------------------------------------------------------- */

typedef void ray_family(const ray_target *target, dice *d, uint64_t index, htree_ray *ray);

static void make_random(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    (void)index;
    random_in_box(&target->box, target->size * 0.25f, d, ray->org);
    random_unit(d, ray->dir);
    ray->tmin = 0;
    ray->tmax = dice_below(d, 2) != 0 ? INFINITY : target->size * dice_unit(d);
}

/* A pinhole camera on a corner of the box's surroundings, 64 rays a row. */
static void make_camera(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    const float x = (float)(index % 64) / 32.0f - 1, y = (float)(index / 64 % 64) / 32.0f - 1;
    float eye[3], point[3];
    (void)d;
    for (int k = 0; k < 3; ++k) {
        eye[k] = target->box.hi[k] + target->size * (0.5f + 0.2f * (float)k);
        point[k] = 0.5f * (target->box.lo[k] + target->box.hi[k]);
    }
    point[0] += 0.5f * target->size * x;
    point[1] += 0.5f * target->size * y;
    *ray = ray_through(eye, point);
}

/* Nearly in the plane of a triangle: off by 2^-1 to 2^-24 of the direction, or not at all. */
static void make_grazing(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    const float *corner[3];
    float a[3], b[3], off[3];
    (void)index;
    random_triangle(target, d, corner);
    random_on_triangle(corner, d, a);
    random_on_triangle(corner, d, b);
    random_unit(d, off);
    const float tilt = dice_below(d, 4) == 0 ? 0 : ldexpf(1, -(int)dice_below(d, 25));
    for (int k = 0; k < 3; ++k) {
        const float along = b[k] - a[k];
        ray->dir[k] = along + off[k] * tilt * target->size * 0.1f;
        ray->org[k] = a[k] - ray->dir[k] * dice_between(d, 0, 4);
    }
    ray->tmin = 0;
    ray->tmax = INFINITY;
}

static void make_axis(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    const uint32_t axis = dice_below(d, 3);
    (void)index;
    random_in_box(&target->box, target->size * 0.1f, d, ray->org);
    for (int k = 0; k < 3; ++k) ray->dir[k] = signed_zero(d);
    const bool up = dice_below(d, 2) != 0;
    ray->dir[axis] = up ? 1.0f : -1.0f;
    if (dice_below(d, 4) != 0) {
        ray->org[axis] =
            up ? target->box.lo[axis] - target->size : target->box.hi[axis] + target->size;
    }
    ray->tmin = 0;
    ray->tmax = INFINITY;
}

static void make_edges(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    const float *corner[3];
    float org[3], point[3];
    (void)index;
    random_triangle(target, d, corner);
    random_in_box(&target->box, target->size * 0.5f, d, org);
    const uint32_t side = dice_below(d, 3);
    const float s = dice_below(d, 4) == 0 ? 0.5f : dice_unit(d);
    for (int k = 0; k < 3; ++k) {
        const float a = corner[side][k], b = corner[(side + 1) % 3][k];
        point[k] = nudged(a + s * (b - a), few_ulps(d));
    }
    *ray = ray_through(org, point);
}

static void make_vertices(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    const float *corner[3];
    float org[3], point[3];
    (void)index;
    random_triangle(target, d, corner);
    random_in_box(&target->box, target->size * 0.5f, d, org);
    const bool exact = dice_below(d, 2) != 0;
    for (int k = 0; k < 3; ++k) point[k] = nudged(corner[0][k], exact ? 0 : few_ulps(d));
    *ray = ray_through(org, point);
}

/* Starts at a corner or at a point of a triangle; tmin is 0, so the surface itself may be hit. */
static void make_surface(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    const float *corner[3];
    (void)index;
    random_triangle(target, d, corner);
    if (dice_below(d, 3) == 0) {
        memcpy(ray->org, corner[0], sizeof ray->org);
    } else {
        random_on_triangle(corner, d, ray->org);
    }
    random_unit(d, ray->dir);
    ray->tmin = signed_zero(d);
    ray->tmax = dice_below(d, 8) == 0 ? 0 : INFINITY;
}

/* Intervals around a point known to be near t = 1: empty, a single t, negative, unbounded. */
static void make_intervals(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    static const float ends[] = {-INFINITY, -2, -1, -0.0f, 0, 0.5f, 1, 1, 2, INFINITY};
    const float *corner[3];
    float org[3], point[3];
    (void)index;
    random_triangle(target, d, corner);
    random_on_triangle(corner, d, point);
    random_in_box(&target->box, target->size * 0.5f, d, org);
    *ray = ray_through(org, point);
    if (dice_below(d, 2) != 0) {
        for (int k = 0; k < 3; ++k) ray->dir[k] = -ray->dir[k];
    }
    const float end = ends[dice_below(d, COUNT_OF(ends))]; /* arguments have no order */
    ray->tmin = nudged(end, few_ulps(d));
    ray->tmax = dice_below(d, 4) == 0 ? ray->tmin : ends[dice_below(d, COUNT_OF(ends))];
}

/* One field, or all, of a good ray replaced by a value that is no number of a ray. */
static void make_invalid(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    static const float values[] = {NAN,     -NAN,   INFINITY, -INFINITY, 0,         -0.0f,
                                   1e30f,   -1e30f, 3.4e38f,  1e-40f,    1.17e-38f, 1e-19f,
                                   1.2e18f, 1e18f,  1,        -1};
    float fields[8];
    make_random(target, d, index, ray);
    memcpy(fields, ray, sizeof fields);
    if (dice_below(d, 2) != 0) {
        fields[dice_below(d, 8)] = values[dice_below(d, COUNT_OF(values))];
    } else {
        for (int k = 0; k < 8; ++k) fields[k] = values[dice_below(d, COUNT_OF(values))];
    }
    memcpy(ray, fields, sizeof fields);
}

/* Runs inside a plane in which corners, and so faces of boxes, lie. */
static void make_faces(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    const float *corner[3];
    (void)index;
    random_triangle(target, d, corner);
    random_in_box(&target->box, target->size * 0.25f, d, ray->org);
    random_unit(d, ray->dir);
    const uint32_t axis = dice_below(d, 3);
    for (uint32_t k = 0; k < 3; ++k) {
        if (k != axis && dice_below(d, 2) != 0) continue;
        ray->org[k] = dice_below(d, 4) == 0 ? target->box.lo[k] : corner[dice_below(d, 3)][k];
        ray->dir[k] = signed_zero(d);
    }
    ray->tmin = 0;
    ray->tmax = INFINITY;
}

static void make_far(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    float away[3], point[3], org[3];
    (void)index;
    random_in_box(&target->box, 0, d, point);
    random_unit(d, away);
    const float distance = target->size * ldexpf(1, (int)dice_below(d, 21));
    for (int k = 0; k < 3; ++k) org[k] = point[k] + distance * away[k];
    *ray = ray_through(org, point);
}

/* Directions of any length that is allowed, and a little beyond; components may underflow to 0. */
static void make_lengths(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    make_edges(target, d, index, ray);
    float largest = fmaxf(fabsf(ray->dir[0]), fmaxf(fabsf(ray->dir[1]), fabsf(ray->dir[2])));
    int exponent = 0;
    if (!(largest > 0 && largest < INFINITY)) largest = 1;
    (void)frexpf(largest, &exponent);
    const int wanted = (int)dice_below(d, 125) - 62;
    for (int k = 0; k < 3; ++k) ray->dir[k] = ldexpf(ray->dir[k], wanted - exponent);
}

/* Small whole numbers: ties and exact coincidences are the rule. */
static void make_lattice(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    (void)index;
    for (int k = 0; k < 3; ++k) {
        const float step = (target->box.hi[k] - target->box.lo[k]) * 0.25f;
        ray->org[k] = target->box.lo[k] + step * (float)((int)dice_below(d, 9) - 2);
        ray->dir[k] = (float)((int)dice_below(d, 5) - 2);
    }
    ray->tmin = 0;
    ray->tmax = INFINITY;
}

static void make_bits(const ray_target *target, dice *d, uint64_t index, htree_ray *ray) {
    uint32_t words[8];
    (void)target;
    (void)index;
    for (int k = 0; k < 8; ++k) words[k] = dice_u32(d);
    memcpy(ray, words, sizeof words);
}

static const struct {
    const char *name;
    ray_family *make;
} families[RAY_FAMILIES] = {
    {"random", make_random},   {"camera", make_camera},
    {"grazing", make_grazing}, {"axis", make_axis},
    {"edges", make_edges},     {"vertices", make_vertices},
    {"surface", make_surface}, {"intervals", make_intervals},
    {"invalid", make_invalid}, {"faces", make_faces},
    {"far", make_far},         {"lengths", make_lengths},
    {"lattice", make_lattice}, {"bits", make_bits},
};

const char *ray_family_name(uint32_t family) {
    return families[family].name;
}

void rays_make(const ray_target *target, uint32_t family, dice *d, htree_ray *rays,
               uint64_t count) {
    for (uint64_t i = 0; i < count; ++i) families[family].make(target, d, i, &rays[i]);
}

void rays_make_mixed(const ray_target *target, dice *d, htree_ray *rays, uint64_t count) {
    for (uint64_t i = 0; i < count; ++i) {
        families[i % RAY_FAMILIES].make(target, d, i / RAY_FAMILIES, &rays[i]);
    }
}
