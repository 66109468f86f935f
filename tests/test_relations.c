/* test_relations.c: what must follow when a scene, its rays or the way of asking change. No oracle here: a
 * tree is held against itself.
 *
 * A change is exact where float arithmetic is: powers of two, signs, the order of things. Where only the
 * order of a sum in double changes, t may move to the next float. */
#include "ledger.h"
#include "rays.h"
#include "saved.h"

#include <math.h>

enum { MOST_TRIANGLES = 400, RAYS = 64 };

/* A scene, rays and their hits; its changed twin has the hits that must follow. */
typedef struct world {
    uint32_t triangles;
    float xyz[MOST_TRIANGLES][3][3];
    htree_ray rays[RAYS];
    htree_hit hits[RAYS];
    bool is_whole; /* whole numbers, small ones */
} world;

static htree_mesh mesh_of_world(const world *w) {
    return plain_mesh(&w->xyz[0][0][0], w->triangles);
}

static void draw_world(world *w, uint32_t number, dice *d) {
    static const char *const names[] = {"knot", "soup", "slivers", "terrain", "city"};
    memset(w, 0, sizeof *w);
    w->is_whole = number % 3 == 2;
    shape s = shape_of(names[number % COUNT_OF(names)], 20 + dice_below(d, 100), number);
    const htree_mesh mesh = mesh_of(&s);
    for (uint32_t i = 0; i < mesh.triangle_count && i < MOST_TRIANGLES / 2; ++i, ++w->triangles) {
        for (uint32_t c = 0; c < 3; ++c) {
            const float *const p = mesh_corner(&mesh, i, c);
            for (int k = 0; k < 3; ++k) w->xyz[i][c][k] = w->is_whole ? floorf(16 * p[k]) : p[k];
        }
    }
    shape_free(&s);
    const htree_mesh own = mesh_of_world(w);
    const ray_target target = ray_target_of(&own);
    for (uint32_t i = 0; i < RAYS; ++i) {
        /* Families beyond these have special numbers in their rays, which do not scale. */
        rays_make(&target, i % 4, d, &w->rays[i], 1);
        w->rays[i].tmin = 0;
        w->rays[i].tmax = dice_below(d, 4) ? INFINITY : dice_between(d, 0, 4);
        for (int k = 0; k < 3 && w->is_whole; ++k) {
            w->rays[i].org[k] = floorf(w->rays[i].org[k]);
            w->rays[i].dir[k] = (float)dice_below(d, 15) - 7 + (k == 0 ? 0.25f : 0);
        }
    }
}

static void ask(const htree *tree, const world *w, htree_hit *hits) {
    assert_int_equal(htree_intersect(tree, w->rays, RAYS, hits, NULL), HTREE_OK);
}

/* ---- Changes of the world --------------------------------------------------------------------- */

/* Makes *x, the changed twin of *w, with the hits that follow. */
typedef void change_world(const world *w, world *x, dice *d);

static void scale_hits(world *x, float scale) {
    for (uint32_t i = 0; i < RAYS; ++i) {
        x->rays[i].tmin *= scale;
        x->rays[i].tmax *= scale;
        x->hits[i].t *= scale;
    }
}

static void scale_space(const world *w, world *x, dice *d) {
    const float scale = ldexpf(1, (int)dice_below(d, 61) - 30);
    (void)w;
    for (uint32_t i = 0; i < x->triangles; ++i)
        for (int k = 0; k < 9; ++k) x->xyz[i][k / 3][k % 3] *= scale;
    for (uint32_t i = 0; i < RAYS; ++i)
        for (int k = 0; k < 3; ++k) x->rays[i].org[k] *= scale;
    scale_hits(x, scale);
}

static void scale_directions(const world *w, world *x, dice *d) {
    const int exponent = (int)dice_below(d, 41) - 20;
    (void)w;
    for (uint32_t i = 0; i < RAYS; ++i)
        for (int k = 0; k < 3; ++k) x->rays[i].dir[k] = ldexpf(x->rays[i].dir[k], exponent);
    scale_hits(x, ldexpf(1, -exponent));
}

