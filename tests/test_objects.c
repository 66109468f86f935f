/* test_objects.c: objects known by box and callback, alone and among triangles, equal the
 * oracle. */
#include "oracle.h"
#include "rays.h"

#include <math.h>

typedef struct ball {
    float center[3];
    float radius;
} ball;

static uint64_t rays_compared, hits_found;

/* ---- Balls ---------------------------------------------------------------------------------- */

/* The float t of a root counts if its point is on the ball, up to rounding: what htree.h asks
 * for. */
static bool is_on_ball(const ball *b, const htree_ray *ray, float t) {
    if (!(ray->tmin <= t && t <= ray->tmax)) return false;
    for (int k = 0; k < 3; ++k) {
        const double move = (double)t * (double)ray->dir[k];
        const double off = fabs((double)ray->org[k] + move - (double)b->center[k]);
        const double slack = 2.4e-7 * (fabs(move) + fabs((double)ray->org[k]));
        if (!(off <= (double)b->radius + slack)) return false;
    }
    return true;
}

static int32_t hit_ball(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    const ball *const b = (const ball *)user + object;
    double along = 0, square = 0, away = 0;
    for (int k = 0; k < 3; ++k) {
        along += ((double)b->center[k] - (double)ray->org[k]) * (double)ray->dir[k];
        square += (double)ray->dir[k] * (double)ray->dir[k];
    }
    const double middle = along / square;
    for (int k = 0; k < 3; ++k) {
        const double q = (double)ray->org[k] + middle * (double)ray->dir[k] - (double)b->center[k];
        away += q * q;
    }
    const double inside = (double)b->radius * (double)b->radius - away;
    if (!(inside >= 0)) return 0;
    const double half = sqrt(inside / square);
    for (int i = 0; i < 2; ++i) {
        const float t = (float)(i == 0 ? middle - half : middle + half);
        if (!is_on_ball(b, ray, t)) continue;
        hit->t = t;
        hit->u = (float)object;
        hit->v = 0.5f;
        hit->prim = 12345; /* the library sets it */
        return 1;
    }
    return 0;
}

static void make_balls(ball *balls, htree_box *boxes, uint32_t count, const htree_box *around,
                       dice *d) {
    for (uint32_t i = 0; i < count; ++i) {
        random_in_box(around, 0, d, balls[i].center);
        balls[i].radius = dice_between(d, 0.01f, 0.2f);
        for (int k = 0; k < 3; ++k) {
            boxes[i].lo[k] = balls[i].center[k] - balls[i].radius;
            boxes[i].hi[k] = balls[i].center[k] + balls[i].radius;
        }
    }
}

/* ---- Proof ---------------------------------------------------------------------------------- */

static void compare(const htree_mesh *mesh, const ray_target *target, uint64_t count,
                    uint64_t seed) {
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    htree_hit *const truth = (htree_hit *)take(count * sizeof *truth);
    htree_hit *const hits = (htree_hit *)take(count * sizeof *hits);
    uint8_t *const any = (uint8_t *)take(count);
    oracle o = oracle_of(mesh);
    dice d = {seed};
    rays_make_mixed(target, &d, rays, count);
    hits_found += oracle_batch(&o, rays, count, truth);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(mesh, kind);
        const htree_stats stats = stats_of(tree);
        assert_int_equal(stats.objects, mesh->objects->count);
        assert_int_equal(stats.invalid, o.invalid);
        assert_int_equal(htree_intersect(tree, rays, count, hits, NULL), HTREE_OK);
        assert_int_equal(hits_differ(hits, truth, count), 0);
        assert_int_equal(htree_occluded(tree, rays, count, any, NULL), HTREE_OK);
        for (uint64_t i = 0; i < count; ++i) assert_int_equal(any[i], truth[i].prim != HTREE_NONE);
        htree_free(tree);
        rays_compared += count;
    }
    oracle_free(&o);
    free(rays);
    free(truth);
    free(hits);
    free(any);
}

