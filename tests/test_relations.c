/* test_relations.c: what must follow when a scene, its rays or the way of asking change. No oracle here: a
 * tree is held against itself. */
#include "ledger.h"
#include "saved.h"
#include "worlds.h"

#include <math.h>

enum { RAYS = WORLD_RAYS };

static void ask(const htree *tree, const world *w, htree_hit *hits) {
    assert_int_equal(htree_intersect(tree, w->rays, RAYS, hits, NULL), HTREE_OK);
}

/* ---- Changes of the world --------------------------------------------------------------------- */

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
    for (uint32_t r = 0; r < WORLD_CHANGES; ++r) {
        memcpy(&x, w, sizeof x);
        world_changes[r].change(w, &x, d);
        const htree_mesh mesh = mesh_of_world(&x);
        htree *const tree = tree_of_kind(&mesh, kind);
        ask(tree, &x, hits);
        htree_free(tree);
        for (uint32_t i = 0; i < RAYS; ++i) {
            if (follows(&hits[i], &x.hits[i], world_changes[r].how)) continue;
            fail_msg("%s, %s: ray %lu: t %a prim %lu, should be t %a prim %lu",
                     htree_kind_name(kind), world_changes[r].name, (unsigned long)i,
                     (double)hits[i].t, (unsigned long)hits[i].prim, (double)x.hits[i].t,
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
    static float wide[3 * WORLD_TRIANGLES][5];
    static uint32_t indices[3 * WORLD_TRIANGLES];
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
