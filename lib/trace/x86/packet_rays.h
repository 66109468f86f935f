/* packet_rays.h: rays side by side, a lane each, and made ready together.
 * Included by one file per instruction set, which defines what the lanes of a vector do.
 *
 * A group is as many rays as a vector has lanes; a packet is as many groups. Boxes are asked for a
 * group as a whole, its beam: intervals of what ray.h makes of each ray. Rounding is monotonic, so
 * what intervals of origins and directions give holds what every ray would have given: beams are
 * exactly as conservative as rays are, and need no pad of their own. */
#ifndef HT_PACKET_RAYS_H
#define HT_PACKET_RAYS_H

#include "trace/coherence.h"
#include "trace/trace.h"

enum { ROWS = 4, COLUMNS = LANES / ROWS }; /* lane 4 j + k: the ray of column j and row k */

#define VECTORS   __attribute__((aligned(4 * LANES)))
#define ALL_LANES ((1u << LANES) - 1)

/* The rays of a group, and their best hits. Those that are a miss by their numbers have the
 * numbers of another. */
typedef struct group {
    VECTORS float org[3][LANES];
    float dir[3][LANES], tmin[LANES];
    float tmax[LANES];          /* as the caller gave it */
    float sx[LANES], sy[LANES]; /* as in ht_shear */
    float limit[LANES];         /* t of the best hit; -inf: the ray wants nothing any more */
    uint32_t prim[LANES];
    double det[LANES], v[LANES], w[LANES]; /* of the best hit: its u and v are quotients of these */
} group;

/* What bounds the rays of a group: a lane for each. See ray.h. Signs are the octant's. */
typedef struct beams {
    VECTORS float entry[3][LANES];         /* the foremost */
    float exit[3][LANES];                  /* the hindmost */
    float least[3][LANES], most[3][LANES]; /* rdir, by magnitude */
    float tnear[LANES], tfar[LANES];       /* of the rays that want something; tnear >= 0 */
} beams;

/* What rays must have in common to go together. */
typedef struct heading {
    uint32_t negative; /* a bit for each negative axis */
    uint32_t kz;       /* the axis of the largest component of dir; 3: they do not go together */
} heading;

/* ---- Groups --------------------------------------------------------------------------------- */

/* The rays that htree.h does not declare a miss. */
HT_TARGET HT_INLINE uint32_t valid_rays(const lanes org[3], const lanes dir[3], lanes tmin,
                                        lanes tmax) {
    const lanes x = magnitude(dir[0]), y = magnitude(dir[1]), z = magnitude(dir[2]);
    lanes most = larger_or_nan(larger_or_nan(x, y), z);
    const uint32_t moves = at_most(spread(1 / HTREE_COORDINATE_MAX), most);
    for (int i = 0; i < 3; ++i) most = larger_or_nan(most, magnitude(org[i]));
    return moves & at_most(most, spread(HTREE_COORDINATE_MAX)) & at_most(tmin, tmax);
}

/* Puts rays into a group; returns the mask of those that want an answer. */
HT_TARGET HT_INLINE uint32_t fill_group(group *g, const htree_ray *rays, uint64_t stride) {
    lanes o[ROWS], d[ROWS];
    for (uint32_t k = 0; k < ROWS; ++k) load_row(rays + k * stride, &o[k], &d[k]);
    transpose(o);
    transpose(d);
    const uint32_t mask = valid_rays(o, d, o[3], d[3]);
    for (int i = 0; i < 3 && mask != ALL_LANES; ++i) {
        const uint32_t first = mask ? (uint32_t)__builtin_ctz(mask) : 0;
        o[i] = pick(mask, o[i], spread_lane(o[i], first));
        d[i] = pick(mask, d[i], spread_lane(d[i], first));
    }
    for (int i = 0; i < 3; ++i) {
        store(g->org[i], o[i]);
        store(g->dir[i], d[i]);
    }
    store(g->tmin, pick(mask, o[3], spread(INFINITY)));
    store(g->tmax, d[3]);
    store(g->limit, pick(mask, d[3], spread(-INFINITY)));
    store_prim(g->prim, ALL_LANES, HTREE_NONE);
    return mask;
}

/* Shears as ht_shear_init does. */
HT_TARGET HT_INLINE void shear_group(group *g, uint32_t kz) {
    const uint32_t kx = kz == 2 ? 0 : kz + 1, ky = kx == 2 ? 0 : kx + 1;
    store(g->sx, load(g->dir[kx]) / load(g->dir[kz]));
    store(g->sy, load(g->dir[ky]) / load(g->dir[kz]));
}

/* Writes the hits of a whole group. */
HT_TARGET HT_INLINE void give_hits(const group *g, htree_hit *hits, uint64_t stride) {
    const uint32_t hit = prims_hit(g->prim);
    lanes out[ROWS] = {pick(hit, load(g->limit), load(g->tmax)), spread(0), spread(0),
                       load((const float *)(const void *)g->prim)};
    if (hit) {
        half u[2], v[2];
        for (int side = 0; side < 2; ++side) {
            const half det = load_half(g->det + side * LANES / 2);
            u[side] = load_half(g->v + side * LANES / 2) / det;
            v[side] = load_half(g->w + side * LANES / 2) / det;
        }
        out[1] = pick(hit, narrow(u[0], u[1]), spread(0));
        out[2] = pick(hit, narrow(v[0], v[1]), spread(0));
    }
    transpose(out);
    for (uint32_t k = 0; k < ROWS; ++k) storeu((float *)(void *)(hits + k * stride), out[k]);
}

/* ---- Beams ---------------------------------------------------------------------------------- */

