/* common.cl: rays, the triangle test and the kernels of every structure: the twin of
 * lib/trace/ray.h and lib/trace/triangle.h, where the reasons stand. The host compiles
 * lib/tree/layout.h + this + the file of one structure, which ends in HT_KERNELS(its walk), with
 *
 *   HT_FP64    the device has double arithmetic
 *   HT_STACK   entries that the traversal stack needs
 *
 * The hits must be the CPU's, bit for bit: no contraction, and every operation in the same order. */

#pragma OPENCL FP_CONTRACT OFF
#ifdef HT_FP64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif

#define HT_NONE           0xffffffffu
#define HT_COORDINATE_MAX 1152921504606846976.0f /* 2^60 */
#define HT_RAY_PAD        1.9073486328125e-6f    /* 32 e */
#define HT_RAY_ROUND      1.1920928955078125e-7f /* 2 e */
#define HT_RAY_TINY       9.094947017729282e-13f /* 2^-40 */
#define HT_FLT_MIN        1.17549435e-38f

#ifdef HT_FP64
typedef double ht_wide_float;
#else
typedef float ht_wide_float;
#endif

typedef struct ht_hit {
    float t, u, v;
    uint prim;
} ht_hit;

typedef struct ht_ray {
    float org[3], dir[3];
    float rdir[3];
    float entry[3], exit[3];
    uint negative[3];
    float reach;
    float tmin;
    float tnear, tfar;
    float ox, oy, oz; /* the origin along kx, ky, kz */
    float sx, sy;
    float dz;
    uint kx, ky, kz;
} ht_ray;

float ht_min(float a, float b) {
    return b < a ? b : a;
}

float ht_max(float a, float b) {
    return b > a ? b : a;
}

float ht_magnitude(float x) {
    return x < 0 ? -x : x;
}

/* Correctly rounded, on devices whose own division is not: two roundings of a quotient of floats,
 * first to double, are as one. Without double, a step of Newton's gets as close as it can. */
float ht_divide(float a, float b) {
#ifdef HT_FP64
    return (float)((double)a / (double)b);
#else
    const float q = a / b;
    const float better = q + fma(-q, b, a) / b;
    return better - better == 0 ? better : q;
#endif
}

/* ---- Rays ----------------------------------------------------------------------------------- */

float ht_ray_entry(const ht_ray *r, uint axis, float plane) {
    return (plane - r->entry[axis]) * r->rdir[axis];
}

float ht_ray_exit(const ht_ray *r, uint axis, float plane) {
    return (plane - r->exit[axis]) * r->rdir[axis];
}

void ht_ray_clip(const ht_ray *r, uint axis, float lo, float hi, float *tnear, float *tfar) {
    const uint negative = r->negative[axis];
    *tnear = ht_max(*tnear, ht_ray_entry(r, axis, negative ? hi : lo));
    *tfar = ht_min(*tfar, ht_ray_exit(r, axis, negative ? lo : hi));
}

/* False for the rays that htree.h declares a miss; NaN fails every comparison. */
bool ht_ray_is_valid(const ht_ray *r, float tmax) {
    const float limit = HT_COORDINATE_MAX;
    const float x = ht_magnitude(r->dir[0]);
    const float y = ht_magnitude(r->dir[1]);
    const float z = ht_magnitude(r->dir[2]);
    return ht_magnitude(r->org[0]) <= limit && ht_magnitude(r->org[1]) <= limit &&
           ht_magnitude(r->org[2]) <= limit && x <= limit && y <= limit && z <= limit &&
           (x >= 1 / limit || y >= 1 / limit || z >= 1 / limit) && r->tmin <= tmax;
}

void ht_ray_shear(ht_ray *r) {
    const float x = ht_magnitude(r->dir[0]);
    const float y = ht_magnitude(r->dir[1]);
    const float z = ht_magnitude(r->dir[2]);
    r->kz = x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
    r->kx = r->kz == 2 ? 0 : r->kz + 1;
    r->ky = r->kx == 2 ? 0 : r->kx + 1;
    r->ox = r->org[r->kx];
    r->oy = r->org[r->ky];
    r->oz = r->org[r->kz];
    r->dz = r->dir[r->kz];
    r->sx = ht_divide(r->dir[r->kx], r->dz);
    r->sy = ht_divide(r->dir[r->ky], r->dz);
}

/* False if the ray misses by its numbers alone, or misses the bounds. */
bool ht_ray_init(ht_ray *r, __global const ht_scene *scene, float4 from, float4 to) {
    r->org[0] = from.x;
    r->org[1] = from.y;
    r->org[2] = from.z;
    r->tmin = from.w;
    r->dir[0] = to.x;
    r->dir[1] = to.y;
    r->dir[2] = to.z;
    if (!ht_ray_is_valid(r, to.w) || scene->prims == 0) return false;
    ht_ray_shear(r);
    float reach = 0;
    for (int i = 0; i < 3; ++i) {
        reach = ht_max(reach, ht_magnitude(scene->lo[i] - r->org[i]));
        reach = ht_max(reach, ht_magnitude(scene->hi[i] - r->org[i]));
    }
    const float tiny = HT_RAY_TINY * ht_magnitude(r->dz);
    r->tnear = from.w;
    r->tfar = to.w;
    for (uint i = 0; i < 3; ++i) {
        const float pad =
            ht_max(HT_RAY_PAD * reach + HT_RAY_ROUND * ht_magnitude(r->org[i]), HT_FLT_MIN);
        const float size = ht_max(tiny, ht_magnitude(r->dir[i]));
        const bool negative = r->dir[i] < 0;
        r->negative[i] = negative;
        r->rdir[i] = ht_divide(1, negative ? -size : size);
        r->entry[i] = negative ? r->org[i] - pad : r->org[i] + pad;
        r->exit[i] = negative ? r->org[i] + pad : r->org[i] - pad;
        ht_ray_clip(r, i, scene->lo[i], scene->hi[i], &r->tnear, &r->tfar);
    }
    r->reach = reach;
    return r->tnear <= r->tfar;
}