static void balls_among(const char *name, uint64_t triangles, uint32_t count, uint64_t rays) {
    enum { MOST = 300 };
    static ball balls[MOST];
    shape s = shape_of(name, triangles, 1);
    htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree_box *const boxes =
        (htree_box *)take(count * sizeof *boxes); /* exact, for AddressSanitizer */
    dice d = {count};
    make_balls(balls, boxes, count, &target.box, &d);
    const htree_objects objects = {boxes, count, hit_ball, balls};
    mesh.objects = &objects;
    compare(&mesh, &target, scaled(rays), count);
    free(boxes);
    shape_free(&s);
}

/* The same nodes around triangles and balls that have moved, for a callback that is told of them. */
static void refitted_balls_equal_the_oracle(void **state) {
    enum { COUNT = 50, RAYS = 2000 };
    static ball balls[COUNT];
    static htree_ray rays[RAYS];
    static htree_hit truth[RAYS];
    htree_box boxes[COUNT];
    shape s = shape_of("knot", 2000, 1);
    htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    const htree_objects objects = {boxes, COUNT, hit_ball, balls};
    dice d = {4};
    (void)state;
    mesh.objects = &objects;
    make_balls(balls, boxes, COUNT, &target.box, &d);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    const uint64_t nodes = stats_of(tree).nodes;
    for (uint32_t step = 0; step < 5; ++step) {
        make_balls(balls, boxes, COUNT, &target.box, &d);
        for (uint64_t i = 0; i < 3 * s.vertex_count; ++i) s.positions[i] *= 1.1f;
        assert_int_equal(htree_update(tree, &mesh, HTREE_REFIT, NULL), HTREE_OK);
        assert_int_equal(htree_check(tree), HTREE_OK);
        assert_int_equal(stats_of(tree).nodes, nodes);
        oracle o = oracle_of(&mesh);
        rays_make_mixed(&target, &d, rays, RAYS);
        hits_found += oracle_batch(&o, rays, RAYS, truth);
        assert_int_equal(batch_differs(tree, rays, truth, RAYS), 0);
        rays_compared += RAYS;
        oracle_free(&o);
    }
    htree_free(tree);
    shape_free(&s);
}

static void report(void **state) {
    (void)state;
    say("%llu rays with objects, %llu hits, 0 differences", (unsigned long long)rays_compared,
        (unsigned long long)hits_found);
    tally("oracle rays", rays_compared);
    assert_true(hits_found > 0);
}

static void balls_alone_equal_oracle(void **state) {
    (void)state;
    for (uint32_t count = 0; count <= 40; ++count) balls_among("none", 0, count, 1000);
    balls_among("none", 0, 300, 50000);
}

static void balls_among_triangles_equal_oracle(void **state) {
    (void)state;
    balls_among("one", 1, 1, 5000);
    balls_among("knot", 300, 100, 60000);
    balls_among("soup", 300, 300, 60000);
    balls_among("terrain", 300, 10, 30000);
}

/* ---- Callbacks and boxes that do not behave ------------------------------------------------- */

typedef struct answer {
    float t, u, v;
    int32_t returned;
} answer;

static int32_t hit_as_told(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    const answer *const a = (const answer *)user + object;
    (void)ray;
    hit->t = a->t;
    hit->u = a->u;
    hit->v = a->v;
    hit->prim = object * 77;
    return a->returned;
}

