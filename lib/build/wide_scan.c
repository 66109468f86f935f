/* wide_scan.c: the first pass over a mesh: what can be hit, its bounds, and the cell of each prim
 * in a grid over all of them (section 7.1), with exact boxes of what the cells hold.
 *
 * Each thread takes a chunk of the prims and has its own table of cells. Chunks follow each other
 * in order of id, and so do the prims of a cell, so the result does not depend on how many there
 * are. */
#include "cells.h"
#include "wide.h"

enum {
    MOST_CHUNKS = 16,
    MOST_PIECES = 16,
    PRIMS_A_CHUNK = 4096,
    PRIMS_A_CELL = 8, /* one of a few cells is occupied where prims form surfaces */
    MOST_CELLS = 1 << 20,
    CELLS_PAY = 2048 /* prims from which on a grid is worth its while */
};

typedef struct chunk {
    uint32_t first, end; /* prims, triangles before objects */
    uint64_t invalid, degenerate;
    uint32_t bad; /* the first prim that the mesh is refused for */
    bool no_vertex;
    uint32_t *next; /* by cell: how many prims, then where the next one goes */
    ht_box4 *boxes; /* by cell */
} chunk;

/* Of the arrays of vertices and objects. */
typedef struct piece {
    htree_box extent;
    bool in_range; /* every vertex, NaN and infinity apart */
} piece;

typedef struct scan {
    const ht_builder *builder;
    const ht_source *source;
    ht_wide_cells *cells;
    ht_wide_grid grid;
    bool strict, in_range;
    uint32_t chunks;
    chunk part[MOST_CHUNKS];
    uint32_t piece_count;
    piece pieces[MOST_PIECES];
} scan;

/* ---- How far the mesh reaches --------------------------------------------------------------- */

static void add_valid(htree_box *extent, const float *lo, const float *hi) {
    for (int k = 0; k < 3; ++k) {
        if (ht_magnitude(lo[k]) <= HTREE_COORDINATE_MAX)
            extent->lo[k] = ht_min(extent->lo[k], lo[k]);
        if (ht_magnitude(hi[k]) <= HTREE_COORDINATE_MAX)
            extent->hi[k] = ht_max(extent->hi[k], hi[k]);
    }
}

/* Sets *extent as if every vertex were in range; returns whether it is so. */
static bool measure_vertices(const ht_source *from, uint64_t first, uint64_t end,
                             htree_box *extent) {
    const ht_source source = *from;
    const ht_f4 limit = ht_f4_all(HTREE_COORDINATE_MAX);
    ht_f4 finite = ht_f4_all(0); /* x - x is 0, or NaN for ever */
    ht_box4 box = ht_box4_empty();
    for (uint64_t i = first; i < end; ++i) {
        const ht_f4 position = ht_source_any_position(&source, i);
        ht_box4_add(&box, position, position);
        finite = ht_f4_add(finite, ht_f4_sub(position, position));
    }
    *extent = ht_box4_box(&box);
    const uint32_t good = ht_f4_above(ht_f4_all(1), finite) & ~ht_f4_above(box.hi, limit) &
                          ~ht_f4_above(ht_f4_sub(ht_f4_all(0), limit), box.lo);
    return (good & HT_XYZ) == HT_XYZ;
}

static htree_box valid_extent_of(const ht_source *source, uint64_t first, uint64_t end) {
    htree_box extent = ht_box_empty();
    for (uint64_t i = first; i < end; ++i) {
        float p[3];
        memcpy(p, source->positions + i * source->stride, sizeof p);
        add_valid(&extent, p, p);
    }
    return extent;
}

static void measure_piece(void *data, uint32_t index) {
    scan *s = (scan *)data;
    const ht_source *source = s->source;
    const uint64_t vertices = source->vertex_count, objects = source->object_count;
    const uint64_t pieces = s->piece_count;
    const uint64_t first = vertices * index / pieces, end = vertices * (index + 1) / pieces;
    piece *p = &s->pieces[index];
    p->in_range = measure_vertices(source, first, end, &p->extent);
    if (!p->in_range) p->extent = valid_extent_of(source, first, end);
    for (uint64_t i = objects * index / pieces; i < objects * (index + 1) / pieces; ++i)
        add_valid(&p->extent, source->boxes[i].lo, source->boxes[i].hi);
}

static void shape_grid(scan *s) {
    const uint64_t prims = (uint64_t)s->source->triangle_count + s->source->object_count;
    const double wanted = prims < CELLS_PAY ? 1 : (double)prims / PRIMS_A_CELL;
    htree_box all = ht_box_empty();
    s->in_range = true;
    for (uint32_t i = 0; i < s->piece_count; ++i) {
        ht_box_add(&all, &s->pieces[i].extent);
        s->in_range &= s->pieces[i].in_range;
    }
    for (int k = 0; k < 3; ++k) {
        all.lo[k] *= 2;
        all.hi[k] *= 2;
    }
    ht_wide_grid_shape(&s->grid, &all, wanted < MOST_CELLS ? wanted : MOST_CELLS);
}

