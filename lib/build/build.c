/* build.c: htree_build: options and mesh in, the kind's builder called, a finished tree out. */
#include "build.h"
#include "collapse.h"
#include "mesh.h"
#include "refit.h"
#include "wide.h"
#include "base/clock.h"
#include "base/float_env.h"
#include "tree/options.h"

/* The kinds that can be built. Adding one: a builder file, a row here, a row in trace/trace.c and
 * one in tree/visit.c. */
static const struct {
    htree_kind kind;
    ht_build *build;
    uint32_t most; /* prims that its nodes and the arrays of its builder can address */
    bool loads;    /* reads the mesh by itself, and sets the tree's bounds and counts */
} builders[] = {
    {HTREE_UG, ht_build_ug, UINT32_MAX / 6, false},
    {HTREE_KD, ht_build_kd, HT_KD_SLOTS / 8, false},
    {HTREE_BVH_MEDIAN, ht_build_bvh_median, INT32_MAX, false},
    {HTREE_BVH_SAH, ht_build_bvh_sah, INT32_MAX, false},
    {HTREE_SKD, ht_build_skd, HT_H_PRIMS, false},
    {HTREE_H, ht_build_h, HT_H_PRIMS, false},
    {HTREE_AH, ht_build_ah, HT_H_PRIMS, false},
    {HTREE_WIDE, ht_build_wide, HT_WIDE_PRIMS - 1, true},
};

/* Index of the kind's row. */
static size_t find_builder(htree_kind kind) {
    size_t i = 0;
    while (builders[i].kind != kind) ++i;
    return i;
}

/* ---- The tree ------------------------------------------------------------------------------- */

/* A tree without nodes, which keeps its memory in mind. */
static void tree_begin(htree *tree, ht_memory memory, const htree_mesh *mesh,
                       const htree_options *options) {
    memset(tree, 0, sizeof *tree);
    tree->memory = memory;
    tree->options = *options;
    memset(&tree->options.progress, 0, sizeof tree->options.progress); /* of that call only */
    tree->kind = options->kind;
    tree->threads = ht_team_threads(&options->tasks, options->threads);
    tree->tasks = options->tasks;
    tree->isa = ht_isa_here();
    tree->bounds = ht_box_empty();
    tree->triangle_count = (uint32_t)mesh->triangle_count;
    if (mesh->objects) {
        tree->object_count = (uint32_t)mesh->objects->count;
        tree->intersect = mesh->objects->intersect;
        tree->intersect_user = mesh->objects->user;
    }
    tree->cost_skd = options->cost_skd;
    tree->cost_bv2 = options->cost_bv2;
    tree->cost_bv6 = options->cost_bv6;
    tree->cost_intersect = options->cost_intersect;
}

static htree *tree_new(const htree_mesh *mesh, const htree_options *options) {
    ht_memory memory = {options->allocator, 0, 0, NULL};
    htree *tree = (htree *)ht_allocate(&memory, sizeof *tree);
    if (tree) tree_begin(tree, memory, mesh, options);
    return tree;
}

ht_prim *ht_builder_spare(ht_builder *builder) {
    htree *tree = builder->tree;
    if (!builder->spare) {
        builder->spare = (ht_prim *)ht_allocate(&tree->memory, tree->prim_count * sizeof(ht_prim));
    }
    return builder->spare;
}

/* UG and KD divide space: their leaves share prims, which wide trees do not. */
static bool is_collapsed(const htree *tree, const htree_options *options) {
    return (options->flags & HTREE_COLLAPSE) != 0 && tree->kind != HTREE_UG &&
           tree->kind != HTREE_KD && tree->kind != HTREE_WIDE;
}

static htree_status verify_count(const htree *tree, const htree_options *options, size_t row) {
    const uint64_t prims = (uint64_t)tree->triangle_count + tree->object_count;
    uint32_t most = builders[row].most;
    if (is_collapsed(tree, options) && most >= HT_WIDE_PRIMS) most = HT_WIDE_PRIMS - 1;
    if (prims <= most) return HTREE_OK;
    return ht_fail(HTREE_ERROR_LIMIT, "%llu triangles and objects: a tree of kind %s holds %lu",
                   (unsigned long long)prims, htree_kind_name(tree->kind), (unsigned long)most);
}

static htree_status load_and_build(ht_builder *builder, ht_build *build) {
    HT_TRY(ht_load_mesh(builder));
    if (builder->tree->prim_count == 0) return HTREE_OK;
    ht_progress_begin(&builder->progress, &builder->options->progress, builder->tree->prim_count);
    return build(builder);
}