static void mirror_an_axis(const world *w, world *x, dice *d) {
    const uint32_t axis = dice_below(d, 3);
    (void)w;
    for (uint32_t i = 0; i < x->triangles; ++i)
        for (int c = 0; c < 3; ++c) x->xyz[i][c][axis] = -x->xyz[i][c][axis];
    for (uint32_t i = 0; i < RAYS; ++i) {
        x->rays[i].org[axis] = -x->rays[i].org[axis];
        x->rays[i].dir[axis] = -x->rays[i].dir[axis];
    }
}

/* The axis that the triangle test takes for z must not depend on a tie. */
static bool has_one_largest(const float *dir) {
    const float x = fabsf(dir[0]), y = fabsf(dir[1]), z = fabsf(dir[2]);
    return (x > y && x > z) || (y > x && y > z) || (z > x && z > y);
}

static void turn_axes(const world *w, world *x, dice *d) {
    (void)d;
    for (uint32_t i = 0; i < x->triangles; ++i)
        for (int k = 0; k < 9; ++k) x->xyz[i][k / 3][(k + 1) % 3] = w->xyz[i][k / 3][k % 3];
    for (uint32_t i = 0; i < RAYS; ++i) {
        for (int k = 0; k < 3; ++k) {
            x->rays[i].org[(k + 1) % 3] = w->rays[i].org[k];
            x->rays[i].dir[(k + 1) % 3] = w->rays[i].dir[k];
        }
        if (has_one_largest(w->rays[i].dir)) continue;
        x->rays[i].tmin = x->hits[i].t = 1; /* a ray that misses by its numbers */
        x->rays[i].tmax = x->hits[i].t = 0;
        x->hits[i].u = x->hits[i].v = 0;
        x->hits[i].prim = HTREE_NONE;
    }
}

/* The first come first; ties may fall to another prim, so the order is kept among equals of t. */
static void turn_order(const world *w, world *x, dice *d) {
    const uint32_t shift = 1 + dice_below(d, w->triangles);
    for (uint32_t i = 0; i < w->triangles; ++i)
        memcpy(x->xyz[(i + shift) % w->triangles], w->xyz[i], sizeof w->xyz[i]);
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (w->hits[i].prim != HTREE_NONE)
            x->hits[i].prim = (w->hits[i].prim + shift) % w->triangles;
    }
}

/* v0 becomes the last corner: the weights 1 - u - v, u, v change places. */
static void turn_corners(const world *w, world *x, dice *d) {
    (void)d;
    for (uint32_t i = 0; i < w->triangles; ++i)
        for (uint32_t c = 0; c < 3; ++c)
            memcpy(x->xyz[i][(c + 2) % 3], w->xyz[i][c], sizeof w->xyz[i][c]);
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (w->hits[i].prim == HTREE_NONE) continue;
        x->hits[i].u = w->hits[i].v;
        x->hits[i].v = 1 - w->hits[i].u - w->hits[i].v;
    }
}

static void flip_triangles(const world *w, world *x, dice *d) {
    (void)d;
    for (uint32_t i = 0; i < w->triangles; ++i) {
        memcpy(x->xyz[i][1], w->xyz[i][2], sizeof w->xyz[i][2]);
        memcpy(x->xyz[i][2], w->xyz[i][1], sizeof w->xyz[i][1]);
    }
    for (uint32_t i = 0; i < RAYS; ++i) {
        x->hits[i].u = w->hits[i].v;
        x->hits[i].v = w->hits[i].u;
    }
}

/* Of twins the lower number is hit. */
static void add_twins(const world *w, world *x, dice *d) {
    (void)d;
    memcpy(x->xyz[w->triangles], w->xyz, w->triangles * sizeof w->xyz[0]);
    x->triangles = 2 * w->triangles;
}

static void add_what_is_never_hit(const world *w, world *x, dice *d) {
    static const float bad[] = {NAN, INFINITY, -INFINITY, 2e18f, -3e38f};
    (void)w;
    for (int i = 0; i < 60; ++i) {
        float(*const t)[3] = x->xyz[x->triangles++];
        for (int k = 0; k < 9; ++k) t[k / 3][k % 3] = dice_between(d, -1, 1);
        if (i % 2)
            t[dice_below(d, 3)][dice_below(d, 3)] = bad[dice_below(d, COUNT_OF(bad))];
        else
            memcpy(t[0], t[dice_below(d, 2) + 1], sizeof t[0]);
    }
}

