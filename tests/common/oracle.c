/* oracle.c: brute force. */
#include "oracle.h"
#include "rays.h"

#include "trace/triangle.h"

#include <math.h>

static bool is_valid(const float *p) {
    for (int i = 0; i < 3; ++i) {
        if (!(fabsf(p[i]) <= HTREE_COORDINATE_MAX)) return false;
    }
    return true;
}

/* An object counts if its box has valid planes in the right order. */
static bool is_valid_box(const htree_box *box) {
    return is_valid(box->lo) && is_valid(box->hi) && box->lo[0] <= box->hi[0] &&
           box->lo[1] <= box->hi[1] && box->lo[2] <= box->hi[2];
}

oracle oracle_of(const htree_mesh *mesh) {
    oracle o;
    memset(&o, 0, sizeof o);
    o.triangle_count = mesh->triangle_count;
    o.corners = (float *)take(mesh->triangle_count * 9 * sizeof(float));
    o.prims = (uint32_t *)take(mesh->triangle_count * sizeof(uint32_t));
    if (mesh->objects != NULL) o.objects = *mesh->objects;
    for (uint64_t i = 0; i < mesh->triangle_count; ++i) {
        const float *const a = mesh_corner(mesh, i, 0);
        const float *const b = mesh_corner(mesh, i, 1);
        const float *const c = mesh_corner(mesh, i, 2);
        if (!is_valid(a) || !is_valid(b) || !is_valid(c)) {
            ++o.invalid;
        } else if (ht_triangle_is_degenerate(a, b, c)) {
            ++o.degenerate;
        } else {
            float *const to = o.corners + 9 * o.count;
            memcpy(to, a, 3 * sizeof *a);
            memcpy(to + 3, b, 3 * sizeof *b);
            memcpy(to + 6, c, 3 * sizeof *c);
            o.prims[o.count++] = (uint32_t)i;
        }
    }
    for (uint64_t j = 0; j < o.objects.count; ++j) o.invalid += !is_valid_box(&o.objects.boxes[j]);
    return o;
}

void oracle_free(oracle *o) {
    free(o->corners);
    free(o->prims);
    memset(o, 0, sizeof *o);
}

static void ask_objects(const oracle *o, const htree_ray *ray, htree_hit *best) {
    for (uint64_t j = 0; j < o->objects.count; ++j) {
        htree_hit hit = {0, 0, 0, 0};
        if (!is_valid_box(&o->objects.boxes[j])) continue;
        if (!o->objects.intersect(o->objects.user, (uint32_t)j, ray, &hit)) continue;
        if (!(ray->tmin <= hit.t && hit.t <= ray->tmax)) continue;
        if (hit.u != hit.u || hit.v != hit.v) continue;
        if (best->prim != HTREE_NONE && !(hit.t < best->t)) continue;
        *best = hit;
        best->prim = (uint32_t)(o->triangle_count + j);
    }
}

/* Prims ascend, so a later hit replaces an earlier one only if it is strictly closer. */
htree_hit oracle_closest(const oracle *o, const htree_ray *ray) {
    htree_hit best;
    memset(&best, 0, sizeof best);
    memcpy(&best.t, &ray->tmax, sizeof best.t);
    best.prim = HTREE_NONE;
    ht_shear shear;
    if (!ht_shear_init(&shear, ray)) return best;
    for (uint64_t i = 0; i < o->count; ++i) {
        const float *const p = o->corners + 9 * i;
        htree_hit hit;
        if (!ht_triangle_intersect(&shear, p, p + 3, p + 6, ray->tmin, ray->tmax, &hit)) continue;
        if (best.prim != HTREE_NONE && !(hit.t < best.t)) continue;
        best = hit;
        best.prim = o->prims[i];
    }
    ask_objects(o, ray, &best);
    return best;
}

uint64_t oracle_batch(const oracle *o, const htree_ray *rays, uint64_t count, htree_hit *hits) {
    uint64_t found = 0;
    for (uint64_t i = 0; i < count; ++i) {
        hits[i] = oracle_closest(o, &rays[i]);
        found += hits[i].prim != HTREE_NONE;
    }
    return found;
}

static void grow(htree_box *box, const float *lo, const float *hi) {
    for (int i = 0; i < 3; ++i) {
        if (lo[i] < box->lo[i]) box->lo[i] = lo[i];
        if (hi[i] > box->hi[i]) box->hi[i] = hi[i];
    }
}

htree_box oracle_bounds(const oracle *o) {
    htree_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (uint64_t i = 0; i < 3 * o->count; ++i) grow(&box, o->corners + 3 * i, o->corners + 3 * i);
    for (uint64_t j = 0; j < o->objects.count; ++j) {
        if (!is_valid_box(&o->objects.boxes[j])) continue;
        grow(&box, o->objects.boxes[j].lo, o->objects.boxes[j].hi);
    }
    return box;
}

void oracle_compare(const htree *tree, const htree_mesh *mesh, uint64_t rays, uint64_t seed) {
    const ray_target target = ray_target_of(mesh);
    oracle o = oracle_of(mesh);
    dice d = {seed};
    for (uint64_t i = 0; i < rays; ++i) {
        htree_ray ray;
        htree_hit hit;
        rays_make(&target, (uint32_t)(i % RAY_FAMILIES), &d, &ray, 1);
        const htree_hit should = oracle_closest(&o, &ray);
        assert_int_equal(htree_intersect(tree, &ray, 1, &hit, NULL), HTREE_OK);
        assert_memory_equal(&hit, &should, sizeof hit);
    }
    oracle_free(&o);
}