/* The least, or the greatest, of what one array of each group holds: `values` is the first one's. */
HT_TARGET HT_INLINE lanes least_of(const float *values) {
    lanes v[LANES];
    for (uint32_t i = 0; i < LANES; ++i) v[i] = load(values + i * (sizeof(group) / sizeof *values));
    return fold(v, false);
}

HT_TARGET HT_INLINE lanes greatest_of(const float *values) {
    lanes v[LANES];
    for (uint32_t i = 0; i < LANES; ++i) v[i] = load(values + i * (sizeof(group) / sizeof *values));
    return fold(v, true);
}

/* Intervals of all groups, a lane for each. */
typedef struct spans {
    lanes org_lo[3], org_hi[3];
    lanes size_lo[3], size_hi[3]; /* magnitudes of dir */
    lanes main_lo, main_hi;       /* the largest of each */
    lanes reach, tnear;
    uint32_t negative[3];
} spans;

/* Returns a bit for each group whose rays have one octant, are near each other, and begin at 0 or
 * later. */
HT_TARGET HT_INLINE uint32_t find_spans(const group *groups, const htree_box *bounds,
                                        uint32_t triangles, spans *s) {
    lanes turn = spread(0), move = spread(0);
    const float widest = 36 * ht_near_square(triangles); /* twice the three steps of a group */
    uint32_t one_octant = ALL_LANES;
    s->reach = s->main_lo = s->main_hi = spread(0);
    s->tnear = least_of(groups->tmin);
    for (int i = 0; i < 3; ++i) {
        const lanes lo = least_of(groups->dir[i]), hi = greatest_of(groups->dir[i]);
        s->org_lo[i] = least_of(groups->org[i]);
        s->org_hi[i] = greatest_of(groups->org[i]);
        s->reach = greatest(s->reach, magnitude(spread(bounds->lo[i]) - s->org_hi[i]));
        s->reach = greatest(s->reach, magnitude(spread(bounds->hi[i]) - s->org_lo[i]));
        s->negative[i] = below(lo, spread(0));
        one_octant &= ~s->negative[i] | below(hi, spread(0));
        s->size_lo[i] = least(magnitude(lo), magnitude(hi));
        s->size_hi[i] = greatest(magnitude(lo), magnitude(hi));
        s->main_lo = greatest(s->main_lo, s->size_lo[i]);
        s->main_hi = greatest(s->main_hi, s->size_hi[i]);
        turn = greatest(turn, hi - lo);
        move = greatest(move, s->org_hi[i] - s->org_lo[i]);
    }
    const lanes reach = s->reach / spread(ht_extent(bounds));
    const lanes wide =
        greatest(turn / s->main_lo * greatest(reach, spread(1)), move / spread(ht_extent(bounds)));
    return one_octant & at_most(wide * wide, spread(widest)) & at_most(spread(0), s->tnear);
}

/* Returns a bit for each group whose rays have one main axis: by the rule of ht_shear_init. */
HT_TARGET HT_INLINE uint32_t find_headings(const spans *s, heading *out) {
    const lanes *lo = s->size_lo, *hi = s->size_hi;
    const uint32_t x = at_most(hi[1], lo[0]) & at_most(hi[2], lo[0]);
    const uint32_t y = below(hi[0], lo[1]) & at_most(hi[2], lo[1]);
    const uint32_t z = below(hi[0], lo[2]) & below(hi[1], lo[2]);
    for (uint32_t i = 0; i < LANES; ++i) {
        out[i].kz = (y >> i & 1) | (z >> i & 1) << 1;
        out[i].negative = (s->negative[0] >> i & 1) | (s->negative[1] >> i & 1) << 1 |
                          (s->negative[2] >> i & 1) << 2;
    }
    return x | y | z;
}

/* As ht_ray_init, by intervals. Returns a bit for each beam that meets the bounds. */
HT_TARGET HT_INLINE uint32_t make_beams(const group *groups, const htree_box *bounds,
                                        const spans *s, beams *b) {
    const lanes tiny_lo = spread(HT_RAY_TINY) * s->main_lo;
    const lanes tiny_hi = spread(HT_RAY_TINY) * s->main_hi;
    lanes enter = s->tnear, leave = greatest_of(groups->limit);
    store(b->tnear, enter);
    store(b->tfar, leave);
    for (int i = 0; i < 3; ++i) {
        const uint32_t negative = s->negative[i];
        const lanes away = greatest(magnitude(s->org_lo[i]), magnitude(s->org_hi[i]));
        const lanes pad =
            greatest(spread(HT_RAY_PAD) * s->reach + spread(HT_RAY_ROUND) * away, spread(FLT_MIN));
        const lanes sign = pick(negative, spread(-1), spread(1));
        const lanes entry = pick(negative, s->org_lo[i], s->org_hi[i]) + sign * pad;
        const lanes exit = pick(negative, s->org_hi[i], s->org_lo[i]) - sign * pad;
        const lanes slow = spread(1) / (sign * greatest(tiny_hi, s->size_hi[i]));
        const lanes fast = spread(1) / (sign * greatest(tiny_lo, s->size_lo[i]));
        const lanes lo = spread(bounds->lo[i]), hi = spread(bounds->hi[i]);
        enter = greatest((pick(negative, hi, lo) - entry) * slow, enter);
        leave = least((pick(negative, lo, hi) - exit) * fast, leave);
        store(b->entry[i], entry);
        store(b->exit[i], exit);
        store(b->least[i], slow);
        store(b->most[i], fast);
    }
    return at_most(enter, leave);
}

#endif
