/* test_exact.c: the triangle test against 113 bits, on triangles and rays of any shape and size, with a
 * margin that is proved and no case left out.
 *
 * With e = 2^-24, a corner at distance (x, y, z) from the origin, and the shear s = d / d_z, |s| <= 1,
 * of the ray's axis z, the test computes X = x - s z and Y alike in float. Each of x, z, s, s z and the
 * difference is rounded once, so X is off by less than
 *
 *     m = (1 + 2^-20) e (|x| + 3 |s z| + |X|) + 2^-140 (1 + |z|)
 *
 * where the last term is for quotients and products that underflow, and z is off by e |z|. All that follows is done in
 * double, whose 2^-52 the factor covers. The test therefore gives the exact answer for corners moved by
 * at most m across the ray and e |z| along it. Hence, U being the exact edge functions and B what moving
 * their corners by m can change them by:
 *
 *  - a hit means that all U are above -B, or that all are below B;
 *  - a miss means that not all U are above B, nor all below -B;
 *  - the hit's u and v name a point within m of the ray, and its t dz is within
 *    m (|g_x| + |g_y|) + 2 e |z| of the plane's z there, g being the plane's gradient. */
#include "suite.h"
#include "trace/triangle.h"

#include <math.h>

#ifdef __SIZEOF_FLOAT128__

__extension__ typedef __float128 real;

static const real unit = 5.9604644775390625e-8; /* e */
static const real slack = 1.00000095367431640625;
static const real tiny = 7.17464813734306340312949466444e-43; /* 2^-140 */

static real magnitude(real x) {
    return x < 0 ? -x : x;
}

static real larger(real a, real b) {
    return a > b ? a : b;
}

/* A corner seen from the ray, exact but for 113 bits, and how far the test may move it. */
typedef struct seen {
    real x, y, z, mx, my, mz;
} seen;

typedef struct exact_case {
    htree_ray ray;
    float corner[3][3];
    seen c[3];
    real edge[3], bound[3];
} exact_case;

static seen see(const htree_ray *ray, const ht_shear *shear, const float *corner) {
    const real sx = (real)ray->dir[shear->kx] / ray->dir[shear->kz];
    const real sy = (real)ray->dir[shear->ky] / ray->dir[shear->kz];
    const real x = (real)corner[shear->kx] - ray->org[shear->kx];
    const real y = (real)corner[shear->ky] - ray->org[shear->ky];
    const real z = (real)corner[shear->kz] - ray->org[shear->kz];
    const real small = tiny * (1 + magnitude(z));
    seen s = {x - sx * z, y - sy * z, z, 0, 0, 0};
    s.mx = slack * unit * (magnitude(x) + 3 * magnitude(sx * z) + magnitude(s.x)) + small;
    s.my = slack * unit * (magnitude(y) + 3 * magnitude(sy * z) + magnitude(s.y)) + small;
    s.mz = slack * unit * magnitude(z) + tiny;
    return s;
}

static void solve(exact_case *e, const ht_shear *shear) {
    for (int i = 0; i < 3; ++i) e->c[i] = see(&e->ray, shear, e->corner[i]);
    for (int i = 0; i < 3; ++i) {
        const seen *const p = &e->c[(i + 2) % 3], *const q = &e->c[(i + 1) % 3];
        e->edge[i] = p->x * q->y - p->y * q->x;
        e->bound[i] =
            slack * (p->mx * magnitude(q->y) + p->my * magnitude(q->x) + q->mx * magnitude(p->y) +
                     q->my * magnitude(p->x) + p->mx * q->my + p->my * q->mx);
    }
}

/* Whether all edge functions are on one side of that many bounds. */
static bool is_inside(const exact_case *e, int bounds) {
    bool above = true, below = true;
    for (int i = 0; i < 3; ++i) {
        above = above && e->edge[i] > bounds * e->bound[i];
        below = below && e->edge[i] < -bounds * e->bound[i];
    }
    return above || below;
}

/* ---- Where a hit is ------------------------------------------------------------------------- */

static void check_point(const exact_case *e, const htree_hit *hit) {
    const real weight[3] = {1 - (real)hit->u - hit->v, hit->u, hit->v};
    real x = 0, y = 0, mx = 0, my = 0;
    for (int i = 0; i < 3; ++i) {
        x += weight[i] * e->c[i].x;
        y += weight[i] * e->c[i].y;
        /* u and v are rounded as well. */
        mx = larger(mx, e->c[i].mx + 4 * unit * magnitude(e->c[i].x));
        my = larger(my, e->c[i].my + 4 * unit * magnitude(e->c[i].y));
    }
    assert_true(magnitude(x) <= 2 * mx && magnitude(y) <= 2 * my);
}

