/* table1.c: htree-table1. The paper's Table 1 with today's figures, and two studies beside it:
 * growth with the number of triangles, and precision of the splits. What is known is printed and
 * written when a scene is done.
 *
 * SPDX-License-Identifier: MIT */
#include "growth.h"
#include "machine.h"
#include "table.h"
#include "table1_args.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_INPUT = 1, EXIT_USAGE = 2 };

typedef struct table1 {
    table1_args args;
    char machine[256], command[512], error[512];
    table_block *blocks;
    uint32_t block_count;
} table1;

static bool fail_status(table1 *t, htree_status status) {
    const char *text = htree_error_text();
    const bool own = status == HTREE_ERROR_MEMORY || !*text;
    snprintf(t->error, sizeof t->error, "%s", own ? "out of memory: try smaller scenes" : text);
    return false;
}

static void print_head(const table1 *t) {
    const table1_args *args = &t->args;
    printf("# machine: %s\n# command: %s\n# medians of %u, %u thread%s, libhtree %d.%d.%d\n",
           t->machine, t->command, args->repeat, args->threads, args->threads == 1 ? "" : "s",
           HTREE_VERSION_MAJOR, HTREE_VERSION_MINOR, HTREE_VERSION_PATCH);
    fflush(stdout);
}

static measure_job make_job(const table1_args *args, const bench_scene *scene) {
    measure_job job;
    memset(&job, 0, sizeof job);
    job.mesh = &scene->mesh;
    job.width = args->width;
    job.height = args->height;
    job.view = camera_place(&scene->camera, &scene->mesh, args->width, args->height);
    job.threads = args->threads;
    job.repeat = args->repeat;
    job.label = scene->name;
    job.quiet = args->quiet;
    return job;
}

/* ---- The table ------------------------------------------------------------------------------ */

/* One answer: if the structures disagree about a single hit, their times mean nothing. */
static bool same_answers(table1 *t, const table_block *block) {
    for (uint32_t i = 1; i < block->row_count; ++i) {
        if (block->rows[i].answer == block->rows[0].answer) continue;
        snprintf(t->error, sizeof t->error, "%s: the hits of %s differ from those of %s",
                 block->name, htree_kind_name(block->rows[i].way.kind),
                 htree_kind_name(block->rows[0].way.kind));
        return false;
    }
    return true;
}

static bool fill_block(table1 *t, table_block *block, const bench_scene *scene) {
    const table1_args *args = &t->args;
    const measure_job job = make_job(args, scene);
    measure_way ways[TABLE_MAX_WAYS];
    memset(ways, 0, sizeof ways);
    for (uint32_t i = 0; i < args->kind_count; ++i) ways[i].kind = args->kinds[i];
    snprintf(block->name, sizeof block->name, "%s", scene->name);
    snprintf(block->note, sizeof block->note, "%s", scene->note);
    block->label = scene->label;
    block->paper = scene->paper;
    block->triangles = scene->mesh.triangle_count;
    block->width = args->width;
    block->height = args->height;
    block->threads = args->threads;
    block->row_count = args->kind_count;
    const htree_status status = measure_run(&job, ways, args->kind_count, block->rows);
    if (status != HTREE_OK) return fail_status(t, status);
    return same_answers(t, block);
}

static bool open_scene(table1 *t, uint32_t index, bench_scene *scene) {
    const table1_args *args = &t->args;
    return bench_scene_open(scene, &args->scenes[index], args->folder, args->levels, &args->camera,
                            t->error, sizeof t->error);
}

/* Written anew after every scene: a path that cannot be written fails early, and a run that is
 * stopped keeps what it has. */
static bool write_files(table1 *t) {
    const table1_args *args = &t->args;
    return (!args->json || table_write_json(t->blocks, t->block_count, t->machine, t->command,
                                            args->json, t->error, sizeof t->error)) &&
           (!args->csv ||
            table_write_csv(t->blocks, t->block_count, args->csv, t->error, sizeof t->error));
}

static bool run_table(table1 *t) {
    const table1_args *args = &t->args;
    t->blocks = (table_block *)calloc(args->scene_count, sizeof *t->blocks);
    if (!t->blocks) return fail_status(t, HTREE_ERROR_MEMORY);
    for (uint32_t i = 0; i < args->scene_count; ++i) {
        bench_scene scene;
        if (!open_scene(t, i, &scene)) return false;
        const bool ok = fill_block(t, &t->blocks[i], &scene);
        shape_free(&scene.mesh);
        if (!ok) return false;
        table_print_block(stdout, &t->blocks[t->block_count++]);
        fflush(stdout);
        if (!write_files(t)) return false;
    }
    if (t->block_count > 1) table_print_averages(stdout, t->blocks, t->block_count);
    return true;
}

/* ---- The studies ---------------------------------------------------------------------------- */

static bool run_growth(table1 *t) {
    const table1_args *args = &t->args;
    for (uint32_t i = 0; i < args->scene_count; ++i) {
        growth_job job;
        memset(&job, 0, sizeof job);
        job.scene = args->scenes[i].name;
        job.from = args->from;
        job.to = args->to;
        job.kinds = args->kinds;
        job.kind_count = args->kind_count;
        job.threads = args->threads;
        job.repeat = args->repeat;
        job.patience = args->patience;
        job.quiet = args->quiet;
        const htree_status status = growth_print(stdout, &job);
        if (status != HTREE_OK) return fail_status(t, status);
    }
    return true;
}

static bool run_precision(table1 *t) {
    for (uint32_t i = 0; i < t->args.scene_count; ++i) {
        bench_scene scene;
        if (!open_scene(t, i, &scene)) return false;
        const measure_job job = make_job(&t->args, &scene);
        const htree_status status = precision_print(stdout, &job, scene.name);
        shape_free(&scene.mesh);
        if (status != HTREE_OK) return fail_status(t, status);
    }
    return true;
}

int main(int argc, char **argv) {
    static table1 t;
    const args_result parsed = table1_args_parse(&t.args, argc, argv);
    if (parsed != ARGS_RUN) return parsed == ARGS_DONE ? EXIT_SUCCESS : EXIT_USAGE;
    machine_describe(t.machine, sizeof t.machine);
    machine_command(t.command, sizeof t.command, argc, argv);
    print_head(&t);
    const bool ok = t.args.mode == TABLE1_GROWTH      ? run_growth(&t)
                    : t.args.mode == TABLE1_PRECISION ? run_precision(&t)
                                                      : run_table(&t);
    const bool shown = fflush(stdout) == 0 && !ferror(stdout);
    if (!ok) fprintf(stderr, "htree-table1: %s\n", t.error);
    if (!shown) fputs("htree-table1: cannot write to the standard output\n", stderr);
    free(t.blocks);
    return ok && shown ? EXIT_SUCCESS : EXIT_INPUT;
}
