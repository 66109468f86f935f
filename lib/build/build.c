/* build.c: htree_build: checks the mesh, copies what the tree keeps, and calls the kind's builder.
 */
#include "build.h"
#include "options.h"
#include "base/clock.h"

/* The kinds that can be built. Adding one: a builder file, a row here, a row in trace/trace.c and
 * one in tree/visit.c. */
static const struct {
    htree_kind kind;
    ht_build *build;
} builders[] = {
    {HTREE_UG, ht_build_ug},
    {HTREE_KD, ht_build_kd},
    {HTREE_BVH_MEDIAN, ht_build_bvh_median},
    {HTREE_BVH_SAH, ht_build_bvh_sah},
    {HTREE_SKD, ht_build_skd},
    {HTREE_H, ht_build_h},
    {HTREE_AH, ht_build_ah},
    {HTREE_WIDE, ht_build_wide},
};

static ht_build *find_builder(htree_kind kind) {
    for (size_t i = 0; i < sizeof builders / sizeof *builders; ++i) {
        if (builders[i].kind == kind) return builders[i].build;
    }
    return NULL;
}

/* ---- The mesh ------------------------------------------------------------------------------- */

static htree_status verify_mesh(const htree_mesh *mesh) {
    const uint64_t stride = mesh->position_stride;
    if (mesh->reserved[0] || mesh->reserved[1]) {
        return ht_fail(HTREE_ERROR_ARGUMENT,
                       "mesh.reserved must be 0: start from htree_mesh mesh = {0}");
    }
    if (stride && (stride < 12 || stride % 4)) {
        return ht_fail(
            HTREE_ERROR_ARGUMENT,
            "mesh.position_stride is %llu: must be 0, or at least 12 and a multiple of 4",
            (unsigned long long)stride);
    }
    if (mesh->triangle_count && !mesh->positions) {
        return ht_fail(HTREE_ERROR_ARGUMENT,
                       "mesh.positions is NULL but mesh.triangle_count is not 0");
    }
    if ((uintptr_t)mesh->positions % 4 || (uintptr_t)mesh->indices % 4) {
        return ht_fail(HTREE_ERROR_ARGUMENT,
                       "mesh.positions and mesh.indices must be aligned to 4 bytes");
    }
    if (mesh->objects && mesh->objects->count) {
        if (!mesh->objects->boxes)
            return ht_fail(HTREE_ERROR_ARGUMENT, "mesh.objects->boxes is NULL");
        if (!mesh->objects->intersect) {
            return ht_fail(HTREE_ERROR_ARGUMENT, "mesh.objects->intersect is NULL");
        }
    }
    const uint64_t objects = mesh->objects ? mesh->objects->count : 0;
    if (mesh->triangle_count >= HTREE_NONE || objects >= HTREE_NONE - mesh->triangle_count) {
        return ht_fail(HTREE_ERROR_LIMIT, "a tree holds fewer than 2^32 - 1 triangles and objects");
    }
    if (mesh->vertex_count > UINT64_MAX / (stride ? stride : 12)) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "mesh.vertex_count times the stride exceeds 2^64");
    }
    if (!mesh->indices && mesh->triangle_count > mesh->vertex_count / 3) {
        return ht_fail(HTREE_ERROR_GEOMETRY,
                       "mesh.triangle_count needs three vertices a triangle where indices is NULL");
    }
    return HTREE_OK;
}

static bool is_in_range(const float *p) {
    return ht_magnitude(p[0]) <= HTREE_COORDINATE_MAX &&
           ht_magnitude(p[1]) <= HTREE_COORDINATE_MAX && ht_magnitude(p[2]) <= HTREE_COORDINATE_MAX;
}

/* A box without an order of its planes contains nothing. */
static bool is_box_in_range(const htree_box *box) {
    return is_in_range(box->lo) && is_in_range(box->hi) && box->lo[0] <= box->hi[0] &&
           box->lo[1] <= box->hi[1] && box->lo[2] <= box->hi[2];
}

static htree_status load_corners(const htree_mesh *mesh, uint32_t i, ht_triangle *triangle) {
    const uint64_t stride = mesh->position_stride ? mesh->position_stride : 12;
    for (uint64_t k = 0; k < 3; ++k) {
        const uint64_t at = 3 * (uint64_t)i + k;
        const uint64_t vertex = mesh->indices ? mesh->indices[at] : at;
        if (HT_UNLIKELY(vertex >= mesh->vertex_count)) {
            return ht_fail(HTREE_ERROR_GEOMETRY, "triangle %lu refers to vertex %llu of %llu",
                           (unsigned long)i, (unsigned long long)vertex,
                           (unsigned long long)mesh->vertex_count);
        }
        memcpy(triangle->v[k], (const char *)mesh->positions + vertex * stride, 12);
    }
    return HTREE_OK;
}

static void add_prim(ht_builder *builder, uint32_t id, const htree_box *box) {
    ht_prim *prim = &builder->prims[builder->tree->prim_count++];
    memcpy(prim->lo, box->lo, sizeof box->lo);
    memcpy(prim->hi, box->hi, sizeof box->hi);
    memcpy(&prim->lo[3], &id, sizeof id);
    prim->hi[3] = 0;
    ht_box_add(&builder->tree->bounds, box);
}

