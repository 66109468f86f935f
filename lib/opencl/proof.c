/* proof.c: known answers: a small scene and rays that reach every branch of a walk, answered by the
 * CPU and by the device. A device or a driver that is wrong is found before anyone relies on it. */
#include "cl.h"

#include <math.h>

enum { TRIANGLES = 1000, RAYS = 4096 };

/* The batch comes first, aligned: where memory is shared, it goes as batches do there. */
typedef struct exam {
    htree_ray rays[RAYS];
    htree_hit truth[RAYS], hits[RAYS];
    uint8_t occluded[RAYS];
    float corners[TRIANGLES][9];
    uint32_t state;
} exam;

/* In [0, 1). */
static float next(exam *e) {
    e->state = e->state * 1664525u + 1013904223u;
    return (float)(e->state >> 8) / 16777216.0f;
}

/* Small triangles in the unit cube, and some large ones: they become oversize objects of an
 * AH-tree. */
static void make_triangles(exam *e) {
    for (int i = 0; i < TRIANGLES; ++i) {
        const float size = i % 50 == 0 ? 0.9f : 0.1f;
        float centre[3];
        for (int k = 0; k < 3; ++k) centre[k] = next(e);
        for (int k = 0; k < 9; ++k) e->corners[i][k] = centre[k % 3] + size * (next(e) - 0.5f);
    }
}

/* Into the scene from near and from very far, along axes, through corners, and what is no ray. */
static void make_rays(exam *e) {
    for (int i = 0; i < RAYS; ++i) {
        htree_ray *ray = &e->rays[i];
        const float distance = i % 7 == 0 ? 1e6f : 1.5f;
        const float *corner = e->corners[i % TRIANGLES];
        ray->tmin = i % 5 == 0 ? -1 : 0;
        ray->tmax = i % 3 == 0 ? 0.9f : 4;
        for (int k = 0; k < 3; ++k) {
            const float to = i % 4 == 0 ? corner[k] : next(e);
            ray->org[k] = to + distance * (2 * next(e) - 1);
            ray->dir[k] = i % 11 == 0 ? (float)((i / 11 + k) % 3 == 0) : to - ray->org[k];
            if (i % 11 == 0) ray->org[k] = to - 2 * ray->dir[k];
        }
        if (i % 64 == 1) ray->dir[i % 3] = 0;
        if (i % 64 == 2) ray->dir[0] = ray->dir[1] = ray->dir[2] = 0;
        if (i % 64 == 3) ray->tmin = ray->tmax + 1;
    }
}

/* The kind whose walk the file is, with every type of node that it has. */
static htree_options options_of(const htree_cl *device, ht_cl_file file) {
    static const htree_kind kinds[HT_CL_FILES] = {HTREE_H,  HTREE_BVH_SAH, HTREE_AH,
                                                  HTREE_KD, HTREE_UG,      HTREE_WIDE};
    htree_options options;
    (void)htree_options_init(&options, sizeof options, kinds[file]);
    options.threads = 1;
    options.flags = file == HT_CL_H ? HTREE_ANY_PLANES : 0;
    options.allocator = device->options.allocator;
    return options;
}

static htree_status answer_by_cpu(const htree_cl *device, ht_cl_file file, exam *e, htree **tree) {
    const htree_options options = options_of(device, file);
    htree_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = e->corners[0];
    mesh.vertex_count = 3 * TRIANGLES;
    mesh.triangle_count = TRIANGLES;
    htree_status status = htree_build(tree, &mesh, &options);
    if (status == HTREE_OK) status = htree_intersect(*tree, e->rays, RAYS, e->truth, NULL);
    if (status == HTREE_OK) return status;
    return ht_cl_fail(status, 0, "the scene of known answers: %s", htree_status_name(status));
}

static htree_status answer_by_device(htree_cl *device, ht_cl_program *program, exam *e,
                                     const htree *tree) {
    htree_view view;
    htree_cl_tree *uploaded;
    view.size = sizeof view;
    (void)htree_get_view(tree, &view);
    HT_TRY(ht_cl_upload_for(device, program, &view, &uploaded));
    htree_status status = htree_cl_intersect(uploaded, e->rays, RAYS, e->hits, NULL);
    if (status == HTREE_OK) status = htree_cl_occluded(uploaded, e->rays, RAYS, e->occluded, NULL);
    htree_cl_free(uploaded);
    return status;
}

/* ---- Judging -------------------------------------------------------------------------------- */

static bool is_exact(const exam *e) {
    if (memcmp(e->hits, e->truth, sizeof e->hits) != 0) return false;
    for (int i = 0; i < RAYS; ++i) {
        if (e->occluded[i] != (e->truth[i].prim != HTREE_NONE)) return false;
    }
    return true;
}

/* Barycentrics of triangles as good as these differ by much less; NaN is near nothing. */
static bool is_near(float a, float b) {
    return a - b <= 1e-3f && b - a <= 1e-3f;
}

/* The largest relative error of t; infinite where it is NaN, where u or v is wrong, and where one
 * hits and the other does not, but for rays aimed at corners, which rounding may decide either way.
 */
static float worst_error(const exam *e) {
    float worst = 0;
    for (int i = 0; i < RAYS; ++i) {
        const htree_hit *is = &e->hits[i], *should = &e->truth[i];
        const bool hit = should->prim != HTREE_NONE, corner = i % 4 == 0;
        if (corner && is->prim != should->prim) continue;
        const bool agree = (is->prim != HTREE_NONE) == hit && (corner || e->occluded[i] == hit);
        const float difference = is->t < should->t ? should->t - is->t : is->t - should->t;
        const float size = should->t < 0 ? -should->t : should->t;
        const bool inside =
            is->prim != should->prim || (is_near(is->u, should->u) && is_near(is->v, should->v));
        const bool sound = agree && inside && difference >= 0; /* NaN is not */
        const float error = !sound ? INFINITY : difference > 0 ? difference / size : 0;
        if (error > worst) worst = error;
    }
    return worst;
}

static htree_status judge(htree_cl *device, ht_cl_file file, const exam *e) {
    const bool exact = is_exact(e);
    const float error = exact ? 0 : worst_error(e);
    if (!(error <= HTREE_CL_T_ERROR)) {
        return ht_cl_fail(HTREE_ERROR_KERNEL, 0,
                          "%s gives wrong hits: its t differs from the CPU's by up to %g of it",
                          device->info.device, (double)error);
    }
    if (file == HT_CL_PROBE) {
        device->info.exact = device->info.exact && exact;
        device->info.t_error = error;
    } else if (device->info.exact && !exact) {
        return ht_cl_fail(HTREE_ERROR_KERNEL, 0,
                          "%s computes exactly, but a kernel of its compiler does not",
                          device->info.device);
    }
    return HTREE_OK;
}

htree_status ht_cl_prove(htree_cl *device, ht_cl_file file, ht_cl_program *program) {
    htree *tree = NULL;
    exam *e = (exam *)ht_allocate(&device->memory, sizeof *e);
    if (!e) return ht_cl_fail(HTREE_ERROR_MEMORY, 0, "out of memory");
    memset(e, 0, sizeof *e);
    make_triangles(e);
    make_rays(e);
    htree_status status = answer_by_cpu(device, file, e, &tree);
    if (status == HTREE_OK) status = answer_by_device(device, program, e, tree);
    if (status == HTREE_OK) status = judge(device, file, e);
    htree_free(tree);
    ht_release(&device->memory, e, sizeof *e);
    return status;
}