/* Beyond all that is there, and beyond every tmax. */
static void add_what_lies_beyond(const world *w, world *x, dice *d) {
    (void)w;
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (isinf(x->rays[i].tmax)) x->rays[i].tmax = x->hits[i].t = fminf(x->hits[i].t, 1e9f);
    }
    for (int i = 0; i < 20; ++i) {
        float(*const t)[3] = x->xyz[x->triangles++];
        for (int k = 0; k < 9; ++k)
            t[k / 3][k % 3] = (k % 3 == 0 ? 1e15f : 1e14f) * dice_between(d, 1, 2);
    }
}

static void remove_what_is_not_hit(const world *w, world *x, dice *d) {
    uint32_t number[MOST_TRIANGLES];
    bool kept[MOST_TRIANGLES] = {false};
    for (uint32_t i = 0; i < RAYS; ++i)
        if (w->hits[i].prim != HTREE_NONE) kept[w->hits[i].prim] = true;
    x->triangles = 0;
    for (uint32_t i = 0; i < w->triangles; ++i) {
        if (!kept[i] && dice_below(d, 4)) continue;
        memcpy(x->xyz[x->triangles], w->xyz[i], sizeof w->xyz[i]);
        number[i] = x->triangles++;
    }
    for (uint32_t i = 0; i < RAYS; ++i)
        if (w->hits[i].prim != HTREE_NONE) x->hits[i].prim = number[w->hits[i].prim];
}

static void negate_zeros(const world *w, world *x, dice *d) {
    float *const xyz = &x->xyz[0][0][0];
    (void)w;
    (void)d;
    for (uint32_t i = 0; i < 9 * x->triangles; ++i)
        if (xyz[i] == 0) xyz[i] = -xyz[i];
    for (uint32_t i = 0; i < RAYS; ++i) {
        float *const f = x->rays[i].org; /* and all that follows it */
        for (int k = 0; k < 8; ++k)
            if (f[k] == 0) f[k] = -f[k];
    }
}

/* Whole numbers move by whole numbers without rounding. */
static void move_whole_numbers(const world *w, world *x, dice *d) {
    float by[3];
    for (int k = 0; k < 3; ++k) by[k] = w->is_whole ? (float)dice_below(d, 100000) - 50000 : 0;
    for (uint32_t i = 0; i < x->triangles; ++i)
        for (int k = 0; k < 9; ++k) x->xyz[i][k / 3][k % 3] += by[k % 3];
    for (uint32_t i = 0; i < RAYS; ++i)
        for (int k = 0; k < 3; ++k) x->rays[i].org[k] += by[k];
}

/* tmin may come up to the hit, and tmax down to it. */
static void close_in(const world *w, world *x, dice *d) {
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (w->hits[i].prim == HTREE_NONE) continue;
        if (dice_below(d, 2)) x->rays[i].tmin = w->hits[i].t;
        if (dice_below(d, 2)) x->rays[i].tmax = w->hits[i].t;
    }
}

static void end_just_before(const world *w, world *x, dice *d) {
    (void)d;
    for (uint32_t i = 0; i < RAYS; ++i) {
        if (w->hits[i].prim == HTREE_NONE) continue;
        x->rays[i].tmax = nextafterf(w->hits[i].t, -INFINITY);
        x->hits[i].t = x->rays[i].tmax;
        x->hits[i].u = x->hits[i].v = 0;
        x->hits[i].prim = HTREE_NONE;
    }
}

typedef enum strictness { EXACT, NEXT_FLOAT, TIES } strictness;

static const struct {
    const char *name;
    change_world *change;
    strictness how;
} changes[] = {
    {"scale space by a power of two", scale_space, EXACT},
    {"scale directions by a power of two", scale_directions, EXACT},
    {"mirror an axis", mirror_an_axis, EXACT},
    {"turn the axes", turn_axes, EXACT},
    {"turn the order of triangles", turn_order, TIES},
    {"turn the corners of triangles", turn_corners, NEXT_FLOAT},
    {"flip triangles", flip_triangles, NEXT_FLOAT},
    {"add twins", add_twins, EXACT},
    {"add what is never hit", add_what_is_never_hit, EXACT},
    {"add what lies beyond", add_what_lies_beyond, EXACT},
    {"remove what is not hit", remove_what_is_not_hit, EXACT},
    {"negate zeros", negate_zeros, EXACT},
    {"move whole numbers", move_whole_numbers, EXACT},
    {"close in on the hit", close_in, EXACT},
    {"end just before the hit", end_just_before, EXACT},
};

