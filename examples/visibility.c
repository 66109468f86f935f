/* visibility.c: htree-visibility. The paper's other use of a hierarchy: queries along lines for
 * visibility preprocessing. Mesh -> tree -> lines and segments from a view cell -> triangles seen.
 *
 * SPDX-License-Identifier: MIT */
#include "build_tree.h"
#include "mesh_file.h"
#include "visible.h"
#include "visible_args.h"
#include "visible_paint.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_INPUT = 1, EXIT_USAGE = 2 };

typedef struct visibility {
    visible_args args;
    char error[512];
    shape mesh;
    htree *tree;
    camera view;
    visible_job job;
    visible_result result;
    picture image;
} visibility;

static bool fail_status(visibility *v, htree_status status) {
    const char *text = htree_error_text();
    const bool own = status == HTREE_ERROR_MEMORY || !*text;
    snprintf(v->error, sizeof v->error, "%s",
             own ? "out of memory: try a smaller --size or mesh" : text);
    return false;
}

static bool load(visibility *v) {
    const visible_args *args = &v->args;
    if (args->mesh_path)
        return mesh_file_read(args->mesh_path, &v->mesh, v->error, sizeof v->error);
    return shape_make(&v->mesh, args->scene, args->triangles, args->seed) ||
           fail_status(v, HTREE_ERROR_MEMORY);
}

static bool build(visibility *v) {
    const htree_status status =
        build_tree(&v->tree, &v->mesh, v->args.kind, v->args.threads, v->args.quiet);
    return status == HTREE_OK || fail_status(v, status);
}

static void place(visibility *v) {
    const visible_args *args = &v->args;
    const bool inside = args->camera.mode == CAMERA_INSIDE;
    v->view = camera_place(&args->camera, &v->mesh, args->width, args->height);
    v->job.tree = v->tree;
    v->job.mesh = &v->mesh;
    v->job.cell = args->cell_given
                      ? args->cell
                      : visible_place_cell(v->tree, &v->mesh, &v->view, inside, args->seed);
    v->job.lines = args->lines;
    v->job.segments = args->segments;
    v->job.threads = args->threads;
    v->job.seed = args->seed;
    v->job.quiet = args->quiet;
    v->job.report = args->quiet ? NULL : stdout;
}

static bool sample(visibility *v) {
    place(v);
    if (!v->args.quiet) {
        const htree_box *cell = &v->job.cell;
        printf("cell %.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n", (double)cell->lo[0], (double)cell->lo[1],
               (double)cell->lo[2], (double)cell->hi[0], (double)cell->hi[1], (double)cell->hi[2]);
        printf("%12s %10s %8s %10s\n", "lines", "triangles", "percent", "new");
    }
    const htree_status status = visible_sample(&v->result, &v->job);
    return status == HTREE_OK || fail_status(v, status);
}

static void summarise(const visibility *v) {
    const visible_result *r = &v->result;
    const double lines = (double)v->args.lines / 1e6, segments = (double)r->segment_count / 1e6;
    printf("of %llu triangles %llu are hit by a line; %llu more by a segment alone\n",
           (unsigned long long)v->mesh.triangle_count, (unsigned long long)r->by_line,
           (unsigned long long)r->by_segment);
    if (!v->args.quiet)
        printf("%.3f million lines in %.3f s, %.3f million segments in %.3f s, %s, %u threads\n",
               lines, r->line_seconds, segments, r->segment_seconds, htree_kind_name(v->args.kind),
               v->args.threads);
}

static bool paint(visibility *v) {
    const visible_args *args = &v->args;
    if (!args->output) return true;
    const htree_status status = visible_paint(&v->image, &v->job, &v->result, &v->view, args);
    if (status != HTREE_OK) return fail_status(v, status);
    return picture_write(&v->image, args->output, "triangles seen from a view cell", v->error,
                         sizeof v->error);
}

int main(int argc, char **argv) {
    visibility v;
    memset(&v, 0, sizeof v);
    const args_result parsed = visible_args_parse(&v.args, argc, argv);
    if (parsed != ARGS_RUN) return parsed == ARGS_DONE ? EXIT_SUCCESS : EXIT_USAGE;
    const bool ok = load(&v) && build(&v) && sample(&v) && paint(&v);
    if (ok)
        summarise(&v);
    else
        fprintf(stderr, "htree-visibility: %s\n", v.error);
    picture_free(&v.image);
    visible_free(&v.result);
    htree_free(v.tree);
    shape_free(&v.mesh);
    return ok ? EXIT_SUCCESS : EXIT_INPUT;
}
