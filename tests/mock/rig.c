/* rig.c: trees, rays and answers for tests on the mock. */
#include "rig.h"

static void *take_aligned(uint64_t bytes) {
    void *memory = NULL;
    if (posix_memalign(&memory, 16, (size_t)bytes) != 0) fail_msg("no memory for the test");
    return memory;
}

void rig_begin(rig *r, const char *shape_name, uint64_t triangles, uint64_t rays) {
    dice d = {11};
    memset(r, 0, sizeof *r);
    r->s = shape_of(shape_name, triangles, 1);
    r->mesh = mesh_of(&r->s);
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree_options options = options_of(kind);
        options.threads = 1;
        if (kind == HTREE_H) options.flags |= HTREE_ANY_PLANES;
        assert_true(r->kinds < RIG_KINDS);
        r->trees[r->kinds++] = tree_of(&r->mesh, &options);
    }
    r->count = rays;
    r->rays = (htree_ray *)take_aligned(rays * sizeof *r->rays);
    r->truth = (htree_hit *)take_aligned(rays * sizeof *r->truth);
    r->hits = (htree_hit *)take_aligned(rays * sizeof *r->hits);
    r->any_truth = (uint8_t *)take_aligned(rays);
    r->any = (uint8_t *)take_aligned(rays);
    const ray_target target = ray_target_of(&r->mesh);
    rays_make_mixed(&target, &d, r->rays, rays);
    assert_int_equal(htree_intersect(r->trees[0], r->rays, rays, r->truth, NULL), HTREE_OK);
    assert_int_equal(htree_occluded(r->trees[0], r->rays, rays, r->any_truth, NULL), HTREE_OK);
    ledger_init(&r->books);
}

void rig_end(rig *r) {
    ledger_assert_balanced(&r->books);
    ledger_free(&r->books);
    for (uint32_t i = 0; i < r->kinds; ++i) htree_free(r->trees[i]);
    shape_free(&r->s);
    free(r->rays);
    free(r->truth);
    free(r->hits);
    free(r->any_truth);
    free(r->any);
    memset(r, 0, sizeof *r);
}

htree_cl_options rig_options(rig *r) {
    htree_cl_options options = cl_options();
    options.allocator = ledger_allocator(&r->books);
    return options;
}

bool rig_hits_are_right(const rig *r, uint64_t count) {
    return hits_differ(r->hits, r->truth, count) == 0;
}

bool rig_any_is_right(const rig *r, uint64_t count) {
    return memcmp(r->any, r->any_truth, (size_t)count) == 0;
}

void rig_spoil(rig *r) {
    memset(r->hits, 0x5a, (size_t)r->count * sizeof *r->hits);
    memset(r->any, 0x5a, (size_t)r->count);
}

void rig_prove(rig *r, const htree_cl_tree *tree) {
    rig_spoil(r);
    assert_cl_ok(htree_cl_intersect(tree, r->rays, r->count, r->hits, NULL));
    assert_cl_ok(htree_cl_occluded(tree, r->rays, r->count, r->any, NULL));
    assert_true(rig_hits_are_right(r, r->count));
    assert_true(rig_any_is_right(r, r->count));
}

void rig_nothing_is_left(const rig *r) {
    if (mock_mistakes() != 0) fail_msg("the mock saw a mistake: %s", mock_first_mistake());
    assert_int_equal(mock_live_all(), 0);
    assert_int_equal(mock_live_bytes(), 0);
    assert_int_equal(mock_pending(), 0);
    ledger_assert_balanced(&r->books);
}
