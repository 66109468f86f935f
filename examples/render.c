/* render.c: htree-render. Mesh -> tree -> primary rays -> picture and figures; the files are
 * written last, so that a run that fails leaves none behind.
 *
 * SPDX-License-Identifier: MIT */
#include "args.h"
#include "build_tree.h"
#include "device.h"
#include "heat.h"
#include "mesh_file.h"
#include "picture.h"
#include "primary.h"
#include "progress.h"
#include "report.h"
#include "shade.h"
#include "tracer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_INPUT = 1, EXIT_USAGE = 2 };

typedef struct render {
    render_args args;
    char error[512];
    shape mesh;
    htree *tree;
    struct htree_cl *device; /* NULL: the CPU answers the rays */
    char device_text[320];
    tracer by;
    camera view;
    primary rays;
    picture image;
    report figures;
} render;

static bool fail(render *r, const char *cause) {
    snprintf(r->error, sizeof r->error, "%s", cause);
    return false;
}

/* A memory error may be the renderer's own, which the library has no text for. */
static bool fail_status(render *r, htree_status status) {
    const char *text = tracer_error_text(&r->by);
    const bool own = status == HTREE_ERROR_MEMORY || !*text;
    return fail(r, own ? "out of memory: try a smaller --size or mesh" : text);
}

/* Before anything that takes long: the name may be wrong. */
static bool open_device(render *r) {
    const render_args *args = &r->args;
    if (!args->device) return true;
    r->device = device_open(args->device, r->error, sizeof r->error);
    if (!r->device) return false;
    device_describe(r->device, r->device_text, sizeof r->device_text);
    r->figures.device = r->device_text;
    return true;
}

static const char *scene_name(const render *r) {
    const char *path = r->args.mesh_path;
    if (!path) return r->args.scene;
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

static bool load(render *r) {
    const render_args *args = &r->args;
    if (args->mesh_path)
        return mesh_file_read(args->mesh_path, &r->mesh, r->error, sizeof r->error);
    return shape_make(&r->mesh, args->scene, args->triangles, args->seed) ||
           fail(r, "out of memory: try a smaller scene");
}

static bool build(render *r) {
    const render_args *args = &r->args;
    htree_status status = build_tree(&r->tree, &r->mesh, args->kind, args->threads, args->quiet);
    r->by = tracer_cpu(r->tree, args->threads);
    if (status == HTREE_OK && r->device)
        status = tracer_upload(&r->by, r->device, r->tree, args->threads);
    return status == HTREE_OK || fail_status(r, status);
}

static bool measure(render *r) {
    const render_args *args = &r->args;
    r->view = camera_place(&args->camera, &r->mesh, args->width, args->height);
    htree_status status = primary_trace(&r->rays, &r->by, &r->view, args->width, args->height);
    r->figures.scene = scene_name(r);
    r->figures.threads = args->threads;
    r->figures.rays = &r->rays;
    r->figures.stats.size = sizeof r->figures.stats;
    if (status == HTREE_OK) status = htree_get_stats(r->tree, &r->figures.stats);
    return status == HTREE_OK || fail_status(r, status);
}

/* ---- Pictures ------------------------------------------------------------------------------- */

/* One number per pixel from its primary ray; NaN where there is nothing to show. */
static float heat_value(const render *r, uint64_t i) {
    const htree_counters *counters = &r->rays.counters[i];
    const htree_hit *hit = &r->rays.hits[i];
    switch (r->args.mode) {
    case MODE_STEPS: return (float)counters->traversal_steps;
    case MODE_TESTS: return (float)counters->intersections;
    default: return hit->prim == HTREE_NONE ? NAN : hit->t;
    }
}

static bool paint_heat(render *r) {
    char title[64];
    const uint64_t count = r->rays.count;
    const bool depth = r->args.mode == MODE_DEPTH;
    const char *text = depth                        ? "depth in scene units"
                       : r->args.mode == MODE_STEPS ? "N_TS nodes visited per ray"
                                                    : "N_IT triangles tested per ray";
    heat_scale scale;
    snprintf(title, sizeof title, "%s, %s", text, htree_kind_name(r->args.kind));
    float *values = (float *)malloc((size_t)count * sizeof *values);
    for (uint64_t i = 0; values && i < count; ++i) values[i] = heat_value(r, i);
    const bool ok = values && heat_measure(&scale, depth ? text : title, !depth, values, count,
                                           r->args.heat_max);
    if (ok) heat_paint(&r->image, &scale, values);
    free(values);
    return ok || fail_status(r, HTREE_ERROR_MEMORY);
}

static bool paint(render *r) {
    const render_args *args = &r->args;
    if (!args->output) return true;
    if (!picture_make(&r->image, args->width, args->height))
        return fail_status(r, HTREE_ERROR_MEMORY);
    if (args->mode == MODE_DEPTH || args->mode == MODE_STEPS || args->mode == MODE_TESTS)
        return paint_heat(r);
    progress bar = progress_start("render", args->quiet);
    const shade_scene scene = {&r->by, &r->mesh, &r->view, args};
    const htree_status status = shade_picture(&r->image, &scene, &bar);
    progress_end(&bar);
    return status == HTREE_OK || fail_status(r, status);
}

static bool write_files(render *r) {
    const render_args *args = &r->args;
    if (args->output &&
        !picture_write(&r->image, args->output, scene_name(r), r->error, sizeof r->error))
        return false;
    return !args->json || report_write_json(&r->figures, args->json, r->error, sizeof r->error);
}

static void summarise(const render *r) {
    const htree_stats *stats = &r->figures.stats;
    if (r->args.quiet) return;
    if (r->device && !device_exact(r->device))
        printf("note: this device does not give the CPU's bits: pictures may differ by a little\n");
    if (r->args.stats) {
        report_print(&r->figures);
        return;
    }
    printf("%s: %llu triangles, %s built in %.3f s, %llu rays in %.3f s\n",
           r->args.output ? r->args.output : r->figures.scene, (unsigned long long)stats->triangles,
           htree_kind_name(stats->kind), stats->build_seconds, (unsigned long long)r->rays.count,
           r->rays.seconds);
}

static int list_devices(void) {
    char error[512];
    if (device_list(stdout, error, sizeof error)) return EXIT_SUCCESS;
    fprintf(stderr, "htree-render: %s\n", error);
    return EXIT_INPUT;
}

int main(int argc, char **argv) {
    render r;
    memset(&r, 0, sizeof r);
    const args_result parsed = args_parse(&r.args, argc, argv);
    if (parsed != ARGS_RUN) return parsed == ARGS_DONE ? EXIT_SUCCESS : EXIT_USAGE;
    if (r.args.list_devices) return list_devices();
    const bool ok =
        open_device(&r) && load(&r) && build(&r) && measure(&r) && paint(&r) && write_files(&r);
    if (ok)
        summarise(&r);
    else
        fprintf(stderr, "htree-render: %s\n", r.error);
    picture_free(&r.image);
    primary_free(&r.rays);
    tracer_end(&r.by);
    device_close(r.device);
    htree_free(r.tree);
    shape_free(&r.mesh);
    return ok ? EXIT_SUCCESS : EXIT_INPUT;
}