/* Every object fills the same box, so every callback is asked, and only proper answers count. */
static void answers_outside_the_interval_or_with_nan_are_ignored(void **state) {
    static answer answers[] = {
        {-0.5f, 0, 0, 1},   {1.5f, 0, 0, 1},    {NAN, 0, 0, 1},   {INFINITY, 0, 0, 1},
        {0.25f, NAN, 0, 1}, {0.25f, 0, NAN, 1}, {0.25f, 0, 0, 0}, {0.75f, 7, 8, 1},
        {0.5f, 3, 4, -9},   {0.5f, 5, 6, 1},
    };
    htree_box boxes[COUNT_OF(answers)];
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(answers); ++i) {
        const htree_box box = {{0, 0, 0}, {1, 1, 1}};
        boxes[i] = box;
    }
    const htree_objects objects = {boxes, COUNT_OF(answers), hit_as_told, answers};
    htree_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.objects = &objects;
    const htree_ray ray = {{0.5f, 0.5f, 0}, 0, {0, 0, 1}, 1};
    const htree_hit should = {0.5f, 3, 4, 8};
    oracle o = oracle_of(&mesh);
    const htree_hit truth = oracle_closest(&o, &ray);
    assert_memory_equal(&truth, &should, sizeof should);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&mesh, kind);
        htree_hit hit;
        assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
        assert_memory_equal(&hit, &should, sizeof hit);
        htree_free(tree);
    }
    oracle_free(&o);
}

static void bad_boxes_are_skipped_and_counted(void **state) {
    static const float bad[] = {NAN, INFINITY, -INFINITY, 2e18f, 5};
    static answer answers[2] = {{0.25f, 0, 0, 1}, {0.5f, 0, 0, 1}};
    (void)state;
    for (uint32_t i = 0; i < 6 * COUNT_OF(bad); ++i) {
        htree_box boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
        const uint32_t field = i % 6;
        if (field >= 3 && i / 6 == 4) continue; /* hi = 5 is a fine box */
        *(field < 3 ? &boxes[0].lo[field] : &boxes[0].hi[field - 3]) = bad[i / 6];
        const htree_objects objects = {boxes, 2, hit_as_told, answers};
        htree_mesh mesh;
        memset(&mesh, 0, sizeof mesh);
        mesh.objects = &objects;
        const htree_ray ray = {{0.5f, 0.5f, 0}, 0, {0, 0, 1}, 1};
        for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
            htree *const tree = tree_of_kind(&mesh, kind);
            htree_hit hit;
            assert_int_equal(stats_of(tree).invalid, 1);
            assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
            assert_int_equal(hit.prim, 1);
            htree_free(tree);
            htree_options strict = options_of(kind);
            strict.flags = HTREE_STRICT;
            htree *none = tree;
            assert_int_equal(htree_build(&none, &mesh, &strict), HTREE_ERROR_GEOMETRY);
            assert_null(none);
        }
    }
}

/* Triangle 0 and objects 1 and 2 lie at the same t: the lowest prim wins. */
static void ties_go_to_the_lowest_prim(void **state) {
    static const float xyz[9] = {0, 0, 0.5f, 4, 0, 0.5f, 0, 4, 0.5f};
    static answer answers[2] = {{0.5f, 1, 1, 1}, {0.5f, 2, 2, 1}};
    const htree_box boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
    const htree_objects objects = {boxes, 2, hit_as_told, answers};
    const htree_ray ray = {{0.5f, 0.5f, 0}, 0, {0, 0, 1}, 1};
    htree_mesh mesh;
    (void)state;
    for (uint32_t triangles = 0; triangles <= 1; ++triangles) {
        memset(&mesh, 0, sizeof mesh);
        mesh.positions = xyz;
        mesh.vertex_count = 3;
        mesh.triangle_count = triangles;
        mesh.objects = &objects;
        for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
            htree *const tree = tree_of_kind(&mesh, kind);
            htree_hit hit;
            assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
            assert_int_equal(hit.prim, 0);
            assert_true(hit.t == 0.5f);
            htree_free(tree);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(balls_alone_equal_oracle),
        cmocka_unit_test(balls_among_triangles_equal_oracle),
        cmocka_unit_test(answers_outside_the_interval_or_with_nan_are_ignored),
        cmocka_unit_test(bad_boxes_are_skipped_and_counted),
        cmocka_unit_test(ties_go_to_the_lowest_prim),
        cmocka_unit_test(refitted_balls_equal_the_oracle),
        cmocka_unit_test(report),
    };
    return cmocka_run_group_tests_name("objects", tests, NULL, NULL);
}
