/* file_load.c: htree_load. Nothing in a file is believed: sizes are compared with those of the bytes
 * before anything is allocated, numbers and boxes are computed anew, and htree_check proves the nodes,
 * because walks have no checks of their own. */
#include "file.h"
#include "options.h"
#include "base/clock.h"
#include "base/float_env.h"
#include "base/sized.h"

/* ---- Options -------------------------------------------------------------------------------- */

/* The struct as version 0.1 knew it. */
enum { FIRST_OPTIONS_SIZE = sizeof(htree_load_options) };

htree_status htree_load_options_init(htree_load_options *options, uint64_t size) {
    if (!options) return ht_fail(HTREE_ERROR_ARGUMENT, "options is NULL");
    if (size < FIRST_OPTIONS_SIZE || size > 65536) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "size is %llu: pass sizeof(htree_load_options)",
                       (unsigned long long)size);
    }
    memset(options, 0, (size_t)size);
    options->size = (uint32_t)size;
    return HTREE_OK;
}

static htree_status read_options(const htree_load_options *given, htree_load_options *options) {
    HT_TRY(htree_load_options_init(options, sizeof *options));
    if (!given) return HTREE_OK;
    HT_TRY(
        ht_sized_read(options, sizeof *options, FIRST_OPTIONS_SIZE, given, given->size, "options"));
    if (options->flags & ~(uint32_t)HTREE_BORROW) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "options.flags is %#lx: unknown bits",
                       (unsigned long)options->flags);
    }
    if (options->reserved) return ht_fail(HTREE_ERROR_ARGUMENT, "options.reserved must be 0");
    if (!options->allocator.allocate != !options->allocator.release) {
        return ht_fail(HTREE_ERROR_ARGUMENT,
                       "options.allocator needs both allocate and release, or neither");
    }
    return HTREE_OK;
}

/* ---- The header ----------------------------------------------------------------------------- */

static htree_status corrupt(const char *what) {
    return ht_fail(HTREE_ERROR_CORRUPT, "%s", what);
}

static htree_status check_origin(const ht_file_header *h) {
    if (memcmp(h->magic, ht_file_magic, sizeof h->magic) != 0) {
        return corrupt("the bytes do not begin as htree_save begins them");
    }
    if (h->order != HT_FILE_ORDER) {
        return ht_fail(HTREE_ERROR_UNSUPPORTED, "the file is of a machine with other byte order");
    }
    if (h->format != HT_FILE_FORMAT) {
        return ht_fail(HTREE_ERROR_UNSUPPORTED, "the file has format %lu, this library reads %lu",
                       (unsigned long)h->format, (unsigned long)HT_FILE_FORMAT);
    }
    return HTREE_OK;
}

static bool is_zero(const void *bytes, uint64_t count) {
    for (uint64_t i = 0; i < count; ++i) {
        if (((const char *)bytes)[i] != 0) return false;
    }
    return true;
}

static bool is_positive(float x, float most) {
    return x > 0 && x <= most;
}

/* What only some kinds have. */
static bool has_fitting_parts(const ht_file_header *h) {
    const bool refs = h->kind == HTREE_UG || h->kind == HTREE_KD;
    return (h->ref_count == 0 || refs) && (h->leaf_count == 0 || h->kind == HTREE_WIDE) &&
           (h->vertex_count == 0 || h->leaf_count > 0) &&
           (h->kind == HTREE_UG || is_zero(&h->grid, sizeof h->grid)) &&
           is_zero(h->spare, sizeof h->spare);
}

/* What the tree was built with, and htree_update builds it with again. */
static htree_options build_options(const ht_file_header *h) {
    htree_options options;
    htree_options_init(&options, sizeof options, h->kind);
    options.kind = h->built_as;
    options.flags = h->flags;
    options.buckets = h->buckets;
    options.axes = h->axes;
    options.few_prims = h->few_prims;
    options.cells_per_prim = h->cells_per_prim;
    options.cost_skd = h->cost[0];
    options.cost_bv2 = h->cost[1];
    options.cost_bv6 = h->cost[2];
    options.cost_intersect = h->cost[3];
    return options;
}

/* The tree is of the kind that was asked for, or it was collapsed. */
static htree_status check_build(const ht_file_header *h) {
    const htree_options options = build_options(h);
    htree_options same;
    const bool collapsed = h->kind == HTREE_WIDE && h->built_as >= HTREE_BVH_MEDIAN &&
                           h->built_as <= HTREE_AH && (h->flags & HTREE_COLLAPSE) != 0;
    if ((h->built_as != h->kind && !collapsed) || ht_options_read(&options, &same) != HTREE_OK)
        return corrupt("the tree was built with options that there are not");
    return HTREE_OK;
}

