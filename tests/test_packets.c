/* test_packets.c: batches whose rays agree with their neighbours are traced as packets, and give the
 * hits of the same rays one by one, bit for bit, whatever disturbs the picture. White-box: a tree's
 * choice of instructions is written to, and walks are called beside the detection. */
#include "pictures.h"

#include "trace/coherence.h"
#include "trace/trace.h"

#include <math.h>
#include <pthread.h>

static uint64_t rays_total, differences_total;

/* ---- Comparison ----------------------------------------------------------------------------- */

/* Rays one by one, by the portable walk. */
static void trace_alone(htree *tree, const htree_ray *rays, uint64_t count, htree_hit *truth) {
    const ht_isa best = tree->isa;
    tree->isa = HT_PORTABLE;
    for (uint64_t i = 0; i < count; ++i)
        assert_int_equal(htree_intersect(tree, &rays[i], 1, &truth[i], NULL), HTREE_OK);
    tree->isa = best;
}

static uint64_t any_differ(const uint8_t *any, const htree_hit *truth, uint64_t count) {
    uint64_t differ = 0;
    for (uint64_t i = 0; i < count; ++i) differ += any[i] != (truth[i].prim != HTREE_NONE);
    return differ;
}

/* The batch on every instruction set that has packets, by one thread and by three. */
static void compare(htree *tree, const picture *p) {
    const ht_isa best = tree->isa;
    htree_hit *const truth = (htree_hit *)take((p->count + 1) * sizeof *truth);
    htree_hit *const hits = (htree_hit *)take((p->count + 1) * sizeof *hits);
    uint8_t *const any = (uint8_t *)take(p->count + 1);
    htree_query query;
    trace_alone(tree, p->rays, p->count, truth);
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    for (int isa = HT_AVX2; isa <= (int)best; ++isa) {
        tree->isa = (ht_isa)isa;
        for (query.threads = 1; query.threads <= 3; query.threads += 2) {
            assert_int_equal(htree_intersect(tree, p->rays, p->count, hits, &query), HTREE_OK);
            assert_int_equal(htree_occluded(tree, p->rays, p->count, any, &query), HTREE_OK);
            differences_total += hits_differ(hits, truth, p->count);
            differences_total += any_differ(any, truth, p->count);
        }
    }
    tree->isa = best;
    rays_total += p->count;
    free(truth);
    free(hits);
    free(any);
}

static void compare_and_free(htree *tree, picture p) {
    compare(tree, &p);
    free(p.rays);
}

static void conclude(const char *what) {
    say("%s: %llu rays, %llu differences", what, (unsigned long long)rays_total,
        (unsigned long long)differences_total);
    assert_int_equal(differences_total, 0);
    rays_total = 0;
}

/* ---- Pictures of scenes --------------------------------------------------------------------- */

static void compare_views(const char *name, uint64_t triangles, uint32_t seed) {
    static const uint32_t sizes[][3] = {{1, 80, 0}, {3, 30, 1},   {64, 2, 0},
                                        {5, 33, 2}, {67, 21, 29}, {32, 32, 0}};
    shape s = shape_of(name, triangles, seed);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    dice d = {seed};
    for (uint32_t i = 0; i < COUNT_OF(sizes); ++i) {
        const float light[3] = {target.box.hi[0] + target.size, target.box.hi[1], 0.3f};
        float eye[3], forward[3];
        picture_view(&target, &d, eye, forward);
        const float step = dice_between(&d, 0.5f, 1.5f) / (float)(sizes[i][0] + sizes[i][1]);
        picture p = picture_pinhole(sizes[i][0], sizes[i][1], sizes[i][2], eye, forward, step);
        compare(tree, &p);
        compare_and_free(tree, picture_shadows(tree, &p, light));
        picture_shuffle(&p, &d);
        compare_and_free(tree, p);
        compare_and_free(
            tree, picture_parallel(sizes[i][0], sizes[i][1], eye, forward, step * target.size));
        random_in_box(&target.box, 0, &d, eye);
        compare_and_free(tree, picture_pinhole(sizes[i][0], sizes[i][1], 0, eye, forward, step));
    }
    htree_free(tree);
    shape_free(&s);
}

