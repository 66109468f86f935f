/* mesh.c: checks a mesh, copies what the tree keeps, and makes prims of what can be hit.
 *
 * Triangles are loaded in chunks, whose number follows from the mesh. A chunk leaves out what cannot
 * be hit, and the gaps are closed afterwards, so prims come in the same order from any threads. */
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

/* ---- Triangles ------------------------------------------------------------------------------ */

enum { TRIANGLES_A_CHUNK = 8192, MOST_CHUNKS = 64 };

/* What a chunk found: bad is the first triangle that refers to a vertex that is not there, or that
 * HTREE_STRICT refuses. */
typedef struct chunk {
    htree_box bounds;
    uint32_t first, end;
    uint32_t prims; /* written to builder->prims from `first` on */
    uint32_t bad;
    bool no_vertex;
    uint64_t invalid, degenerate;
} chunk;

typedef struct loading {
    ht_builder *builder;
    const htree_mesh *mesh;
    uint32_t chunks;
    chunk part[MOST_CHUNKS];
} loading;

static bool is_in_range(const float *p) {
    return ht_magnitude(p[0]) <= HTREE_COORDINATE_MAX &&
           ht_magnitude(p[1]) <= HTREE_COORDINATE_MAX && ht_magnitude(p[2]) <= HTREE_COORDINATE_MAX;
}

/* A box without an order of its planes contains nothing. */
static bool is_box_in_range(const htree_box *box) {
    return is_in_range(box->lo) && is_in_range(box->hi) && box->lo[0] <= box->hi[0] &&
           box->lo[1] <= box->hi[1] && box->lo[2] <= box->hi[2];
}

/* Index of corner k of triangle i, a vertex or beyond the last one. */
HT_INLINE uint64_t vertex_of(const htree_mesh *mesh, uint32_t i, uint64_t k) {
    const uint64_t at = 3 * (uint64_t)i + k;
    return mesh->indices ? mesh->indices[at] : at;
}

HT_INLINE bool load_corners(const htree_mesh *mesh, uint32_t i, ht_triangle *triangle) {
    const uint64_t stride = mesh->position_stride ? mesh->position_stride : 12;
    for (uint64_t k = 0; k < 3; ++k) {
        const uint64_t vertex = vertex_of(mesh, i, k);
        if (HT_UNLIKELY(vertex >= mesh->vertex_count)) return false;
        memcpy(triangle->v[k], (const char *)mesh->positions + vertex * stride, 12);
    }
    return true;
}

static void set_prim(ht_prim *prim, uint32_t id, const htree_box *box) {
    memcpy(prim->lo, box->lo, sizeof box->lo);
    memcpy(prim->hi, box->hi, sizeof box->hi);
    memcpy(&prim->lo[3], &id, sizeof id);
    prim->hi[3] = 0;
}

/* Loads one triangle; false if the mesh is to be refused. */
HT_INLINE bool load_triangle(const loading *l, chunk *c, uint32_t i) {
    htree *tree = l->builder->tree;
    ht_triangle *triangle = &tree->triangles[i];
    c->no_vertex = !load_corners(l->mesh, i, triangle);
    if (c->no_vertex) return false;
    const float(*v)[3] = (const float(*)[3])triangle->v;
    const bool valid = is_in_range(v[0]) && is_in_range(v[1]) && is_in_range(v[2]);
    if (valid && !ht_triangle_is_degenerate(v[0], v[1], v[2])) {
        const htree_box box = ht_prim_box(tree, i);
        set_prim(&l->builder->prims[c->first + c->prims++], i, &box);
        ht_box_add(&c->bounds, &box);
        return true;
    }
    memset(triangle, 0, sizeof *triangle);
    if (valid)
        ++c->degenerate;
    else
        ++c->invalid;
    return valid || !(l->builder->options->flags & HTREE_STRICT);
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

static htree_status refuse(const char *what, uint32_t index) {
    return ht_fail(HTREE_ERROR_GEOMETRY,
                   "%s %lu has a NaN, infinite or oversize coordinate, or lo > hi", what,
                   (unsigned long)index);
}

/* Closes the gaps between chunks, and adds up what they found. */
static htree_status join_chunks(const loading *l) {
    ht_builder *builder = l->builder;
    htree *tree = builder->tree;
    for (uint32_t k = 0; k < l->chunks; ++k) {
        const chunk *c = &l->part[k];
        if (c->bad != HTREE_NONE && c->no_vertex) {
            uint64_t vertex = 0;
            for (uint64_t i = 0; i < 3 && vertex < l->mesh->vertex_count; ++i)
                vertex = vertex_of(l->mesh, c->bad, i);
            return ht_fail(HTREE_ERROR_GEOMETRY, "triangle %lu refers to vertex %llu of %llu",
                           (unsigned long)c->bad, (unsigned long long)vertex,
                           (unsigned long long)l->mesh->vertex_count);
        }
        if (c->bad != HTREE_NONE) return refuse("triangle", c->bad);
        if (tree->prim_count != c->first)
            memmove(builder->prims + tree->prim_count, builder->prims + c->first,
                    c->prims * sizeof *builder->prims);
        tree->prim_count += c->prims;
        tree->invalid += c->invalid;
        tree->degenerate += c->degenerate;
        ht_box_add(&tree->bounds, &c->bounds);
    }
    return HTREE_OK;
}

static htree_status load_triangles(ht_builder *builder, const htree_mesh *mesh) {
    const uint64_t count = builder->tree->triangle_count;
    loading l;
    l.builder = builder;
    l.mesh = mesh;
    l.chunks = (uint32_t)((count + TRIANGLES_A_CHUNK - 1) / TRIANGLES_A_CHUNK);
    if (l.chunks > MOST_CHUNKS) l.chunks = MOST_CHUNKS;
    for (uint32_t k = 0; k < l.chunks; ++k) {
        const chunk empty = {ht_box_empty(),
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

static htree_status load_objects(ht_builder *builder, const htree_mesh *mesh) {
    htree *tree = builder->tree;
    for (uint32_t i = 0; i < tree->object_count; ++i) {
        htree_box *box = &tree->object_boxes[i];
        *box = mesh->objects->boxes[i];
        if (is_box_in_range(box)) {
            set_prim(&builder->prims[tree->prim_count++], tree->triangle_count + i, box);
            ht_box_add(&tree->bounds, box);
            continue;
        }
        if (builder->options->flags & HTREE_STRICT) return refuse("object", i);
        ++tree->invalid;
        *box = ht_box_empty();
    }
    return HTREE_OK;
}

htree_status ht_load_mesh(ht_builder *builder, const htree_mesh *mesh) {
    HT_TRY(load_triangles(builder, mesh));
    return load_objects(builder, mesh);
}