static htree_status read_header(const void *file, uint64_t size, ht_file_header *h,
                                ht_file_plan *plan) {
    if (size < sizeof *h) return corrupt("the file is shorter than its header");
    memcpy(h, file, sizeof *h);
    HT_TRY(check_origin(h));
    if (h->kind < HTREE_UG || h->kind > HTREE_WIDE) return corrupt("the file is of no kind");
    *plan = ht_file_plan_of(h);
    if (h->bytes != size || plan->end != size) {
        return ht_fail(HTREE_ERROR_CORRUPT, "the file has %llu bytes, its header needs %llu",
                       (unsigned long long)size, (unsigned long long)plan->end);
    }
    if (h->checksum != ht_file_checksum(file, size)) return corrupt("the checksum is wrong");
    if (h->triangle_count >= HTREE_NONE || h->object_count >= HTREE_NONE - h->triangle_count ||
        !has_fitting_parts(h)) {
        return corrupt("the header contradicts itself");
    }
    HT_TRY(check_build(h));
    for (int i = 0; i < HT_FILE_PARTS; ++i) {
        const uint64_t end = i + 1 < HT_FILE_PARTS ? plan->offset[i + 1] : plan->end;
        const uint64_t used = plan->offset[i] + plan->bytes[i];
        if (!is_zero((const char *)file + used, end - used)) return corrupt("a gap is not 0");
    }
    return HTREE_OK;
}

/* ---- The arrays ----------------------------------------------------------------------------- */

static htree *tree_new(const ht_file_header *h, const htree_load_options *options) {
    ht_memory memory = {options->allocator, 0, 0, NULL};
    htree *tree = (htree *)ht_allocate(&memory, sizeof *tree);
    if (!tree) return NULL;
    memset(tree, 0, sizeof *tree);
    tree->memory = memory;
    tree->kind = h->kind;
    tree->threads = ht_team_threads(&options->tasks, options->threads);
    tree->tasks = options->tasks;
    tree->isa = ht_isa_here();
    tree->bounds = ht_box_empty();
    tree->triangle_count = h->triangle_count;
    tree->object_count = h->object_count;
    tree->intersect = options->intersect;
    tree->intersect_user = options->user;
    tree->node_slots = h->node_slots;
    tree->leaf_count = h->leaf_count;
    tree->ref_count = h->ref_count;
    tree->vertex_count = h->vertex_count;
    tree->grid = h->grid;
    tree->stack = h->stack;
    tree->invalid = h->invalid;
    tree->degenerate = h->degenerate;
    tree->cost_skd = h->cost[0];
    tree->cost_bv2 = h->cost[1];
    tree->cost_bv6 = h->cost[2];
    tree->cost_intersect = h->cost[3];
    tree->options = build_options(h);
    tree->options.threads = options->threads;
    tree->options.allocator = options->allocator;
    tree->options.tasks = options->tasks;
    return tree;
}

/* A part of the caller's bytes, or a copy of it; NULL: no memory, or there is no such part. */
static void *take_part(htree *tree, const void *file, const ht_file_plan *plan, int i) {
    const char *const from = (const char *)file + plan->offset[i];
    if (plan->bytes[i] == 0) return NULL;
    /* Nothing writes to the arrays of a tree that is borrowed. */
    if (tree->borrowed) return (void *)(uintptr_t)from;
    void *const copy = ht_allocate(&tree->memory, plan->bytes[i]);
    if (copy) memcpy(copy, from, (size_t)plan->bytes[i]);
    return copy;
}

static htree_status take_parts(htree *tree, const void *file, const ht_file_plan *plan) {
    void *part[HT_FILE_PARTS];
    bool all = true;
    for (int i = 0; i < HT_FILE_PARTS; ++i) {
        part[i] = all ? take_part(tree, file, plan, i) : NULL;
        all = all && (part[i] || plan->bytes[i] == 0);
    }
    tree->triangles = (ht_triangle *)part[0];
    tree->object_boxes = (htree_box *)part[1];
    tree->nodes = part[2];
    tree->node_bytes = plan->bytes[2];
    if (tree->vertex_count)
        tree->compact_leaves = (ht_compact_leaf *)part[3];
    else
        tree->leaves = (ht_wide_leaf *)part[3];
    tree->refs = (uint32_t *)part[4];
    tree->vertices = (float *)part[5];
    return all ? HTREE_OK : HTREE_ERROR_MEMORY;
}

/* ---- The proof ------------------------------------------------------------------------------ */

/* Takes a prim that can be hit into the bounds; false if a coordinate is out of range. */
static bool take_triangle(htree *tree, const ht_triangle *t) {
    if (!ht_triangle_is_valid(t)) return false;
    for (int k = 0; k < 3; ++k) ht_box_add_point(&tree->bounds, t->v[k]);
    ++tree->prim_count;
    return true;
}

static bool take_triangles(htree *tree) {
    const uint32_t count = tree->triangles ? tree->triangle_count : 0;
    for (uint32_t i = 0; i < count; ++i) {
        const ht_triangle *t = &tree->triangles[i];
        const bool skipped = ht_triangle_is_degenerate(t->v[0], t->v[1], t->v[2]);
        if (skipped ? !ht_triangle_is_valid(t) : !take_triangle(tree, t)) return false;
    }
    return true;
}

