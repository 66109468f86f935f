/* wide.cl: twin of lib/trace/wide.c; eight lanes are one vector.
 *
 * A ray a work-item, as devices of many threads like it; or, where the compiler is for a CPU with
 * AVX-512, 32 rays in flight on one thread, as in lib/trace/streams.h: the first work-item of a
 * group answers all of its rays, and the others have nothing to do. */

#define HT_WIDE_LEAST 8.673617379884035e-19f /* 2^-60 */
#define HT_WIDE_FAR   1.099511627776e12f     /* 2^40 */

float8 max8(float8 a, float8 b) {
    return b > a ? b : a;
}

float8 min8(float8 a, float8 b) {
    return b < a ? b : a;
}

/* The larger magnitude. */
float8 larger8(float8 a, float8 b) {
    return max8(as_float8(as_int8(a) & INT_MAX), as_float8(as_int8(b) & INT_MAX));
}

#ifdef __AVX__
typedef __attribute__((__vector_size__(32))) float ymm;
typedef __attribute__((__vector_size__(32))) int ymm_int;
#endif

/* ---- Lanes ---------------------------------------------------------------------------------- */

/* A bit for every lane that is negative, as what is true is. OpenCL C has no word for the
 * instruction that CPUs have for it, which is worth a sixth of the time. */
uint lanes_of(int8 lanes) {
#ifdef __AVX__
    return (uint)__builtin_ia32_movmskps256(__builtin_astype(lanes, ymm));
#else
    const int8 bits = (lanes >> 31) & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
    const int4 four = bits.lo | bits.hi;
    const int2 two = four.lo | four.hi;
    return (uint)(two.x | two.y);
#endif
}

uint lowest_lane(uint mask) {
    return 31 - clz(mask & (0 - mask));
}

/* ---- Boxes ---------------------------------------------------------------------------------- */

/* What a ray needs besides ht_ray: see lib/trace/streams.h. */
typedef struct wide_ray {
    uint near[3], far[3]; /* rows of planes that are met first, and last */
    uint order;           /* the lane that is met first: a bit for each negative axis */
    float first, slack;   /* tmin dz, and what that may be off by before it is scaled */
} wide_ray;

wide_ray set_out(const ht_ray *r) {
    wide_ray s;
    s.order = 0;
    for (uint axis = 0; axis < 3; ++axis) {
        s.order |= r->negative[axis] << axis;
        s.near[axis] = r->negative[axis] ? axis + 3 : axis;
        s.far[axis] = r->negative[axis] ? axis : axis + 3;
    }
    s.first = r->tmin * r->dz;
    s.slack = r->reach <= HT_WIDE_FAR ? ht_magnitude(s.first) + HT_WIDE_LEAST : INFINITY;
    return s;
}

/* Where the ray enters the children, and where it leaves them. */
void clip_children(__global const ht_wide_node *node, const ht_ray *r, const wide_ray *s,
                   float tfar, float8 *enter, float8 *leave) {
    __global const float8 *planes = (__global const float8 *)node;
    *enter = (float8)(r->tnear);
    *leave = (float8)(tfar);
    for (uint axis = 0; axis < 3; ++axis) {
        *enter = max8(*enter, (planes[s->near[axis]] - r->entry[axis]) * r->rdir[axis]);
        *leave = min8(*leave, (planes[s->far[axis]] - r->exit[axis]) * r->rdir[axis]);
    }
}

/* ---- Triangles ------------------------------------------------------------------------------ */

typedef struct corners {
    float8 x, y, z;
} corners;

corners shear_lanes(__global const ht_wide_leaf *leaf, uint corner, const ht_ray *r) {
    __global const float8 *v = (__global const float8 *)leaf + 3 * corner;
    corners c;
    c.z = v[r->kz] - r->oz;
    c.x = (v[r->kx] - r->ox) - r->sx * c.z;
    c.y = (v[r->ky] - r->oy) - r->sy * c.z;
    return c;
}

