/* test_watertight.c: no ray through a shared edge or vertex of a closed mesh is lost.
 *
 * From a point well inside a closed mesh every ray hits, whatever it is aimed at. And a ray from
 * anywhere to a point well inside hits before it gets there, or the point would not be inside. */
#include "oracle.h"
#include "rays.h"

#include <math.h>

enum { INSIDE_POINTS = 64, BATCH = 4096 };

typedef struct closed {
    const char *name;
    htree_mesh mesh;
    htree_box box;
    float inside[INSIDE_POINTS][3];
} closed;

static uint64_t rays_shot, leaks_found;

/* ---- Points that are inside -------------------------------------------------------------------
 */

/* Parity of the surfaces that a ray in a random direction crosses. */
static bool is_odd(const oracle *o, const float *point, dice *d) {
    htree_ray ray;
    uint32_t crossings = 0;
    memcpy(ray.org, point, sizeof ray.org);
    random_unit(d, ray.dir);
    ray.tmin = 0;
    ray.tmax = INFINITY;
    for (htree_hit hit = oracle_closest(o, &ray); hit.prim != HTREE_NONE;
         hit = oracle_closest(o, &ray)) {
        ++crossings;
        ray.tmin = nextafterf(hit.t, INFINITY);
    }
    return crossings % 2 != 0;
}

static bool is_inside(const oracle *o, const float *point, dice *d) {
    for (int i = 0; i < 7; ++i) {
        if (!is_odd(o, point, d)) return false;
    }
    return true;
}

/* Steps from the middle of a triangle inwards, by half a side: well inside, or refused. */
static bool step_inside(const closed *c, const oracle *o, dice *d, float *out) {
    const uint64_t i = dice_below(d, (uint32_t)c->mesh.triangle_count);
    const float *const a = mesh_corner(&c->mesh, i, 0);
    const float *const b = mesh_corner(&c->mesh, i, 1);
    const float *const e = mesh_corner(&c->mesh, i, 2);
    double n[3], side = 0, length = 0;
    for (int k = 0; k < 3; ++k) {
        const int x = (k + 1) % 3, y = (k + 2) % 3;
        n[k] = ((double)b[x] - a[x]) * (e[y] - a[y]) - ((double)b[y] - a[y]) * (e[x] - a[x]);
        side += ((double)b[k] - a[k]) * (b[k] - a[k]);
        length += n[k] * n[k];
    }
    if (!(length > 0)) return false;
    const double step = sqrt(side / length) * (dice_below(d, 2) != 0 ? 0.25 : -0.25);
    for (int pass = 1; pass <= 2; ++pass) {
        for (int k = 0; k < 3; ++k) {
            out[k] = (a[k] + b[k] + e[k]) / 3 + (float)(n[k] * step * pass);
        }
        if (!is_inside(o, out, d)) return false; /* at half the way and at the end */
    }
    for (int k = 0; k < 3; ++k) out[k] -= (float)(n[k] * step * 0.5);
    return true;
}

static void find_inside(closed *c) {
    oracle o = oracle_of(&c->mesh);
    dice d = {23};
    uint32_t found = 0;
    for (uint32_t tries = 0; found < INSIDE_POINTS && tries < 20000; ++tries) {
        found += step_inside(c, &o, &d, c->inside[found]);
    }
    oracle_free(&o);
    if (found < INSIDE_POINTS) fail_msg("%s: only %u points inside", c->name, found);
}

/* ---- Rays -------------------------------------------------------------------------------------
 */

/* A point on an edge or a vertex, up to 3 ulp off. */
static void aim(const closed *c, dice *d, float *out) {
    const uint64_t i = dice_below(d, (uint32_t)c->mesh.triangle_count);
    const uint32_t side = dice_below(d, 3);
    const float *const a = mesh_corner(&c->mesh, i, side);
    const float *const b = mesh_corner(&c->mesh, i, (side + 1) % 3);
    const uint32_t how = dice_below(d, 8);
    const float s = how < 3 ? 0 : how == 3 ? 0.5f : dice_unit(d);
    for (int k = 0; k < 3; ++k) {
        const int ulps = how % 2 != 0 ? (int)dice_below(d, 7) - 3 : 0;
        out[k] = nudged(s == 0 ? a[k] : a[k] + s * (b[k] - a[k]), ulps);
    }
}

/* Scales dir by a power of two; a mesh of any size gives directions that count as valid. */
static void set_length(htree_ray *ray, int exponent) {
    float largest = 0;
    for (int k = 0; k < 3; ++k) largest = fmaxf(largest, fabsf(ray->dir[k]));
    int is = 0;
    (void)frexpf(largest, &is);
    if (is + exponent < -58) exponent = -is;
    if (is + exponent > 59) exponent = -is;
    for (int k = 0; k < 3; ++k) ray->dir[k] = ldexpf(ray->dir[k], exponent);
}

