/* mpi_render.c: one picture by many processes: mpirun -np N htree-mpi-render OUT.png [SCENE [TRIANGLES]].
 *
 * One process builds the tree and sends its bytes to all others, once. Tiles are taken from a counter
 * that all of them share, by whoever is idle, so that hard tiles hold up nobody. A tile is the same
 * pixels whoever paints it, and so is the picture.
 *
 * SPDX-License-Identifier: MIT */
#include "camera.h"
#include "picture.h"
#include "shape_mesh.h"
#include "surface.h"

#include <math.h>
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 512, HEIGHT = 512, TILE = 32, TILES = WIDTH / TILE * (HEIGHT / TILE), SAMPLES = 16 };
enum { PIXELS = TILE * TILE, CHUNK = 1 << 30 /* bytes that MPI sends at once */ };

typedef struct painter {
    int rank, ranks;
    shape mesh;
    htree *tree;
    void *file; /* the tree's bytes, which it refers to where it was not built */
    camera view;
    double lift, reach;
    picture image;
    uint64_t painted; /* tiles */
} painter;

/* Ends all processes. */
static void give_up(const painter *p, const char *why) {
    fprintf(stderr, "htree-mpi-render: process %d: %s\n", p->rank, why);
    MPI_Abort(MPI_COMM_WORLD, 1);
    exit(1);
}

/* ---- The tree ------------------------------------------------------------------------------- */

static uint64_t build(painter *p) {
    const htree_mesh mesh = shape_mesh(&p->mesh);
    uint64_t bytes = 0;
    if (htree_build(&p->tree, &mesh, NULL) != HTREE_OK) give_up(p, htree_error_text());
    if (htree_save(p->tree, NULL, 0, &bytes) != HTREE_OK) give_up(p, htree_error_text());
    if (posix_memalign(&p->file, 64, bytes)) give_up(p, "out of memory");
    if (htree_save(p->tree, p->file, bytes, &bytes) != HTREE_OK) give_up(p, htree_error_text());
    return bytes;
}

static void load(painter *p, uint64_t bytes) {
    htree_load_options options;
    htree_load_options_init(&options, sizeof options);
    options.flags = HTREE_BORROW;
    if (htree_load(&p->tree, p->file, bytes, &options) != HTREE_OK) give_up(p, htree_error_text());
}

