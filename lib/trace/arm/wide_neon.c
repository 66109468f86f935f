/* wide_neon.c: boxes and triangles of a wide tree by NEON, eight lanes as two halves of four;
 * trace/streams.h does the rest. Floats are never multiplied and added in one instruction: every
 * other path rounds the product, so hits would not be the same bits. */
#include "base/isa.h"

#ifdef HT_ARM
#define HT_TARGET /* every 64-bit ARM has it */
#include "trace/streams.h"
#include "trace/to_front.h"

#include <arm_neon.h>

/* What lane i adds to lanes_in: bit i ^ flip, and one to the count. */
HT_INLINE uint16x8_t lane_bits(uint32_t flip) {
    static const int16_t lane[HT_LANES] = {0, 1, 2, 3, 4, 5, 6, 7};
    const int16x8_t place = veorq_s16(vld1q_s16(lane), vdupq_n_s16((int16_t)flip));
    return vorrq_u16(vshlq_u16(vdupq_n_u16(1), place), vdupq_n_u16(256));
}

/* The sum of bits over the lanes whose words are all ones: a mask, and eight bits higher their
 * number. */
HT_INLINE uint32_t lanes_in(uint32x4_t low, uint32x4_t high, uint16x8_t bits) {
    return vaddvq_u16(vandq_u16(vcombine_u16(vmovn_u32(low), vmovn_u32(high)), bits));
}

/* ---- Boxes ---------------------------------------------------------------------------------- */

HT_INLINE void clip_axis(const float *planes, const stream *s, int axis, float32x4_t *enter,
                         float32x4_t *leave) {
    const float32x4_t near = vld1q_f32(planes + s->r.near[axis]);
    const float32x4_t far = vld1q_f32(planes + s->r.far[axis]);
    const float32x4_t from = vdupq_n_f32(s->r.enter[axis]), to = vdupq_n_f32(s->r.leave[axis]);
    *enter = vmaxnmq_f32(vmulq_n_f32(vsubq_f32(near, from), s->r.rdir[axis]), *enter);
    *leave = vminnmq_f32(vmulq_n_f32(vsubq_f32(far, to), s->r.rdir[axis]), *leave);
}

/* All ones where the ray meets the box of a lane, of four. */
HT_INLINE uint32x4_t clip_half(const float *planes, const stream *s, float32x4_t *enter) {
    float32x4_t leave = vdupq_n_f32(s->hit.t);
    *enter = vdupq_n_f32(s->r.tnear);
    clip_axis(planes, s, 0, enter, &leave);
    clip_axis(planes, s, 1, enter, &leave);
    clip_axis(planes, s, 2, enter, &leave);
    return vcleq_f32(*enter, leave);
}

/* The bytes of four words out of eight. */
HT_INLINE uint8x16_t bytes_of(uint16x4_t words) {
    const uint32x4_t first = vmulq_n_u32(vmovl_u16(words), 0x04040404);
    return vreinterpretq_u8_u32(vorrq_u32(first, vdupq_n_u32(0x03020100)));
}

/* Moves eight words, the one whose number is from[i] to place i: orders and compresses at once. */
HT_INLINE void store_words(void *to, uint8x16x2_t words, uint16x8_t from) {
    vst1q_u8((uint8_t *)to, vqtbl2q_u8(words, bytes_of(vget_low_u16(from))));
    vst1q_u8((uint8_t *)to + 16, vqtbl2q_u8(words, bytes_of(vget_high_u16(from))));
}

HT_INLINE uint32_t step_node(const ht_wide_node *node, const stream *s, uint32_t *child,
                             float *tnear, const bool any) {
    const float *planes = &node->lo[0][0];
    const uint32_t flip = any ? 0 : s->r.order ^ 7; /* what is met first comes last, on top */
    float32x4_t enter[2];
    const uint32x4_t low = clip_half(planes, s, &enter[0]);
    const uint32x4_t high = clip_half(planes + 4, s, &enter[1]);
    const uint32_t met = lanes_in(low, high, lane_bits(flip));
    const uint8x8_t places = vcreate_u8(ht_to_front[met & 255]);
    const uint16x8_t from = vmovl_u8(veor_u8(places, vdup_n_u8((uint8_t)flip)));
    const uint8x16x2_t near = {{vreinterpretq_u8_f32(enter[0]), vreinterpretq_u8_f32(enter[1])}};
    if (!any) store_words(tnear, near, from);
    store_words(child, vld1q_u8_x2((const uint8_t *)node->child), from);
    return met >> 8;
}

HT_INLINE uint32_t keep_near(uint32_t *child, float *tnear, uint32_t count, float t) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; ++i) {
        child[kept] = child[i];
        tnear[kept] = tnear[i];
        kept += tnear[kept] <= t;
    }
    return kept;
}

/* ---- Triangles ------------------------------------------------------------------------------ */

typedef struct corner_lanes {
    float32x4_t x, y, z;
} corner_lanes;