/* ---- Every prim ----------------------------------------------------------------------------- */

HT_INLINE void add_prim(const ht_wide_scanner *s, uint32_t i, const ht_box4 *box) {
    const uint32_t cell = ht_wide_grid_cell(&s->grid, box->lo, box->hi);
    s->cell_of[i] = cell;
    ++s->next[cell];
    ht_box4_add(&s->boxes[cell], box->lo, box->hi);
}

HT_INLINE ht_verdict scan_triangle(const ht_wide_scanner *s, uint32_t i, bool in_range) {
    if (HT_UNLIKELY(!ht_source_has_corners(&s->source, i))) return HT_NO_VERTEX;
    const ht_corners corners = ht_source_corners(&s->source, i);
    const ht_verdict verdict =
        in_range ? ht_corners_judge_area(&corners) : ht_corners_judge(&corners);
    if (HT_UNLIKELY(verdict != HT_HITTABLE)) return verdict;
    const ht_box4 box = ht_corners_box(&corners);
    add_prim(s, i, &box);
    return HT_HITTABLE;
}

/* Up to the first triangle that cannot be hit, or the end. */
HT_INLINE uint32_t scan_some(const ht_wide_scanner *given, uint32_t i, uint32_t end, bool in_range,
                             ht_verdict *verdict) {
    const ht_wide_scanner s = *given;
    for (*verdict = HT_HITTABLE; i < end; ++i) {
        *verdict = scan_triangle(&s, i, in_range);
        if (HT_UNLIKELY(*verdict != HT_HITTABLE)) break;
    }
    return i;
}

static ht_verdict scan_object(const ht_wide_scanner *s, uint32_t i) {
    const htree_box *object = &s->source.boxes[i - s->source.triangle_count];
    if (!ht_box_is_valid(object)) return HT_INVALID;
    const ht_box4 box = ht_box4_of(object);
    add_prim(s, i, &box);
    return HT_HITTABLE;
}

/* Notes a prim that cannot be hit; returns false if the mesh is to be refused for it. */
static bool skip(const scan *s, chunk *c, uint32_t i, ht_verdict why) {
    s->cells->leaf_order[i] = HTREE_NONE;
    c->degenerate += why == HT_DEGENERATE;
    c->invalid += why == HT_INVALID;
    c->no_vertex = why == HT_NO_VERTEX;
    if (why == HT_DEGENERATE || (why == HT_INVALID && !s->strict)) return true;
    c->bad = i;
    return false;
}

/* Scans what can be scanned many at a time; returns up to where the rest goes one by one. */
static uint32_t scan_many(const scan *s, chunk *c, const ht_wide_scanner *local, uint32_t *i,
                          uint32_t end) {
#ifdef HT_X86
    if (s->builder->tree->isa == HT_AVX512 && s->in_range) {
        *i = ht_wide_scan_avx512(local, *i, end, &c->degenerate);
        return end - *i < HT_WIDE_AT_ONCE ? end : *i + HT_WIDE_AT_ONCE;
    }
#endif
    (void)s, (void)c, (void)local, (void)i;
    return end;
}

static bool scan_triangles(const scan *s, chunk *c, const ht_wide_scanner *local) {
    const uint32_t triangles = local->source.triangle_count;
    const uint32_t end = c->end < triangles ? c->end : triangles;
    for (uint32_t i = c->first; i < end;) {
        ht_verdict verdict;
        const uint32_t stop = scan_many(s, c, local, &i, end);
        i = s->in_range ? scan_some(local, i, stop, true, &verdict)
                        : scan_some(local, i, stop, false, &verdict);
        if (verdict != HT_HITTABLE && !skip(s, c, i++, verdict)) return false;
    }
    return true;
}

static void scan_chunk(void *data, uint32_t index) {
    scan *s = (scan *)data;
    chunk *c = &s->part[index];
    const ht_wide_scanner local = {*s->source, s->grid, s->cells->leaf_order, c->next, c->boxes};
    const uint32_t triangles = local.source.triangle_count;
    memset(c->next, 0, s->grid.total * sizeof *c->next);
    for (uint32_t cell = 0; cell < s->grid.total; ++cell) c->boxes[cell] = ht_box4_empty();
    if (!scan_triangles(s, c, &local)) return;
    for (uint32_t i = c->first < triangles ? triangles : c->first; i < c->end; ++i) {
        const ht_verdict verdict = scan_object(&local, i);
        if (verdict != HT_HITTABLE && !skip(s, c, i, verdict)) return;
    }
}