static bool take_object(htree *tree, const htree_box *box) {
    const htree_box skipped = ht_box_empty();
    if (memcmp(box, &skipped, sizeof skipped) == 0) return true;
    if (!ht_box_is_valid(box)) return false;
    ht_box_add(&tree->bounds, box);
    ++tree->prim_count;
    return true;
}

/* The triangles of a wide leaf; after a refit there may be some without area. */
static bool take_leaf(htree *tree, uint32_t index) {
    ht_wide_leaf room;
    if (!ht_has_vertices(tree, index)) return false;
    const ht_wide_leaf *leaf = ht_wide_leaf_at(tree, index, &room);
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        ht_triangle t;
        if (leaf->prim[i] >= tree->triangle_count) continue;
        for (uint32_t k = 0; k < 9; ++k) t.v[k / 3][k % 3] = leaf->v[k / 3][k % 3][i];
        if (!take_triangle(tree, &t)) return false;
    }
    return true;
}

/* Every coordinate is in range: the walks and the proof compute with them. */
static htree_status take_geometry(htree *tree) {
    const uint64_t prims = (uint64_t)tree->triangle_count + tree->object_count;
    bool sound = take_triangles(tree);
    for (uint32_t i = 0; sound && i < tree->leaf_count; ++i) sound = take_leaf(tree, i);
    for (uint32_t i = 0; sound && i < tree->object_count; ++i)
        sound = take_object(tree, &tree->object_boxes[i]);
    if (!sound) return corrupt("a coordinate is out of range");
    if (tree->invalid > prims || tree->degenerate > prims ||
        tree->invalid + tree->degenerate + tree->prim_count != prims) {
        return corrupt("prims were skipped that can be hit");
    }
    return HTREE_OK;
}

/* A walk turns distances into cells: there is no way to a cell that is not there. */
static htree_status check_grid(const htree *tree) {
    const ht_ug_grid *grid = &tree->grid;
    const float limit = 8 * HTREE_COORDINATE_MAX;
    uint64_t cells = 1;
    for (int i = 0; i < 3; ++i) {
        if (!(ht_magnitude(grid->lo[i]) <= limit && ht_magnitude(grid->hi[i]) <= limit &&
              is_positive(grid->size[i], limit) && grid->reach <= limit)) {
            return corrupt("the grid has no shape");
        }
        cells *= grid->cells[i];
        if (cells == 0 || cells >= tree->node_slots) return corrupt("the grid has other cells");
    }
    return cells + 1 == tree->node_slots ? HTREE_OK : corrupt("the grid has other cells");
}

static htree_status prove(htree *tree) {
    HT_TRY(take_geometry(tree));
    if (tree->object_count && !tree->intersect) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "the tree holds objects: set options.intersect");
    }
    if (tree->prim_count == 0) {
        const bool bare = !tree->node_slots && !tree->leaf_count && !tree->ref_count &&
                          !tree->stack && is_zero(&tree->grid, sizeof tree->grid);
        return bare ? HTREE_OK : corrupt("there are nodes, and no prims");
    }
    if (tree->node_slots == 0) return corrupt("there are prims, and no nodes");
    if (tree->kind == HTREE_UG) HT_TRY(check_grid(tree));
    return htree_check(tree);
}

/* ---- Load ----------------------------------------------------------------------------------- */

static htree_status load(htree **out, const void *file, uint64_t size,
                         const htree_load_options *given) {
    const double start = ht_seconds();
    if (!out) return ht_fail(HTREE_ERROR_ARGUMENT, "out is NULL");
    *out = NULL;
    if (!file) return ht_fail(HTREE_ERROR_ARGUMENT, "file is NULL");
    htree_load_options options;
    HT_TRY(read_options(given, &options));
    const bool borrow = (options.flags & HTREE_BORROW) != 0;
    if (borrow && (uintptr_t)file % HT_ALIGNMENT != 0) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "a borrowed file must lie at a multiple of %d bytes",
                       HT_ALIGNMENT);
    }
    ht_file_header header;
    ht_file_plan plan;
    HT_TRY(read_header(file, size, &header, &plan));
    htree *tree = tree_new(&header, &options);
    if (!tree) return HTREE_ERROR_MEMORY;
    tree->borrowed = borrow;
    htree_status status = take_parts(tree, file, &plan);
    if (status == HTREE_OK) status = prove(tree);
    if (status != HTREE_OK) {
        htree_free(tree);
        return status;
    }
    tree->build_seconds = ht_seconds() - start;
    *out = tree;
    return HTREE_OK;
}

htree_status htree_load(htree **out, const void *file, uint64_t size,
                        const htree_load_options *given) {
    HT_RETURN_IN_DEFAULT_ENV(load(out, file, size, given));
}
