/* test_cl.c: trees on an OpenCL device answer as the CPU does, bit for bit, whatever the kind, the
 * scene, the rays and the way they travel. The CPU's answers are the oracle's: test_trace. */
#include "cl_suite.h"
#include "rays.h"

#include <math.h>
#include <pthread.h>

static htree_cl *device;
static uint64_t rays_total, differences_total;

static void report(const char *what) {
    say("%s: %llu rays on the device, %llu differences", what, (unsigned long long)rays_total,
        (unsigned long long)differences_total);
    const uint64_t differences = differences_total;
    rays_total = differences_total = 0;
    assert_int_equal(differences, 0);
}

/* Both queries on both sides. */
static void compare(const htree *tree, const htree_cl_tree *uploaded, const htree_ray *rays,
                    uint64_t count) {
    htree_hit *const is = (htree_hit *)take(count * sizeof *is);
    htree_hit *const should = (htree_hit *)take(count * sizeof *should);
    uint8_t *const any = (uint8_t *)take(count);
    memset(is, 0x5a, (size_t)(count * sizeof *is));
    memset(any, 0x5a, (size_t)count);
    assert_int_equal(htree_intersect(tree, rays, count, should, NULL), HTREE_OK);
    assert_cl_ok(htree_cl_intersect(uploaded, rays, count, is, NULL));
    assert_cl_ok(htree_cl_occluded(uploaded, rays, count, any, NULL));
    differences_total += hits_differ(is, should, count);
    for (uint64_t i = 0; i < count; ++i)
        differences_total += any[i] != (should[i].prim != HTREE_NONE);
    rays_total += count;
    free(is);
    free(should);
    free(any);
}

static void compare_all_kinds(const htree_mesh *mesh, const htree_ray *rays, uint64_t count) {
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree_options options = options_of(kind);
        if (kind == HTREE_AH) options.flags = HTREE_ANY_PLANES;
        htree *const tree = tree_of(mesh, &options);
        htree_cl_tree *const uploaded = upload(device, tree);
        compare(tree, uploaded, rays, count);
        htree_cl_free(uploaded);
        htree_free(tree);
    }
}

/* ---- Same answer ---------------------------------------------------------------------------- */

static void every_kind_equals_the_cpu_on_every_shape_and_ray_family(void **state) {
    const uint64_t most = scaled(14 * 2600);
    htree_ray *const rays = (htree_ray *)take(most * sizeof *rays);
    uint32_t seed = 1;
    (void)state;
    for (const char *const *name = shape_names(); *name != NULL; ++name, ++seed) {
        for (uint64_t triangles = 40; triangles <= 4000; triangles *= 100) {
            const uint64_t count = triangles == 40 ? most : most / 10;
            shape s = shape_of(*name, triangles, seed);
            const htree_mesh mesh = mesh_of(&s);
            const ray_target target = ray_target_of(&mesh);
            dice d = {seed};
            rays_make_mixed(&target, &d, rays, count);
            compare_all_kinds(&mesh, rays, count);
            shape_free(&s);
        }
    }
    free(rays);
    report("13 shapes, 14 families, all kinds");
}

/* Denormal extents, the largest coordinates, and far from the origin. */
static void every_kind_equals_the_cpu_at_every_scale(void **state) {
    static const int exponents[] = {-148, -140, -128, -100, -40, 40, 59};
    const uint64_t count = scaled(4000);
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    (void)state;
    for (uint32_t e = 0; e < 2 * COUNT_OF(exponents); ++e) {
        shape s = shape_of(e % 2 != 0 ? "soup" : "sphere", 100, e);
        htree_mesh mesh = mesh_of(&s);
        int exponent = 0;
        (void)frexpf(ray_target_of(&mesh).size, &exponent);
        for (uint64_t i = 0; i < 3 * s.vertex_count; ++i) {
            s.positions[i] = ldexpf(s.positions[i], exponents[e / 2] - exponent);
            if (e % 4 == 3) s.positions[i] += 1e6f * (float)(i % 3);
        }
        const ray_target target = ray_target_of(&mesh);
        dice d = {e};
        rays_make_mixed(&target, &d, rays, count);
        compare_all_kinds(&mesh, rays, count);
        shape_free(&s);
    }
    free(rays);
    report("scales 2^-148 to 2^59");
}

