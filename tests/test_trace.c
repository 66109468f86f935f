/* test_trace.c: every kind gives the oracle's hits, bit for bit, whatever the rays, the scene and
 * the options are. */
#include "oracle.h"
#include "rays.h"
#include "tree/layout.h"

#include <math.h>

enum { MAX_KINDS = 8 };

typedef struct run {
    const char *scene;
    htree_mesh mesh;
    ray_target target;
    oracle truth;
    htree_kind kind[MAX_KINDS];
    htree *tree[MAX_KINDS];
    uint32_t trees;
    uint64_t rays, hits, differences; /* per structure */
} run;

static uint64_t rays_total, answers_total, hits_total, differences_total;

static void run_begin(run *r, const char *scene, const htree_mesh *mesh) {
    memset(r, 0, sizeof *r);
    r->scene = scene;
    r->mesh = *mesh;
    r->target = ray_target_of(mesh);
    r->truth = oracle_of(mesh);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        r->kind[r->trees] = kind;
        r->tree[r->trees++] = tree_of_kind(mesh, kind);
    }
    assert_true(r->trees > 0);
}

static void run_end(run *r) {
    for (uint32_t i = 0; i < r->trees; ++i) htree_free(r->tree[i]);
    oracle_free(&r->truth);
    rays_total += r->rays;
    answers_total += r->rays * r->trees;
    hits_total += r->hits;
    differences_total += r->differences;
}

static void show_difference(const run *r, uint32_t tree, const char *family, const htree_ray *ray,
                            const htree_hit *is, const htree_hit *should) {
    if (r->differences > 5) return;
    print_message("%s %s %s: org %a %a %a tmin %a dir %a %a %a tmax %a\n", r->scene,
                  htree_kind_name(r->kind[tree]), family, (double)ray->org[0], (double)ray->org[1],
                  (double)ray->org[2], (double)ray->tmin, (double)ray->dir[0], (double)ray->dir[1],
                  (double)ray->dir[2], (double)ray->tmax);
    print_message("  is     t %a u %a v %a prim %u\n  should t %a u %a v %a prim %u\n",
                  (double)is->t, (double)is->u, (double)is->v, is->prim, (double)should->t,
                  (double)should->u, (double)should->v, should->prim);
}

static void compare(run *r, const char *family, const htree_ray *rays, const htree_hit *truth,
                    uint64_t count) {
    htree_hit *const hits = (htree_hit *)take(count * sizeof *hits);
    uint8_t *const any = (uint8_t *)take(count);
    for (uint32_t k = 0; k < r->trees; ++k) {
        memset(hits, 0x5a, (size_t)(count * sizeof *hits));
        memset(any, 0x5a, (size_t)count);
        assert_int_equal(htree_intersect(r->tree[k], rays, count, hits, NULL), HTREE_OK);
        assert_int_equal(htree_occluded(r->tree[k], rays, count, any, NULL), HTREE_OK);
        for (uint64_t i = 0; i < count; ++i) {
            const bool same = memcmp(&hits[i], &truth[i], sizeof hits[i]) == 0;
            const bool same_any = any[i] == (truth[i].prim != HTREE_NONE);
            if (same && same_any) continue;
            ++r->differences;
            show_difference(r, k, family, &rays[i], &hits[i], &truth[i]);
            if (same) print_message("  any-hit says %u\n", any[i]);
        }
    }
    free(hits);
    free(any);
}

/* `per_family` rays of every family, in batches of at most 4096. */
static void run_rays(run *r, uint64_t per_family, uint64_t seed) {
    enum { BATCH = 4096 };
    dice d = {seed};
    htree_ray *const rays = (htree_ray *)take(BATCH * sizeof *rays);
    htree_hit *const truth = (htree_hit *)take(BATCH * sizeof *truth);
    for (uint32_t family = 0; family < RAY_FAMILIES; ++family) {
        for (uint64_t done = 0; done < per_family;) {
            const uint64_t count = per_family - done < BATCH ? per_family - done : BATCH;
            rays_make(&r->target, family, &d, rays, count);
            r->hits += oracle_batch(&r->truth, rays, count, truth);
            compare(r, ray_family_name(family), rays, truth, count);
            r->rays += count;
            done += count;
        }
    }
    free(rays);
    free(truth);
}

static void report(const char *what) {
    say("%s: %llu rays per structure, %llu hits, %llu differences", what,
        (unsigned long long)rays_total, (unsigned long long)hits_total,
        (unsigned long long)differences_total);
    tally("oracle rays", answers_total);
    const uint64_t differences = differences_total;
    rays_total = answers_total = hits_total = differences_total = 0;
    assert_int_equal(differences, 0);
}

/* ---- The claims ----------------------------------------------------------------------------- */