HT_INLINE corner_lanes shear_corner(const float (*v)[HT_LANES], uint32_t lane, const ready *r) {
    const float *const lanes = v[0] + lane;
    const float32x4_t x = vsubq_f32(vld1q_f32(lanes + r->row[0]), vdupq_n_f32(r->org[0]));
    const float32x4_t y = vsubq_f32(vld1q_f32(lanes + r->row[1]), vdupq_n_f32(r->org[1]));
    corner_lanes c;
    c.z = vsubq_f32(vld1q_f32(lanes + r->row[2]), vdupq_n_f32(r->org[2]));
    c.x = vsubq_f32(x, vmulq_n_f32(c.z, r->sx));
    c.y = vsubq_f32(y, vmulq_n_f32(c.z, r->sy));
    return c;
}

HT_INLINE float32x4_t edge(corner_lanes a, corner_lanes b) {
    return vsubq_f32(vmulq_f32(a.x, b.y), vmulq_f32(a.y, b.x));
}

/* All ones where no two signs differ: the ray may hit the triangle of a lane, of four. */
HT_INLINE uint32x4_t may_hit(const ht_wide_leaf *leaf, uint32_t lane, const ready *r) {
    const corner_lanes a = shear_corner(leaf->v[0], lane, r);
    const corner_lanes b = shear_corner(leaf->v[1], lane, r);
    const corner_lanes c = shear_corner(leaf->v[2], lane, r);
    const float32x4_t u = edge(c, b), v = edge(a, c), w = edge(b, a);
    const uint32x4_t below = vcltzq_f32(vminnmq_f32(vminnmq_f32(u, v), w));
    const uint32x4_t above = vcgtzq_f32(vmaxnmq_f32(vmaxnmq_f32(u, v), w));
    const uint32x4_t in_use = vcgezq_s32(vreinterpretq_s32_u32(vld1q_u32(leaf->prim + lane)));
    return vbicq_u32(in_use, vandq_u32(below, above));
}

HT_INLINE uint32_t candidates(const ht_wide_leaf *leaf, const ready *r) {
    return lanes_in(may_hit(leaf, 0, r), may_hit(leaf, 4, r), lane_bits(0)) & 255;
}

HT_INLINE void expand_node(const htree *tree, uint32_t slot, ht_wide_node *node) {
    ht_expand_node(tree, slot, node);
}

HT_INLINE void expand_leaf(const htree *tree, uint32_t index, ht_wide_leaf *leaf) {
    ht_expand_leaf(tree, index, leaf);
}

/* ---- Rays ----------------------------------------------------------------------------------- */

/* Box tests subtract and multiply here, so entry and exit are what they need. */
HT_INLINE void write_ready(const ht_ray *r, float tmax, ready *out) {
    const ht_shear *const s = &r->shear;
    const uint32_t axes[3] = {s->kx, s->ky, s->kz};
    memset(out, 0, sizeof *out);
    for (uint32_t k = 0; k < 3; ++k) {
        out->rdir[k] = r->rdir[k];
        out->enter[k] = r->entry[k];
        out->leave[k] = r->exit[k];
        out->org[k] = s->org[axes[k]];
        out->row[k] = HT_LANES * axes[k];
        out->order |= r->negative[k] << k;
        out->near[k] = HT_LANES * (k + 3 * r->negative[k]);
        out->far[k] = HT_LANES * (k + 3 - 3 * r->negative[k]);
    }
    out->tnear = r->tnear;
    out->tmin = r->tmin;
    out->tmax = tmax;
    out->dz = (float)s->dz;
    out->sx = s->sx;
    out->sy = s->sy;
}

HT_INLINE uint32_t make_ready(const htree_box *bounds, const htree_ray *rays, ready *out,
                              uint32_t *apart) {
    uint32_t ready_rays = 0;
    *apart = 0;
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        ht_ray r;
        if (!ht_ray_init(&r, &rays[i], bounds)) continue;
        write_ready(&r, rays[i].tmax, &out[i]);
        ready_rays |= 1u << i;
    }
    return ready_rays;
}

HT_INLINE ray_set sort_out(const uint32_t next[STREAMS], ray_set *ended) {
    const uint16x8_t bits = lane_bits(0);
    ray_set elsewhere = 0;
    *ended = 0;
    for (uint32_t i = 0; i < STREAMS; i += HT_LANES) {
        const uint32x4_t none = vdupq_n_u32(HT_WIDE_NONE), leaf = vdupq_n_u32(HT_WIDE_LEAF);
        const uint32x4_t low = vld1q_u32(next + i), high = vld1q_u32(next + i + 4);
        elsewhere |= (ray_set)(lanes_in(vcgeq_u32(low, leaf), vcgeq_u32(high, leaf), bits) & 255)
                     << i;
        *ended |= (ray_set)(lanes_in(vceqq_u32(low, none), vceqq_u32(high, none), bits) & 255) << i;
    }
    return elsewhere;
}

HT_DEFINE_BLOCK_WALKS(ht_wide_neon_walks);
#else
typedef int ht_no_neon; /* a file is not empty */
#endif
