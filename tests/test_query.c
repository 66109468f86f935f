/* test_query.c: what queries promise beside the hits themselves: intervals, batches, counters, rays
 * that miss by their numbers. */
#include "oracle.h"
#include "pictures.h"
#include "rays.h"

#include <math.h>

/* tmax = t still hits with the same bits; the float below t does not; tmin = t still hits. */
static void check_interval(const htree *tree, const oracle *o, htree_ray ray,
                           const htree_hit *first) {
    htree_hit hit;
    uint8_t any = 2;
    ray.tmax = first->t;
    assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
    assert_memory_equal(&hit, first, sizeof hit);
    ray.tmin = first->t;
    assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
    assert_memory_equal(&hit, first, sizeof hit);
    assert_int_equal(htree_occluded(tree, &ray, 1, &any, NULL), HTREE_OK);
    assert_int_equal(any, 1);
    ray.tmin = 0;
    ray.tmax = nextafterf(first->t, -INFINITY);
    assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
    assert_int_equal(hit.prim, HTREE_NONE);
    ray.tmin = nextafterf(first->t, INFINITY);
    ray.tmax = INFINITY;
    const htree_hit next = oracle_closest(o, &ray);
    assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
    assert_memory_equal(&hit, &next, sizeof hit);
}

static void the_interval_is_closed_at_both_ends(void **state) {
    (void)state;
    shape s = shape_of("knot", 500, 3);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    oracle o = oracle_of(&mesh);
    uint64_t checked = 0;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&mesh, kind);
        dice d = {9};
        for (uint64_t i = 0; i < scaled(20000); ++i) {
            htree_ray ray;
            rays_make(&target, (uint32_t)(i % 6), &d, &ray, 1);
            ray.tmin = 0;
            ray.tmax = INFINITY;
            const htree_hit first = oracle_closest(&o, &ray);
            if (first.prim == HTREE_NONE) continue;
            check_interval(tree, &o, ray, &first);
            ++checked;
        }
        htree_free(tree);
    }
    oracle_free(&o);
    shape_free(&s);
    say("intervals cut at the hit: %llu", (unsigned long long)checked);
    assert_true(checked > 0);
}

static void shuffle(dice *d, uint32_t *order, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) order[i] = i;
    for (uint32_t i = count; i > 1; --i) {
        const uint32_t j = dice_below(d, i), swap = order[i - 1];
        order[i - 1] = order[j];
        order[j] = swap;
    }
}

/* Sizes around every power of two up to `most`, at odd starts, in a shuffled order of rays. */
static uint64_t check_batches(const htree *tree, const htree_ray *rays, const htree_hit *singles,
                              uint32_t most, dice *d) {
    uint64_t batches = 0;
    uint32_t *const order = (uint32_t *)take(most * sizeof *order);
    for (uint32_t size = 1; size <= most; size = size < 70 ? size + 1 : size * 2 - 37) {
        htree_ray *const some = (htree_ray *)take(size * sizeof *some);
        htree_hit *const hits = (htree_hit *)take(size * sizeof *hits);
        uint8_t *const any = (uint8_t *)take(size);
        shuffle(d, order, most);
        for (uint32_t i = 0; i < size; ++i) some[i] = rays[order[i]];
        assert_int_equal(htree_intersect(tree, some, size, hits, NULL), HTREE_OK);
        assert_int_equal(htree_occluded(tree, some, size, any, NULL), HTREE_OK);
        for (uint32_t i = 0; i < size; ++i) {
            assert_memory_equal(&hits[i], &singles[order[i]], sizeof hits[i]);
            assert_int_equal(any[i], singles[order[i]].prim != HTREE_NONE);
        }
        free(some);
        free(hits);
        free(any);
        ++batches;
    }
    free(order);
    return batches;
}

static void batches_equal_singles_in_any_order_and_size(void **state) {
    enum { MOST = 20000 };
    (void)state;
    shape s = shape_of("waves", 2000, 5);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree_ray *const rays = (htree_ray *)take(MOST * sizeof *rays);
    htree_hit *const singles = (htree_hit *)take(MOST * sizeof *singles);
    uint64_t batches = 0;
    dice d = {11};
    rays_make_mixed(&target, &d, rays, MOST);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&mesh, kind);
        for (uint32_t i = 0; i < MOST; ++i) {
            assert_int_equal(htree_intersect(tree, &rays[i], 1, &singles[i], NULL), HTREE_OK);
        }
        batches += check_batches(tree, rays, singles, MOST, &d);
        htree_free(tree);
    }
    free(rays);
    free(singles);
    shape_free(&s);
    say("batches of 1 to 20000 rays equal to singles: %llu", (unsigned long long)batches);
}