static void every_kind_equals_oracle_on_every_shape_and_ray_family(void **state) {
    (void)state;
    uint32_t seed = 1;
    for (const char *const *name = shape_names(); *name != NULL; ++name, ++seed) {
        for (uint64_t triangles = 40; triangles <= 640; triangles *= 16) {
            shape s = shape_of(*name, triangles, seed);
            const htree_mesh mesh = mesh_of(&s);
            run r;
            run_begin(&r, *name, &mesh);
            run_rays(&r, scaled(triangles == 40 ? 5200 : 3000), seed);
            run_end(&r);
            shape_free(&s);
        }
    }
    report("shapes");
}

static void every_kind_equals_oracle_on_large_shapes(void **state) {
    static const char *const names[] = {"knot", "terrain", "soup", "slivers"};
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(names); ++i) {
        shape s = shape_of(names[i], 20000, 7 + i);
        const htree_mesh mesh = mesh_of(&s);
        run r;
        run_begin(&r, names[i], &mesh);
        run_rays(&r, scaled(300), 100 + i);
        run_end(&r);
        shape_free(&s);
    }
    report("20000 triangles");
}

/* From denormal extents, where every bound rounds, to the largest coordinates there are. */
static void every_kind_equals_oracle_at_every_scale(void **state) {
    static const int exponents[] = {-148, -145, -140, -134, -128, -120, -100, -64, -40, 20, 40, 59};
    (void)state;
    for (uint32_t e = 0; e < COUNT_OF(exponents); ++e) {
        shape s = shape_of(e % 2 != 0 ? "soup" : "sphere", 100, e);
        htree_mesh mesh = mesh_of(&s);
        const float size = ray_target_of(&mesh).size;
        int exponent = 0;
        (void)frexpf(size, &exponent);
        for (uint64_t i = 0; i < 3 * s.vertex_count; ++i) {
            s.positions[i] = ldexpf(s.positions[i], exponents[e] - exponent);
        }
        run r;
        run_begin(&r, "scaled", &mesh);
        run_rays(&r, scaled(1000), 200 + e);
        run_end(&r);
        shape_free(&s);
    }
    report("scales 2^-148 to 2^59");
}

/* The same triangles far from the origin, where coordinates are coarse. */
static void every_kind_equals_oracle_far_from_the_origin(void **state) {
    static const float offsets[][3] = {
        {148376, 1234, -223423}, {16777216, 0, 0}, {1e6f, 1e7f, 1e8f}, {-1e12f, 1, 1e-12f}};
    (void)state;
    for (uint32_t k = 0; k < COUNT_OF(offsets); ++k) {
        shape s = shape_of(k % 2 != 0 ? "soup" : "knot", 300, k);
        for (uint64_t i = 0; i < 3 * s.vertex_count; ++i) s.positions[i] += offsets[k][i % 3];
        const htree_mesh mesh = mesh_of(&s);
        run r;
        run_begin(&r, "offset", &mesh);
        run_rays(&r, scaled(2000), 300 + k);
        run_end(&r);
        shape_free(&s);
    }
    report("offsets");
}

/* Unit cubes on a grid: every slab is touched exactly, by every axis-parallel ray. */
static void every_kind_equals_oracle_on_a_lattice(void **state) {
    enum { SIDE = 4, QUADS = 3 * (SIDE + 1) * SIDE * SIDE };
    static float xyz[QUADS * 18];
    uint32_t n = 0;
    (void)state;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        for (uint32_t i = 0; i < (SIDE + 1) * SIDE * SIDE; ++i) {
            static const uint8_t corner[6][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 0}, {1, 1}, {0, 1}};
            for (uint32_t c = 0; c < 6; ++c, n += 3) {
                xyz[n + axis] = (float)(i % (SIDE + 1));
                xyz[n + (axis + 1) % 3] = (float)(i / (SIDE + 1) % SIDE + corner[c][0]);
                xyz[n + (axis + 2) % 3] = (float)(i / (SIDE + 1) / SIDE + corner[c][1]);
            }
        }
    }
    htree_mesh mesh = {0};
    mesh.positions = xyz;
    mesh.vertex_count = QUADS * 6;
    mesh.triangle_count = QUADS * 2;
    run r;
    run_begin(&r, "lattice", &mesh);
    run_rays(&r, scaled(6000), 400);
    run_end(&r);
    report("lattice");
}

/* Any way through the scene, but not along `axis`. */
static htree_ray ray_within_plane(const run *r, uint32_t axis, float plane, dice *d) {
    float org[3], to[3];
    random_in_box(&r->target.box, 0.5f, d, org);
    random_in_box(&r->target.box, 0, d, to);
    org[axis] = to[axis] = plane;
    htree_ray ray = ray_through(org, to);
    if (dice_below(d, 2) != 0) ray.dir[axis] = -0.0f;
    return ray;
}

