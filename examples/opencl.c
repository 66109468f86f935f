/* opencl.c: a mesh, a tree, and a batch of rays on an OpenCL device: opencl [DEVICE]. */
#include <htree_cl.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SIDE = 64, RAYS = 1 << 16 }; /* quads along a side of the mesh, rays of the batch */

static float positions[3 * (SIDE + 1) * (SIDE + 1)];
static uint32_t indices[6 * SIDE * SIDE];
static htree_ray rays[RAYS];
static htree_hit hits[RAYS], same[RAYS];

/* Waves over the unit square, and rays from above that all lean the same way. */
static htree_mesh make_scene(void) {
    for (int i = 0; i < (SIDE + 1) * (SIDE + 1); ++i) {
        const float x = (float)(i % (SIDE + 1)) / SIDE, z = (float)(i / (SIDE + 1)) / SIDE;
        const float p[3] = {x, 0.05f * sinf(20 * x) * cosf(13 * z), z};
        memcpy(positions + 3 * i, p, sizeof p);
    }
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const uint32_t a = (uint32_t)(i / SIDE * (SIDE + 1) + i % SIDE), b = a + SIDE + 1;
        const uint32_t quad[6] = {a, b, a + 1, a + 1, b, b + 1};
        memcpy(indices + 6 * i, quad, sizeof quad);
    }
    for (int i = 0; i < RAYS; ++i) {
        const htree_ray ray = {.org = {(float)(i % 256) / 256, 1, (float)(i / 256) / 256},
                               .dir = {0.25f, -1, 0.125f},
                               .tmax = INFINITY};
        rays[i] = ray;
    }
    const htree_mesh mesh = {.positions = positions,
                             .vertex_count = (SIDE + 1) * (SIDE + 1),
                             .indices = indices,
                             .triangle_count = 2 * SIDE * SIDE};
    return mesh;
}

static void list_devices(void) {
    htree_cl_info info = {.size = sizeof info};
    for (uint32_t i = 0; htree_cl_get_device_info(i, &info) == HTREE_OK; ++i)
        printf("device %u: %s, %s\n", (unsigned)i, info.device, info.platform);
}

static htree_status trace(const htree *tree, const char *name) {
    htree_cl *device = NULL;
    htree_cl_tree *copy = NULL;
    htree_cl_info info = {.size = sizeof info};
    htree_status status = htree_cl_open(&device, name, NULL);
    if (status == HTREE_OK) status = htree_cl_upload(&copy, device, tree);
    if (status == HTREE_OK) status = htree_cl_intersect(copy, rays, RAYS, hits, NULL);
    if (status == HTREE_OK) status = htree_cl_get_info(device, &info);
    if (status == HTREE_OK) printf("opened %u: %s\n", (unsigned)info.index, info.device);
    htree_cl_free(copy);
    htree_cl_close(device);
    return status;
}

int main(int argc, char **argv) {
    const htree_mesh mesh = make_scene();
    htree *tree = NULL;
    if (htree_build(&tree, &mesh, NULL) != HTREE_OK ||
        htree_intersect(tree, rays, RAYS, same, NULL) != HTREE_OK) {
        fprintf(stderr, "opencl: %s\n", htree_error_text());
        htree_free(tree);
        return 1;
    }
    list_devices();
    const htree_status status = trace(tree, argc > 1 ? argv[1] : NULL);
    htree_free(tree);
    if (status != HTREE_OK) {
        fprintf(stderr, "opencl: %s\n", htree_cl_error_text());
        return 1;
    }
    for (int i = 0; i < RAYS; i += RAYS / 4 + 40) {
        if (hits[i].prim == HTREE_NONE)
            printf("ray %d: miss\n", i);
        else
            printf("ray %d: triangle %u at t = %g\n", i, (unsigned)hits[i].prim, (double)hits[i].t);
    }
    const int equal = memcmp(hits, same, sizeof hits) == 0;
    printf("%d rays: %s on the CPU\n", RAYS, equal ? "the same bytes as" : "not what they are");
    return equal ? 0 : 1;
}