/* ---- Triangles ------------------------------------------------------------------------------ */

/* A sheared corner. */
typedef struct ht_corner {
    float x, y, z;
} ht_corner;

ht_corner ht_ray_corner(const ht_ray *r, float x, float y, float z) {
    ht_corner c;
    c.z = z - r->oz;
    c.x = (x - r->ox) - r->sx * c.z;
    c.y = (y - r->oy) - r->sy * c.z;
    return c;
}

#ifdef HT_FP64
/* Products of floats are exact in double. */
double ht_edge(ht_corner a, ht_corner b) {
    return (double)a.x * (double)b.y - (double)a.y * (double)b.x;
}
#else
/* The difference of two products in float with the error of both products: its sign is right but
 * where both cancel to the last bits. */
float ht_edge(ht_corner a, ht_corner b) {
    const float p = a.x * b.y, q = a.y * b.x;
    return (p - q) + (fma(a.x, b.y, -p) - fma(a.y, b.x, -q));
}
#endif

/* The verdict on what float signs did not reject. */
bool ht_triangle_verdict(const ht_ray *r, ht_corner a, ht_corner b, ht_corner c, uint prim,
                         ht_hit *hit) {
    const ht_wide_float u = ht_edge(c, b);
    const ht_wide_float v = ht_edge(a, c);
    const ht_wide_float w = ht_edge(b, a);
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const ht_wide_float det = u + v + w;
    if (det == 0) return false;
    const ht_wide_float z =
        u * (ht_wide_float)a.z + v * (ht_wide_float)b.z + w * (ht_wide_float)c.z;
    const float t = (float)(z / (det * (ht_wide_float)r->dz));
    if (!(r->tmin <= t && t <= hit->t)) return false;
    if (t < hit->t || prim < hit->prim) {
        hit->t = t;
        hit->u = (float)(v / det);
        hit->v = (float)(w / det);
        hit->prim = prim;
    }
    return true;
}

/* Keeps the minimum of (t, prim) in *hit; returns whether the triangle was hit at all. */
bool ht_triangle_intersect(const ht_ray *r, __global const float *triangles, uint prim,
                           ht_hit *hit) {
    __global const float *v = triangles + 9 * (size_t)prim;
    const ht_corner a = ht_ray_corner(r, v[r->kx], v[r->ky], v[r->kz]);
    const ht_corner b = ht_ray_corner(r, v[3 + r->kx], v[3 + r->ky], v[3 + r->kz]);
    const ht_corner c = ht_ray_corner(r, v[6 + r->kx], v[6 + r->ky], v[6 + r->kz]);
    const float eu = c.x * b.y - c.y * b.x;
    const float ev = a.x * c.y - a.y * c.x;
    const float ew = b.x * a.y - b.y * a.x;
    if ((eu < 0 || ev < 0 || ew < 0) && (eu > 0 || ev > 0 || ew > 0)) return false;
    return ht_triangle_verdict(r, a, b, c, prim, hit);
}

/* ---- Kernels: rays first .. end, each to its answer ----------------------------------------- */

#define HT_ARGUMENTS                                                                               \
    __global const ht_scene *scene, __global const void *nodes, __global const float *triangles,   \
        __global const void *leaves, __global const float4 *rays

/* walk(scene, nodes, triangles, leaves, ray, hit, any) is inlined twice: for the closest hit, and
 * with `any`, when it stops at the first. */
#define HT_KERNELS(walk)                                                                           \
    __kernel void htree_closest(HT_ARGUMENTS, __global uint4 *hits, ulong first, ulong end) {      \
        const ulong i = first + get_global_id(0);                                                  \
        if (i >= end) return;                                                                      \
        const float4 from = rays[2 * i], to = rays[2 * i + 1];                                     \
        ht_hit hit = {to.w, 0, 0, HT_NONE};                                                        \
        ht_ray r;                                                                                  \
        if (ht_ray_init(&r, scene, from, to))                                                      \
            walk(scene, nodes, triangles, leaves, &r, &hit, false);                                \
        hits[i] = (uint4)(as_uint(hit.t), as_uint(hit.u), as_uint(hit.v), hit.prim);               \
    }                                                                                              \
    __kernel void htree_any(HT_ARGUMENTS, __global uchar *occluded, ulong first, ulong end) {      \
        const ulong i = first + get_global_id(0);                                                  \
        if (i >= end) return;                                                                      \
        const float4 from = rays[2 * i], to = rays[2 * i + 1];                                     \
        ht_hit hit = {to.w, 0, 0, HT_NONE};                                                        \
        ht_ray r;                                                                                  \
        if (ht_ray_init(&r, scene, from, to))                                                      \
            walk(scene, nodes, triangles, leaves, &r, &hit, true);                                 \
        occluded[i] = hit.prim != HT_NONE;                                                         \
    }

typedef struct ht_stack_entry {
    uint slot;
    float tnear, tfar;
} ht_stack_entry;