/* From inside, through the target; in every second ray the length of dir is far from 1. */
static void from_inside(const closed *c, dice *d, htree_ray *ray) {
    float target[3];
    const float *const org = c->inside[dice_below(d, INSIDE_POINTS)];
    do {
        aim(c, d, target);
        *ray = ray_through(org, target);
    } while (ray->dir[0] == 0 && ray->dir[1] == 0 && ray->dir[2] == 0);
    set_length(ray, dice_below(d, 2) != 0 ? 0 : (int)dice_below(d, 41) - 20);
}

static bool is_beyond(const htree_box *box, const float *p) {
    for (int k = 0; k < 3; ++k) {
        if (p[k] < box->lo[k] || p[k] > box->hi[k]) return true;
    }
    return false;
}

/* From beyond the target, 2 to 2^10 times as far away, through it to a point inside. From outside
 * the bounds it must hit before it reaches that point, at t = 1; else it hits where it leaves. */
static void from_outside(const closed *c, dice *d, htree_ray *ray) {
    float target[3], org[3];
    const float *const goal = c->inside[dice_below(d, INSIDE_POINTS)];
    aim(c, d, target);
    const float beyond = ldexpf(1 + dice_unit(d), 1 + (int)dice_below(d, 9));
    for (int k = 0; k < 3; ++k) org[k] = goal[k] + beyond * (target[k] - goal[k]);
    *ray = ray_through(org, goal);
    if (is_beyond(&c->box, org)) ray->tmax = 1;
}

typedef void make_ray(const closed *c, dice *d, htree_ray *ray);

static void show_leak(const closed *c, htree_kind kind, const htree_ray *ray) {
    if (++leaks_found > 5) return;
    print_message("leak: %s %s org %a %a %a dir %a %a %a\n", c->name, htree_kind_name(kind),
                  (double)ray->org[0], (double)ray->org[1], (double)ray->org[2],
                  (double)ray->dir[0], (double)ray->dir[1], (double)ray->dir[2]);
}

static void shoot(const closed *c, htree_kind kind, const htree *tree, make_ray *make,
                  uint64_t count, dice *d) {
    htree_ray *const rays = (htree_ray *)take(BATCH * sizeof *rays);
    htree_hit *const hits = (htree_hit *)take(BATCH * sizeof *hits);
    uint8_t *const any = (uint8_t *)take(BATCH);
    for (uint64_t done = 0; done < count;) {
        const uint64_t size = count - done < BATCH ? count - done : BATCH;
        for (uint64_t i = 0; i < size; ++i) make(c, d, &rays[i]);
        assert_int_equal(htree_intersect(tree, rays, size, hits, NULL), HTREE_OK);
        assert_int_equal(htree_occluded(tree, rays, size, any, NULL), HTREE_OK);
        for (uint64_t i = 0; i < size; ++i) {
            if (hits[i].prim == HTREE_NONE || any[i] != 1) show_leak(c, kind, &rays[i]);
        }
        rays_shot += size;
        done += size;
    }
    free(rays);
    free(hits);
    free(any);
}

static void prove(closed *c, uint64_t rays_per_kind) {
    dice d = {17};
    c->box = ray_target_of(&c->mesh).box;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&c->mesh, kind);
        shoot(c, kind, tree, from_inside, rays_per_kind * 2 / 3, &d);
        shoot(c, kind, tree, from_outside, rays_per_kind / 3, &d);
        htree_free(tree);
    }
}

static void report(void) {
    say("%llu rays at edges and vertices, %llu leaks", (unsigned long long)rays_shot,
        (unsigned long long)leaks_found);
    tally("rays at edges and vertices", rays_shot);
    const uint64_t leaks = leaks_found;
    rays_shot = leaks_found = 0;
    assert_int_equal(leaks, 0);
}

static void prove_shape(const char *name, uint64_t triangles, const float *offset, float scale,
                        uint64_t rays) {
    shape s = shape_of(name, triangles, 1);
    for (uint64_t i = 0; i < 3 * s.vertex_count; ++i) {
        s.positions[i] = s.positions[i] * scale + offset[i % 3];
    }
    closed c = {name, mesh_of(&s), {{0}, {0}}, {{0}}};
    find_inside(&c);
    prove(&c, scaled(rays));
    shape_free(&s);
}

/* What is inside stays inside when space is stretched. */
static void prove_stretched(const char *name, uint64_t triangles, const float *by, uint64_t rays) {
    shape s = shape_of(name, triangles, 1);
    closed c = {name, mesh_of(&s), {{0}, {0}}, {{0}}};
    find_inside(&c);
    for (uint64_t i = 0; i < 3 * s.vertex_count; ++i) s.positions[i] *= by[i % 3];
    for (uint32_t i = 0; i < 3 * INSIDE_POINTS; ++i) c.inside[i / 3][i % 3] *= by[i % 3];
    prove(&c, scaled(rays));
    shape_free(&s);
}

/* ---- The claims -------------------------------------------------------------------------------
 */

static const float nowhere[3] = {0, 0, 0};

static void no_ray_leaks_from_a_sphere(void **state) {
    (void)state;
    prove_shape("sphere", 300, nowhere, 1, 100000);
    prove_shape("sphere", 5000, nowhere, 1, 100000);
    report();
}

