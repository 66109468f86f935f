/* fuzz_api.c: any sequence of calls with good and with bad arguments, over a few trees, while memory
 * runs out and progress cancels. Statuses are those that htree.h names, failures write nothing, and in
 * the end everything has come back. */
#include "fuzz.h"
#include "ledger.h"

#include <math.h>

enum { TREES = 4, RAYS = 5 };

typedef struct machine {
    fuzz_bytes b;
    ledger books;
    htree *trees[TREES];
    uint32_t reports; /* until progress cancels; 0: never */
} machine;

/* A tree, or none: then the call must refuse NULL. */
static htree *any_tree(machine *m) {
    return m->trees[fuzz_u8(&m->b) % TREES];
}

static int32_t report(void *user, double fraction) {
    machine *const m = (machine *)user;
    assert_true(fraction >= 0 && fraction <= 1);
    return m->reports > 0 && --m->reports == 0;
}

/* A status that the call may return; a failure is told in words. */
static bool succeeded(htree_status status, uint32_t allowed) {
    if (status == HTREE_OK) return true;
    assert_true(status > 0 && status < 32 && (allowed >> status & 1));
    assert_true(htree_error_text()[0] != 0);
    return false;
}

#define MAY(name) (1u << HTREE_ERROR_##name)

static int32_t hit_box(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    (void)user;
    hit->t = ray->tmin + (float)object;
    return 1;
}

static void step_build(machine *m) {
    static const float xyz[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, NAN, 0, 0, 1, 1, 1, 1e30f, 0, 2};
    static const uint32_t abc[] = {0, 1, 2, 1, 2, 4, 3, 1, 2, 0, 0, 0, 5, 1, 0, 4, 0, 1, 9, 9, 9};
    static const htree_box boxes[] = {{{0, 0, 0}, {1, 1, 1}}, {{5, 5, 5}, {6, 6, 6}}};
    htree_objects objects = {boxes, fuzz_u8(&m->b) % 3, hit_box, NULL};
    htree_options options;
    htree_mesh mesh;
    const uint32_t choice = fuzz_u8(&m->b), slot = fuzz_u8(&m->b) % TREES;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = choice & 1 ? xyz : NULL;
    mesh.vertex_count = 6;
    mesh.position_stride = choice & 2 ? fuzz_u8(&m->b) : 12;
    if (mesh.position_stride > 12) mesh.vertex_count = 1 + 60 / mesh.position_stride;
    mesh.indices = choice & 4 ? abc : NULL;
    mesh.triangle_count = choice & 8 ? fuzz_u8(&m->b) % 8 : 2;
    mesh.objects = choice & 16 ? &objects : NULL;
    if (choice & 32) mesh.reserved[choice >> 7] = fuzz_u8(&m->b);
    if (htree_options_init(&options, sizeof options, (htree_kind)(1 + fuzz_u8(&m->b) % 8)) != 0)
        fail_msg("%s", htree_error_text());
    options.allocator = ledger_allocator(&m->books);
    options.progress.report = report;
    options.progress.user = m;
    m->reports = fuzz_u8(&m->b);
    if (choice & 64) {
        uint32_t *const words = (uint32_t *)(void *)&options;
        words[fuzz_u8(&m->b) % (offsetof(htree_options, allocator) / 4)] = fuzz_u32(&m->b);
        if (options.threads > 2) options.threads = 2;
        if (options.size > sizeof options) options.size = 0; /* there is no more of it */
    }
    htree_free(m->trees[slot]);
    m->trees[slot] = (htree *)(void *)m;
    const htree_status status = htree_build(&m->trees[slot], &mesh, &options);
    if (!succeeded(status, MAY(ARGUMENT) | MAY(MEMORY) | MAY(GEOMETRY) | MAY(CANCELLED)))
        assert_null(m->trees[slot]);
    m->reports = 0;
}

static void step_query(machine *m) {
    htree_ray rays[RAYS];
    htree_hit hits[RAYS];
    uint8_t any[RAYS];
    htree_counters counters[RAYS];
    htree_query query;
    const htree *const tree = any_tree(m);
    const uint32_t choice = fuzz_u8(&m->b), count = fuzz_u8(&m->b) % (RAYS + 1);
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    for (uint32_t i = 0; i < RAYS; ++i) {
        float *const f = rays[i].org;
        for (int k = 0; k < 8; ++k) f[k] = fuzz_float(&m->b, (int)(choice >> 6));
    }
    query.flags = choice & 1 ? fuzz_u8(&m->b) : 0;
    query.size = choice & 2 ? fuzz_u8(&m->b) % (sizeof query + 1) : (uint32_t)sizeof query;
    query.counters = choice & 4 ? counters : NULL;
    query.progress.report = report;
    query.progress.user = m;
    query.threads = 1;
    m->reports = fuzz_u8(&m->b);
    const htree_ray *const from = choice & 8 ? NULL : rays;
    const uint32_t may = MAY(ARGUMENT) | MAY(CANCELLED);
    if (choice & 16)
        (void)succeeded(htree_intersect(tree, from, count, choice & 32 ? NULL : hits, &query), may);
    else
        (void)succeeded(htree_occluded(tree, from, count, choice & 32 ? NULL : any, &query), may);
    m->reports = 0;
}