/* A corner of one lane, once more: cheaper than to keep 72 floats for the few that need them. */
ht_corner shear_lane(__global const ht_wide_leaf *leaf, uint corner, uint lane, const ht_ray *r) {
    return ht_ray_corner(r, leaf->v[corner][r->kx][lane], leaf->v[corner][r->ky][lane],
                         leaf->v[corner][r->kz][lane]);
}

/* Where a triangle that the signs do not reject lies before tmin without doubt: the proof, which
 * needs double, is in lib/trace/x86/wide_x86.h. */
int8 before_start(corners a, corners b, corners c, float8 u, float8 v, float8 w, const ht_ray *r,
                  const wide_ray *s) {
#ifdef HT_FP64
    const float8 det = (u + v) + w;
    const float8 below = s->first * det - ((u * a.z + v * b.z) + w * c.z);
    const int8 flip = (as_int8(det) ^ as_int(r->dz)) & (int)0x80000000;
    const float8 xy = larger8(larger8(a.x, b.x), c.x) * larger8(larger8(a.y, b.y), c.y);
    const float8 zs = larger8(larger8(a.z, b.z), c.z) + s->slack;
    return as_float8(as_int8(below) ^ flip) > ((xy + HT_WIDE_LEAST) * zs) * 3.814697265625e-6f;
#else
    return (int8)(0);
#endif
}

/* The triangles of a leaf that the ray may hit, as a mask. */
uint candidates(__global const ht_wide_leaf *leaf, const ht_ray *r, const wide_ray *s) {
    const corners a = shear_lanes(leaf, 0, r);
    const corners b = shear_lanes(leaf, 1, r);
    const corners c = shear_lanes(leaf, 2, r);
    const float8 u = c.x * b.y - c.y * b.x;
    const float8 v = a.x * c.y - a.y * c.x;
    const float8 w = b.x * a.y - b.y * a.x;
    const float8 least = min8(min8(u, v), w), most = max8(max8(u, v), w);
    const int8 outside = (least < 0) & (most > 0);
    const int8 idle = ((__global const int8 *)leaf->prim)[0];
    return 255 & ~lanes_of(outside | idle | before_start(a, b, c, u, v, w, r, s));
}

/* Judges candidates; with `any`, until the first hit. Whether there was one. */
bool judge(__global const ht_wide_leaf *leaf, uint mask, const ht_ray *r, ht_hit *hit,
           const bool any) {
    bool met = false;
    for (; mask && !(any && met); mask &= mask - 1) {
        const uint i = lowest_lane(mask);
        const ht_corner p = shear_lane(leaf, 0, i, r), q = shear_lane(leaf, 1, i, r);
        met |= ht_triangle_verdict(r, p, q, shear_lane(leaf, 2, i, r), leaf->prim[i], hit);
    }
    return met;
}

/* ---- A ray a work-item ---------------------------------------------------------------------- */

#ifndef __AVX512VL__
typedef struct wide_entry {
    uint child;
    float tnear;
} wide_entry;

/* Follows the nearest child in *here and leaves the others on the stack, the farthest at the
 * bottom; the first hit that comes will do for `any`, so there the order is as it is. */
uint push_children(__global const ht_wide_node *node, uint mask, const float *entry,
                   wide_entry *here, wide_entry *stack, uint top, const bool any) {
    const uint bottom = top, first = lowest_lane(mask);
    here->child = node->child[first];
    here->tnear = entry[first];
    for (mask &= mask - 1; mask; mask &= mask - 1) {
        const uint i = lowest_lane(mask);
        wide_entry later = {node->child[i], entry[i]};
        if (!any && later.tnear < here->tnear) {
            const wide_entry nearer = later;
            later = *here;
            *here = nearer;
        }
        uint k = top++;
        for (; !any && k > bottom && stack[k - 1].tnear < later.tnear; --k) stack[k] = stack[k - 1];
        stack[k] = later;
    }
    return top;
}

