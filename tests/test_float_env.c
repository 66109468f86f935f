/* test_float_env.c: rounding, denormals and traps are the caller's: whatever a thread has set, trees
 * and hits are those of the default environment, and the thread has its own again afterwards. */
#include "pictures.h"
#include "saved.h"

#include <fenv.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

enum { MIXED = 300, WIDTH = 32, HEIGHT = 16, RAYS = MIXED + WIDTH * HEIGHT };

/* ---- Environments --------------------------------------------------------------------------- */

typedef struct mode {
    const char *name;
    int rounding;
    bool flushes; /* denormals count as zero, and come out as zero */
    bool traps;   /* at invalid numbers, divisions by zero, overflows */
} mode;

static const mode modes[] = {
    {"up", FE_UPWARD, false, false},          {"down", FE_DOWNWARD, false, false},
    {"to zero", FE_TOWARDZERO, false, false}, {"flushing", FE_TONEAREST, true, false},
    {"traps", FE_TONEAREST, false, true},     {"all", FE_UPWARD, true, true},
};

/* What this machine can be told beyond its rounding, as it keeps it. */
#if defined(__SSE2__)
static uint32_t control_word(void) {
    return _mm_getcsr() & 0xffc0;
}

static void set_control(const mode *m) {
    if (m->flushes) _mm_setcsr(_mm_getcsr() | 0x8040);
    if (m->traps) _mm_setcsr(_mm_getcsr() & ~UINT32_C(0x0680));
}
#elif defined(__aarch64__)
static uint64_t control_word(void) {
    uint64_t word;
    __asm__ volatile("mrs %0, fpcr" : "=r"(word));
    return word;
}

/* Many of these processors have no traps to set. */
static void set_control(const mode *m) {
    const uint64_t word = control_word() | (m->flushes ? UINT64_C(1) << 24 : 0);
    __asm__ volatile("msr fpcr, %0" : : "r"(word));
}
#else
static int control_word(void) {
    return fegetround();
}

static void set_control(const mode *m) {
    (void)m;
}
#endif

static void set_mode(const mode *m) {
    fesetround(m->rounding);
    set_control(m);
}

static void set_default(void) {
    fesetenv(FE_DFL_ENV);
}

/* ---- What a thread gets --------------------------------------------------------------------- */

typedef struct answers {
    saved file, refitted;
    htree_stats stats;
    double quality;
    htree_hit hits[RAYS], loaded[RAYS], single[RAYS];
    uint8_t occluded[RAYS];
} answers;

typedef struct stage {
    htree_mesh mesh, moved; /* moved: other positions, for a refit */
    htree_options options;
    htree_ray rays[RAYS]; /* of any kind, and a picture after them */
} stage;

static bool all_kept; /* every call so far has left the thread its environment */

/* A call must succeed and leave the environment of the thread as it was. */
#define KEEPS(call)                                                                                \
    do {                                                                                           \
        const uint64_t before = (uint64_t)control_word();                                          \
        if ((call) != HTREE_OK || (uint64_t)control_word() != before) all_kept = false;            \
    } while (0)

/* Every call that computes. What is compared is compared later, in the default environment. */
static void ask(const stage *s, answers *a) {
    htree *tree = NULL, *again = NULL;
    KEEPS(htree_build(&tree, &s->mesh, &s->options));
    if (s->options.flags & HTREE_LAZY)
        KEEPS(htree_intersect(tree, s->rays + RAYS - 1, 1, a->single, NULL));
    KEEPS(htree_complete(tree));
    a->file = saved_of(tree);
    KEEPS(htree_intersect(tree, s->rays, MIXED, a->hits, NULL));
    KEEPS(htree_intersect(tree, s->rays + MIXED, RAYS - MIXED, a->hits + MIXED, NULL));
    KEEPS(htree_occluded(tree, s->rays, RAYS, a->occluded, NULL));
    for (uint32_t i = 0; i < RAYS; i += 7)
        KEEPS(htree_intersect(tree, s->rays + i, 1, a->single + i, NULL));
    a->stats.size = sizeof a->stats;
    KEEPS(htree_get_stats(tree, &a->stats));
    KEEPS(htree_check(tree));
    KEEPS(htree_load(&again, a->file.bytes, a->file.size, NULL));
    KEEPS(htree_intersect(again, s->rays, RAYS, a->loaded, NULL));
    KEEPS(htree_update(tree, &s->moved, HTREE_REFIT, &a->quality));
    a->refitted = saved_of(tree);
    htree_free(again);
    htree_free(tree);
}

static void answers_free(answers *a) {
    saved_free(&a->file);
    saved_free(&a->refitted);
    free(a);
}

static answers *answers_of(const stage *s, const mode *m) {
    answers *const a = (answers *)take(sizeof *a);
    memset(a, 0, sizeof *a);
    all_kept = true;
    if (m) set_mode(m);
    ask(s, a);
    set_default();
    assert_true(all_kept);
    a->stats.build_seconds = 0;
    return a;
}