/* Values, not bits: a mirrored 0 may be -0. */
static bool follows(const htree_hit *is, const htree_hit *should, strictness how) {
    const bool same_prim = is->prim == should->prim;
    if (how == EXACT)
        return same_prim && is->t == should->t && is->u == should->u && is->v == should->v;
    if ((is->prim == HTREE_NONE) != (should->prim == HTREE_NONE)) return false;
    if (how == TIES) return is->t == should->t && (!same_prim || is->u == should->u);
    const bool near = is->t == should->t || nextafterf(is->t, should->t) == should->t;
    return near &&
           (!same_prim || (fabsf(is->u - should->u) <= 3e-7f && fabsf(is->v - should->v) <= 3e-7f));
}

static void check_changes(const world *w, htree_kind kind, dice *d, uint64_t *checked) {
    static world x;
    htree_hit hits[RAYS];
    for (uint32_t r = 0; r < COUNT_OF(changes); ++r) {
        memcpy(&x, w, sizeof x);
        changes[r].change(w, &x, d);
        const htree_mesh mesh = mesh_of_world(&x);
        htree *const tree = tree_of_kind(&mesh, kind);
        ask(tree, &x, hits);
        htree_free(tree);
        for (uint32_t i = 0; i < RAYS; ++i) {
            if (follows(&hits[i], &x.hits[i], changes[r].how)) continue;
            fail_msg("%s, %s: ray %lu: t %a prim %lu, should be t %a prim %lu",
                     htree_kind_name(kind), changes[r].name, (unsigned long)i, (double)hits[i].t,
                     (unsigned long)hits[i].prim, (double)x.hits[i].t,
                     (unsigned long)x.hits[i].prim);
        }
        *checked += RAYS;
    }
}

/* ---- Changes of the way of asking --------------------------------------------------------------- */

static void must_be_same(const htree_hit *is, const world *w, const char *what) {
    if (hits_differ(is, w->hits, RAYS) != 0) fail_msg("other hits: %s", what);
}

static void ask_backwards_and_one_by_one(const htree *tree, const world *w) {
    htree_ray rays[RAYS];
    htree_hit hits[RAYS], back[RAYS];
    for (uint32_t i = 0; i < RAYS; ++i) rays[i] = w->rays[RAYS - 1 - i];
    assert_int_equal(htree_intersect(tree, rays, RAYS, back, NULL), HTREE_OK);
    for (uint32_t i = 0; i < RAYS; ++i) hits[i] = back[RAYS - 1 - i];
    must_be_same(hits, w, "backwards");
    for (uint32_t i = 0; i < RAYS; ++i)
        assert_int_equal(htree_intersect(tree, &w->rays[i], 1, &hits[i], NULL), HTREE_OK);
    must_be_same(hits, w, "one by one");
}

static void ask_for_any(const htree *tree, const world *w) {
    uint8_t any[RAYS];
    assert_int_equal(htree_occluded(tree, w->rays, RAYS, any, NULL), HTREE_OK);
    for (uint32_t i = 0; i < RAYS; ++i) assert_int_equal(any[i], w->hits[i].prim != HTREE_NONE);
}

/* The nearer hit of two halves of the interval is that of the whole. */
static void ask_for_halves(const htree *tree, const world *w, dice *d) {
    world halves = *w;
    htree_hit first[RAYS], second[RAYS];
    for (uint32_t i = 0; i < RAYS; ++i) {
        const float middle = dice_between(d, 0, 3), most = w->rays[i].tmax;
        halves.rays[i].tmax = middle < most ? middle : most;
    }
    ask(tree, &halves, first);
    for (uint32_t i = 0; i < RAYS; ++i) {
        halves.rays[i].tmin = halves.rays[i].tmax;
        halves.rays[i].tmax = w->rays[i].tmax;
    }
    ask(tree, &halves, second);
    for (uint32_t i = 0; i < RAYS; ++i)
        if (first[i].prim == HTREE_NONE) first[i] = second[i];
    must_be_same(first, w, "halves");
}