static htree_status build_tree(htree *tree, const htree_mesh *mesh, const htree_options *options,
                               size_t row) {
    const uint64_t prims = (uint64_t)tree->triangle_count + tree->object_count;
    ht_builder builder;
    ht_team team;
    HT_TRY(verify_count(tree, options, row));
    memset(&builder, 0, sizeof builder);
    builder.options = options;
    builder.mesh = mesh;
    builder.tree = tree;
    builder.team = &team;
    ht_team_begin(&team, &tree->tasks, tree->threads);
    htree_status status = ht_copy_objects(&builder);
    if (status == HTREE_OK) {
        status = builders[row].loads ? builders[row].build(&builder)
                                     : load_and_build(&builder, builders[row].build);
    }
    if (status == HTREE_OK && tree->prim_count > 0 && is_collapsed(tree, options)) {
        status = ht_collapse(&builder);
        if (status == HTREE_OK && options->flags & HTREE_COMPACT)
            status = ht_wide_compact(&builder);
    }
    ht_team_end(&team);
    ht_release(&tree->memory, builder.spare, tree->prim_count * sizeof(ht_prim));
    ht_release(&tree->memory, builder.prims, prims * sizeof(ht_prim));
    if (status == HTREE_ERROR_CANCELLED) ht_fail(status, "the progress hook cancelled the build");
    return status;
}

static htree_status build(htree **out, const htree_mesh *mesh, const htree_options *given) {
    const double start = ht_seconds();
    if (!out) return ht_fail(HTREE_ERROR_ARGUMENT, "out is NULL");
    *out = NULL;
    if (!mesh) return ht_fail(HTREE_ERROR_ARGUMENT, "mesh is NULL");
    htree_options options;
    HT_TRY(ht_options_read(given, &options));
    HT_TRY(ht_verify_mesh(mesh));
    htree *tree = tree_new(mesh, &options);
    if (!tree) return HTREE_ERROR_MEMORY;
    const htree_status status = build_tree(tree, mesh, &options, find_builder(options.kind));
    if (status != HTREE_OK) {
        htree_free(tree);
        return status;
    }
    tree->build_seconds = ht_seconds() - start;
    assert(htree_check(tree) != HTREE_ERROR_CORRUPT);
    *out = tree;
    return HTREE_OK;
}

htree_status htree_build(htree **out, const htree_mesh *mesh, const htree_options *given) {
    HT_RETURN_IN_DEFAULT_ENV(build(out, mesh, given));
}

/* ---- The same tree again -------------------------------------------------------------------- */

/* The new tree is finished before the old one ends, so a failure loses nothing. */
static htree_status rebuild(htree *tree, const htree_mesh *mesh) {
    const double start = ht_seconds();
    const htree_options options = tree->options;
    htree next;
    if (!ht_recycler_begin(&tree->memory)) return HTREE_ERROR_MEMORY;
    tree_begin(&next, tree->memory, mesh, &options);
    next.isa = tree->isa;
    const htree_status status = build_tree(&next, mesh, &options, find_builder(options.kind));
    if (status != HTREE_OK) {
        ht_tree_release(&next);
        tree->memory = next.memory;
        return status;
    }
    tree->memory = next.memory;
    ht_tree_release(tree);
    next.memory = tree->memory;
    next.build_seconds = ht_seconds() - start;
    ht_recycler_tidy(&next.memory);
    *tree = next;
    return HTREE_OK;
}

static htree_status read_update(const htree *tree, const htree_mesh *mesh, int32_t how) {
    HT_TRY(ht_tree_verify(tree));
    if (!mesh) return ht_fail(HTREE_ERROR_ARGUMENT, "mesh is NULL");
    if (how != HTREE_REBUILD && how != HTREE_REFIT) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "how is %ld: HTREE_REBUILD or HTREE_REFIT", (long)how);
    }
    return ht_verify_mesh(mesh);
}

static htree_status update(htree *tree, const htree_mesh *mesh, int32_t how, double *quality) {
    bool refits = false;
    double ratio = 1;
    HT_TRY(read_update(tree, mesh, how));
    if (how == HTREE_REFIT) HT_TRY(ht_refit(tree, mesh, &refits, &ratio));
    if (!refits) HT_TRY(rebuild(tree, mesh));
    if (refits && mesh->objects) {
        tree->intersect = mesh->objects->intersect;
        tree->intersect_user = mesh->objects->user;
    }
    assert(htree_check(tree) != HTREE_ERROR_CORRUPT);
    if (quality) *quality = ratio;
    return HTREE_OK;
}

htree_status htree_update(htree *tree, const htree_mesh *mesh, int32_t how, double *quality) {
    HT_RETURN_IN_DEFAULT_ENV(update(tree, mesh, how, quality));
}

static htree_status complete_tree(htree *tree) {
    HT_TRY(ht_tree_verify(tree));
    if (tree->lazy) tree->lazy->complete(tree);
    return HTREE_OK;
}

htree_status htree_complete(htree *tree) {
    HT_RETURN_IN_DEFAULT_ENV(complete_tree(tree));
}
