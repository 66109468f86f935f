/* subdivide.c: after C. Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987, with the
 * weights of J. Warren. Loop's rules hold where exactly two triangles meet at an edge and one fan
 * at a vertex. Scans and models break both, and the rules for boundaries take over there: what is
 * not a plain surface keeps its place, and no crack opens. */
#include "subdivide.h"

#include "numbers.h"

#include <stdlib.h>
#include <string.h>

#define NO_EDGE UINT32_MAX

typedef struct edge {
    uint32_t a, b;        /* its ends, a <= b */
    uint32_t opposite[2]; /* third corners of its first two triangles */
    uint32_t corners[2];  /* where in the indices the first two triangles have `a`, ... */
    uint32_t others[2];   /* ... and `b` */
    uint32_t triangles;
} edge;

/* What the edges around a vertex add up to. */
typedef struct ring {
    double sum[3], curve[3]; /* of all neighbours, and of those across boundary edges */
    uint32_t count, curve_count, fans;
} ring;

typedef struct mesh_edges {
    edge *list;
    uint64_t count;
    uint32_t *table; /* hash of the ends to the place in the list; empty: NO_EDGE */
    uint64_t mask;
    uint32_t *of_triangle; /* edge i of triangle t joins its corners i and i + 1: at 3 t + i */
    uint32_t *fan;         /* union-find over the corners: one set per fan of triangles */
    ring *rings;
} mesh_edges;

static void edges_free(mesh_edges *e) {
    free(e->list);
    free(e->table);
    free(e->of_triangle);
    free(e->fan);
    free(e->rings);
}

static bool edges_reserve(mesh_edges *e, const shape *mesh) {
    const uint64_t corners = 3 * mesh->triangle_count;
    uint64_t size = 16;
    memset(e, 0, sizeof *e);
    if (corners >= NO_EDGE / 4) return false;
    while (size < 2 * corners) size *= 2;
    e->mask = size - 1;
    e->list = (edge *)malloc((size_t)(corners + 1) * sizeof *e->list);
    e->table = (uint32_t *)malloc((size_t)size * sizeof *e->table);
    e->of_triangle = (uint32_t *)malloc((size_t)(corners + 1) * sizeof *e->of_triangle);
    e->fan = (uint32_t *)malloc((size_t)(corners + 1) * sizeof *e->fan);
    e->rings = (ring *)calloc((size_t)mesh->vertex_count + 1, sizeof *e->rings);
    if (!e->list || !e->table || !e->of_triangle || !e->fan || !e->rings) return false;
    memset(e->table, 0xFF, (size_t)size * sizeof *e->table);
    for (uint64_t i = 0; i < corners; ++i) e->fan[i] = (uint32_t)i;
    return true;
}

/* The edge between two vertices, which is appended when it is new. */
static uint32_t edge_between(mesh_edges *e, uint32_t a, uint32_t b) {
    uint64_t place = hash_pair(a, b) & e->mask;
    for (; e->table[place] != NO_EDGE; place = (place + 1) & e->mask) {
        const edge *known = &e->list[e->table[place]];
        if (known->a == a && known->b == b) return e->table[place];
    }
    edge *fresh = &e->list[e->count];
    memset(fresh, 0, sizeof *fresh);
    fresh->a = a;
    fresh->b = b;
    e->table[place] = (uint32_t)e->count;
    return (uint32_t)e->count++;
}

static void find_edges(mesh_edges *e, const shape *mesh) {
    for (uint64_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const uint64_t first = i - i % 3, next = first + (i + 1) % 3, third = first + (i + 2) % 3;
        const uint32_t from = mesh->indices[i], to = mesh->indices[next];
        const bool upward = from < to;
        const uint32_t name = edge_between(e, upward ? from : to, upward ? to : from);
        edge *found = &e->list[name];
        if (found->triangles < 2) {
            found->opposite[found->triangles] = mesh->indices[third];
            found->corners[found->triangles] = (uint32_t)(upward ? i : next);
            found->others[found->triangles] = (uint32_t)(upward ? next : i);
        }
        ++found->triangles;
        e->of_triangle[i] = name;
    }
}

/* ---- Fans ----------------------------------------------------------------------------------- */

static uint32_t fan_of(uint32_t *fan, uint32_t corner) {
    while (fan[corner] != corner) corner = fan[corner] = fan[fan[corner]];
    return corner;
}

/* Corners that two triangles have at one end of their common edge belong to one fan. */
static void join(uint32_t *fan, const uint32_t *corners) {
    const uint32_t a = fan_of(fan, corners[0]), b = fan_of(fan, corners[1]);
    fan[a > b ? a : b] = a > b ? b : a;
}