static void ask_while_counting_on_threads(const htree *tree, const world *w) {
    htree_counters counters[RAYS];
    htree_hit hits[RAYS];
    htree_query query;
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    query.threads = 3;
    assert_int_equal(htree_intersect(tree, w->rays, RAYS, hits, &query), HTREE_OK);
    must_be_same(hits, w, "on threads");
    query.counters = counters;
    assert_int_equal(htree_intersect(tree, w->rays, RAYS, hits, &query), HTREE_OK);
    must_be_same(hits, w, "while counting");
}

static void ask_its_file(const htree *tree, const world *w) {
    htree_hit hits[RAYS];
    htree *back = NULL;
    saved file = saved_of(tree);
    assert_int_equal(htree_load(&back, file.bytes, file.size, NULL), HTREE_OK);
    ask(back, w, hits);
    must_be_same(hits, w, "saved and loaded");
    htree_free(back);
    saved_free(&file);
}

/* The same triangles by indices and among other data, by other options, in other memory. */
static void ask_its_twins(const world *w, htree_kind kind, dice *d) {
    static float wide[3 * MOST_TRIANGLES][5];
    static uint32_t indices[3 * MOST_TRIANGLES];
    htree_hit hits[RAYS];
    ledger books;
    for (uint32_t i = 0; i < 3 * w->triangles; ++i) {
        const uint32_t to = 3 * w->triangles - 1 - i;
        memcpy(wide[to], w->xyz[i / 3][i % 3], 3 * sizeof(float));
        wide[to][3] = wide[to][4] = NAN;
        indices[i] = to;
    }
    htree_mesh mesh = plain_mesh(&wide[0][0], w->triangles);
    mesh.position_stride = sizeof wide[0];
    mesh.indices = indices;
    ledger_init(&books);
    htree_options options = options_of(kind);
    options.allocator = ledger_allocator(&books);
    options.threads = 1 + dice_below(d, 4);
    options.buckets = 2 + dice_below(d, 63);
    options.axes = dice_below(d, 2) ? 1 : 3;
    options.few_prims = 1 + dice_below(d, 100);
    options.flags = dice_below(d, 2) ? HTREE_ANY_PLANES : HTREE_LOOSE_PLANES;
    options.cost_intersect = dice_between(d, 0.1f, 10);
    htree *const tree = tree_of(&mesh, &options);
    ask(tree, w, hits);
    must_be_same(hits, w, "by indices and other options");
    htree_free(tree);
    ledger_assert_balanced(&books);
    ledger_free(&books);
}

/* ---- Runs --------------------------------------------------------------------------------------- */

static void what_must_follow_follows(void **state) {
    static world w;
    const uint64_t worlds = scaled(800);
    uint64_t checked = 0, hits = 0;
    dice d = {29};
    (void)state;
    for (uint64_t n = 0; n < worlds; ++n) {
        draw_world(&w, (uint32_t)n, &d);
        for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
            const htree_mesh mesh = mesh_of_world(&w);
            htree *const tree = tree_of_kind(&mesh, kind);
            htree_hit first[RAYS];
            ask(tree, &w, first);
            if (kind > HTREE_UG) must_be_same(first, &w, "of another kind");
            memcpy(w.hits, first, sizeof first);
            for (uint32_t i = 0; i < RAYS; ++i) hits += first[i].prim != HTREE_NONE;
            ask_backwards_and_one_by_one(tree, &w);
            ask_for_any(tree, &w);
            ask_for_halves(tree, &w, &d);
            ask_while_counting_on_threads(tree, &w);
            ask_its_file(tree, &w);
            ask_its_twins(&w, kind, &d);
            checked += 9 * RAYS;
            htree_free(tree);
            check_changes(&w, kind, &d, &checked);
        }
    }
    say("24 relations, %llu worlds on every kind: %llu hits, %llu rays held against each other",
        (unsigned long long)worlds, (unsigned long long)hits, (unsigned long long)checked);
    assert_true(hits > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_must_follow_follows),
    };
    return cmocka_run_group_tests_name("relations", tests, NULL, NULL);
}
