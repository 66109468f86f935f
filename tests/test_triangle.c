/* test_triangle.c: the triangle test against exact arithmetic: corners, origins and directions are small
 * whole numbers, so that 64-bit integers decide without rounding who is hit and where.
 *
 * The test moves a corner by at most 6 e D across the ray (lib/trace/ray.h). Along an axis it moves none:
 * there every decision must be the exact one, on edges and corners too. */
#include "suite.h"
#include "trace/triangle.h"

#include <math.h>

enum { RANGE = 512 }; /* of coordinates: a product of four differences stays below 2^63 */

typedef struct whole_case {
    int64_t corner[3][3], org[3], dir[3];
} whole_case;

/* Signed volumes of the three edges with the ray: the exact edge functions, times dir[kz]. */
typedef struct exact_answer {
    int64_t edge[3], sum;
    double t; /* of the plane, in double: right to its last bits */
} exact_answer;

static int64_t triple(const int64_t *d, const int64_t *p, const int64_t *q) {
    return d[0] * (p[1] * q[2] - p[2] * q[1]) + d[1] * (p[2] * q[0] - p[0] * q[2]) +
           d[2] * (p[0] * q[1] - p[1] * q[0]);
}

static exact_answer solve(const whole_case *w) {
    int64_t p[3][3];
    exact_answer answer;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) p[i][k] = w->corner[i][k] - w->org[k];
    for (int i = 0; i < 3; ++i) answer.edge[i] = triple(w->dir, p[(i + 1) % 3], p[(i + 2) % 3]);
    answer.sum = answer.edge[0] + answer.edge[1] + answer.edge[2];
    answer.t = (double)triple(p[0], p[1], p[2]) / (double)answer.sum;
    return answer;
}

static whole_case draw(dice *d, bool along_axis, int64_t range) {
    whole_case w;
    const uint32_t axis = dice_below(d, 3);
    const uint32_t wide = (uint32_t)(2 * range + 1);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) w.corner[i][k] = (int64_t)dice_below(d, wide) - range;
    for (uint32_t k = 0; k < 3; ++k) {
        w.org[k] = (int64_t)dice_below(d, wide) - range;
        w.dir[k] = (int64_t)dice_below(d, wide) - range;
        if (along_axis) w.dir[k] = k == axis ? (dice_below(d, 2) ? 3 : -5) : 0;
    }
    return w;
}

static bool is_zero(const int64_t *v) {
    return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

static bool test_hits(const whole_case *w, htree_hit *hit) {
    htree_ray ray;
    float corner[3][3];
    ht_shear shear;
    for (int k = 0; k < 3; ++k) {
        ray.org[k] = (float)w->org[k];
        ray.dir[k] = (float)w->dir[k];
        for (int i = 0; i < 3; ++i) corner[i][k] = (float)w->corner[i][k];
    }
    ray.tmin = -INFINITY;
    ray.tmax = INFINITY;
    const bool valid = ht_shear_init(&shear, &ray);
    assert_true(valid);
    return valid &&
           ht_triangle_intersect(&shear, corner[0], corner[1], corner[2], ray.tmin, ray.tmax, hit);
}

static int64_t magnitude(int64_t x) {
    return x < 0 ? -x : x;
}

/* 1: hit, 0: missed, -1: nearer to an edge than the pads promise to decide. */
static int expect(const whole_case *w, const exact_answer *exact, bool along_axis) {
    int64_t main_axis = 0, least = INT64_MAX;
    bool positive = false, negative = false;
    for (int i = 0; i < 3; ++i) {
        if (magnitude(w->dir[i]) > main_axis) main_axis = magnitude(w->dir[i]);
        if (magnitude(exact->edge[i]) < least) least = magnitude(exact->edge[i]);
        positive = positive || exact->edge[i] > 0;
        negative = negative || exact->edge[i] < 0;
    }
    /* An edge function moves by 2 * 6 e D times the largest sheared coordinate, 2 D, twice. */
    const double reach = 2.0 * RANGE;
    const double unsure = 48 * 5.9604644775390625e-8 * reach * reach * (double)main_axis;
    if (!along_axis && (double)least <= unsure) return -1;
    return exact->sum != 0 && !(positive && negative);
}

/* The hit lies in the triangle's plane: t may be off by what the pads allow, along the normal. */
static void check_distance(const whole_case *w, const htree_hit *hit, bool along_axis,
                           const exact_answer *exact) {
    double normal[3], length = 0, off = 0;
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        normal[k] =
            (double)((w->corner[1][a] - w->corner[0][a]) * (w->corner[2][b] - w->corner[0][b]) -
                     (w->corner[1][b] - w->corner[0][b]) * (w->corner[2][a] - w->corner[0][a]));
        length += normal[k] * normal[k];
        off += normal[k] *
               ((double)(w->org[k] - w->corner[0][k]) + (double)hit->t * (double)w->dir[k]);
    }
    assert_true(fabs(off) <= sqrt(length) * 16 * 5.9604644775390625e-8 * 2 * RANGE);
    if (along_axis) assert_true(hit->t == (float)exact->t);
}

static void compare(bool along_axis, int64_t range, uint64_t wanted, const char *what) {
    dice d = {(uint64_t)range};
    uint64_t hits = 0, unsure = 0;
    for (uint64_t i = 0; i < wanted; ++i) {
        const whole_case w = draw(&d, along_axis, range);
        if (is_zero(w.dir)) continue;
        const exact_answer exact = solve(&w);
        const int expected = expect(&w, &exact, along_axis);
        htree_hit hit;
        const bool is_hit = test_hits(&w, &hit);
        if (expected < 0) ++unsure;
        if (expected >= 0) assert_int_equal(is_hit, expected);
        if (expected == 1) check_distance(&w, &hit, along_axis, &exact);
        hits += is_hit;
    }
    say("%s: %llu rays, %llu hits, %llu too near to an edge to say, 0 wrong", what,
        (unsigned long long)wanted, (unsigned long long)hits, (unsigned long long)unsure);
}

static void rays_along_an_axis_are_decided_exactly(void **state) {
    (void)state;
    compare(true, 4, scaled(2000000), "along an axis, edges and corners often");
    compare(true, RANGE, scaled(1000000), "along an axis");
}

static void rays_in_any_direction_are_decided_within_the_pads(void **state) {
    (void)state;
    compare(false, RANGE, scaled(3000000), "in any direction");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_along_an_axis_are_decided_exactly),
        cmocka_unit_test(rays_in_any_direction_are_decided_within_the_pads),
    };
    return cmocka_run_group_tests_name("triangle", tests, NULL, NULL);
}
