/* visible_paint.c: the tint is the mean over a few rays per pixel, so that it is as smooth as the
 * shading that it multiplies. */
#include "visible_paint.h"

#include "shade.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TAPS = 4, ROWS = 32 };

static const colour tints[3] = {{.52f, .54f, .58f}, {1.15f, .60f, .16f}, {.20f, .62f, 1.15f}};

static colour tint_of(const visible_result *result, uint32_t prim) {
    const uint8_t how = result->marks[prim];
    return tints[how & VISIBLE_BY_LINE ? 1 : how ? 2 : 0];
}

/* Tints the pixel by its four rays; those that miss leave what is there. */
static void tint_pixel(uint8_t *rgb, const htree_hit *hits, const visible_result *result) {
    const float luma = (0.3f * rgb[0] + 0.59f * rgb[1] + 0.11f * rgb[2]) * (1.25f / 255);
    float sum[3] = {0, 0, 0};
    for (int i = 0; i < TAPS; ++i) {
        const bool hit = hits[i].prim != HTREE_NONE;
        const colour tint = hit ? tint_of(result, hits[i].prim) : tints[0];
        const float taps[3] = {tint.r, tint.g, tint.b};
        for (int k = 0; k < 3; ++k) sum[k] += hit ? luma * taps[k] : (float)rgb[k] / 255;
    }
    for (int k = 0; k < 3; ++k) {
        const float value = sum[k] / TAPS * 255 + 0.5f;
        rgb[k] = (uint8_t)(value < 255 ? (int)value : 255);
    }
}

static htree_status tint(picture *p, const visible_job *job, const visible_result *result,
                         const camera *view) {
    static const double at[TAPS][2] = {{.375, .125}, {.875, .375}, {.125, .625}, {.625, .875}};
    const size_t most = (size_t)ROWS * p->width * TAPS;
    htree_ray *rays = (htree_ray *)malloc(most * sizeof *rays);
    htree_hit *hits = (htree_hit *)malloc(most * sizeof *hits);
    htree_status status = rays && hits ? HTREE_OK : HTREE_ERROR_MEMORY;
    for (uint32_t y = 0; y < p->height && status == HTREE_OK; y += ROWS) {
        const uint32_t rows = p->height - y < ROWS ? p->height - y : ROWS;
        const uint64_t pixels = (uint64_t)rows * p->width;
        for (uint64_t i = 0; i < pixels * TAPS; ++i) {
            const double px = (double)(i / TAPS % p->width), py = (double)(i / TAPS / p->width + y);
            rays[i] =
                camera_ray(view, px + at[i % TAPS][0], py + at[i % TAPS][1], p->width, p->height);
        }
        status = htree_intersect(job->tree, rays, pixels * TAPS, hits, NULL);
        for (uint64_t i = 0; status == HTREE_OK && i < pixels; ++i)
            tint_pixel(p->rgb + 3 * ((size_t)y * p->width + i), hits + i * TAPS, result);
    }
    free(rays);
    free(hits);
    return status;
}

/* ---- The cell ------------------------------------------------------------------------------- */

/* Where the camera sees a point, in pixels; false behind it. */
static bool project(const camera *view, const picture *p, const double *point, double *out) {
    double along[3] = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
        const double d = point[i] - view->eye[i];
        along[0] += d * view->right[i];
        along[1] += d * view->up[i];
        along[2] += d * view->forward[i];
    }
    if (!(along[2] > 1e-9)) return false;
    out[0] = (1 + along[0] / along[2] / view->slope_x) / 2 * p->width;
    out[1] = (1 - along[1] / along[2] / view->slope_y) / 2 * p->height;
    return fabs(out[0]) < 1e5 && fabs(out[1]) < 1e5;
}

static void draw_line(picture *p, const double *a, const double *b, colour c) {
    const double length = fmax(fabs(b[0] - a[0]), fabs(b[1] - a[1]));
    const int64_t steps = (int64_t)(2 * length) + 1;
    for (int64_t i = 0; i <= steps; ++i) {
        const double f = (double)i / (double)steps;
        picture_fill(p, (int64_t)floor(a[0] + f * (b[0] - a[0])),
                     (int64_t)floor(a[1] + f * (b[1] - a[1])), 2, 2, c);
    }
}

/* Drawn over everything: the cell is what the picture is about. */
static void draw_cell(picture *p, const htree_box *cell, const camera *view) {
    static const colour ink = {.98f, .96f, .35f};
    double at[8][2];
    for (int i = 0; i < 8; ++i) {
        double corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = (double)(i >> k & 1 ? cell->hi[k] : cell->lo[k]);
        if (!project(view, p, corner, at[i])) return;
    }
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k)
            if (!(i >> k & 1)) draw_line(p, at[i], at[i | 1 << k], ink);
}

static void draw_legend(picture *p, const visible_result *result, uint64_t triangles) {
    static const colour ink = {1, 1, 1};
    static const char *const names[3] = {"UNSEEN", "HIT BY A LINE", "BY A SEGMENT ONLY"};
    const uint64_t counts[3] = {triangles - result->by_line - result->by_segment, result->by_line,
                                result->by_segment};
    const int zoom = p->width >= 700 ? 2 : 1;
    const int64_t margin = 6 * zoom, line = 12 * zoom, height = 3 * line + margin;
    if (p->width < 300 || p->height < 4 * height) return;
    picture_dim(p, 0, (int64_t)p->height - height, (int64_t)p->width, height, 0.35f);
    for (int i = 0; i < 3; ++i) {
        const int shown = (i + 1) % 3; /* unseen ones last */
        char text[64];
        const int64_t y = (int64_t)p->height - height + margin + i * line;
        snprintf(text, sizeof text, "%s: %llu", names[shown], (unsigned long long)counts[shown]);
        picture_fill(p, margin, y, 7 * zoom, 7 * zoom, tints[shown]);
        picture_text(p, margin + 14 * zoom, y, zoom, ink, text);
    }
}

htree_status visible_paint(picture *out, const visible_job *job, const visible_result *result,
                           const camera *view, const visible_args *args) {
    render_args shading;
    progress bar = progress_start("render", args->quiet);
    memset(&shading, 0, sizeof shading);
    shading.mode = MODE_SHADED;
    shading.width = args->width;
    shading.height = args->height;
    shading.spp = 4;
    shading.threads = args->threads;
    shading.seed = args->seed;
    shading.camera = args->camera;
    tracer cpu = tracer_cpu(job->tree, args->threads);
    const shade_scene scene = {&cpu, job->mesh, view, &shading};
    if (!picture_make(out, args->width, args->height)) return HTREE_ERROR_MEMORY;
    htree_status status = shade_picture(out, &scene, &bar);
    progress_end(&bar);
    if (status == HTREE_OK) status = tint(out, job, result, view);
    if (status == HTREE_OK) {
        draw_cell(out, &job->cell, view);
        draw_legend(out, result, job->mesh->triangle_count);
    }
    return status;
}