static void pictures_equal_rays_one_by_one(void **state) {
    uint32_t seed = 1;
    (void)state;
    for (const char *const *name = shape_names(); *name != NULL; ++name, ++seed) {
        compare_views(*name, 30, seed);
        compare_views(*name, scaled(3000), seed);
    }
    conclude("pictures");
}

/* Along an axis, and along diagonals, where octants and main axes change from ray to ray. */
static void mixed_headings_change_nothing(void **state) {
    shape s = shape_of("knot", scaled(4000), 1);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    (void)state;
    for (int way = 1; way < 27; ++way) {
        const float forward[3] = {(float)(way % 3 - 1), (float)(way / 3 % 3 - 1),
                                  (float)(way / 9 - 1)};
        float eye[3];
        if (way == 13) continue;
        for (int k = 0; k < 3; ++k) {
            eye[k] = 0.5f * (target.box.lo[k] + target.box.hi[k]);
            eye[k] -= (way & 1 ? 1.0f : 0.1f) * target.size * forward[k];
        }
        compare_and_free(tree, picture_pinhole(45, 43, 0, eye, forward, 0.02f));
        compare_and_free(tree, picture_parallel(44, 20, eye, forward, 0.02f * target.size));
    }
    htree_free(tree);
    shape_free(&s);
    conclude("mixed headings");
}

/* ---- Disturbed pictures --------------------------------------------------------------------- */

static void odd_rays_change_nothing(void **state) {
    shape s = shape_of("city", scaled(3000), 5);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    dice d = {11};
    (void)state;
    for (uint32_t i = 0; i < 12; ++i) {
        float eye[3], forward[3];
        picture_view(&target, &d, eye, forward);
        picture p = picture_pinhole(61, 40, 3, eye, forward, 0.01f);
        picture_disturb(&p, &d);
        compare_and_free(tree, p);
    }
    htree_free(tree);
    shape_free(&s);
    conclude("odd rays");
}

static void cells_change_nothing(void **state) {
    shape s = shape_of("city", scaled(3000), 5);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    dice d = {13};
    (void)state;
    for (uint32_t i = 0; i < 12; ++i) {
        const uint32_t side = i % 2 ? 8 : 4, width = side * (5 + i);
        float eye[3], forward[3];
        picture_view(&target, &d, eye, forward);
        picture p = picture_pinhole(width, 5 * side, i, eye, forward, 0.01f);
        picture_cells(&p, side);
        const ht_rows rows = ht_find_rows(p.rays, p.count, &tree->bounds, tree->prim_count);
        assert_int_equal(rows.cell, i % 2 ? 3 : 2);
        if (i > 5) picture_disturb(&p, &d);
        compare_and_free(tree, p);
    }
    htree_free(tree);
    shape_free(&s);
    conclude("cells");
}

static void every_scale_gives_the_same(void **state) {
    static const int scales[] = {-140, -100, -60, -20, 20, 40, 57};
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(scales); ++i) {
        /* Where coordinates are denormal, a ray meets most of the boxes. */
        shape s = shape_of("knot", scales[i] < -100 ? 150 : scaled(1500), 2);
        const htree_mesh mesh = mesh_of(&s);
        dice d = {i + 1};
        for (uint64_t k = 0; k < 3 * s.vertex_count; ++k)
            s.positions[k] = ldexpf(s.positions[k], scales[i]);
        const ray_target target = ray_target_of(&mesh);
        htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
        for (uint32_t view = 0; view < 3; ++view) {
            float eye[3], forward[3];
            picture_view(&target, &d, eye, forward);
            compare_and_free(tree, picture_pinhole(50, 50, 0, eye, forward, 0.01f));
            compare_and_free(tree, picture_parallel(50, 50, eye, forward, 0.01f * target.size));
        }
        htree_free(tree);
        shape_free(&s);
    }
    conclude("scales");
}

/* ---- Corners -------------------------------------------------------------------------------- */