/* ---- Sort ----------------------------------------------------------------------------------- */

/* Turns counts into places, cell by cell and chunk by chunk, and lists the cells that hold any. */
static htree_status list_cells(scan *s) {
    uint32_t place = 0;
    ht_box4 bounds = ht_box4_empty();
    for (uint32_t cell = 0; cell < s->grid.total; ++cell) {
        const uint32_t first = place;
        ht_box4 box = ht_box4_empty();
        for (uint32_t i = 0; i < s->chunks; ++i) {
            chunk *c = &s->part[i];
            const uint32_t count = c->next[cell];
            c->next[cell] = place;
            place += count;
            ht_box4_add(&box, c->boxes[cell].lo, c->boxes[cell].hi);
        }
        if (place == first) continue;
        ht_prim *listed = (ht_prim *)ht_array_add(&s->cells->cells);
        if (!listed) return HTREE_ERROR_MEMORY;
        ht_cell_set(listed, &box, first, place - first);
        ht_box4_add(&bounds, box.lo, box.hi);
    }
    s->builder->tree->bounds = ht_box4_box(&bounds);
    return HTREE_OK;
}

static void sort_chunk(void *data, uint32_t index) {
    scan *s = (scan *)data;
    chunk *c = &s->part[index];
    for (uint32_t i = c->first; i < c->end; ++i) {
        const uint32_t cell = s->cells->leaf_order[i];
        if (cell != HTREE_NONE) s->cells->order[c->next[cell]++] = i;
    }
}

/* ---- All of it ------------------------------------------------------------------------------ */

static htree_status join_chunks(const scan *s) {
    htree *tree = s->builder->tree;
    for (uint32_t i = 0; i < s->chunks; ++i) {
        const chunk *c = &s->part[i];
        if (c->bad != HTREE_NONE) return ht_refuse_prim(s->source, c->bad, c->no_vertex);
        tree->prim_count += c->end - c->first - (uint32_t)(c->invalid + c->degenerate);
        tree->invalid += c->invalid;
        tree->degenerate += c->degenerate;
    }
    return HTREE_OK;
}

static void cut_chunks(scan *s) {
    const uint64_t prims = (uint64_t)s->source->triangle_count + s->source->object_count;
    const htree *tree = s->builder->tree;
    uint64_t chunks = prims / PRIMS_A_CHUNK + 1;
    const uint32_t threads = ht_thread_count(&tree->tasks, tree->threads);
    if (chunks > threads) chunks = threads;
    if (chunks > MOST_CHUNKS) chunks = MOST_CHUNKS;
    s->chunks = (uint32_t)chunks;
    for (uint32_t i = 0; i < s->chunks; ++i) {
        chunk *c = &s->part[i];
        c->first = (uint32_t)(prims * i / chunks);
        c->end = (uint32_t)(prims * (i + 1) / chunks);
        c->bad = HTREE_NONE;
    }
    const uint64_t pieces = (s->source->vertex_count + s->source->object_count) / PRIMS_A_CHUNK + 1;
    s->piece_count = pieces < MOST_PIECES ? (uint32_t)pieces : MOST_PIECES;
}

static htree_status scan_and_sort(scan *s) {
    ht_builder_run(s->builder, s->chunks, scan_chunk, s);
    HT_TRY(join_chunks(s));
    HT_TRY(list_cells(s));
    ht_builder_run(s->builder, s->chunks, sort_chunk, s);
    return HTREE_OK;
}

htree_status ht_wide_scan(ht_wide_build *build) {
    const ht_builder *builder = build->builder;
    ht_memory *memory = &builder->tree->memory;
    scan s;
    memset(&s, 0, sizeof s);
    s.builder = builder;
    s.source = &build->source;
    s.cells = &build->cells;
    s.strict = (builder->options->flags & HTREE_STRICT) != 0;
    cut_chunks(&s);
    ht_builder_run(builder, s.piece_count, measure_piece, &s);
    shape_grid(&s);
    const uint64_t cell_bytes = sizeof(uint32_t) + sizeof(ht_box4);
    const uint64_t bytes = s.chunks * cell_bytes * s.grid.total;
    char *tables = (char *)ht_allocate(memory, bytes);
    if (!tables) return HTREE_ERROR_MEMORY;
    for (uint32_t i = 0; i < s.chunks; ++i) {
        s.part[i].boxes = (ht_box4 *)(void *)tables + (size_t)i * s.grid.total;
        s.part[i].next = (uint32_t *)(void *)(tables + s.chunks * sizeof(ht_box4) * s.grid.total) +
                         (size_t)i * s.grid.total;
    }
    const htree_status status = scan_and_sort(&s);
    ht_release(memory, tables, bytes);
    return status;
}