static void share_tree(painter *p) {
    uint64_t bytes = p->rank == 0 ? build(p) : 0;
    MPI_Bcast(&bytes, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    if (p->rank > 0 && posix_memalign(&p->file, 64, bytes)) give_up(p, "out of memory");
    for (uint64_t at = 0; at < bytes; at += CHUNK) {
        const uint64_t left = bytes - at;
        MPI_Bcast((char *)p->file + at, left < CHUNK ? (int)left : CHUNK, MPI_BYTE, 0,
                  MPI_COMM_WORLD);
    }
    if (p->rank > 0) load(p, bytes);
}

/* ---- A tile --------------------------------------------------------------------------------- */

/* In [0, 1), by pixel and sample alone. */
static double chance(uint64_t pixel, uint32_t sample) {
    uint64_t x = (pixel << 16 | sample) * 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return (double)(x >> 40) / 16777216;
}

/* Of the sky above each surface, the share that nothing hides. */
static void see_sky(const painter *p, const surface *at, const uint64_t *pixel, uint32_t count,
                    float *sky) {
    static htree_ray rays[PIXELS];
    static uint8_t hidden[PIXELS];
    htree_query query;
    htree_query_init(&query, sizeof query);
    query.threads = 1; /* as many processes as cores */
    for (uint32_t s = 0; s < SAMPLES; ++s) {
        for (uint32_t i = 0; i < count; ++i) {
            double direction[3];
            surface_cosine(&at[i], chance(pixel[i], 2 * s), chance(pixel[i], 2 * s + 1), direction);
            rays[i] = surface_ray(&at[i], direction, p->reach);
        }
        if (htree_occluded(p->tree, rays, count, hidden, &query) != HTREE_OK)
            give_up(p, htree_error_text());
        for (uint32_t i = 0; i < count; ++i) sky[i] += hidden[i] ? 0 : 1.0f / SAMPLES;
    }
}

static void paint_tile(painter *p, uint64_t tile) {
    static htree_ray rays[PIXELS];
    static htree_hit hits[PIXELS];
    static surface at[PIXELS];
    static uint64_t pixel[PIXELS];
    static float sky[PIXELS];
    const uint64_t left = tile % (WIDTH / TILE) * TILE, top = tile / (WIDTH / TILE) * TILE;
    uint32_t count = 0;
    for (uint32_t i = 0; i < PIXELS; ++i) {
        const double x = (double)(left + i % TILE) + 0.5, y = (double)(top + i / TILE) + 0.5;
        rays[i] = camera_ray(&p->view, x, y, WIDTH, HEIGHT);
    }
    if (htree_intersect(p->tree, rays, PIXELS, hits, NULL) != HTREE_OK)
        give_up(p, htree_error_text());
    memset(sky, 0, sizeof sky);
    for (uint32_t i = 0; i < PIXELS; ++i) {
        if (hits[i].prim == HTREE_NONE) continue;
        pixel[count] = (top + i / TILE) * WIDTH + left + i % TILE;
        surface_find(&at[count++], &p->mesh, &hits[i], &rays[i], p->lift);
    }
    see_sky(p, at, pixel, count, sky);
    for (uint32_t i = 0; i < count; ++i) {
        const float light = sky[i] * (0.75f + 0.25f * (float)at[i].normal[1]);
        const colour c = {light, light, 0.96f * light};
        picture_set(&p->image, (int64_t)(pixel[i] % WIDTH), (int64_t)(pixel[i] / WIDTH), c);
    }
    ++p->painted;
}

/* ---- The picture ---------------------------------------------------------------------------- */

static void paint_tiles(painter *p) {
    uint64_t *next = NULL, tile = 0;
    const uint64_t one = 1;
    MPI_Win window;
    MPI_Win_allocate(p->rank == 0 ? sizeof *next : 0, sizeof *next, MPI_INFO_NULL, MPI_COMM_WORLD,
                     &next, &window);
    if (p->rank == 0) *next = 0;
    MPI_Barrier(MPI_COMM_WORLD);
    for (;;) {
        MPI_Win_lock(MPI_LOCK_SHARED, 0, 0, window);
        MPI_Fetch_and_op(&one, &tile, MPI_UINT64_T, 0, 0, MPI_SUM, window);
        MPI_Win_unlock(0, window);
        if (tile >= TILES) break;
        paint_tile(p, tile);
    }
    MPI_Win_free(&window);
}

/* What a process has not painted is 0 in its picture. */
static void gather(painter *p, const char *path, const char *scene) {
    char error[512];
    uint64_t *painted = (uint64_t *)calloc((size_t)p->ranks, sizeof *painted);
    if (!painted) give_up(p, "out of memory");
    MPI_Gather(&p->painted, 1, MPI_UINT64_T, painted, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    MPI_Reduce(p->rank == 0 ? MPI_IN_PLACE : p->image.rgb, p->rank == 0 ? p->image.rgb : NULL,
               3 * WIDTH * HEIGHT, MPI_UINT8_T, MPI_BOR, 0, MPI_COMM_WORLD);
    if (p->rank == 0) {
        if (!picture_write(&p->image, path, scene, error, sizeof error)) give_up(p, error);
        printf("%s: %d tiles, by process:", path, TILES);
        for (int i = 0; i < p->ranks; ++i) printf(" %llu", (unsigned long long)painted[i]);
        printf("\n");
    }
    free(painted);
}

int main(int argc, char **argv) {
    painter p = {0};
    const camera_wish wish = {.mode = CAMERA_OUTSIDE, .up = 1};
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &p.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &p.ranks);
    if (argc < 2) give_up(&p, "usage: htree-mpi-render OUT.png [SCENE [TRIANGLES]]");
    const char *scene = argc > 2 ? argv[2] : "knot";
    const uint64_t triangles = argc > 3 ? strtoull(argv[3], NULL, 10) : 100000;
    if (!shape_make(&p.mesh, scene, triangles, 1)) give_up(&p, "no such scene, or no memory");
    if (!picture_make(&p.image, WIDTH, HEIGHT)) give_up(&p, "out of memory");
    share_tree(&p);

    htree_box box;
    htree_get_bounds(p.tree, &box);
    double diagonal = 0;
    for (int k = 0; k < 3; ++k) diagonal += pow((double)box.hi[k] - (double)box.lo[k], 2);
    p.reach = 0.2 * sqrt(diagonal);
    p.lift = surface_lift(sqrt(diagonal));
    p.view = camera_place(&wish, &p.mesh, WIDTH, HEIGHT);
    paint_tiles(&p);
    gather(&p, argv[1], scene);

    picture_free(&p.image);
    htree_free(p.tree);
    free(p.file);
    shape_free(&p.mesh);
    return MPI_Finalize();
}
