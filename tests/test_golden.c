/* test_golden.c: hits and trees are the same on every machine: constants from one machine and one
 * compiler hold on all others. `test_golden --print` prints them anew: those of trees change with
 * builders; those of hits never may. */
#include "rays.h"
#include "suite.h"

#include <inttypes.h>
#include <math.h>

enum { RAYS = 14 * 300, JUNK = 60, PANES = 40, KINDS = HTREE_WIDE };

typedef struct golden {
    const char *shape;
    uint64_t closest, any; /* the same for all kinds */
    uint64_t trees[KINDS]; /* by kind */
} golden;

static const golden constants[] = {
#include "golden.inc"
};

/* ---- Scenes: a shape, triangles that are broken or twice there, and panes by callback -------- */

typedef struct scene {
    float *positions;
    uint32_t *indices;
    htree_box panes[PANES];
    htree_objects objects;
    htree_mesh mesh;
} scene;

/* A pane is a rectangle across the y axis. */
static int32_t hit_pane(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    const htree_box *const pane = (const htree_box *)user + object;
    const float t = (pane->lo[1] - ray->org[1]) / ray->dir[1];
    const float x = ray->org[0] + t * ray->dir[0], z = ray->org[2] + t * ray->dir[2];
    hit->t = t;
    hit->u = (x - pane->lo[0]) / (pane->hi[0] - pane->lo[0]);
    hit->v = (z - pane->lo[2]) / (pane->hi[2] - pane->lo[2]);
    return ray->tmin <= t && t <= ray->tmax && 0 <= hit->u && hit->u <= 1 && 0 <= hit->v &&
           hit->v <= 1;
}

static void add_panes(scene *s, const htree_box *around, dice *d) {
    for (uint32_t i = 0; i < PANES; ++i) {
        float center[3];
        random_in_box(around, 0, d, center);
        const float size = 0.1f * dice_unit(d) * (around->hi[0] - around->lo[0]) + 0.01f;
        for (int k = 0; k < 3; ++k) {
            s->panes[i].lo[k] = k == 1 ? center[k] : center[k] - size;
            s->panes[i].hi[k] = k == 1 ? center[k] : center[k] + size;
        }
    }
    s->objects.boxes = s->panes;
    s->objects.count = PANES;
    s->objects.intersect = hit_pane;
    s->objects.user = s->panes;
    s->mesh.objects = &s->objects;
}

/* Three corners at vertices of their own: a copy, or without area, or no number at all. */
static void make_junk(scene *s, const shape *from, uint64_t i, dice *d) {
    static const float bad[] = {NAN, -INFINITY, 2e18f};
    float *const to = s->positions + 3 * (from->vertex_count + 3 * i);
    const uint64_t copied = dice_below(d, (uint32_t)from->triangle_count);
    for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t vertex = from->indices[3 * copied + k];
        memcpy(to + 3 * k, from->positions + 3 * (uint64_t)vertex, 12);
        s->indices[3 * (from->triangle_count + i) + k] = (uint32_t)(from->vertex_count + 3 * i) + k;
    }
    if (i % 3 == 1) memcpy(to + 3, to, 12);
    if (i % 9 == 2) to[dice_below(d, 9)] = bad[dice_below(d, COUNT_OF(bad))];
}

static void make_scene(scene *s, const char *name) {
    shape from = shape_of(name, 2000, 1);
    dice d = {7};
    memset(s, 0, sizeof *s);
    s->mesh.vertex_count = from.vertex_count + 3 * JUNK;
    s->mesh.triangle_count = from.triangle_count + JUNK;
    s->mesh.positions = s->positions = (float *)take(s->mesh.vertex_count * 12);
    s->mesh.indices = s->indices = (uint32_t *)take(s->mesh.triangle_count * 12);
    memcpy(s->positions, from.positions, from.vertex_count * 12);
    memcpy(s->indices, from.indices, from.triangle_count * 12);
    for (uint64_t i = 0; i < JUNK; ++i) make_junk(s, &from, i, &d);
    const ray_target target = ray_target_of(&s->mesh);
    add_panes(s, &target.box, &d);
    shape_free(&from);
}

static void free_scene(scene *s) {
    free(s->positions);
    free(s->indices);
}

/* ---- Hashes --------------------------------------------------------------------------------- */

#define HASH_SEED 0xcbf29ce484222325u

/* FNV-1a by 32-bit words, of which everything consists: no order of bytes counts. */
static uint64_t hash_words(uint64_t hash, const void *words, uint64_t bytes) {
    for (uint64_t i = 0; i < bytes / 4; ++i) {
        uint32_t word;
        memcpy(&word, (const char *)words + 4 * i, 4);
        hash = (hash ^ word) * 0x100000001b3u;
    }
    return hash;
}

