/* coherence.c: finds the picture in a batch. Cameras send rays row by row, so that a ray's neighbours
 * are the ray before it and the one a row before it: the length of a row is how far it is to where
 * rays come back to where they began. Where that is soon, the picture may come in square cells: their
 * first rays make a picture of their own. Where there are no rows, four rays make one. */
#include "coherence.h"

enum {
    PROBES = 32,         /* rays that are asked, evenly spread over the batch */
    SHORTEST_BATCH = 64, /* less is not worth the asking */
    NARROWEST_ROW = 4,
    WIDEST_ROW = 16384
};

/* The square of how far two rays are apart, in direction and in origin. */
static float distance(const htree_ray *a, const htree_ray *b, float scale) {
    float size = 0, dir = 0, org = 0;
    for (int i = 0; i < 3; ++i) {
        const float turn = b->dir[i] - a->dir[i], move = (b->org[i] - a->org[i]) * scale;
        size += a->dir[i] * a->dir[i];
        dir += turn * turn;
        org += move * move;
    }
    return dir / size + org;
}

/* One in each of equal parts, at a place of its own: rows may be as long as parts are. */
static uint64_t probe(uint32_t i, uint64_t count) {
    const uint64_t part = count / PROBES;
    return part * i + i * 0x9e3779b1u % part;
}

/* From the ray's origin to the far end of the bounds, in extents. */
static float reach_of(const htree_ray *ray, const htree_box *bounds, float scale) {
    float reach = 0;
    for (int i = 0; i < 3; ++i) {
        reach = ht_max(reach, ht_magnitude(bounds->lo[i] - ray->org[i]));
        reach = ht_max(reach, ht_magnitude(bounds->hi[i] - ray->org[i]));
    }
    return reach * scale;
}

static bool is_coherent(const htree_ray *rays, uint64_t count, const htree_box *bounds, float scale,
                        uint32_t triangles) {
    uint32_t near = 0;
    for (uint32_t i = 0; i < PROBES; ++i) {
        const htree_ray *ray = rays + probe(i, count - 1);
        const float reach = ht_max(1, reach_of(ray, bounds, scale));
        near += distance(ray, ray + 1, scale) * reach * reach <= ht_near_square(triangles);
    }
    return near > PROBES / 2;
}

/* Whether most rays are much nearer to the one a row on than to the one half a row on. */
static bool is_row(const htree_ray *rays, uint64_t count, float scale, uint64_t row,
                   uint64_t half) {
    uint32_t agree = 0;
    for (uint32_t i = 0; i < PROBES; ++i) {
        const htree_ray *ray = rays + probe(i, count - row);
        agree += 2 * distance(ray, ray + row, scale) <= distance(ray, ray + half, scale);
    }
    return agree >= PROBES * 5 / 8;
}

/* How many parts of so many rays make a row; 0: none do. */
static uint64_t find_row(const htree_ray *rays, uint64_t count, float scale, uint64_t part) {
    const uint64_t parts = count / part, end = parts / 2 < WIDEST_ROW ? parts / 2 : WIDEST_ROW;
    if (end < NARROWEST_ROW) return 0;
    float farthest = 0, before = 0, here = distance(rays, rays + part, scale);
    for (uint64_t i = 1; i < end; ++i) {
        const float after = distance(rays, rays + (i + 1) * part, scale);
        const bool back = here < before && here <= after && 4 * here <= farthest;
        if (back && i >= NARROWEST_ROW && is_row(rays, count, scale, i * part, i / 2 * part))
            return i;
        farthest = ht_max(farthest, here);
        before = here;
        here = after;
    }
    return 0;
}

/* Rows of 4 or of 8 rays may be those of cells. */
static void find_cells(const htree_ray *rays, uint64_t count, float scale, ht_rows *rows) {
    const uint64_t side = rows->row;
    if (side != 4 && side != 8) return;
    const uint64_t across = find_row(rays, count, scale, side * side);
    if (!across) return;
    rows->cell = side == 4 ? 2 : 3;
    rows->row = across * side;
    rows->count = count / (rows->row * side) * side;
}

ht_rows ht_find_rows(const htree_ray *rays, uint64_t count, const htree_box *bounds,
                     uint32_t triangles) {
    ht_rows rows = {0, 0, 0, 0};
    const float scale = 1 / ht_extent(bounds);
    if (count < SHORTEST_BATCH || !is_coherent(rays, count, bounds, scale, triangles)) return rows;
    rows.row = find_row(rays, count, scale, 1);
    if (!rows.row) rows.row = NARROWEST_ROW;
    rows.count = count / rows.row;
    find_cells(rays, count, scale, &rows);
    rows.height = rows.row >= 16 ? 16 : rows.row >= 8 ? 32 : 64;
    return rows;
}