static htree_status skip_invalid(ht_builder *builder, const char *what, uint32_t index) {
    if (builder->options->flags & HTREE_STRICT) {
        return ht_fail(HTREE_ERROR_GEOMETRY,
                       "%s %lu has a NaN, infinite or oversize coordinate, or lo > hi", what,
                       (unsigned long)index);
    }
    ++builder->tree->invalid;
    return HTREE_OK;
}

static htree_status add_triangles(ht_builder *builder, const htree_mesh *mesh) {
    htree *tree = builder->tree;
    for (uint32_t i = 0; i < tree->triangle_count; ++i) {
        ht_triangle *triangle = &tree->triangles[i];
        HT_TRY(load_corners(mesh, i, triangle));
        if (is_in_range(triangle->v[0]) && is_in_range(triangle->v[1]) &&
            is_in_range(triangle->v[2])) {
            if (!ht_triangle_is_degenerate(triangle->v[0], triangle->v[1], triangle->v[2])) {
                const htree_box box = ht_prim_box(tree, i);
                add_prim(builder, i, &box);
                continue;
            }
            ++tree->degenerate;
        } else {
            HT_TRY(skip_invalid(builder, "triangle", i));
        }
        memset(triangle, 0, sizeof *triangle);
    }
    return HTREE_OK;
}

static htree_status add_objects(ht_builder *builder, const htree_mesh *mesh) {
    htree *tree = builder->tree;
    for (uint32_t i = 0; i < tree->object_count; ++i) {
        tree->object_boxes[i] = mesh->objects->boxes[i];
        if (is_box_in_range(&tree->object_boxes[i])) {
            add_prim(builder, tree->triangle_count + i, &tree->object_boxes[i]);
        } else {
            HT_TRY(skip_invalid(builder, "object", i));
            tree->object_boxes[i] = ht_box_empty();
        }
    }
    return HTREE_OK;
}

/* ---- The tree ------------------------------------------------------------------------------- */

static htree *tree_new(const htree_mesh *mesh, const htree_options *options) {
    ht_memory memory = {options->allocator, 0, 0};
    htree *tree = (htree *)ht_allocate(&memory, sizeof *tree);
    if (!tree) return NULL;
    memset(tree, 0, sizeof *tree);
    tree->memory = memory;
    tree->kind = options->kind;
    tree->threads = options->threads;
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
    return tree;
}

ht_prim *ht_builder_spare(ht_builder *builder) {
    htree *tree = builder->tree;
    if (!builder->spare) {
        builder->spare = (ht_prim *)ht_allocate(&tree->memory, tree->prim_count * sizeof(ht_prim));
    }
    return builder->spare;
}

static htree_status run_builder(ht_builder *builder, const htree_mesh *mesh, ht_build *build) {
    htree *tree = builder->tree;
    HT_TRY(add_triangles(builder, mesh));
    HT_TRY(add_objects(builder, mesh));
    if (tree->prim_count == 0) return HTREE_OK;
    ht_progress_begin(&builder->progress, &builder->options->progress, tree->prim_count);
    const htree_status status = build(builder);
    if (status == HTREE_ERROR_CANCELLED) ht_fail(status, "the progress hook cancelled the build");
    return status;
}

static htree_status build_tree(htree *tree, const htree_mesh *mesh, const htree_options *options,
                               ht_build *build) {
    const uint64_t prims = (uint64_t)tree->triangle_count + tree->object_count;
    ht_builder builder = {options, tree, NULL, NULL, {{NULL, NULL}, 0, 0, 0, NULL, 0}};
    tree->triangles =
        (ht_triangle *)ht_allocate(&tree->memory, tree->triangle_count * sizeof(ht_triangle));
    tree->object_boxes =
        (htree_box *)ht_allocate(&tree->memory, tree->object_count * sizeof(htree_box));
    builder.prims = (ht_prim *)ht_allocate(&tree->memory, prims * sizeof(ht_prim));
    htree_status status = HTREE_ERROR_MEMORY;
    if (tree->triangles && tree->object_boxes && builder.prims) {
        status = run_builder(&builder, mesh, build);
    }
    ht_release(&tree->memory, builder.spare, tree->prim_count * sizeof(ht_prim));
    ht_release(&tree->memory, builder.prims, prims * sizeof(ht_prim));
    return status;
}

htree_status htree_build(htree **out, const htree_mesh *mesh, const htree_options *given) {
    const double start = ht_seconds();
    if (!out) return ht_fail(HTREE_ERROR_ARGUMENT, "out is NULL");
    *out = NULL;
    if (!mesh) return ht_fail(HTREE_ERROR_ARGUMENT, "mesh is NULL");
    htree_options options;
    HT_TRY(ht_options_read(given, &options));
    HT_TRY(verify_mesh(mesh));
    ht_build *build = find_builder(options.kind);
    if (!build) {
        return ht_fail(HTREE_ERROR_UNSUPPORTED, "this version of the library cannot build kind %s",
                       htree_kind_name(options.kind));
    }
    htree *tree = tree_new(mesh, &options);
    if (!tree) return HTREE_ERROR_MEMORY;
    const htree_status status = build_tree(tree, mesh, &options, build);
    if (status != HTREE_OK) {
        htree_free(tree);
        return status;
    }
    tree->build_seconds = ht_seconds() - start;
    assert(htree_check(tree) != HTREE_ERROR_CORRUPT);
    *out = tree;
    return HTREE_OK;
}