/* The distance to such a plane is 0 / 0. */
static void every_kind_equals_oracle_within_planes_of_a_grid(void **state) {
    enum { RAYS = 16 };
    htree_ray rays[RAYS];
    htree_hit truth[RAYS];
    shape s = shape_of("soup", 20000, 9);
    const htree_mesh mesh = mesh_of(&s);
    dice d = {31};
    run r;
    (void)state;
    run_begin(&r, "soup", &mesh);
    assert_int_equal(r.kind[0], HTREE_UG);
    const htree_view view = view_of(r.tree[0]);
    const ht_ug_grid *const grid = (const ht_ug_grid *)view.grid;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        for (uint32_t plane = 1; plane < grid->cells[axis]; ++plane) {
            const float at = grid->lo[axis] + (float)plane * grid->size[axis];
            for (uint32_t i = 0; i < RAYS; ++i) {
                rays[i] = ray_within_plane(&r, axis, nudged(at, (int)(i % 4) - 1), &d);
            }
            r.hits += oracle_batch(&r.truth, rays, RAYS, truth);
            compare(&r, "within a plane", rays, truth, RAYS);
            r.rays += RAYS;
        }
    }
    run_end(&r);
    shape_free(&s);
    report("planes of a grid");
}

/* ---- Options do not change hits ----------------------------------------------------------------
 */

static void with_options(const htree_mesh *mesh, const htree_options *options,
                         const htree_ray *rays, const htree_hit *truth, uint64_t count) {
    htree_hit *const hits = (htree_hit *)take(count * sizeof *hits);
    htree *const tree = tree_of(mesh, options);
    assert_int_equal(htree_intersect(tree, rays, count, hits, NULL), HTREE_OK);
    differences_total += hits_differ(hits, truth, count);
    rays_total += count;
    htree_free(tree);
    free(hits);
}

static void with_all_options(const htree_mesh *mesh, htree_kind kind, const htree_ray *rays,
                             const htree_hit *truth, uint64_t count) {
    static const uint32_t axes[] = {1, 3}, buckets[] = {2, 3, 4, 16, 64}, few[] = {1, 20, 1000};
    static const uint32_t flags[] = {0,
                                     HTREE_ANY_PLANES,
                                     HTREE_LOOSE_PLANES | HTREE_ANY_PLANES,
                                     HTREE_STRICT,
                                     HTREE_MORTON,
                                     HTREE_LAZY,
                                     HTREE_COMPACT,
                                     HTREE_COLLAPSE,
                                     HTREE_COLLAPSE | HTREE_COMPACT};
    static const float cells[] = {1, 64, 1.0f / 64, 7};
    static const float costs[][4] = {{1, 1, 1, 1},     {1, 100, 100, 1},    {100, 1, 100, 1},
                                     {100, 100, 1, 1}, {1e-6f, 1, 1, 1e6f}, {1, 2, 3, 1e-3f}};
    for (uint32_t i = 0; i < COUNT_OF(axes) * COUNT_OF(buckets) * COUNT_OF(costs); ++i) {
        const float *const cost = costs[i / COUNT_OF(axes) / COUNT_OF(buckets)];
        htree_options options = options_of(kind);
        options.threads = 1;
        options.axes = axes[i % COUNT_OF(axes)];
        options.buckets = buckets[i / COUNT_OF(axes) % COUNT_OF(buckets)];
        options.flags = flags[i % COUNT_OF(flags)];
        options.cells_per_prim = cells[i / 2 % COUNT_OF(cells)];
        options.few_prims = few[i / 3 % COUNT_OF(few)];
        options.cost_skd = cost[0];
        options.cost_bv2 = cost[1];
        options.cost_bv6 = cost[2];
        options.cost_intersect = cost[3];
        with_options(mesh, &options, rays, truth, count);
    }
}

static void every_option_gives_the_same_hits(void **state) {
    (void)state;
    const uint64_t count = scaled(420);
    htree_ray *const rays = (htree_ray *)take(count * sizeof *rays);
    htree_hit *const truth = (htree_hit *)take(count * sizeof *truth);
    uint32_t seed = 50;
    for (const char *const *name = shape_names(); *name != NULL; ++name, ++seed) {
        shape s = shape_of(*name, 200, seed);
        const htree_mesh mesh = mesh_of(&s);
        const ray_target target = ray_target_of(&mesh);
        dice d = {seed};
        oracle o = oracle_of(&mesh);
        rays_make_mixed(&target, &d, rays, count);
        (void)oracle_batch(&o, rays, count, truth);
        for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
            with_all_options(&mesh, kind, rays, truth, count);
        }
        oracle_free(&o);
        shape_free(&s);
    }
    free(rays);
    free(truth);
    say("60 sets of options: %llu rays over all structures, %llu differences",
        (unsigned long long)rays_total, (unsigned long long)differences_total);
    tally("oracle rays", rays_total);
    assert_int_equal(differences_total, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_equals_oracle_on_every_shape_and_ray_family),
        cmocka_unit_test(every_kind_equals_oracle_on_large_shapes),
        cmocka_unit_test(every_kind_equals_oracle_at_every_scale),
        cmocka_unit_test(every_kind_equals_oracle_far_from_the_origin),
        cmocka_unit_test(every_kind_equals_oracle_on_a_lattice),
        cmocka_unit_test(every_kind_equals_oracle_within_planes_of_a_grid),
        cmocka_unit_test(every_option_gives_the_same_hits),
    };
    return cmocka_run_group_tests_name("trace", tests, NULL, NULL);
}