static bool is_inner(const edge *e) {
    return e->triangles == 2 && e->a != e->b;
}

static void add_neighbour(ring *r, const float *p, bool inner) {
    for (int k = 0; k < 3; ++k) r->sum[k] += (double)p[k];
    ++r->count;
    if (inner) return;
    for (int k = 0; k < 3; ++k) r->curve[k] += (double)p[k];
    ++r->curve_count;
}

static void gather_rings(mesh_edges *e, const shape *mesh) {
    for (uint64_t i = 0; i < e->count; ++i) {
        const edge *at = &e->list[i];
        const bool inner = is_inner(at);
        add_neighbour(&e->rings[at->a], mesh->positions + 3 * (size_t)at->b, inner);
        add_neighbour(&e->rings[at->b], mesh->positions + 3 * (size_t)at->a, inner);
        if (!inner) continue;
        join(e->fan, at->corners);
        join(e->fan, at->others);
    }
    for (uint64_t i = 0; i < 3 * mesh->triangle_count; ++i)
        e->rings[mesh->indices[i]].fans += e->fan[i] == i;
}

/* ---- Positions ------------------------------------------------------------------------------ */

/* An old vertex: smoothed within a surface or along a curve, else left. */
static void place_vertex(const ring *r, const float *old, float *out) {
    const bool curve = r->curve_count == 2 && r->fans == 1;
    const bool inner = r->curve_count == 0 && r->fans == 1 && r->count >= 3;
    const double weight = !inner ? 0 : r->count == 3 ? 3.0 / 16 : 3.0 / (8 * (double)r->count);
    for (int k = 0; k < 3; ++k) {
        const double p = (double)old[k];
        double moved = p;
        if (inner) moved = p + weight * (r->sum[k] - (double)r->count * p);
        if (curve) moved = 0.75 * p + 0.125 * r->curve[k];
        out[k] = (float)moved;
    }
}

/* A new vertex, on an edge. */
static void place_on_edge(const edge *e, const float *positions, float *out) {
    const float *a = positions + 3 * (size_t)e->a, *b = positions + 3 * (size_t)e->b;
    const float *c = positions + 3 * (size_t)e->opposite[0];
    const float *d = positions + 3 * (size_t)e->opposite[1];
    for (int k = 0; k < 3; ++k) {
        const double ends = (double)a[k] + (double)b[k];
        const double across = (double)c[k] + (double)d[k];
        out[k] = (float)(is_inner(e) ? 0.375 * ends + 0.125 * across : 0.5 * ends);
    }
}

static void split_triangles(const mesh_edges *e, const shape *mesh, uint32_t *out) {
    const uint32_t first = (uint32_t)mesh->vertex_count;
    for (uint64_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *v = mesh->indices + 3 * t, *name = e->of_triangle + 3 * t;
        const uint32_t ab = first + name[0], bc = first + name[1], ca = first + name[2];
        const uint32_t four[12] = {v[0], ab, ca, ab, v[1], bc, ca, bc, v[2], ab, bc, ca};
        memcpy(out + 12 * t, four, sizeof four);
    }
}

static bool subdivide_once(shape *mesh) {
    mesh_edges e;
    shape fine = {NULL, NULL, 0, 4 * mesh->triangle_count};
    bool ok = edges_reserve(&e, mesh);
    if (ok) {
        find_edges(&e, mesh);
        gather_rings(&e, mesh);
        fine.vertex_count = mesh->vertex_count + e.count;
        fine.positions = (float *)malloc((size_t)(fine.vertex_count + 1) * 3 * sizeof(float));
        fine.indices = (uint32_t *)malloc((size_t)(fine.triangle_count + 1) * 3 * sizeof(uint32_t));
        ok = fine.vertex_count < UINT32_MAX && fine.positions && fine.indices;
    }
    if (ok) {
        for (uint64_t i = 0; i < mesh->vertex_count; ++i)
            place_vertex(&e.rings[i], mesh->positions + 3 * i, fine.positions + 3 * i);
        for (uint64_t i = 0; i < e.count; ++i)
            place_on_edge(&e.list[i], mesh->positions,
                          fine.positions + 3 * (mesh->vertex_count + i));
        split_triangles(&e, mesh, fine.indices);
        shape_free(mesh);
        *mesh = fine;
    } else {
        shape_free(&fine);
    }
    edges_free(&e);
    return ok;
}

bool subdivide_loop(shape *mesh, uint32_t levels) {
    for (uint32_t i = 0; i < levels; ++i)
        if (!subdivide_once(mesh)) return false;
    return true;
}
