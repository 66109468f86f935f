/* suite.c: dice, meshes and trees for the test programs. */
#include "suite.h"

#include "shape_mesh.h"

#include <math.h>

/* splitmix64: passes the usual batteries, and any seed is a good seed. */
static uint64_t dice_u64(dice *d) {
    uint64_t z = d->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

uint32_t dice_u32(dice *d) {
    return (uint32_t)(dice_u64(d) >> 32);
}

uint32_t dice_below(dice *d, uint32_t limit) {
    return (uint32_t)(((uint64_t)dice_u32(d) * limit) >> 32);
}

float dice_unit(dice *d) {
    return (float)(dice_u32(d) >> 8) * (1.0f / 16777216.0f);
}

float dice_between(dice *d, float lo, float hi) {
    return lo + dice_unit(d) * (hi - lo);
}

float nudged(float x, int ulps) {
    for (; ulps > 0; --ulps) x = nextafterf(x, INFINITY);
    for (; ulps < 0; ++ulps) x = nextafterf(x, -INFINITY);
    return x;
}

uint64_t scaled(uint64_t count) {
    const char *const text = getenv("HTREE_TEST_SCALE");
    const double scale = text != NULL ? strtod(text, NULL) : 1.0;
    const double result = (double)count * scale;
    return result >= 1.0 ? (uint64_t)result : 1;
}

void say(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    printf("count: ");
    vprintf(format, arguments);
    printf("\n");
    va_end(arguments);
    fflush(stdout);
}

void tally(const char *what, uint64_t count) {
    printf("tally: %llu %s\n", (unsigned long long)count, what);
    fflush(stdout);
}

void *take(uint64_t bytes) {
    void *const memory = malloc((size_t)bytes);
    if (memory == NULL && bytes > 0) fail_msg("no memory for the test");
    return memory;
}

static bool kind_is_here(htree_kind kind) {
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    htree_mesh mesh = {0};
    mesh.positions = corners;
    mesh.vertex_count = 3;
    mesh.triangle_count = 1;
    htree_options options = options_of(kind);
    options.threads = 1;
    htree *tree = NULL;
    const htree_status status = htree_build(&tree, &mesh, &options);
    htree_free(tree);
    if (status != HTREE_OK && status != HTREE_ERROR_UNSUPPORTED) {
        fail_msg("%s: %s", htree_kind_name(kind), htree_error_text());
    }
    return status == HTREE_OK;
}

htree_kind next_kind(htree_kind kind) {
    for (++kind; kind <= HTREE_WIDE; ++kind) {
        if (kind_is_here(kind)) return kind;
    }
    return 0;
}

shape shape_of(const char *name, uint64_t triangles, uint32_t seed) {
    shape s;
    memset(&s, 0, sizeof s);
    if (!shape_make(&s, name, triangles, seed)) fail_msg("cannot make shape %s", name);
    return s;
}

htree_mesh mesh_of(const shape *s) {
    return shape_mesh(s);
}

htree_mesh plain_mesh(const float *xyz, uint64_t triangles) {
    htree_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = xyz;
    mesh.vertex_count = 3 * triangles;
    mesh.triangle_count = triangles;
    return mesh;
}

const float *mesh_corner(const htree_mesh *mesh, uint64_t triangle, uint32_t corner) {
    const uint64_t slot = triangle * 3 + corner;
    const uint64_t vertex = mesh->indices != NULL ? mesh->indices[slot] : slot;
    const uint64_t stride = mesh->position_stride != 0 ? mesh->position_stride : 12;
    return mesh->positions + vertex * (stride / 4);
}

int32_t never_hit(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit) {
    (void)user;
    (void)object;
    (void)ray;
    (void)hit;
    return 0;
}

htree_options options_of(htree_kind kind) {
    htree_options options;
    if (htree_options_init(&options, sizeof options, kind) != HTREE_OK) {
        fail_msg("options: %s", htree_error_text());
    }
    return options;
}

htree *tree_of(const htree_mesh *mesh, const htree_options *options) {
    htree *tree = NULL;
    if (htree_build(&tree, mesh, options) != HTREE_OK) fail_msg("build: %s", htree_error_text());
    assert_non_null(tree);
    if (htree_check(tree) != HTREE_OK) {
        fail_msg("check of %s: %s", htree_kind_name(stats_of(tree).kind), htree_error_text());
    }
    return tree;
}

htree *tree_of_kind(const htree_mesh *mesh, htree_kind kind) {
    htree_options options = options_of(kind);
    options.threads = 1;
    return tree_of(mesh, &options);
}

htree_stats stats_of(const htree *tree) {
    htree_stats stats;
    memset(&stats, 0, sizeof stats);
    stats.size = sizeof stats;
    if (htree_get_stats(tree, &stats) != HTREE_OK) fail_msg("stats: %s", htree_error_text());
    return stats;
}

uint64_t hits_differ(const htree_hit *a, const htree_hit *b, uint64_t count) {
    uint64_t differences = 0;
    for (uint64_t i = 0; i < count; ++i) differences += memcmp(&a[i], &b[i], sizeof a[i]) != 0;
    return differences;
}

uint64_t batch_differs(const htree *tree, const htree_ray *rays, const htree_hit *truth,
                       uint64_t count) {
    htree_hit *const hits = (htree_hit *)take(count * sizeof *hits);
    uint8_t *const any = (uint8_t *)take(count);
    assert_int_equal(htree_intersect(tree, rays, count, hits, NULL), HTREE_OK);
    assert_int_equal(htree_occluded(tree, rays, count, any, NULL), HTREE_OK);
    uint64_t differences = hits_differ(hits, truth, count);
    for (uint64_t i = 0; i < count; ++i) differences += any[i] != (truth[i].prim != HTREE_NONE);
    free(any);
    free(hits);
    return differences;
}

htree_view view_of(const htree *tree) {
    htree_view view;
    view.size = sizeof view;
    assert_int_equal(htree_get_view(tree, &view), HTREE_OK);
    return view;
}

void assert_same_trees(const htree *a, const htree *b) {
    const htree_view va = view_of(a), vb = view_of(b);
    assert_int_equal(va.node_bytes, vb.node_bytes);
    assert_int_equal(va.leaf_bytes, vb.leaf_bytes);
    assert_int_equal(va.stack, vb.stack);
    if (va.nodes) assert_true(memcmp(va.nodes, vb.nodes, (size_t)va.node_bytes) == 0);
    if (va.leaves) assert_true(memcmp(va.leaves, vb.leaves, (size_t)va.leaf_bytes) == 0);
}