static void assert_same_file(const saved *is, const saved *should) {
    assert_int_equal(is->size, should->size);
    assert_memory_equal(is->bytes, should->bytes, (size_t)should->size);
}

static void assert_same(const answers *is, const answers *should) {
    assert_same_file(&is->file, &should->file);
    assert_same_file(&is->refitted, &should->refitted);
    assert_memory_equal(&is->stats, &should->stats, sizeof is->stats);
    assert_memory_equal(&is->quality, &should->quality, sizeof is->quality);
    assert_int_equal(hits_differ(is->hits, should->hits, RAYS), 0);
    assert_int_equal(hits_differ(is->loaded, should->hits, RAYS), 0);
    assert_int_equal(hits_differ(is->single, should->single, RAYS), 0);
    assert_memory_equal(is->occluded, should->occluded, sizeof is->occluded);
}

/* ---- Scenes --------------------------------------------------------------------------------- */

static void make_rays(stage *s, uint64_t seed) {
    const ray_target target = ray_target_of(&s->mesh);
    float eye[3], forward[3];
    dice d = {seed};
    rays_make_mixed(&target, &d, s->rays, MIXED);
    picture_view(&target, &d, eye, forward);
    picture p = picture_pinhole(WIDTH, HEIGHT, 0, eye, forward, 1.0f / WIDTH);
    memcpy(s->rays + MIXED, p.rays, (size_t)p.count * sizeof *p.rays);
    free(p.rays);
}

static uint64_t compared;

static void prove(const stage *s) {
    answers *const should = answers_of(s, NULL);
    const uint32_t first =
        scaled(100) < 20 ? COUNT_OF(modes) - 1 : 0; /* slow builds: all at once */
    for (uint32_t m = first; m < COUNT_OF(modes); ++m) {
        answers *const is = answers_of(s, &modes[m]);
        assert_same(is, should);
        answers_free(is);
        ++compared;
    }
    answers_free(should);
}

static float *scaled_positions(const shape *s, float scale) {
    float *const xyz = (float *)take(s->vertex_count * 3 * sizeof *xyz);
    for (uint64_t i = 0; i < s->vertex_count * 3; ++i) xyz[i] = s->positions[i] * scale;
    return xyz;
}

/* Triangles of `scale` for every kind; of 2^-140 most numbers are denormal. */
static void prove_scene(const char *name, uint64_t triangles, float scale) {
    shape made = shape_of(name, triangles, 3);
    float *const xyz = scaled_positions(&made, scale), *const moved =
                                                           scaled_positions(&made, 1.25f * scale);
    stage *const s = (stage *)take(sizeof *s);
    s->mesh = s->moved = mesh_of(&made);
    s->mesh.positions = xyz;
    s->moved.positions = moved;
    make_rays(s, 11);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        s->options = options_of(kind);
        s->options.threads = 3;
        prove(s);
        if (kind != HTREE_WIDE) continue;
        s->options.flags |= HTREE_COMPACT;
        prove(s);
        s->options.flags = (s->options.flags & ~(uint32_t)HTREE_COMPACT) | HTREE_LAZY;
        prove(s);
    }
    free(s);
    free(moved);
    free(xyz);
    shape_free(&made);
}

static void any_environment_gives_the_same_bits(void **state) {
    (void)state;
    prove_scene("city", 500 + scaled(2000), 1);
    prove_scene("knot", 20, 7.174648137343064e-43f); /* 2^-140 */
    say("environments: %llu times all calls in one, the bits of the default one",
        (unsigned long long)compared);
}

/* ---- Threads of a hook ---------------------------------------------------------------------- */

static void run_in_modes(void *user, uint32_t count, void (*task)(void *data, uint32_t index),
                         void *data) {
    ++*(uint32_t *)user;
    for (uint32_t i = 0; i < count; ++i) {
        const mode *const m = &modes[i % COUNT_OF(modes)];
        set_mode(m);
        const uint64_t before = (uint64_t)control_word();
        task(data, i);
        if ((uint64_t)control_word() != before) all_kept = false;
        set_default();
    }
}

static void threads_of_a_hook_may_have_any_environment(void **state) {
    shape made = shape_of("soup", 10000, 5);
    stage *const s = (stage *)take(sizeof *s);
    uint32_t loops = 0;
    (void)state;
    s->mesh = s->moved = mesh_of(&made);
    make_rays(s, 12);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        s->options = options_of(kind);
        answers *const should = answers_of(s, NULL);
        s->options.tasks.run = run_in_modes;
        s->options.tasks.user = &loops;
        answers *const is = answers_of(s, NULL);
        is->stats.peak_bytes = should->stats.peak_bytes;
        assert_same(is, should);
        answers_free(is);
        answers_free(should);
    }
    assert_true(loops > 0);
    free(s);
    shape_free(&made);
    say("environments of a hook's threads: %lu loops", (unsigned long)loops);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_environment_gives_the_same_bits),
        cmocka_unit_test(threads_of_a_hook_may_have_any_environment),
    };
    return cmocka_run_group_tests_name("float_env", tests, NULL, NULL);
}
