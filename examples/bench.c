/* bench.c: htree-bench. Builds and rays of the structures on the CPU, on an OpenCL device and beside
 * another ray tracer, over the same rays. What is known is printed and written when a scene is done.
 *
 * SPDX-License-Identifier: MIT */
#include "bench_args.h"
#include "cores.h"
#include "device.h"
#include "duel_table.h"
#include "machine.h"
#include "ratios.h"
#include "report.h"
#include "whole_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_INPUT = 1, EXIT_USAGE = 2 };

typedef struct bench {
    bench_args args;
    char machine[256], command[512], cores[64], device_text[320], error[512];
    struct htree_cl *device; /* NULL: none */
    bench_rows rows;         /* so far */
    duel fight;
} bench;

static void print_head(const bench *b) {
    const bench_args *args = &b->args;
    printf("# machine: %s\n# command: %s\n# %s; medians of %u round%s of at least %g s a "
           "contender, in turn; libhtree %d.%d.%d\n",
           b->machine, b->command, b->cores, args->rounds, args->rounds == 1 ? "" : "s",
           args->seconds, HTREE_VERSION_MAJOR, HTREE_VERSION_MINOR, HTREE_VERSION_PATCH);
    if (b->device) printf("# device: %s\n", b->device_text);
    fflush(stdout);
}

/* The peers say who they are when they have been opened. */
static void print_peers(const bench *b) {
    for (uint32_t i = 0; i < b->args.peer_count; ++i)
        printf("# embree-%s: %s\n", b->args.peers[i].name, b->fight.peer_text[i]);
}

static bool open_device(bench *b) {
    const char *const pocl = getenv("POCL_MAX_PTHREAD_COUNT");
    if (!b->args.device) return true;
    b->device = device_open(b->args.device, b->error, sizeof b->error);
    if (!b->device) return false;
    device_describe(b->device, b->device_text, sizeof b->device_text);
    const size_t used = strlen(b->device_text);
    if (strstr(b->device_text, "Portable Computing Language") && pocl)
        snprintf(b->device_text + used, sizeof b->device_text - used, ", POCL_MAX_PTHREAD_COUNT=%s",
                 pocl);
    return true;
}

/* ---- JSON ----------------------------------------------------------------------------------- */

/* Written before the first scene, so that a path that cannot be written fails early, and anew after
 * every scene. */
static bool write_json(bench *b) {
    whole_file out;
    if (!b->args.json) return true;
    if (!whole_file_open(&out, b->args.json, b->error, sizeof b->error)) return false;
    fputs("{\"machine\": ", out.file);
    report_write_string(out.file, b->machine);
    fputs(",\n \"command\": ", out.file);
    report_write_string(out.file, b->command);
    fputs(",\n \"device\": ", out.file);
    report_write_string(out.file, b->device_text);
    fputs(",\n \"rows\": [", out.file);
    rows_write(out.file, &b->rows);
    fputs("]}\n", out.file);
    return whole_file_close(&out, true, b->error, sizeof b->error);
}

/* ---- Scenes --------------------------------------------------------------------------------- */

static duel_job make_job(const bench *b, const bench_scene *scene, uint32_t threads) {
    const bench_args *args = &b->args;
    duel_job job;
    memset(&job, 0, sizeof job);
    job.mesh = &scene->mesh;
    job.view = &scene->camera;
    job.wish = args->wish;
    job.load_rays = args->load_rays;
    job.save_rays = args->save_rays;
    job.trees = args->trees;
    job.tree_count = args->tree_count;
    job.device = b->device;
    job.peers = args->peers;
    job.peer_count = args->peer_count;
    job.threads = threads;
    job.rounds = args->rounds;
    job.seconds = args->seconds;
    job.label = scene->name;
    job.quiet = args->quiet;
    return job;
}

static bool keep_rows(bench *b, const bench_scene *scene, uint32_t threads) {
    return rows_add(&b->rows, &b->fight, scene->name, scene->mesh.triangle_count, threads) ||
           (snprintf(b->error, sizeof b->error, "out of memory"), false);
}

static bool run_duel(bench *b, const bench_scene *scene, uint32_t threads) {
    const duel_job job = make_job(b, scene, threads);
    const duel_title title = {scene->name, scene->note, scene->mesh.triangle_count, threads,
                              b->args.wish.seed};
    const bool first = b->rows.count == 0;
    bool ok = duel_run(&b->fight, &job, b->error, sizeof b->error);
    if (ok) {
        if (first) print_peers(b);
        duel_print(stdout, &b->fight, &title);
        ok = keep_rows(b, scene, threads) && write_json(b) &&
             duel_agrees(&b->fight, b->error, sizeof b->error);
    }
    if (ok) {
        const char *also = !b->device                ? ""
                           : device_exact(b->device) ? " and of the device"
                                                     : ", and t of the device within 2^-16";
        printf("\nEqual answers: every byte of every structure%s, in every round.\n", also);
    }
    fflush(stdout);
    duel_end(&b->fight);
    return ok;
}

static bool run_scenes(bench *b) {
    const bench_args *args = &b->args;
    for (uint32_t i = 0; i < args->scene_count; ++i) {
        bench_scene scene;
        bool ok =
            bench_scene_open(&scene, &args->scenes[i], args->folder, 0,
                             args->has_camera ? &args->camera : NULL, b->error, sizeof b->error);
        if (!ok) return false;
        for (uint32_t k = 0; ok && k < args->thread_count; ++k)
            ok = run_duel(b, &scene, args->threads[k]);
        shape_free(&scene.mesh);
        if (!ok) return false;
    }
    ratios_print(stdout, &b->rows);
    return true;
}

static int list_devices(void) {
    char error[512];
    if (device_list(stdout, error, sizeof error)) return EXIT_SUCCESS;
    fprintf(stderr, "htree-bench: %s\n", error);
    return EXIT_INPUT;
}

int main(int argc, char **argv) {
    static bench b;
    const args_result parsed = bench_args_parse(&b.args, argc, argv);
    if (parsed != ARGS_RUN) return parsed == ARGS_DONE ? EXIT_SUCCESS : EXIT_USAGE;
    if (b.args.list_devices) return list_devices();
    machine_describe(b.machine, sizeof b.machine);
    machine_command(b.command, sizeof b.command, argc, argv);
    cores_take(b.args.most_threads, b.cores, sizeof b.cores);
    bool ok = open_device(&b) && write_json(&b);
    if (ok) {
        print_head(&b);
        ok = run_scenes(&b);
    }
    const bool shown = fflush(stdout) == 0 && !ferror(stdout);
    if (!ok) fprintf(stderr, "htree-bench: %s\n", b.error);
    if (!shown) fputs("htree-bench: cannot write to the standard output\n", stderr);
    device_close(b.device);
    free(b.rows.all);
    return ok && shown ? EXIT_SUCCESS : EXIT_INPUT;
}