/* Some 10^5 work-items whose last group is full, short by one, or over by one. */
static void every_batch_size_equals_the_cpu(void **state) {
    enum { MOST = (1 << 17) + 1 };
    shape s = shape_of("knot", 2000, 3);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree_ray *const rays = (htree_ray *)take(MOST * sizeof *rays);
    htree *const tree = tree_of_kind(&mesh, HTREE_H);
    htree_cl_tree *const uploaded = upload(device, tree);
    dice d = {9};
    (void)state;
    rays_make_mixed(&target, &d, rays, MOST);
    for (uint64_t n = 0; n <= 1025; n += scaled(100) < 50 && n > 70 ? 37 : 1)
        compare(tree, uploaded, rays, n);
    for (uint64_t n = 2048; n < MOST; n *= 2) {
        for (uint64_t k = n - 1; k <= n + 1; ++k) compare(tree, uploaded, rays, k);
    }
    htree_cl_free(uploaded);
    htree_free(tree);
    free(rays);
    shape_free(&s);
    report("batches of 0 to 1025 and 2^k +- 1");
}

static void no_triangles_are_never_hit(void **state) {
    htree_mesh mesh;
    const htree_ray ray = {{0, 0, 0}, 0, {1, 0, 0}, 10};
    (void)state;
    memset(&mesh, 0, sizeof mesh);
    compare_all_kinds(&mesh, &ray, 1);
    report("no triangles");
}

/* ---- Other ways to travel ------------------------------------------------------------------- */

static void any_group_and_launch_size_gives_the_same_hits(void **state) {
    static const uint32_t sizes[][2] = {{1, 0}, {7, 100}, {64, 1}, {1000000, 5000}, {0, 333}};
    const uint64_t count = scaled(20000);
    shape s = shape_of("terrain", 2000, 3);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    dice d = {9};
    (void)state;
    rays_make_mixed(&target, &d, rays, count);
    for (uint32_t i = 0; i < COUNT_OF(sizes); ++i) {
        htree_cl_options options = cl_options();
        options.group_size = sizes[i][0];
        options.launch_rays = sizes[i][1];
        htree_cl *const other = open_device(&options);
        htree_cl_tree *const uploaded = upload(other, tree);
        compare(tree, uploaded, rays, options.launch_rays == 1 ? 300 : count);
        htree_cl_free(uploaded);
        htree_cl_close(other);
    }
    htree_free(tree);
    free(rays);
    shape_free(&s);
    report("work-groups and launches of any size");
}

/* Arrays that no vector load may touch are copied instead. */
static void arrays_need_no_alignment(void **state) {
    enum { N = 1000 };
    shape s = shape_of("knot", 500, 3);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    char *const room = (char *)take((N + 1) * sizeof(htree_ray));
    htree *const tree = tree_of_kind(&mesh, HTREE_H);
    htree_cl_tree *const uploaded = upload(device, tree);
    (void)state;
    for (uint32_t shift = 4; shift <= 16; shift += 4) {
        htree_ray *const rays = (htree_ray *)(void *)(room + shift);
        dice d = {shift};
        rays_make_mixed(&target, &d, rays, N);
        compare(tree, uploaded, rays, N);
    }
    htree_cl_free(uploaded);
    htree_free(tree);
    free(room);
    shape_free(&s);
    report("unaligned arrays");
}

typedef struct traveller {
    const htree *tree;
    const htree_cl_tree *uploaded;
    const htree_ray *rays;
    uint64_t count, differences;
} traveller;

static void *travel(void *data) {
    traveller *const t = (traveller *)data;
    htree_hit *const should = (htree_hit *)malloc(t->count * sizeof *should);
    htree_hit *const is = (htree_hit *)malloc(t->count * sizeof *is);
    (void)htree_intersect(t->tree, t->rays, t->count, should, NULL);
    for (int i = 0; i < 20; ++i) {
        memset(is, 0, (size_t)t->count * sizeof *is);
        if (htree_cl_intersect(t->uploaded, t->rays, t->count, is, NULL) != HTREE_OK)
            ++t->differences;
        t->differences += hits_differ(is, should, t->count);
    }
    free(should);
    free(is);
    return NULL;
}