static void no_ray_leaks_from_a_dense_sphere(void **state) {
    (void)state;
    prove_shape("sphere", scaled(100) < 20 ? 5000 : 50000, nowhere, 1, 100000);
    report();
}

/* Stretched until triangles are needles along one axis, and blades across it. */
static void no_ray_leaks_from_needles(void **state) {
    static const float needles[3] = {1, 4096, 1}, blades[3] = {1, 0.001f, 1};
    (void)state;
    prove_stretched("sphere", 1000, needles, 100000);
    prove_stretched("knot", 1000, blades, 100000);
    report();
}

static void no_ray_leaks_from_a_knot(void **state) {
    (void)state;
    prove_shape("knot", 3000, nowhere, 1, 200000);
    report();
}

static void no_ray_leaks_far_from_the_origin(void **state) {
    static const float offset[3] = {148376, 1234, -223423};
    (void)state;
    prove_shape("far", 3000, nowhere, 1, 150000);
    prove_shape("sphere", 1000, offset, 10, 150000);
    report();
}

static void no_ray_leaks_from_tiny_and_huge_meshes(void **state) {
    (void)state;
    prove_shape("sphere", 300, nowhere, 1e-15f, 50000);
    prove_shape("knot", 3000, nowhere, 1e12f, 50000);
    report();
}

/* A cube of SIDE x SIDE quads a face with shared vertices: flat boxes, exact coincidences. */
static void make_cube(float *xyz, uint32_t *indices, uint32_t side) {
    const uint32_t row = side + 1, face_vertices = row * row;
    for (uint32_t face = 0; face < 6; ++face) {
        const uint32_t axis = face / 2, first = face * face_vertices;
        for (uint32_t i = 0; i < face_vertices; ++i, xyz += 3) {
            xyz[axis] = (float)(face % 2 * side);
            xyz[(axis + 1) % 3] = (float)(i % row);
            xyz[(axis + 2) % 3] = (float)(i / row);
        }
        for (uint32_t q = 0; q < side * side; ++q, indices += 6) {
            const uint32_t at = first + q / side * row + q % side;
            const uint32_t corners[6] = {at, at + 1, at + row, at + 1, at + row + 1, at + row};
            memcpy(indices, corners, sizeof corners);
        }
    }
}

static void no_ray_leaks_from_a_cube(void **state) {
    enum { SIDE = 8 };
    static float xyz[6 * (SIDE + 1) * (SIDE + 1) * 3];
    static uint32_t indices[6 * SIDE * SIDE * 6];
    (void)state;
    make_cube(xyz, indices, SIDE);
    closed c;
    memset(&c, 0, sizeof c);
    c.name = "cube";
    c.mesh.positions = xyz;
    c.mesh.vertex_count = COUNT_OF(xyz) / 3;
    c.mesh.indices = indices;
    c.mesh.triangle_count = COUNT_OF(indices) / 3;
    find_inside(&c);
    prove(&c, scaled(200000));
    report();
}

/* Every vertex of the cube's grid from every half-integer point inside it. */
static void no_lattice_ray_leaks_from_a_cube(void **state) {
    enum { SIDE = 4 };
    static float xyz[6 * (SIDE + 1) * (SIDE + 1) * 3];
    static uint32_t indices[6 * SIDE * SIDE * 6];
    (void)state;
    make_cube(xyz, indices, SIDE);
    htree_mesh mesh = {0};
    mesh.positions = xyz;
    mesh.vertex_count = COUNT_OF(xyz) / 3;
    mesh.indices = indices;
    mesh.triangle_count = COUNT_OF(indices) / 3;
    closed c = {"cube", mesh, {{0}, {0}}, {{0}}};
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&mesh, kind);
        for (uint32_t i = 0; i < 7 * 7 * 7; ++i) {
            const float org[3] = {0.5f + 0.5f * (float)(i % 7), 0.5f + 0.5f * (float)(i / 7 % 7),
                                  0.5f + 0.5f * (float)(i / 49)};
            for (uint32_t v = 0; v < COUNT_OF(xyz); v += 3) {
                const htree_ray ray = ray_through(org, xyz + v);
                htree_hit hit;
                assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
                if (hit.prim == HTREE_NONE || fabsf(hit.t - 1) > 1e-6f) show_leak(&c, kind, &ray);
                ++rays_shot;
            }
        }
        htree_free(tree);
    }
    report();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_ray_leaks_from_a_sphere),
        cmocka_unit_test(no_ray_leaks_from_a_dense_sphere),
        cmocka_unit_test(no_ray_leaks_from_needles),
        cmocka_unit_test(no_ray_leaks_from_a_knot),
        cmocka_unit_test(no_ray_leaks_far_from_the_origin),
        cmocka_unit_test(no_ray_leaks_from_tiny_and_huge_meshes),
        cmocka_unit_test(no_ray_leaks_from_a_cube),
        cmocka_unit_test(no_lattice_ray_leaks_from_a_cube),
    };
    return cmocka_run_group_tests_name("watertight", tests, NULL, NULL);
}
