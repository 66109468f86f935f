/* saved.c: small trees of every kind as files. */
#include "saved.h"

#include "tree/file.h"

#include <math.h>

enum { ALIGNMENT = 64 };

saved saved_copy(const void *bytes, uint64_t size) {
    saved file = {NULL, size};
    void *memory = NULL;
    if (posix_memalign(&memory, ALIGNMENT, (size_t)(size ? size : 1)) != 0)
        fail_msg("no memory for the test");
    file.bytes = (char *)memory;
    if (bytes != NULL && size > 0) memcpy(file.bytes, bytes, (size_t)size);
    return file;
}

saved saved_of(const htree *tree) {
    uint64_t size = 0, written = 0;
    assert_int_equal(htree_save(tree, NULL, 0, &size), HTREE_OK);
    saved file = saved_copy(NULL, size);
    assert_int_equal(htree_save(tree, file.bytes, size, &written), HTREE_OK);
    assert_int_equal(written, size);
    return file;
}

void saved_free(saved *file) {
    free(file->bytes);
    memset(file, 0, sizeof *file);
}

void saved_seal(saved *file) {
    const uint64_t checksum = ht_file_checksum(file->bytes, file->size);
    memcpy(file->bytes + offsetof(ht_file_header, checksum), &checksum, sizeof checksum);
}

/* ---- Scenes --------------------------------------------------------------------------------- */

/* The largest ball in the object's box, hit from outside and from inside. */
static int32_t hit_ball(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    const seed_scene *const scene = (const seed_scene *)user;
    if (object >= scene->objects.count) return 0;
    const htree_box *const box = &scene->boxes[object];
    const double radius = ((double)box->hi[0] - (double)box->lo[0]) / 2;
    double along = 0, square = 0, away = 0;
    for (int k = 0; k < 3; ++k) {
        const double center = ((double)box->lo[k] + (double)box->hi[k]) / 2;
        const double d = (double)ray->dir[k], q = (double)ray->org[k] - center;
        along -= q * d;
        square += d * d;
        away += q * q;
    }
    const double inside = along * along - square * (away - radius * radius * 0.98);
    if (!(inside >= 0)) return 0;
    for (int side = -1; side <= 1; side += 2) {
        hit->t = (float)((along + side * sqrt(inside)) / square);
        if (ray->tmin <= hit->t && hit->t <= ray->tmax) return 1;
    }
    return 0;
}

static void make_boxes(seed_scene *scene, uint32_t count) {
    dice d = {3};
    for (uint32_t i = 0; i < count; ++i) {
        const float radius = dice_between(&d, 0.05f, 0.3f);
        for (int k = 0; k < 3; ++k) {
            const float center = dice_between(&d, -1, 1);
            scene->boxes[i].lo[k] = center - radius;
            scene->boxes[i].hi[k] = center + radius;
        }
    }
    scene->boxes[count / 2].lo[1] = NAN; /* skipped */
    scene->objects.boxes = scene->boxes;
    scene->objects.count = count;
    scene->objects.intersect = hit_ball;
    scene->objects.user = scene;
    scene->input.objects = &scene->objects;
}

void seed_scene_make(seed_scene *scene, int which, uint64_t triangles) {
    memset(scene, 0, sizeof *scene);
    const char *name = "knot";
    if (which == SEED_NONE || which == SEED_BALLS) name = "none";
    if (which == SEED_TRIANGLE) name = "one";
    if (which == SEED_BOTH) name = "soup";
    scene->mesh = shape_of(name, triangles, 2);
    scene->input = mesh_of(&scene->mesh);
    if (which == SEED_BALLS || which == SEED_BOTH) make_boxes(scene, 7);
    scene->target = ray_target_of(&scene->input);
}

void seed_scene_free(seed_scene *scene) {
    shape_free(&scene->mesh);
}

htree_kind next_seed_kind(htree_kind kind) {
    const htree_kind next = kind < HTREE_WIDE ? next_kind(kind) : 0;
    return kind == HTREE_WIDE ? SEED_COMPACT : next;
}

htree *seed_tree(const seed_scene *scene, htree_kind kind) {
    htree_options options = options_of(kind == SEED_COMPACT ? HTREE_WIDE : kind);
    if (kind == SEED_COMPACT) options.flags = HTREE_COMPACT;
    options.threads = 1;
    options.few_prims = 8;
    if (kind == HTREE_H || kind == HTREE_AH) options.flags = HTREE_ANY_PLANES;
    return tree_of(&scene->input, &options);
}

htree_load_options seed_load_options(const seed_scene *scene) {
    htree_load_options options;
    assert_int_equal(htree_load_options_init(&options, sizeof options), HTREE_OK);
    options.threads = 1;
    options.intersect = hit_ball;
    options.user = (void *)(uintptr_t)scene;
    return options;
}
