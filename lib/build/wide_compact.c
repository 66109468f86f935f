/* wide_compact.c: a finished wide tree in less than half of its memory. Planes become bytes,
 * rounded outward; leaves share the vertices of their neighbourhood, as a mesh does. Corners stay
 * exact, so hits do not change.
 *
 * Chunks of leaves share no vertices; their number is fixed, and so are the bytes. */
#include "wide.h"

enum {
    CHUNKS = 64,
    PATCH = 256,      /* vertices that a byte can tell apart */
    TABLE = 4 * PATCH /* a power of two */
};

/* ---- Leaves --------------------------------------------------------------------------------- */

typedef struct chunk {
    uint32_t first, end; /* leaves */
    ht_array vertices;   /* of float[3] */
    uint32_t base;       /* where they begin in the tree */
    htree_status status;
} chunk;

typedef struct compacting {
    const ht_builder *builder;
    const htree *tree;
    ht_compact_node *nodes;
    ht_compact_leaf *leaves;
    float *vertices;
    chunk chunks[CHUNKS];
} compacting;

/* The vertices of a patch by the bits of their coordinates. */
typedef struct patch {
    uint32_t first, count;
    uint16_t table[TABLE]; /* 1 + vertex, or 0 */
} patch;

static void begin_patch(patch *p, uint32_t first) {
    p->first = first;
    p->count = 0;
    memset(p->table, 0, sizeof p->table);
}

static uint32_t hash_of(const float v[3]) {
    uint32_t bits[3];
    memcpy(bits, v, sizeof bits);
    const uint32_t mixed = bits[0] * 0x9e3779b1u ^ bits[1] * 0x85ebca6bu ^ bits[2] * 0xc2b2ae35u;
    return (mixed ^ mixed >> 15) % TABLE;
}

/* The number of a vertex in the patch, which takes it in if it is new; PATCH if there is no room.
 * False without memory. */
static bool number_of(patch *p, ht_array *vertices, const float v[3], uint32_t *number) {
    uint32_t at = hash_of(v);
    for (; p->table[at]; at = (at + 1) % TABLE) {
        *number = p->table[at] - 1u;
        if (memcmp(ht_array_at(vertices, p->first + *number), v, 12) == 0) return true;
    }
    *number = PATCH;
    if (p->count == PATCH) return true;
    float *added = (float *)ht_array_add(vertices);
    if (!added) return false;
    memcpy(added, v, 12);
    *number = p->count++;
    p->table[at] = (uint16_t)(*number + 1);
    return true;
}

/* PATCH in *number if the leaf does not fit into the patch. */
static bool number_corners(patch *p, ht_array *vertices, const ht_wide_leaf *leaf,
                           uint32_t triangles, ht_compact_leaf *out, uint32_t *number) {
    *number = 0;
    for (uint32_t i = 0; i < triangles; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            const float v[3] = {leaf->v[k][0][i], leaf->v[k][1][i], leaf->v[k][2][i]};
            if (!number_of(p, vertices, v, number)) return false;
            if (*number == PATCH) return true;
            out->corner[k][i] = (uint8_t)*number;
        }
    }
    return true;
}

static htree_status compact_leaves(const compacting *c, chunk *part) {
    patch p;
    begin_patch(&p, 0);
    for (uint32_t i = part->first; i < part->end; ++i) {
        const ht_wide_leaf *leaf = &c->tree->leaves[i];
        ht_compact_leaf *out = &c->leaves[i];
        uint32_t triangles = 0, number;
        while (triangles < HT_LANES && leaf->prim[triangles] < c->tree->triangle_count) ++triangles;
        memset(out, 0, sizeof *out);
        memcpy(out->prim, leaf->prim, sizeof out->prim);
        if (!number_corners(&p, &part->vertices, leaf, triangles, out, &number))
            return HTREE_ERROR_MEMORY;
        if (number == PATCH) {
            begin_patch(&p, (uint32_t)part->vertices.count);
            if (!number_corners(&p, &part->vertices, leaf, triangles, out, &number))
                return HTREE_ERROR_MEMORY;
        }
        out->first = p.first;
    }
    return HTREE_OK;
}