void walk_wide(__global const ht_scene *scene, __global const void *slots,
               __global const float *triangles, __global const void *blocks, const ht_ray *r,
               ht_hit *hit, const bool any) {
    __global const ht_wide_node *nodes = (__global const ht_wide_node *)slots;
    __global const ht_wide_leaf *leaves = (__global const ht_wide_leaf *)blocks;
    const wide_ray s = set_out(r);
    wide_entry stack[HT_STACK];
    wide_entry here = {0, r->tnear};
    float entry[8] __attribute__((aligned(32)));
    uint top = 0;
    for (;;) {
        if (here.child & HT_WIDE_LEAF) {
            __global const ht_wide_leaf *leaf = &leaves[here.child & ~HT_WIDE_LEAF];
            if (judge(leaf, candidates(leaf, r, &s), r, hit, any) && any) return;
        } else {
            __global const ht_wide_node *node = &nodes[here.child];
            float8 enter, leave;
            clip_children(node, r, &s, hit->t, &enter, &leave);
            *(float8 *)entry = enter;
            const uint mask = lanes_of(enter <= leave);
            if (mask) {
                top = push_children(node, mask, entry, &here, stack, top, any);
                continue;
            }
        }
        do {
            if (top == 0) return;
            here = stack[--top];
        } while (here.tnear > hit->t);
    }
}

HT_KERNELS(walk_wide)

/* ---- Several rays on one thread ------------------------------------------------------------- */

#else
enum { STREAMS = 32 };

/* A ray on its way. Whole vectors are written to its stack. */
typedef struct stream {
    ht_ray r;
    wide_ray s;
    ht_hit hit;
    ulong index;
    uint top;
    uint child[HT_STACK + 12]; /* the mark of the end first */
    float tnear[HT_STACK + 12];
} stream;

/* A batch of the group's: of hits and occluded one is NULL. */
typedef struct batch {
    __global const ht_scene *scene;
    __global const ht_wide_node *nodes;
    __global const ht_wide_leaf *leaves;
    __global const float4 *rays;
    __global uint4 *hits;
    __global uchar *occluded;
    ulong next, end;
} batch;

float8 permuted(float8 lanes, int8 from) {
    return __builtin_astype(__builtin_ia32_permvarsf256(__builtin_astype(lanes, ymm),
                                                        __builtin_astype(from, ymm_int)),
                            float8);
}

/* The lanes of a mask to the front. */
float8 compressed(float8 lanes, uint mask) {
    const ymm all = __builtin_astype(lanes, ymm);
    return __builtin_astype(__builtin_ia32_compresssf256_mask(all, all, (uchar)mask), float8);
}

/* Replaces the node on top of the stack by the children that the ray meets, the one that it is
 * likely to meet first on top; with `any` in no order. Returns the new top. */
uint step_node(__global const ht_wide_node *node, stream *s, const bool any) {
    const uint top = s->top;
    float8 enter, leave, words = ((__global const float8 *)node->child)[0];
    clip_children(node, &s->r, &s->s, s->hit.t, &enter, &leave);
    if (!any) {
        const int8 order = (int8)(7, 6, 5, 4, 3, 2, 1, 0) ^ (int)s->s.order;
        enter = permuted(enter, order);
        leave = permuted(leave, order);
        words = permuted(words, order);
    }
    const uint mask = lanes_of(enter <= leave);
    vstore8(as_uint8(compressed(words, mask)), 0, s->child + top);
    if (!any) vstore8(compressed(enter, mask), 0, s->tnear + top);
    return top + popcount(mask) - 1;
}

/* After a hit: nothing that is strictly beyond it waits any longer, with `any` nothing at all. */
void leave_behind(stream *s, const bool any) {
    uint kept = 1;
    for (uint i = 1; !any && i < s->top; ++i) {
        s->child[kept] = s->child[i];
        s->tnear[kept] = s->tnear[i];
        kept += s->tnear[kept] <= s->hit.t;
    }
    s->top = kept;
}

void give_answer(const batch *b, const stream *s) {
    if (b->hits)
        b->hits[s->index] = (uint4)(as_uint(s->hit.t), as_uint(s->hit.u), as_uint(s->hit.v),
                                    s->hit.prim);
    else
        b->occluded[s->index] = s->hit.prim != HT_NONE;
}

