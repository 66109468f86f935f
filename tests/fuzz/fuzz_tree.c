/* fuzz_tree.c: htree_load of any bytes. An input is a file as it stands, or the small trees of
 * saved.h with words changed: the checksum is set right, else it would hide all that lies behind it. */
#include "fuzz.h"
#include "saved.h"

enum { AS_IT_STANDS, SEALED, CHANGED, RAYS = 16, TRIANGLES = 20 };

/* What is loaded answers in bounded steps and is saved as it was. */
static void use(const htree *tree, const saved *file, const htree_ray *rays) {
    htree_hit hits[RAYS];
    htree_counters counters[RAYS];
    uint8_t any[RAYS];
    htree_query query;
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    query.threads = 1;
    query.counters = counters;
    const htree_stats stats = stats_of(tree);
    assert_int_equal(htree_intersect(tree, rays, RAYS, hits, &query), HTREE_OK);
    assert_int_equal(htree_intersect(tree, rays, RAYS, hits, NULL), HTREE_OK);
    assert_int_equal(htree_occluded(tree, rays, RAYS, any, NULL), HTREE_OK);
    for (int i = 0; i < RAYS; ++i) {
        assert_int_equal(any[i], hits[i].prim != HTREE_NONE);
        assert_true(counters[i].traversal_steps <= 2 * stats.nodes + 1);
    }
    saved again = saved_of(tree);
    assert_int_equal(again.size, file->size);
    assert_memory_equal(again.bytes, file->bytes, (size_t)again.size);
    saved_free(&again);
}

/* One of the small trees, with words changed at offsets. */
static saved changed(fuzz_bytes *b, const seed_scene *scene, uint32_t kind) {
    htree *const tree = seed_tree(scene, (htree_kind)(1 + kind % SEED_COMPACT));
    saved file = saved_of(tree);
    htree_free(tree);
    while (b->at < b->end && file.size >= 4) {
        const uint64_t at = 4 * (uint64_t)fuzz_u16(b) % (file.size & ~UINT64_C(3));
        const uint32_t word = fuzz_u32(b);
        memcpy(file.bytes + at, &word, sizeof word);
    }
    saved_seal(&file);
    return file;
}

static void run_tree(const uint8_t *bytes, size_t size) {
    fuzz_bytes b = {bytes, bytes + size};
    const uint32_t mode = fuzz_u8(&b) % 3, borrow = fuzz_u8(&b) % 2, kind = fuzz_u8(&b);
    seed_scene scene;
    htree_ray rays[RAYS];
    dice d = {3};
    htree *tree = NULL;
    seed_scene_make(&scene, (int)(fuzz_u8(&b) % SEED_SCENES), TRIANGLES);
    rays_make_mixed(&scene.target, &d, rays, RAYS);
    saved file =
        mode == CHANGED ? changed(&b, &scene, kind) : saved_copy(b.at, (uint64_t)(b.end - b.at));
    if (mode == SEALED && file.size >= 192 && file.size % 64 == 0) saved_seal(&file);
    htree_load_options options = seed_load_options(&scene);
    options.flags = borrow ? HTREE_BORROW : 0;
    const htree_status status = htree_load(&tree, file.bytes, file.size, &options);
    assert_true(status == HTREE_OK || status == HTREE_ERROR_CORRUPT ||
                status == HTREE_ERROR_UNSUPPORTED);
    assert_int_equal(status == HTREE_OK, tree != NULL);
    if (tree) use(tree, &file, rays);
    htree_free(tree);
    saved_free(&file);
    seed_scene_free(&scene);
}

static void seed_files(fuzz_emit *emit, void *data) {
    for (htree_kind kind = next_seed_kind(0); kind != 0; kind = next_seed_kind(kind)) {
        for (int which = 0; which < SEED_SCENES; ++which) {
            const uint8_t head[4] = {SEALED, (uint8_t)(kind & 1), 0, (uint8_t)which};
            const uint8_t change[10] = {CHANGED, 0, (uint8_t)(kind - 1), (uint8_t)which, 60, 0, 1};
            seed_scene scene;
            seed_scene_make(&scene, which, TRIANGLES);
            htree *const tree = seed_tree(&scene, kind);
            saved file = saved_of(tree);
            uint8_t *const input = (uint8_t *)take(sizeof head + file.size);
            memcpy(input, head, sizeof head);
            memcpy(input + sizeof head, file.bytes, (size_t)file.size);
            emit(data, input, sizeof head + (size_t)file.size);
            emit(data, change, sizeof change);
            free(input);
            saved_free(&file);
            htree_free(tree);
            seed_scene_free(&scene);
        }
    }
}

const fuzz_target fuzz_tree = {"tree", run_tree, seed_files};