/* Rays and hits at every multiple of four bytes, answers at every byte, and not a byte beside them. */
static void check_places(const htree *tree, const htree_ray *rays, const htree_hit *truth,
                         uint64_t count) {
    enum { PLACES = 16, EDGE = 64 };
    const uint64_t most = count * sizeof *rays + 2 * EDGE;
    char *const from = (char *)take(most), *const to = (char *)take(most);
    for (uint64_t place = 0; place < PLACES; ++place) {
        char *const in = from + 4 * place, *const out = to + EDGE - 4 * place;
        const uint64_t end = (uint64_t)(out - to) + count * sizeof *truth;
        memcpy(in, rays, (size_t)(count * sizeof *rays));
        memset(to, 0x5a, (size_t)most);
        assert_int_equal(htree_intersect(tree, (const htree_ray *)(const void *)in, count,
                                         (htree_hit *)(void *)out, NULL),
                         HTREE_OK);
        assert_memory_equal(out, truth, (size_t)(count * sizeof *truth));
        for (uint64_t i = 0; i < most; ++i) {
            if (to + i < out || i >= end) assert_int_equal(to[i], 0x5a);
        }
        uint8_t *const any = (uint8_t *)to + place;
        assert_int_equal(
            htree_occluded(tree, (const htree_ray *)(const void *)in, count, any, NULL), HTREE_OK);
        for (uint64_t i = 0; i < count; ++i) assert_int_equal(any[i], truth[i].prim != HTREE_NONE);
    }
    free(from);
    free(to);
}

static void arrays_may_lie_anywhere(void **state) {
    enum { MIXED = 100, WIDTH = 64, HEIGHT = 16 };
    const float eye[3] = {0, 0, 4}, forward[3] = {0, 0, -1};
    (void)state;
    shape s = shape_of("waves", 2000, 5);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    picture p = picture_pinhole(WIDTH, HEIGHT, 0, eye, forward, 0.002f);
    htree_ray *const rays = (htree_ray *)take(MIXED * sizeof *rays);
    htree_hit *const truth = (htree_hit *)take((MIXED + p.count) * sizeof *truth);
    dice d = {14};
    rays_make_mixed(&target, &d, rays, MIXED);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&mesh, kind);
        assert_int_equal(htree_intersect(tree, rays, MIXED, truth, NULL), HTREE_OK);
        check_places(tree, rays, truth, MIXED);
        assert_int_equal(htree_intersect(tree, p.rays, p.count, truth, NULL), HTREE_OK);
        check_places(tree, p.rays, truth, p.count);
        htree_free(tree);
    }
    free(truth);
    free(rays);
    free(p.rays);
    shape_free(&s);
}

static void counters_count_and_do_not_change_hits(void **state) {
    (void)state;
    shape s = shape_of("knot", 2000, 5);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    const uint64_t count = scaled(20000);
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    htree_hit *const plain = (htree_hit *)take(count * sizeof *plain);
    htree_hit *const counted = (htree_hit *)take(count * sizeof *counted);
    htree_counters *const counters = (htree_counters *)take(count * sizeof *counters);
    dice d = {12};
    rays_make_mixed(&target, &d, rays, count);
    htree_query query;
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    query.counters = counters;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&mesh, kind);
        const uint64_t nodes = stats_of(tree).nodes;
        memset(counters, 0xff, (size_t)(count * sizeof *counters));
        assert_int_equal(htree_intersect(tree, rays, count, plain, NULL), HTREE_OK);
        assert_int_equal(htree_intersect(tree, rays, count, counted, &query), HTREE_OK);
        assert_int_equal(hits_differ(plain, counted, count), 0);
        for (uint64_t i = 0; i < count; ++i) {
            assert_true(counters[i].leaf_steps <= counters[i].traversal_steps);
            assert_true(counters[i].traversal_steps <= nodes); /* none is visited twice */
            if (plain[i].prim != HTREE_NONE) assert_true(counters[i].intersections > 0);
            assert_int_equal(counters[i].reserved, 0);
        }
        htree_free(tree);
    }
    free(rays);
    free(plain);
    free(counted);
    free(counters);
    shape_free(&s);
}

static void invalid_rays_cost_no_step(void **state) {
    (void)state;
    shape s = shape_of("soup", 2000, 5);
    const htree_mesh mesh = mesh_of(&s);
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1.2e18f};
    uint64_t checked = 0;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&mesh, kind);
        for (uint32_t i = 0; i < 8 * COUNT_OF(bad); ++i) {
            const float good[8] = {0, 0, 0, -1, 1, 0.5f, 0.25f, INFINITY};
            const uint32_t field = i % 8;
            if ((field == 3 || field == 7) && i >= 8) continue; /* infinite ends are valid */
            float fields[8];
            htree_ray ray;
            htree_hit hit;
            htree_counters counters = {9, 9, 9, 9};
            htree_query query;
            memcpy(fields, good, sizeof fields);
            fields[field] = bad[i / 8];
            memcpy(&ray, fields, sizeof ray);
            assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
            query.counters = &counters;
            assert_int_equal(htree_intersect(tree, &ray, 1, &hit, &query), HTREE_OK);
            assert_int_equal(hit.prim, HTREE_NONE);
            assert_memory_equal(&hit.t, &ray.tmax, sizeof hit.t);
            assert_true(hit.u == 0 && hit.v == 0);
            assert_int_equal(counters.traversal_steps + counters.intersections, 0);
            ++checked;
        }
        htree_free(tree);
    }
    shape_free(&s);
    say("invalid rays: %llu, all missed without a step", (unsigned long long)checked);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_interval_is_closed_at_both_ends),
        cmocka_unit_test(batches_equal_singles_in_any_order_and_size),
        cmocka_unit_test(arrays_may_lie_anywhere),
        cmocka_unit_test(counters_count_and_do_not_change_hits),
        cmocka_unit_test(invalid_rays_cost_no_step),
    };
    return cmocka_run_group_tests_name("query", tests, NULL, NULL);
}