/* Puts the next ray that has a way to go at the root; the others are answered at once. */
bool next_ray(batch *b, stream *s) {
    while (b->next < b->end) {
        s->index = b->next++;
        const float4 from = b->rays[2 * s->index], to = b->rays[2 * s->index + 1];
        const ht_hit miss = {to.w, 0, 0, HT_NONE};
        s->hit = miss;
        if (ht_ray_init(&s->r, b->scene, from, to)) {
            s->s = set_out(&s->r);
            s->top = 1;
            return true;
        }
        give_answer(b, s);
    }
    return false;
}

/* Rays that are not at a node; those that have their answer go to *ended too. */
uint sort_out(const uint *next, uint *ended) {
    uint elsewhere = 0;
    *ended = 0;
    for (uint i = 0; i < STREAMS; i += 8) {
        const int8 words = *(const int8 *)(next + i);
        elsewhere |= lanes_of(words) << i;
        *ended |= lanes_of(words == -1) << i;
    }
    return elsewhere;
}

void fetch_leaf(__global const ht_wide_leaf *leaf) {
    for (uint i = 0; i < sizeof *leaf; i += 64)
        __builtin_prefetch((const void *)((size_t)leaf + i));
}

/* Each round takes every ray a step further: first those at a node, then those at a leaf, then
 * those that have candidates to judge, then those that are through. */
void walk_group(batch *b, const bool any) {
    stream all[STREAMS];
    uint next[STREAMS] __attribute__((aligned(32))), lanes[STREAMS], ended;
    uint flying = 0, judged = 0;
    for (uint i = 0; i < STREAMS; ++i) {
        const bool used = next_ray(b, &all[i]);
        all[i].child[0] = HT_WIDE_NONE;
        next[i] = used ? 0 : HT_WIDE_NONE;
        flying |= (uint)used << i;
    }
    while (flying) {
        const uint elsewhere = sort_out(next, &ended), verdicts = judged;
        const uint at_leaves = elsewhere & ~ended & ~judged;
        for (uint set = at_leaves; set; set &= set - 1)
            fetch_leaf(&b->leaves[next[lowest_lane(set)] & ~HT_WIDE_LEAF]);
        for (uint set = ~elsewhere; set; set &= set - 1) {
            const uint i = lowest_lane(set);
            all[i].top = step_node(&b->nodes[next[i]], &all[i], any);
            next[i] = all[i].child[all[i].top];
        }
        judged = 0;
        for (uint set = at_leaves; set; set &= set - 1) {
            const uint i = lowest_lane(set);
            lanes[i] = candidates(&b->leaves[next[i] & ~HT_WIDE_LEAF], &all[i].r, &all[i].s);
            judged |= (uint)(lanes[i] != 0) << i;
            all[i].top -= lanes[i] == 0;
            next[i] = all[i].child[all[i].top];
        }
        for (uint set = verdicts; set; set &= set - 1) {
            const uint i = lowest_lane(set);
            if (judge(&b->leaves[next[i] & ~HT_WIDE_LEAF], lanes[i], &all[i].r, &all[i].hit, any))
                leave_behind(&all[i], any);
            next[i] = all[i].child[--all[i].top];
        }
        for (uint set = ended & flying; set; set &= set - 1) {
            const uint i = lowest_lane(set);
            give_answer(b, &all[i]);
            if (next_ray(b, &all[i]))
                next[i] = 0;
            else
                flying &= ~(1u << i);
        }
    }
}

#define HT_WALK_GROUP(hits, occluded, any)                                                         \
    const ulong i = first + get_global_id(0);                                                      \
    if (get_local_id(0) != 0 || i >= end) return;                                                  \
    batch b = {scene, nodes, leaves, rays, hits, occluded, i, min(end, i + get_local_size(0))};    \
    walk_group(&b, any);

__kernel void htree_closest(HT_ARGUMENTS, __global uint4 *hits, ulong first, ulong end) {
    HT_WALK_GROUP(hits, 0, false)
}

__kernel void htree_any(HT_ARGUMENTS, __global uchar *occluded, ulong first, ulong end) {
    HT_WALK_GROUP(0, occluded, true)
}
#endif