static void run_chunk(void *data, uint32_t index) {
    compacting *c = (compacting *)data;
    c->chunks[index].status = compact_leaves(c, &c->chunks[index]);
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

static float plane_at(const ht_compact_node *node, uint32_t axis, uint32_t q) {
    return node->origin[axis] + (float)q * node->step[axis];
}

/* The step that 255 of reach `hi` with; it is no denormal, which hosts may have turned off. */
static void set_steps(ht_compact_node *node, uint32_t axis, float lo, float hi) {
    node->origin[axis] = lo;
    node->step[axis] = ht_max((hi - lo) / UINT8_MAX, 1.2e-38f);
    while (plane_at(node, axis, UINT8_MAX) < hi) node->step[axis] *= 1.0000002f;
}

static uint8_t round_down(const ht_compact_node *node, uint32_t axis, float plane) {
    const float q = (plane - node->origin[axis]) / node->step[axis];
    uint32_t at = q < UINT8_MAX ? (uint32_t)q : UINT8_MAX;
    while (at > 0 && plane_at(node, axis, at) > plane) --at;
    return (uint8_t)at;
}

static uint8_t round_up(const ht_compact_node *node, uint32_t axis, float plane) {
    uint32_t at = round_down(node, axis, plane);
    while (at < UINT8_MAX && plane_at(node, axis, at) < plane) ++at;
    return (uint8_t)at;
}

static void compact_node(const ht_wide_node *from, ht_compact_node *to) {
    memset(to, 0, sizeof *to);
    memcpy(to->child, from->child, sizeof to->child);
    for (uint32_t axis = 0; axis < 3; ++axis) {
        float lo = INFINITY, hi = -INFINITY;
        for (uint32_t i = 0; i < HT_LANES; ++i) {
            lo = ht_min(lo, from->lo[axis][i]);
            hi = ht_max(hi, from->hi[axis][i]);
        }
        set_steps(to, axis, lo, hi);
        for (uint32_t i = 0; i < HT_LANES; ++i) {
            if (from->child[i] == HT_WIDE_NONE) continue;
            to->lo[axis][i] = round_down(to, axis, from->lo[axis][i]);
            to->hi[axis][i] = round_up(to, axis, from->hi[axis][i]);
        }
    }
}

/* Nodes; and vertices, and the leaves' numbers of them, to where they are in the tree. */
static void finish_chunk(void *data, uint32_t index) {
    const compacting *c = (const compacting *)data;
    const chunk *part = &c->chunks[index];
    const ht_wide_node *nodes = (const ht_wide_node *)c->tree->nodes;
    const uint32_t end = (uint32_t)((uint64_t)c->tree->node_slots * (index + 1) / CHUNKS);
    for (uint32_t i = (uint32_t)((uint64_t)c->tree->node_slots * index / CHUNKS); i < end; ++i)
        compact_node(&nodes[i], &c->nodes[i]);
    for (uint32_t i = part->first; i < part->end; ++i) c->leaves[i].first += part->base;
    if (part->vertices.count)
        memcpy(c->vertices + 3 * (uint64_t)part->base, part->vertices.items,
               (size_t)(12 * part->vertices.count));
}

/* ---- All of it ------------------------------------------------------------------------------ */

/* Returns how many vertices there are; any byte may follow the first one of a leaf. */
static uint64_t place_vertices(compacting *c) {
    uint64_t count = 0;
    for (uint32_t i = 0; i < CHUNKS; ++i) {
        c->chunks[i].base = (uint32_t)count;
        count += c->chunks[i].vertices.count;
    }
    return count + PATCH;
}

/* Gives the wide arrays back, and has the compact ones in their place. */
static void replace_arrays(htree *tree, const compacting *c, uint64_t vertices) {
    ht_release(&tree->memory, tree->nodes, tree->node_bytes);
    ht_release(&tree->memory, tree->leaves, tree->leaf_count * sizeof *tree->leaves);
    tree->nodes = c->nodes;
    tree->node_bytes = tree->node_slots * sizeof *c->nodes;
    tree->leaves = NULL;
    tree->compact_leaves = c->leaves;
    tree->vertices = c->vertices;
    tree->vertex_count = (uint32_t)vertices;
}

static htree_status run(compacting *c, htree *tree) {
    ht_memory *memory = &tree->memory;
    c->nodes = (ht_compact_node *)ht_allocate(memory, tree->node_slots * sizeof *c->nodes);
    c->leaves = (ht_compact_leaf *)ht_allocate(memory, tree->leaf_count * sizeof *c->leaves);
    if (!c->nodes || !c->leaves) return HTREE_ERROR_MEMORY;
    ht_builder_run(c->builder, CHUNKS, run_chunk, c);
    for (uint32_t i = 0; i < CHUNKS; ++i) {
        if (c->chunks[i].status != HTREE_OK)
            return ht_fail(HTREE_ERROR_MEMORY, "out of memory while a thread compacted the tree");
    }
    const uint64_t vertices = place_vertices(c);
    if (vertices > UINT32_MAX)
        return ht_fail(HTREE_ERROR_LIMIT, "a compact tree holds fewer than 2^32 vertices");
    c->vertices = (float *)ht_allocate(memory, 12 * vertices);
    if (!c->vertices) return HTREE_ERROR_MEMORY;
    memset(c->vertices + 3 * (vertices - PATCH), 0, 12 * PATCH);
    ht_builder_run(c->builder, CHUNKS, finish_chunk, c);
    replace_arrays(tree, c, vertices);
    return HTREE_OK;
}

htree_status ht_wide_compact(const ht_builder *builder) {
    htree *tree = builder->tree;
    compacting c;
    memset(&c, 0, sizeof c);
    c.builder = builder;
    c.tree = tree;
    for (uint32_t i = 0; i < CHUNKS; ++i) {
        c.chunks[i].first = (uint32_t)((uint64_t)tree->leaf_count * i / CHUNKS);
        c.chunks[i].end = (uint32_t)((uint64_t)tree->leaf_count * (i + 1) / CHUNKS);
        ht_array_begin(&c.chunks[i].vertices, &tree->memory, 12);
    }
    const htree_status status = run(&c, tree);
    for (uint32_t i = 0; i < CHUNKS; ++i) ht_array_end(&c.chunks[i].vertices);
    if (status != HTREE_OK) {
        ht_release(&tree->memory, c.leaves, tree->leaf_count * sizeof *c.leaves);
        ht_release(&tree->memory, c.nodes, tree->node_slots * sizeof *c.nodes);
    }
    return status;
}