static void eight_threads_share_a_device_and_a_tree(void **state) {
    enum { THREADS = 8 };
    const uint64_t count = scaled(5000);
    shape s = shape_of("knot", 2000, 3);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree_ray *const rays = (htree_ray *)take(THREADS * count * sizeof *rays);
    htree *const tree = tree_of_kind(&mesh, HTREE_AH);
    htree_cl_tree *const uploaded = upload(device, tree);
    traveller travellers[THREADS];
    pthread_t thread[THREADS];
    dice d = {9};
    (void)state;
    rays_make_mixed(&target, &d, rays, THREADS * count);
    for (uint32_t i = 0; i < THREADS; ++i) {
        const traveller t = {tree, uploaded, rays + i * count, count, 0};
        travellers[i] = t;
        assert_int_equal(pthread_create(&thread[i], NULL, travel, &travellers[i]), 0);
    }
    for (uint32_t i = 0; i < THREADS; ++i) {
        pthread_join(thread[i], NULL);
        differences_total += travellers[i].differences;
        rays_total += 20 * count;
    }
    htree_cl_free(uploaded);
    htree_free(tree);
    free(rays);
    shape_free(&s);
    report("8 threads");
}

/* ---- Less than IEEE ------------------------------------------------------------------------- */

/* Without double the bits may differ, but not by more than is promised. */
static void a_device_without_double_keeps_its_bound(void **state) {
    const uint64_t count = scaled(100000);
    htree_cl_options options = cl_options();
    options.flags = HTREE_CL_NO_FP64;
    htree_cl *const single = open_device(&options);
    htree_cl_info info;
    shape s = shape_of("knot", 5000, 3);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    htree_cl_tree *const uploaded = upload(single, tree);
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    htree_hit *const is = (htree_hit *)take(count * sizeof *is);
    htree_hit *const should = (htree_hit *)take(count * sizeof *should);
    dice d = {5};
    uint64_t hits = 0, other = 0;
    float worst = 0;
    (void)state;
    for (uint64_t i = 0; i < count; ++i) {
        float from[3], to[3];
        random_in_box(&target.box, 2 * target.size, &d, from);
        random_in_box(&target.box, 0, &d, to);
        rays[i] = ray_through(from, to);
    }
    info.size = sizeof info;
    assert_cl_ok(htree_cl_get_info(single, &info));
    assert_int_equal(info.exact, 0);
    assert_true(info.t_error <= HTREE_CL_T_ERROR);
    assert_int_equal(htree_intersect(tree, rays, count, should, NULL), HTREE_OK);
    assert_cl_ok(htree_cl_intersect(uploaded, rays, count, is, NULL));
    for (uint64_t i = 0; i < count; ++i) {
        hits += should[i].prim != HTREE_NONE;
        if (is[i].prim != should[i].prim) {
            ++other;
        } else if (is[i].prim != HTREE_NONE) {
            const float error = fabsf(is[i].t - should[i].t) / fabsf(should[i].t);
            if (error > worst) worst = error;
        }
    }
    say("without double: %llu rays, %llu hits, another triangle %llu times, error of t %.2g",
        (unsigned long long)count, (unsigned long long)hits, (unsigned long long)other,
        (double)worst);
    assert_true(hits > count / 20);
    assert_true(worst <= HTREE_CL_T_ERROR);
    assert_true(other <= 1 + count / 10000); /* rays through edges, within rounding */
    free(rays);
    free(is);
    free(should);
    htree_cl_free(uploaded);
    htree_cl_close(single);
    htree_free(tree);
    shape_free(&s);
}

static int open_once(void **state) {
    (void)state;
    device = open_device(NULL);
    return 0;
}

static int close_last(void **state) {
    (void)state;
    htree_cl_close(device);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_equals_the_cpu_on_every_shape_and_ray_family),
        cmocka_unit_test(every_kind_equals_the_cpu_at_every_scale),
        cmocka_unit_test(every_batch_size_equals_the_cpu),
        cmocka_unit_test(no_triangles_are_never_hit),
        cmocka_unit_test(any_group_and_launch_size_gives_the_same_hits),
        cmocka_unit_test(arrays_need_no_alignment),
        cmocka_unit_test(eight_threads_share_a_device_and_a_tree),
        cmocka_unit_test(a_device_without_double_keeps_its_bound),
    };
    return run_on_device("cl", tests, COUNT_OF(tests), open_once, close_last);
}