/* From inside of a closed mesh through its corners and the middles of its edges: all are hit. */
static void no_ray_through_a_corner_is_lost(void **state) {
    shape s = shape_of("sphere", scaled(2000), 1);
    const htree_mesh mesh = mesh_of(&s);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    const uint32_t rays = (uint32_t)(6 * s.triangle_count);
    const float eye[3] = {0.1f, 0.05f, -0.07f};
    picture p = picture_of(rays, 1, 0);
    htree_hit *const hits = (htree_hit *)take(p.count * sizeof *hits);
    (void)state;
    for (uint64_t i = 0; i < p.count; ++i) {
        const float *a = mesh_corner(&mesh, i / 6, (uint32_t)(i % 3));
        const float *b = mesh_corner(&mesh, i / 6, (uint32_t)((i + i / 3 % 2) % 3));
        const float between[3] = {0.5f * (a[0] + b[0]), 0.5f * (a[1] + b[1]), 0.5f * (a[2] + b[2])};
        p.rays[i] = ray_through(eye, between);
    }
    assert_int_equal(htree_intersect(tree, p.rays, p.count, hits, NULL), HTREE_OK);
    for (uint64_t i = 0; i < p.count; ++i) assert_int_not_equal(hits[i].prim, HTREE_NONE);
    compare_and_free(tree, p);
    free(hits);
    htree_free(tree);
    shape_free(&s);
    conclude("corners");
}

/* ---- Tiles ---------------------------------------------------------------------------------- */

#ifdef HT_X86
/* A tile of any size, from the corner of a larger picture, whose other answers stay. */
static void compare_tile(const htree *tree, const ht_tile_walks *walks, const picture *p,
                         const htree_hit *truth, uint32_t width, uint32_t height) {
    htree_hit *const hits = (htree_hit *)take(p->count * sizeof *hits);
    uint8_t *const any = (uint8_t *)take(p->count);
    const ht_tile closest = {p->rays, p->width, 0, width, height, hits, NULL};
    const ht_tile first = {p->rays, p->width, 0, width, height, NULL, any};
    memset(hits, 0x5a, p->count * sizeof *hits);
    memset(any, 0x5a, p->count);
    walks->closest(tree, &closest);
    walks->any(tree, &first);
    for (uint64_t i = 0; i < p->count; ++i) {
        const bool inside = i % p->width < width && i / p->width < height;
        htree_hit kept;
        memset(&kept, 0x5a, sizeof kept);
        differences_total += hits_differ(&hits[i], inside ? &truth[i] : &kept, 1);
        differences_total += any[i] != (inside ? truth[i].prim != HTREE_NONE : 0x5a);
    }
    rays_total += (uint64_t)width * height;
    free(hits);
    free(any);
}

/* Beams much wider than triangles: packets give up, and streams go on. */
static void crowded_tiles_are_whole(void **state) {
    shape s = shape_of("soup", 30000, 1);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    float eye[3], forward[3];
    dice d = {5};
    (void)state;
    picture_view(&target, &d, eye, forward);
    picture p = picture_pinhole(96, 32, 0, eye, forward, 0.006f);
    htree_hit *const truth = (htree_hit *)take(p.count * sizeof *truth);
    trace_alone(tree, p.rays, p.count, truth);
    if (tree->isa >= HT_AVX2) compare_tile(tree, &ht_packet_avx2_walks, &p, truth, 96, 32);
    if (tree->isa >= HT_AVX512) compare_tile(tree, &ht_packet_avx512_walks, &p, truth, 96, 32);
    free(truth);
    free(p.rays);
    htree_free(tree);
    shape_free(&s);
    conclude("crowded tiles");
}

static void tiles_of_every_size_are_whole(void **state) {
    shape s = shape_of("terrain", scaled(2000), 1);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    float eye[3], forward[3];
    dice d = {4};
    (void)state;
    picture_view(&target, &d, eye, forward);
    picture p = picture_pinhole(40, 70, 0, eye, forward, 0.02f);
    htree_hit *const truth = (htree_hit *)take(p.count * sizeof *truth);
    trace_alone(tree, p.rays, p.count, truth);
    for (uint32_t height = 1; height <= 70; height += height < 20 ? 1 : 9) {
        for (uint32_t width = 1; width <= 40; width += width < 20 ? 1 : 5) {
            if (tree->isa >= HT_AVX2)
                compare_tile(tree, &ht_packet_avx2_walks, &p, truth, width, height);
            if (tree->isa >= HT_AVX512)
                compare_tile(tree, &ht_packet_avx512_walks, &p, truth, width, height);
        }
    }
    free(truth);
    free(p.rays);
    htree_free(tree);
    shape_free(&s);
    conclude("tiles");
}
#endif

/* ---- Objects -------------------------------------------------------------------------------- */

