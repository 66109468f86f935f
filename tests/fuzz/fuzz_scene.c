/* fuzz_scene.c: any triangles, any rays, any options: every kind gives the oracle's hits, bit for bit.
 */
#include "fuzz.h"
#include "oracle.h"

#include <math.h>

enum { MOST_TRIANGLES = 48, MOST_RAYS = 32 };

static void read_options(fuzz_bytes *b, htree_options *options) {
    static const float cells[] = {0.5f, 1.0f / 64, 8, 64};
    const uint32_t choice = fuzz_u8(b);
    options->flags = choice & (HTREE_ANY_PLANES | HTREE_LOOSE_PLANES);
    options->axes = choice & 8 ? 3 : 1;
    options->buckets = 2 + fuzz_u8(b) % 63;
    options->few_prims = 1 + fuzz_u8(b) % 16;
    options->cells_per_prim = cells[choice >> 4 & 3];
    options->threads = choice & 64 ? 2 : 1;
}

/* Values that rays are made of when they are not taken from the bytes as they stand. */
static float special(uint32_t choice) {
    static const float values[] = {0,     -0.0f, 1, -1,     0.5f,     2,         1e-45f, 1e-38f,
                                   1e18f, 1e30f, 3, -7.25f, INFINITY, -INFINITY, NAN,    1e-3f};
    return values[choice % COUNT_OF(values)];
}

static void read_ray(fuzz_bytes *b, int grid, const float *corners, uint32_t triangles,
                     htree_ray *ray) {
    const uint32_t how = fuzz_u8(b);
    for (int k = 0; k < 3; ++k) {
        ray->org[k] = how & 1 ? special(fuzz_u8(b)) : fuzz_float(b, grid);
        ray->dir[k] = how & 2 ? special(fuzz_u8(b)) : fuzz_float(b, grid);
    }
    ray->tmin = how & 4 ? special(fuzz_u8(b)) : 0;
    ray->tmax = how & 8 ? special(fuzz_u8(b)) : INFINITY;
    if (!(how & 16) || triangles == 0) return;
    /* Aimed at a corner. */
    const float *const at = corners + 3 * (fuzz_u8(b) % (3 * triangles));
    for (int k = 0; k < 3; ++k) ray->dir[k] = at[k] - ray->org[k];
}

static void compare(const htree *tree, const htree_ray *rays, uint32_t count,
                    const htree_hit *truth) {
    htree_hit hits[MOST_RAYS];
    uint8_t any[MOST_RAYS];
    assert_int_equal(htree_intersect(tree, rays, count, hits, NULL), HTREE_OK);
    assert_int_equal(hits_differ(hits, truth, count), 0);
    assert_int_equal(htree_occluded(tree, rays, count, any, NULL), HTREE_OK);
    for (uint32_t i = 0; i < count; ++i) assert_int_equal(any[i], truth[i].prim != HTREE_NONE);
}

static void run_scene(const uint8_t *bytes, size_t size) {
    float corners[9 * MOST_TRIANGLES];
    htree_ray rays[MOST_RAYS];
    htree_hit truth[MOST_RAYS];
    fuzz_bytes b = {bytes, bytes + size};
    const uint32_t triangles = fuzz_u8(&b) % (MOST_TRIANGLES + 1), form = fuzz_u8(&b);
    const uint32_t count = 1 + fuzz_u8(&b) % MOST_RAYS;
    const int grid = form & 1 ? 1 + (int)(form >> 1 & 3) : 0;
    htree_options wanted = options_of(HTREE_H);
    read_options(&b, &wanted);
    const uint32_t wide = form & 64   ? HTREE_LAZY
                          : form & 32 ? HTREE_MORTON
                          : form & 16 ? HTREE_COMPACT
                                      : 0;
    for (uint32_t i = 0; i < 9 * triangles; ++i) corners[i] = fuzz_float(&b, grid);
    for (uint32_t i = 0; i < count; ++i) read_ray(&b, grid, corners, triangles, &rays[i]);
    const htree_mesh mesh = plain_mesh(corners, triangles);
    oracle o = oracle_of(&mesh);
    (void)oracle_batch(&o, rays, count, truth);
    for (htree_kind kind = HTREE_UG; kind <= HTREE_WIDE; ++kind) {
        htree_options options = wanted;
        options.kind = kind;
        if (kind == HTREE_WIDE) options.flags |= wide;
        if (kind > HTREE_KD && kind < HTREE_WIDE && form & 128) options.flags |= HTREE_COLLAPSE;
        htree *const tree = tree_of(&mesh, &options);
        const htree_stats stats = stats_of(tree);
        assert_int_equal(stats.invalid, o.invalid);
        assert_int_equal(stats.degenerate, o.degenerate);
        compare(tree, rays, count, truth);
        htree_free(tree);
    }
    oracle_free(&o);
}

static void seed_scenes(fuzz_emit *emit, void *data) {
    uint8_t input[700];
    dice d = {41};
    for (uint32_t i = 0; i < 24; ++i) {
        for (size_t k = 0; k < sizeof input; ++k) input[k] = (uint8_t)dice_u32(&d);
        input[0] = (uint8_t)(2 * i);
        emit(data, input, 200 + 20 * i);
    }
}

const fuzz_target fuzz_scene = {"scene", run_scene, seed_scenes};