static void step_inspect(machine *m) {
    const htree *const tree = any_tree(m);
    htree_stats stats;
    htree_view view;
    htree_box box;
    stats.size = fuzz_u8(&m->b) & 1 ? (uint32_t)sizeof stats : fuzz_u8(&m->b) % sizeof stats;
    view.size = fuzz_u8(&m->b) & 1 ? (uint32_t)sizeof view : fuzz_u8(&m->b) % sizeof view;
    (void)succeeded(htree_get_stats(tree, &stats), MAY(ARGUMENT));
    (void)succeeded(htree_get_view(tree, &view), MAY(ARGUMENT) | MAY(UNSUPPORTED));
    (void)succeeded(htree_get_bounds(tree, &box), MAY(ARGUMENT));
    (void)succeeded(htree_check(tree), MAY(ARGUMENT) | MAY(MEMORY));
    if (fuzz_u8(&m->b) & 1)
        (void)succeeded(htree_complete(any_tree(m)), MAY(ARGUMENT) | MAY(MEMORY));
}

/* Saves one tree and loads it, whole or broken, into another's place. */
static void step_file(machine *m) {
    const htree *const tree = any_tree(m);
    const uint32_t choice = fuzz_u8(&m->b), slot = fuzz_u8(&m->b) % TREES;
    uint64_t size = 0;
    htree_load_options options;
    if (!succeeded(htree_save(tree, NULL, 0, &size), MAY(ARGUMENT) | MAY(UNSUPPORTED))) return;
    char *const file = (char *)take(size);
    const uint64_t room = choice & 1 ? fuzz_u16(&m->b) : size;
    if (succeeded(htree_save(tree, file, room < size ? room : size, &size), MAY(ARGUMENT))) {
        if (choice & 2) file[fuzz_u16(&m->b) % size] ^= (char)fuzz_u8(&m->b);
        assert_int_equal(htree_load_options_init(&options, sizeof options), HTREE_OK);
        options.allocator = ledger_allocator(&m->books);
        options.intersect = choice & 4 ? NULL : hit_box;
        if (choice & 8) options.flags = fuzz_u8(&m->b);
        if (options.flags & HTREE_BORROW) options.flags |= 2; /* refused: the file goes at once */
        options.reserved = choice & 16 ? fuzz_u8(&m->b) : 0;
        htree_free(m->trees[slot]);
        m->trees[slot] = (htree *)(void *)m;
        const uint32_t may = MAY(ARGUMENT) | MAY(MEMORY) | MAY(CORRUPT) | MAY(UNSUPPORTED);
        if (!succeeded(htree_load(&m->trees[slot], file, choice & 32 ? size / 2 : size, &options),
                       may))
            assert_null(m->trees[slot]);
    }
    free(file);
}

static void run_api(const uint8_t *bytes, size_t size) {
    machine m;
    memset(&m, 0, sizeof m);
    m.b.at = bytes;
    m.b.end = bytes + size;
    ledger_init(&m.books);
    while (m.b.at < m.b.end) {
        switch (fuzz_u8(&m.b) % 8) {
        case 0:
        case 1: step_build(&m); break;
        case 2:
        case 3: step_query(&m); break;
        case 4: step_inspect(&m); break;
        case 5: step_file(&m); break;
        case 6: ledger_fail(&m.books, fuzz_u8(&m.b) % 16, fuzz_u8(&m.b) & 1); break;
        default: {
            const uint32_t slot = fuzz_u8(&m.b) % TREES;
            htree_free(m.trees[slot]);
            m.trees[slot] = NULL;
            break;
        }
        }
    }
    for (int i = 0; i < TREES; ++i) htree_free(m.trees[i]);
    ledger_assert_balanced(&m.books);
    ledger_free(&m.books);
}

static void seed_calls(fuzz_emit *emit, void *data) {
    uint8_t input[400];
    dice d = {43};
    for (uint32_t i = 0; i < 24; ++i) {
        for (size_t k = 0; k < sizeof input; ++k) input[k] = (uint8_t)dice_u32(&d);
        emit(data, input, 16 + 16 * i);
    }
}

const fuzz_target fuzz_api = {"api", run_api, seed_calls};