/* Returns false where the triangle is seen so much edge-on that its plane says nothing. */
static bool check_distance(const exact_case *e, const ht_shear *shear, const htree_hit *hit) {
    const seen *const a = &e->c[0], *const b = &e->c[1], *const c = &e->c[2];
    const real det = e->edge[0] + e->edge[1] + e->edge[2];
    real mx = 0, my = 0, mz = 0;
    for (int i = 0; i < 3; ++i) {
        mx = larger(mx, e->c[i].mx);
        my = larger(my, e->c[i].my);
        mz = larger(mz, e->c[i].mz);
    }
    const real z = (real)hit->t * shear->dz;
    /* Between the corners, whatever the plane. */
    assert_true(z <= larger(larger(a->z, b->z), c->z) + 3 * mz + tiny);
    assert_true(-z <= larger(larger(-a->z, -b->z), -c->z) + 3 * mz + tiny);
    if (det == 0) return false;
    const real gx = ((b->z - a->z) * (c->y - a->y) - (c->z - a->z) * (b->y - a->y)) /
                    ((b->x - a->x) * (c->y - a->y) - (c->x - a->x) * (b->y - a->y));
    const real gy = ((c->z - a->z) * (b->x - a->x) - (b->z - a->z) * (c->x - a->x)) /
                    ((b->x - a->x) * (c->y - a->y) - (c->x - a->x) * (b->y - a->y));
    const real should = a->z - gx * a->x - gy * a->y;
    const real most =
        slack * (magnitude(gx) * mx + magnitude(gy) * my + mz + unit * magnitude(z)) + tiny;
    assert_true(magnitude(z - should) <= most + tiny * magnitude(shear->dz));
    return true;
}

/* ---- Cases ---------------------------------------------------------------------------------- */

static float scattered(dice *d, int exponent) {
    return ldexpf(dice_between(d, -1, 1), exponent);
}

/* A triangle of any size and shape, anywhere; three in eight are slivers or needles. */
static void draw_triangle(dice *d, exact_case *e) {
    const int where = (int)dice_below(d, 41) - 20, size = where - (int)dice_below(d, 20);
    const uint32_t form = dice_below(d, 8);
    float middle[3];
    for (int k = 0; k < 3; ++k) middle[k] = scattered(d, where);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) e->corner[i][k] = middle[k] + scattered(d, size);
    for (int k = 0; k < 3 && form < 3; ++k) {
        const float s = form == 0 ? 0 : dice_unit(d), *const p = e->corner[0];
        e->corner[2][k] = p[k] + s * (e->corner[1][k] - p[k]) + scattered(d, size - 12);
    }
}

/* Aimed at a corner, at an edge, or inside, by up to 3 ulp off; or along the plane. */
static void draw_ray(dice *d, exact_case *e) {
    float weight[3] = {dice_unit(d), dice_unit(d), dice_unit(d)};
    const uint32_t how = dice_below(d, 8);
    if (how < 4) weight[dice_below(d, 3)] = 0;
    if (how < 2) weight[0] = weight[1] = 0;
    const float sum = weight[0] + weight[1] + weight[2];
    const int away = (int)dice_below(d, 30) - 10, ulps = (int)dice_below(d, 7) - 3;
    for (int k = 0; k < 3; ++k) {
        const float at = sum > 0 ? (weight[0] * e->corner[0][k] + weight[1] * e->corner[1][k] +
                                    weight[2] * e->corner[2][k]) /
                                       sum
                                 : e->corner[2][k];
        const float side = e->corner[1][k] - e->corner[0][k];
        e->ray.org[k] = at + (how == 7 ? 3 * side + scattered(d, away - 20) : scattered(d, away));
        e->ray.dir[k] = nudged(at - e->ray.org[k], how == 6 ? 0 : ulps);
        if (how == 5 && dice_below(d, 2)) e->ray.dir[k] = 0;
    }
    e->ray.tmin = -INFINITY;
    e->ray.tmax = INFINITY;
}

static void every_decision_is_within_the_margin(void **state) {
    const uint64_t count = scaled(2000000);
    uint64_t hits = 0, sure = 0, distances = 0, done = 0;
    dice d = {77};
    (void)state;
    while (done < count) {
        exact_case e;
        htree_hit hit = {0, 0, 0, 0};
        ht_shear shear;
        draw_triangle(&d, &e);
        draw_ray(&d, &e);
        if (!ht_shear_init(&shear, &e.ray)) continue;
        const bool is_hit = ht_triangle_intersect(&shear, e.corner[0], e.corner[1], e.corner[2],
                                                  -INFINITY, INFINITY, &hit);
        solve(&e, &shear);
        const bool surely_in = is_inside(&e, 1), surely_out = !is_inside(&e, -1);
        if (is_hit ? surely_out : surely_in)
            fail_msg("case %llu: %s", (unsigned long long)done, is_hit ? "hit" : "missed");
        sure += surely_in || surely_out;
        hits += is_hit;
        if (is_hit) check_point(&e, &hit);
        if (is_hit) distances += check_distance(&e, &shear, &hit);
        ++done;
    }
    say("%llu rays, %llu hits, %llu decided beyond the margin, %llu distances, 0 wrong",
        (unsigned long long)done, (unsigned long long)hits, (unsigned long long)sure,
        (unsigned long long)distances);
    assert_true(hits > done / 4 && sure > done / 4);
}

#else

static void every_decision_is_within_the_margin(void **state) {
    (void)state;
    say("skipped: this compiler has no __float128");
}

#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_decision_is_within_the_margin),
    };
    return cmocka_run_group_tests_name("exact", tests, NULL, NULL);
}
