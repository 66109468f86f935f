/* test_memory.c: every byte goes through the hook and comes back, and every allocation may fail. */
#include "ledger.h"
#include "rays.h"
#include "base/memory.h"

enum { RAYS = 1500 };

/* A build with assertions ends with a check of its own, which allocates and may fail quietly. */
#ifdef NDEBUG
static const bool checks_itself = false;
#else
static const bool checks_itself = true;
#endif

/* Thread sanitizer looks for races, not for failures. */
#ifdef SUITE_TSAN
enum { FAILURE_STEP = 7 };
#else
enum { FAILURE_STEP = 1 };
#endif

static uint64_t failures_injected;

typedef struct scenario {
    const char *shape;
    uint64_t triangles;
    uint32_t threads;
    bool objects;
    htree_kind kind; /* 0: every kind */
    uint32_t flags;
} scenario;

static const scenario scenarios[] = {
    {"none", 0, 1, false, 0, 0},
    {"one", 1, 1, false, 0, 0},
    {"soup", 50, 1, false, 0, 0},
    {"same", 700, 1, false, 0, 0},
    {"knot", 5000, 1, false, 0, 0},
    {"knot", 5000, 4, true, 0, 0},
    {"terrain", 3000, 1, true, 0, 0},
    {"none", 0, 1, true, 0, 0},
    {"crowd", 11000, 2, false, HTREE_WIDE, 0}, /* with crowded cells */
    {"same", 11000, 1, false, HTREE_WIDE, 0},
    {"knot", 11000, 2, true, HTREE_WIDE, HTREE_MORTON},
    {"crowd", 11000, 1, false, HTREE_WIDE, HTREE_LAZY},
};

/* Everything that a scenario needs, and its hits of a clean run. */
typedef struct stage {
    shape s;
    htree_mesh mesh;
    htree_box boxes[20];
    htree_objects objects;
    htree_options options;
    ledger books;
    htree_ray rays[RAYS];
    htree_hit hits[RAYS], first_hits[RAYS];
} stage;

static void stage_begin(stage *g, const scenario *c, htree_kind kind) {
    dice d = {3};
    memset(g, 0, sizeof *g);
    g->s = shape_of(c->shape, scaled(100) < 20 ? 1 + c->triangles / 5 : c->triangles, 1);
    g->mesh = mesh_of(&g->s);
    const ray_target target = ray_target_of(&g->mesh);
    for (uint32_t i = 0; i < COUNT_OF(g->boxes); ++i) {
        random_in_box(&target.box, 0, &d, g->boxes[i].lo);
        memcpy(g->boxes[i].hi, g->boxes[i].lo, sizeof g->boxes[i].hi);
    }
    g->objects.boxes = g->boxes;
    g->objects.count = COUNT_OF(g->boxes);
    g->objects.intersect = never_hit;
    if (c->objects) g->mesh.objects = &g->objects;
    ledger_init(&g->books);
    g->options = options_of(kind);
    g->options.threads = c->threads;
    g->options.flags |= c->flags;
    g->options.allocator = ledger_allocator(&g->books);
    rays_make_mixed(&target, &d, g->rays, RAYS);
}

static void stage_end(stage *g) {
    ledger_assert_balanced(&g->books);
    ledger_free(&g->books);
    shape_free(&g->s);
}

/* Builds, queries, inspects and frees; the hits go to `hits`. Returns the allocations of the
 * build. */
static uint64_t clean_run(stage *g, htree_hit *hits) {
    htree *tree = NULL;
    ledger_fail(&g->books, 0, false);
    assert_int_equal(htree_build(&tree, &g->mesh, &g->options), HTREE_OK);
    const uint64_t calls = g->books.calls;
    assert_int_equal(htree_intersect(tree, g->rays, RAYS, hits, NULL), HTREE_OK);
    htree_free(tree);
    assert_int_equal(g->books.live_blocks, 0);
    return calls;
}

static void for_each_scenario(void (*prove)(stage *g)) {
    stage *const g = (stage *)take(sizeof *g);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        for (uint32_t i = 0; i < COUNT_OF(scenarios); ++i) {
            if (scenarios[i].kind != 0 && scenarios[i].kind != kind) continue;
            stage_begin(g, &scenarios[i], kind);
            prove(g);
            stage_end(g);
        }
    }
    free(g);
}

/* ---- Books ---------------------------------------------------------------------------------- */

static void prove_balance(stage *g) {
    htree *tree = NULL;
    assert_int_equal(htree_build(&tree, &g->mesh, &g->options), HTREE_OK);
    const htree_stats stats = stats_of(tree);
    assert_int_equal(stats.bytes, g->books.live_bytes);
    if (checks_itself) {
        assert_true(stats.peak_bytes <= g->books.peak_bytes);
    } else {
        assert_int_equal(stats.peak_bytes, g->books.peak_bytes);
    }
    const uint64_t live = g->books.live_bytes;
    assert_int_equal(htree_check(tree), HTREE_OK);
    assert_int_equal(htree_intersect(tree, g->rays, RAYS, g->hits, NULL), HTREE_OK);
    assert_int_equal(g->books.live_bytes, live);
    htree_free(tree);
    ledger_assert_balanced(&g->books);
    assert_true(g->books.calls < 200); /* a number of blocks that does not grow with the mesh */
}

static void every_byte_is_counted_and_comes_back(void **state) {
    (void)state;
    for_each_scenario(prove_balance);
}

/* ---- Failures ------------------------------------------------------------------------------- */

