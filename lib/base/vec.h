/* vec.h: boxes and the few vector operations that builders and walks need.
 *
 * min and max are written as one comparison so that compilers emit single instructions, and so that
 * a NaN in the second argument is dropped; geometry is free of NaN before it gets here anyway. */
#ifndef HT_VEC_H
#define HT_VEC_H

#include "base.h"

#include <math.h>

HT_INLINE float ht_min(float a, float b) {
    return b < a ? b : a;
}

HT_INLINE float ht_max(float a, float b) {
    return b > a ? b : a;
}

HT_INLINE float ht_magnitude(float x) {
    return x < 0 ? -x : x;
}

HT_INLINE htree_box ht_box_empty(void) {
    const htree_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    return box;
}

HT_INLINE void ht_box_add_point(htree_box *box, const float *p) {
    for (int i = 0; i < 3; ++i) {
        box->lo[i] = ht_min(box->lo[i], p[i]);
        box->hi[i] = ht_max(box->hi[i], p[i]);
    }
}

HT_INLINE void ht_box_add(htree_box *box, const htree_box *other) {
    for (int i = 0; i < 3; ++i) {
        box->lo[i] = ht_min(box->lo[i], other->lo[i]);
        box->hi[i] = ht_max(box->hi[i], other->hi[i]);
    }
}

HT_INLINE htree_box ht_box_intersection(const htree_box *a, const htree_box *b) {
    htree_box box;
    for (int i = 0; i < 3; ++i) {
        box.lo[i] = ht_max(a->lo[i], b->lo[i]);
        box.hi[i] = ht_min(a->hi[i], b->hi[i]);
    }
    return box;
}

HT_INLINE bool ht_box_contains(const htree_box *outer, const htree_box *inner) {
    for (int i = 0; i < 3; ++i) {
        if (!(outer->lo[i] <= inner->lo[i] && inner->hi[i] <= outer->hi[i])) return false;
    }
    return true;
}

HT_INLINE bool ht_box_touches(const htree_box *a, const htree_box *b) {
    for (int i = 0; i < 3; ++i) {
        if (!(a->lo[i] <= b->hi[i] && b->lo[i] <= a->hi[i])) return false;
    }
    return true;
}

HT_INLINE bool ht_point_is_valid(const float *p) {
    return ht_magnitude(p[0]) <= HTREE_COORDINATE_MAX &&
           ht_magnitude(p[1]) <= HTREE_COORDINATE_MAX && ht_magnitude(p[2]) <= HTREE_COORDINATE_MAX;
}

/* A box without an order of its planes contains nothing. */
HT_INLINE bool ht_box_is_valid(const htree_box *box) {
    return ht_point_is_valid(box->lo) && ht_point_is_valid(box->hi) && box->lo[0] <= box->hi[0] &&
           box->lo[1] <= box->hi[1] && box->lo[2] <= box->hi[2];
}

/* Half the surface area. Finite for coordinates up to HTREE_COORDINATE_MAX; 0 for an empty box. */
HT_INLINE float ht_box_area(const htree_box *box) {
    const float x = ht_max(0, box->hi[0] - box->lo[0]);
    const float y = ht_max(0, box->hi[1] - box->lo[1]);
    const float z = ht_max(0, box->hi[2] - box->lo[2]);
    return x * (y + z) + y * z;
}

HT_INLINE int ht_widest_axis(const htree_box *box) {
    const float x = box->hi[0] - box->lo[0];
    const float y = box->hi[1] - box->lo[1];
    const float z = box->hi[2] - box->lo[2];
    return x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
}

/* A triangle without area is never hit, so it is left out of every tree. Exact for coordinates
 * within a factor 2^28 of each other. */
HT_INLINE bool ht_triangle_is_degenerate(const float *v0, const float *v1, const float *v2) {
    double a[3], b[3];
    for (int i = 0; i < 3; ++i) {
        a[i] = (double)v1[i] - (double)v0[i];
        b[i] = (double)v2[i] - (double)v0[i];
    }
    return a[1] * b[2] == a[2] * b[1] && a[2] * b[0] == a[0] * b[2] && a[0] * b[1] == a[1] * b[0];
}

#endif
