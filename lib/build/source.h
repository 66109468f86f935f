/* source.h: triangles and objects straight from the caller's arrays, for builders that keep no copy
 * of the mesh. */
#ifndef HT_SOURCE_H
#define HT_SOURCE_H

#include "build.h"

typedef struct ht_source {
    const char *positions;
    uint64_t stride, vertex_count;
    const uint32_t *indices; /* NULL: as in htree_mesh */
    uint32_t triangle_count, object_count;
    const htree_box *boxes; /* of objects */
} ht_source;

ht_source ht_source_of(const htree_mesh *mesh);

/* GEOMETRY, and in words why the mesh is refused for a prim. */
htree_status ht_refuse_prim(const ht_source *source, uint32_t prim, bool no_vertex);

/* Corners of a triangle: the last lane means nothing. */
typedef struct ht_corners {
    ht_f4 v[3];
} ht_corners;

/* Index of corner k of triangle i, a vertex or beyond the last one. */
HT_INLINE uint64_t ht_source_vertex(const ht_source *source, uint32_t i, uint32_t k) {
    const uint64_t at = 3 * (uint64_t)i + k;
    return source->indices ? source->indices[at] : at;
}

/* The largest of the three. */
HT_INLINE uint64_t ht_source_last_vertex(const ht_source *source, uint32_t i) {
    uint64_t last = ht_source_vertex(source, i, 0);
    for (uint32_t k = 1; k < 3; ++k) {
        const uint64_t vertex = ht_source_vertex(source, i, k);
        last = vertex > last ? vertex : last;
    }
    return last;
}

HT_INLINE bool ht_source_has_corners(const ht_source *source, uint32_t i) {
    return ht_source_last_vertex(source, i) < source->vertex_count;
}

/* Three floats, wherever they are; and four, where another vertex follows. */
HT_INLINE ht_f4 ht_source_position(const ht_source *source, uint64_t vertex) {
    float position[4] = {0, 0, 0, 0};
    memcpy(position, source->positions + vertex * source->stride, 12);
    return ht_f4_load(position);
}

HT_INLINE ht_f4 ht_source_position4(const ht_source *source, uint64_t vertex) {
    return ht_f4_load((const float *)(const void *)(source->positions + vertex * source->stride));
}

/* Four, but for the last vertex: a float that is stored by itself is slow to read with its neighbours. */
HT_INLINE ht_f4 ht_source_any_position(const ht_source *source, uint64_t vertex) {
    return vertex + 1 == source->vertex_count ? ht_source_position(source, vertex)
                                              : ht_source_position4(source, vertex);
}

/* Of a triangle whose vertices are known to be there. */
HT_INLINE ht_corners ht_source_corners(const ht_source *source, uint32_t i) {
    ht_corners corners;
    if (HT_UNLIKELY(ht_source_last_vertex(source, i) + 1 == source->vertex_count)) {
        for (uint32_t k = 0; k < 3; ++k)
            corners.v[k] = ht_source_position(source, ht_source_vertex(source, i, k));
        return corners;
    }
    for (uint32_t k = 0; k < 3; ++k)
        corners.v[k] = ht_source_position4(source, ht_source_vertex(source, i, k));
    return corners;
}

/* Asks for the indices of a prim that will be read soon. */
HT_INLINE void ht_source_prefetch(const ht_source *source, uint32_t id) {
    if (source->indices && id < source->triangle_count)
        HT_PREFETCH(&source->indices[3 * (uint64_t)id]);
}

HT_INLINE ht_corners ht_no_corners(void) {
    const ht_f4 zero = ht_f4_all(0);
    const ht_corners none = {{zero, zero, zero}};
    return none;
}

HT_INLINE ht_box4 ht_corners_box(const ht_corners *c) {
    ht_box4 box;
    box.lo = ht_f4_min(ht_f4_min(c->v[0], c->v[1]), c->v[2]);
    box.hi = ht_f4_max(ht_f4_max(c->v[0], c->v[1]), c->v[2]);
    return box;
}

/* ---- What can be hit ------------------------------------------------------------------------ */

typedef enum ht_verdict { HT_HITTABLE, HT_DEGENERATE, HT_INVALID, HT_NO_VERTEX } ht_verdict;

enum { HT_XYZ = 7 /* lanes that mean something */ };

/* NaN and infinity are in the sum of all corners, where min and max could have lost a NaN. */
HT_INLINE bool ht_corners_are_in_range(const ht_corners *c) {
    const ht_f4 limit = ht_f4_all(HTREE_COORDINATE_MAX);
    const ht_f4 sum = ht_f4_add(ht_f4_add(c->v[0], c->v[1]), c->v[2]);
    const uint32_t finite = ht_f4_above(ht_f4_sub(sum, sum), ht_f4_all(-1));
    const ht_box4 box = ht_corners_box(c);
    const uint32_t beyond =
        ht_f4_above(box.hi, limit) | ht_f4_above(ht_f4_sub(ht_f4_all(0), limit), box.lo);
    return (~finite & HT_XYZ) == 0 && (beyond & HT_XYZ) == 0;
}

/* Settles nearly all triangles: a component of the cross product carries five roundings, so one
 * that stands out by more than 2^-20 is not 0. */
HT_INLINE bool ht_corners_have_area(const ht_corners *c) {
    const ht_f4 a = ht_f4_sub(c->v[1], c->v[0]), b = ht_f4_sub(c->v[2], c->v[0]);
    const ht_f4 p = ht_f4_mul(a, ht_f4_rotate(b)), q = ht_f4_mul(ht_f4_rotate(a), b);
    const ht_f4 sum = ht_f4_add(ht_f4_magnitude(p), ht_f4_magnitude(q));
    const ht_f4 error = ht_f4_add(ht_f4_mul(sum, ht_f4_all(1e-6f)), ht_f4_all(1e-30f));
    return (ht_f4_above(ht_f4_magnitude(ht_f4_sub(p, q)), error) & HT_XYZ) != 0;
}

/* mesh.c: the same beyond doubt. */
bool ht_corners_are_degenerate(ht_corners corners);

/* Of corners in range. */
HT_INLINE ht_verdict ht_corners_judge_area(const ht_corners *c) {
    if (HT_UNLIKELY(!ht_corners_have_area(c)) && ht_corners_are_degenerate(*c))
        return HT_DEGENERATE;
    return HT_HITTABLE;
}

HT_INLINE ht_verdict ht_corners_judge(const ht_corners *c) {
    return HT_UNLIKELY(!ht_corners_are_in_range(c)) ? HT_INVALID : ht_corners_judge_area(c);
}

/* The box of a prim that can be hit. */
HT_INLINE ht_box4 ht_source_box(const ht_source *source, uint32_t id) {
    if (id >= source->triangle_count)
        return ht_box4_of(&source->boxes[id - source->triangle_count]);
    const ht_corners corners = ht_source_corners(source, id);
    return ht_corners_box(&corners);
}

#endif