static int32_t hit_plate(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    const htree_box *box = (const htree_box *)user + object;
    hit->t = (box->lo[1] - ray->org[1]) / ray->dir[1];
    const float x = ray->org[0] + hit->t * ray->dir[0], z = ray->org[2] + hit->t * ray->dir[2];
    return box->lo[0] <= x && x <= box->hi[0] && box->lo[2] <= z && z <= box->hi[2];
}

static void objects_change_nothing(void **state) {
    htree_box plates[20];
    shape s = shape_of("soup", 500, 1);
    htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    const htree_objects objects = {plates, COUNT_OF(plates), hit_plate, plates};
    dice d = {9};
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(plates); ++i) {
        random_in_box(&target.box, 0, &d, plates[i].lo);
        for (int k = 0; k < 3; ++k)
            plates[i].hi[k] = plates[i].lo[k] + (k == 1 ? 0 : 0.2f * target.size);
    }
    mesh.objects = &objects;
    htree *const tree = tree_of_kind(&mesh, HTREE_WIDE);
    for (uint32_t i = 0; i < 5; ++i) {
        float eye[3], forward[3];
        picture_view(&target, &d, eye, forward);
        compare_and_free(tree, picture_pinhole(40, 40, 0, eye, forward, 0.02f));
    }
    htree_free(tree);
    shape_free(&s);
    conclude("objects");
}

#ifdef SUITE_SMALL_STACK

/* ---- A small stack -------------------------------------------------------------------------- */

typedef struct errand {
    htree *tree;
    picture seen;
    htree_hit *hits;
    htree_status status;
} errand;

static void *run_errand(void *data) {
    errand *const e = (errand *)data;
    e->status = htree_intersect(e->tree, e->seen.rays, e->seen.count, e->hits, NULL);
    return NULL;
}

/* At its deepest: subtrees are made while rays that are no packet walk beside packets. */
static void a_stack_of_64_kib_is_enough(void **state) {
    shape s = shape_of("knot", 20000, 1);
    const htree_mesh mesh = mesh_of(&s);
    const float eye[3] = {0, 0, 5}, forward[3] = {0, 0, -1};
    htree_options lazy = options_of(HTREE_FAST);
    errand e = {NULL, picture_pinhole(65, 65, 9, eye, forward, 0.01f), NULL, HTREE_ERROR_MEMORY};
    ht_isa best = HT_PORTABLE;
    pthread_attr_t attributes;
    (void)state;
    e.hits = (htree_hit *)take(e.seen.count * sizeof *e.hits);
    lazy.flags |= HTREE_LAZY;
    /* Rays that begin before t = 0 are no part of a packet. */
    for (uint64_t i = 0; i < e.seen.count; i += 97) e.seen.rays[i].tmin = -1;
    assert_int_equal(pthread_attr_init(&attributes), 0);
    assert_int_equal(pthread_attr_setstacksize(&attributes, 65536), 0);
    for (int isa = HT_PORTABLE; isa <= (int)best; ++isa) {
        pthread_t thread;
        e.tree = tree_of(&mesh, &lazy);
        best = e.tree->isa;
        e.tree->isa = (ht_isa)isa;
        assert_int_equal(pthread_create(&thread, &attributes, run_errand, &e), 0);
        assert_int_equal(pthread_join(thread, NULL), 0);
        assert_int_equal(e.status, HTREE_OK);
        htree_free(e.tree);
    }
    pthread_attr_destroy(&attributes);
    free(e.hits);
    free(e.seen.rays);
    shape_free(&s);
}
#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_equal_rays_one_by_one),
        cmocka_unit_test(mixed_headings_change_nothing),
        cmocka_unit_test(odd_rays_change_nothing),
        cmocka_unit_test(cells_change_nothing),
        cmocka_unit_test(every_scale_gives_the_same),
        cmocka_unit_test(no_ray_through_a_corner_is_lost),
#ifdef HT_X86
        cmocka_unit_test(tiles_of_every_size_are_whole),
        cmocka_unit_test(crowded_tiles_are_whole),
#endif
        cmocka_unit_test(objects_change_nothing),
#ifdef SUITE_SMALL_STACK
        cmocka_unit_test(a_stack_of_64_kib_is_enough),
#endif
    };
    return cmocka_run_group_tests_name("packets", tests, NULL, NULL);
}