static void fail_build_at(stage *g, uint64_t call, bool for_good) {
    htree *tree = (htree *)(uintptr_t)8;
    ledger_fail(&g->books, call, for_good);
    const htree_status status = htree_build(&tree, &g->mesh, &g->options);
    ledger_fail(&g->books, 0, false);
    if (status == HTREE_OK && checks_itself) { /* the call that failed was the check's */
        htree_free(tree);
    } else {
        assert_int_equal(status, HTREE_ERROR_MEMORY);
        assert_null(tree);
        assert_true(strlen(htree_error_text()) > 5);
    }
    ledger_assert_balanced(&g->books);
    ++failures_injected;
}

/* A failure past the last allocation that a build needs must not be one; before it, it must. */
static void prove_failures(stage *g) {
    const uint64_t calls = clean_run(g, g->first_hits);
    assert_int_equal(clean_run(g, g->hits), calls);
    assert_true(calls > 0);
    for (uint64_t call = 1; call <= calls; call += FAILURE_STEP) {
        fail_build_at(g, call, false);
        fail_build_at(g, call, true);
        (void)clean_run(g, g->hits);
        assert_int_equal(hits_differ(g->hits, g->first_hits, RAYS), 0);
    }
}

static void a_build_survives_the_failure_of_any_allocation(void **state) {
    (void)state;
    for_each_scenario(prove_failures);
}

/* Queries allocate nothing, so no failure can reach them; a check says that it could not be
 * made. */
static void prove_tree_without_memory(stage *g) {
    htree *tree = NULL;
    (void)clean_run(g, g->first_hits);
    assert_int_equal(htree_build(&tree, &g->mesh, &g->options), HTREE_OK);
    const uint64_t live = g->books.live_bytes;
    for (uint64_t call = 1; call <= 20; ++call) {
        ledger_fail(&g->books, call, call % 2 != 0);
        assert_int_equal(htree_intersect(tree, g->rays, RAYS, g->hits, NULL), HTREE_OK);
        assert_int_equal(hits_differ(g->hits, g->first_hits, RAYS), 0);
        (void)stats_of(tree);
        const htree_status status = htree_check(tree);
        assert_true(status == HTREE_ERROR_MEMORY || (status == HTREE_OK && g->books.calls < call));
        assert_int_equal(g->books.live_bytes, live);
        ++failures_injected;
        if (status == HTREE_OK) break;
    }
    ledger_fail(&g->books, 0, false);
    assert_int_equal(htree_check(tree), HTREE_OK);
    htree_free(tree);
}

static void a_tree_works_on_without_memory(void **state) {
    (void)state;
    for_each_scenario(prove_tree_without_memory);
}

static void every_failed_build_gives_memory_back(void **state) {
    static const float xyz[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t indices[6] = {0, 1, 2, 0, 1, 3};
    ledger books;
    (void)state;
    ledger_init(&books);
    for (htree_kind kind = HTREE_UG; kind <= HTREE_WIDE; ++kind) {
        htree *tree = NULL;
        htree_mesh mesh = {0};
        htree_options options = options_of(kind);
        options.allocator = ledger_allocator(&books);
        mesh.positions = xyz;
        mesh.vertex_count = 3;
        mesh.indices = indices;
        mesh.triangle_count = 2;
        assert_int_not_equal(htree_build(&tree, &mesh, &options), HTREE_OK);
        ledger_assert_balanced(&books);
    }
    ledger_free(&books);
}

/* ---- Kept blocks ---------------------------------------------------------------------------- */

/* Takes and releases a block; returns whether it was a new one. */
static bool is_fresh(ht_memory *memory, const ledger *books, uint64_t bytes) {
    const uint64_t before = books->calls;
    void *const block = ht_allocate(memory, bytes);
    assert_non_null(block);
    ht_release(memory, block, bytes);
    return books->calls > before;
}

/* A recycler has room for some hundred blocks: a larger one takes the place of the smallest. */
static void large_blocks_are_kept_first(void **state) {
    enum { BLOCKS = 400, BYTES = 1 << 15 };
    static void *block[BLOCKS];
    ledger books;
    (void)state;
    ledger_init(&books);
    ht_memory memory = {ledger_allocator(&books), 0, 0, NULL};
    assert_non_null(ht_recycler_begin(&memory));
    for (uint64_t i = 0; i < BLOCKS; ++i) block[i] = ht_allocate(&memory, BYTES + i);
    assert_int_equal(books.live_blocks, BLOCKS + 1);
    for (uint64_t i = 0; i < BLOCKS; ++i) ht_release(&memory, block[i], BYTES + i);
    const uint64_t kept = books.live_blocks - 1;
    assert_true(kept > 0 && kept < BLOCKS);
    assert_true(is_fresh(&memory, &books, 8 * BYTES));
    assert_false(is_fresh(&memory, &books, 8 * BYTES));
    assert_false(is_fresh(&memory, &books, BYTES + BLOCKS - 1)); /* the largest of the others */
    assert_true(is_fresh(&memory, &books, BYTES / 2 - 1));       /* smaller than any that is kept */
    assert_true(is_fresh(&memory, &books, BYTES / 2 - 1));
    assert_int_equal(books.live_blocks, kept + 1);
    ht_recycler_end(&memory);
    ledger_assert_balanced(&books);
    ledger_free(&books);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_byte_is_counted_and_comes_back),
        cmocka_unit_test(a_build_survives_the_failure_of_any_allocation),
        cmocka_unit_test(a_tree_works_on_without_memory),
        cmocka_unit_test(every_failed_build_gives_memory_back),
        cmocka_unit_test(large_blocks_are_kept_first),
    };
    const int failed = cmocka_run_group_tests_name("memory", tests, NULL, NULL);
    say("%llu allocation failures injected", (unsigned long long)failures_injected);
    tally("allocation failures", failures_injected);
    return failed;
}