static uint64_t hash_tree(const htree *tree) {
    htree_view view;
    memset(&view, 0, sizeof view);
    view.size = sizeof view;
    assert_int_equal(htree_get_view(tree, &view), HTREE_OK);
    uint64_t hash = hash_words(HASH_SEED, &view.bounds, sizeof view.bounds);
    hash = hash_words(hash, &view.stack, sizeof view.stack);
    if (view.triangles) hash = hash_words(hash, view.triangles, view.triangle_count * (uint64_t)36);
    hash = hash_words(hash, view.nodes, view.node_bytes);
    hash = hash_words(hash, view.leaves, view.leaf_bytes);
    return hash_words(hash, view.grid, view.grid_bytes);
}

static uint64_t hash_closest(const htree *tree, const htree_ray *rays) {
    htree_hit *const hits = (htree_hit *)take(RAYS * sizeof *hits);
    assert_int_equal(htree_intersect(tree, rays, RAYS, hits, NULL), HTREE_OK);
    const uint64_t hash = hash_words(HASH_SEED, hits, RAYS * sizeof *hits);
    free(hits);
    return hash;
}

static uint64_t hash_any(const htree *tree, const htree_ray *rays) {
    uint8_t *const any = (uint8_t *)take(RAYS);
    uint64_t hash = HASH_SEED;
    assert_int_equal(htree_occluded(tree, rays, RAYS, any, NULL), HTREE_OK);
    for (uint32_t i = 0; i < RAYS; ++i) {
        const uint32_t word = any[i];
        hash = hash_words(hash, &word, 4);
    }
    free(any);
    return hash;
}

/* What this machine makes of a scene, by kind. */
typedef struct figures {
    uint64_t closest[KINDS], any[KINDS], trees[KINDS];
} figures;

static void measure(const char *name, figures *out) {
    scene s;
    make_scene(&s, name);
    const ray_target target = ray_target_of(&s.mesh);
    htree_ray *const rays = (htree_ray *)take(RAYS * sizeof *rays);
    dice d = {11};
    rays_make_mixed(&target, &d, rays, RAYS);
    for (htree_kind kind = 1; kind <= KINDS; ++kind) {
        htree *const tree = tree_of_kind(&s.mesh, kind);
        out->closest[kind - 1] = hash_closest(tree, rays);
        out->any[kind - 1] = hash_any(tree, rays);
        out->trees[kind - 1] = hash_tree(tree);
        htree_free(tree);
    }
    free(rays);
    free_scene(&s);
}

/* ---- Proof ---------------------------------------------------------------------------------- */

static figures measured[COUNT_OF(constants)];

static uint32_t differs(uint32_t at, uint32_t kind, const char *what, uint64_t is, uint64_t was) {
    if (is == was) return 0;
    print_error("%s, %s of %s: 0x%016" PRIx64 " instead of 0x%016" PRIx64 "\n", constants[at].shape,
                what, htree_kind_name((htree_kind)kind + 1), is, was);
    return 1;
}

static void hits_are_the_same_on_every_machine(void **state) {
    uint32_t wrong = 0;
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(constants); ++i) {
        measure(constants[i].shape, &measured[i]);
        for (uint32_t k = 0; k < KINDS; ++k) {
            wrong += differs(i, k, "closest", measured[i].closest[k], constants[i].closest);
            wrong += differs(i, k, "any", measured[i].any[k], constants[i].any);
        }
    }
    say("%d scenes, %d rays each by every kind, %d differences", (int)COUNT_OF(constants), RAYS,
        (int)wrong);
    assert_int_equal(wrong, 0);
}

static void trees_are_the_same_on_every_machine(void **state) {
    uint32_t wrong = 0;
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(constants); ++i) {
        for (uint32_t k = 0; k < KINDS; ++k)
            wrong += differs(i, k, "tree", measured[i].trees[k], constants[i].trees[k]);
    }
    say("%d trees, %d differences", (int)COUNT_OF(constants) * KINDS, (int)wrong);
    assert_int_equal(wrong, 0);
}

static void print_constants(void) {
    printf("/* golden.inc: hashes of the closest hits, of any, and of a tree of each kind, as\n"
           " * `test_golden --print` printed them. */\n");
    for (uint32_t i = 0; i < COUNT_OF(constants); ++i) {
        figures now;
        measure(constants[i].shape, &now);
        printf("{\"%s\", 0x%016" PRIx64 ", 0x%016" PRIx64 ",\n {", constants[i].shape,
               now.closest[0], now.any[0]);
        for (int k = 0; k < KINDS; ++k)
            printf("%s0x%016" PRIx64, k == 0 ? "" : k % 4 ? ", " : ",\n  ", now.trees[k]);
        printf("}},\n");
    }
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(hits_are_the_same_on_every_machine),
                                       cmocka_unit_test(trees_are_the_same_on_every_machine)};
    if (argc > 1 && strcmp(argv[1], "--print") == 0) {
        print_constants();
        return 0;
    }
    return cmocka_run_group_tests_name("golden", tests, NULL, NULL);
}
