/* mesh.c: checks a mesh, copies what the tree keeps, and makes prims of what can be hit.
 *
 * Triangles are loaded in chunks, whose number follows from the mesh. A chunk leaves out what
 * cannot be hit, and the gaps are closed afterwards, so prims come in the same order from any
 * threads. */
#include "mesh.h"

/* ---- Check ---------------------------------------------------------------------------------- */

htree_status ht_verify_mesh(const htree_mesh *mesh) {
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

/* ---- What builders read ---------------------------------------------------------------------- */

ht_source ht_source_of(const htree_mesh *mesh) {
    const htree_objects *objects = mesh->objects;
    ht_source source;
    source.positions = (const char *)mesh->positions;
    source.stride = mesh->position_stride ? mesh->position_stride : 12;
    source.vertex_count = mesh->positions ? mesh->vertex_count : 0;
    source.indices = mesh->indices;
    source.triangle_count = (uint32_t)mesh->triangle_count;
    source.object_count = objects ? (uint32_t)objects->count : 0;
    source.boxes = objects ? objects->boxes : NULL;
    return source;
}

bool ht_corners_are_degenerate(ht_corners corners) {
    float v[3][4];
    for (int k = 0; k < 3; ++k) ht_f4_store(v[k], corners.v[k]);
    return ht_triangle_is_degenerate(v[0], v[1], v[2]);
}

htree_status ht_refuse_prim(const ht_source *source, uint32_t prim, bool no_vertex) {
    if (!no_vertex) {
        const bool triangle = prim < source->triangle_count;
        return ht_fail(HTREE_ERROR_GEOMETRY,
                       "%s %lu has a NaN, infinite or oversize coordinate, or lo > hi",
                       triangle ? "triangle" : "object",
                       (unsigned long)(triangle ? prim : prim - source->triangle_count));
    }
    uint64_t vertex = 0;
    for (uint32_t k = 0; k < 3 && vertex < source->vertex_count; ++k)
        vertex = ht_source_vertex(source, prim, k);
    return ht_fail(HTREE_ERROR_GEOMETRY, "triangle %lu refers to vertex %llu of %llu",
                   (unsigned long)prim, (unsigned long long)vertex,
                   (unsigned long long)source->vertex_count);
}

/* ---- Triangles ------------------------------------------------------------------------------ */

enum { TRIANGLES_A_CHUNK = 8192, MOST_CHUNKS = 64 };

/* What a chunk found: bad is the first triangle that refers to a vertex that is not there, or that
 * HTREE_STRICT refuses. */
typedef struct chunk {
    ht_box4 bounds;
    uint32_t first, end;
    uint32_t prims; /* written to builder->prims from `first` on */
    uint32_t bad;
    bool no_vertex;
    uint64_t invalid, degenerate;
} chunk;

typedef struct loading {
    ht_builder *builder;
    ht_source source;
    uint32_t chunks;
    chunk part[MOST_CHUNKS];
} loading;

/* Loads one triangle; false if the mesh is to be refused. */
HT_INLINE bool load_triangle(const loading *l, chunk *c, uint32_t i) {
    ht_triangle *triangle = &l->builder->tree->triangles[i];
    c->no_vertex = !ht_source_has_corners(&l->source, i);
    if (c->no_vertex) return false;
    const ht_corners corners = ht_source_corners(&l->source, i);
    const ht_verdict verdict = ht_corners_judge(&corners);
    if (verdict == HT_HITTABLE) {
        ht_prim *prim = &l->builder->prims[c->first + c->prims++];
        const ht_box4 box = ht_corners_box(&corners);
        ht_prim_set(prim, &box, i);
        ht_box4_add(&c->bounds, box.lo, box.hi);
        for (int k = 0; k < 3; ++k) {
            float v[4];
            ht_f4_store(v, corners.v[k]);
            memcpy(triangle->v[k], v, sizeof triangle->v[k]);
        }
        return true;
    }
    memset(triangle, 0, sizeof *triangle);
    c->degenerate += verdict == HT_DEGENERATE;
    c->invalid += verdict == HT_INVALID;
    return verdict == HT_DEGENERATE || !(l->builder->options->flags & HTREE_STRICT);
}

static void load_chunk(void *data, uint32_t index) {
    loading *l = (loading *)data;
    chunk *c = &l->part[index];
    for (uint32_t i = c->first; i < c->end; ++i) {
        if (load_triangle(l, c, i)) continue;
        c->bad = i;
        return;
    }
}

/* Closes the gaps between chunks, and adds up what they found. */
static htree_status join_chunks(const loading *l) {
    ht_builder *builder = l->builder;
    htree *tree = builder->tree;
    for (uint32_t k = 0; k < l->chunks; ++k) {
        const chunk *c = &l->part[k];
        if (c->bad != HTREE_NONE) return ht_refuse_prim(&l->source, c->bad, c->no_vertex);
        if (tree->prim_count != c->first)
            memmove(builder->prims + tree->prim_count, builder->prims + c->first,
                    c->prims * sizeof *builder->prims);
        tree->prim_count += c->prims;
        tree->invalid += c->invalid;
        tree->degenerate += c->degenerate;
        const htree_box bounds = ht_box4_box(&c->bounds);
        ht_box_add(&tree->bounds, &bounds);
    }
    return HTREE_OK;
}

static htree_status load_triangles(ht_builder *builder) {
    const uint64_t count = builder->tree->triangle_count;
    loading l;
    l.builder = builder;
    l.source = ht_source_of(builder->mesh);
    l.chunks = (uint32_t)((count + TRIANGLES_A_CHUNK - 1) / TRIANGLES_A_CHUNK);
    if (l.chunks > MOST_CHUNKS) l.chunks = MOST_CHUNKS;
    for (uint32_t k = 0; k < l.chunks; ++k) {
        const chunk empty = {ht_box4_empty(),
                             (uint32_t)(count * k / l.chunks),
                             (uint32_t)(count * (k + 1) / l.chunks),
                             0,
                             HTREE_NONE,
                             false,
                             0,
                             0};
        l.part[k] = empty;
    }
    ht_builder_run(builder, l.chunks, load_chunk, &l);
    return join_chunks(&l);
}

/* ---- Objects -------------------------------------------------------------------------------- */

static htree_status load_objects(ht_builder *builder) {
    htree *tree = builder->tree;
    const ht_source source = ht_source_of(builder->mesh);
    for (uint32_t i = 0; i < tree->object_count; ++i) {
        const uint32_t id = tree->triangle_count + i;
        if (ht_box_is_valid(&tree->object_boxes[i])) {
            const ht_box4 box = ht_box4_of(&tree->object_boxes[i]);
            ht_prim_set(&builder->prims[tree->prim_count++], &box, id);
            ht_box_add(&tree->bounds, &tree->object_boxes[i]);
        } else if (builder->options->flags & HTREE_STRICT) {
            return ht_refuse_prim(&source, id, false);
        } else {
            ++tree->invalid;
        }
    }
    return HTREE_OK;
}

htree_status ht_copy_objects(ht_builder *builder) {
    htree *tree = builder->tree;
    const htree_objects *objects = builder->mesh->objects;
    tree->object_boxes =
        (htree_box *)ht_allocate(&tree->memory, tree->object_count * sizeof(htree_box));
    if (!tree->object_boxes) return HTREE_ERROR_MEMORY;
    for (uint32_t i = 0; i < tree->object_count; ++i) {
        const bool fine = ht_box_is_valid(&objects->boxes[i]);
        tree->object_boxes[i] = fine ? objects->boxes[i] : ht_box_empty();
    }
    return HTREE_OK;
}

htree_status ht_load_mesh(ht_builder *builder) {
    htree *tree = builder->tree;
    const uint64_t prims = (uint64_t)tree->triangle_count + tree->object_count;
    tree->triangles =
        (ht_triangle *)ht_allocate(&tree->memory, tree->triangle_count * sizeof(ht_triangle));
    builder->prims = (ht_prim *)ht_allocate(&tree->memory, prims * sizeof(ht_prim));
    if (!tree->triangles || !builder->prims) return HTREE_ERROR_MEMORY;
    HT_TRY(load_triangles(builder));
    return load_objects(builder);
}
