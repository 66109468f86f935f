/* animate.c: htree-animate. Film -> frame -> tree -> rays, anew for every frame; pictures and
 * checks are outside the times.
 *
 * SPDX-License-Identifier: MIT */
#include "anim_play.h"
#include "anim_shade.h"
#include "primary.h"
#include "webp_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_INPUT = 1, EXIT_USAGE = 2, CHECK_STEP = 37, SHOWN_PER_SECOND = 25 };

typedef struct animation {
    anim_args args;
    char error[512];
    film f;
    double *times;
    anim_figures *figures;
    anim_slot slots[2];
    anim_stage stage;
    anim_report report;
    picture image;
    webp_file *webp;
} animation;

static bool fail(animation *a, const char *cause) {
    snprintf(a->error, sizeof a->error, "%s", cause);
    return false;
}

/* ---- Which frames --------------------------------------------------------------------------- */

static bool plan(animation *a) {
    const anim_args *args = &a->args;
    const double from = args->has_from ? args->from : a->f.from;
    const double to = args->has_to ? args->to : a->f.to;
    const uint32_t frames = args->frames ? args->frames : a->f.frames;
    const uint32_t count = (frames - 1) / args->every + 1;
    if (!(from <= to)) return fail(a, "the film ends before it begins: see --from and --to");
    a->times = (double *)malloc(count * sizeof *a->times);
    a->figures = (anim_figures *)calloc(count, sizeof *a->figures);
    if (!a->times || !a->figures) return fail(a, "out of memory: try fewer frames");
    for (uint32_t i = 0; i < count; ++i)
        a->times[i] = frames > 1 ? from + (to - from) * (i * args->every) / (frames - 1) : from;
    a->stage.args = args;
    a->stage.f = &a->f;
    a->stage.times = a->times;
    a->stage.count = count;
    return true;
}

static bool open_all(animation *a) {
    const anim_args *args = &a->args;
    if (!film_open(&a->f, &args->film, a->error, sizeof a->error) || !plan(a)) return false;
    for (int i = 0; i < (args->pipeline ? 2 : 1); ++i)
        if (!anim_slot_make(&a->slots[i], &a->stage)) return fail(a, "out of memory");
    if (!args->output && !args->webp) return true;
    if (!picture_make(&a->image, args->width, args->height)) return fail(a, "out of memory");
    if (args->webp) a->webp = webp_open(args->width, args->height, a->error, sizeof a->error);
    return !args->webp || a->webp;
}

/* ---- One frame ------------------------------------------------------------------------------ */

static bool show(animation *a, uint32_t index) {
    const anim_args *args = &a->args;
    const anim_slot *slot = &a->slots[0];
    char path[1024];
    if (!a->image.rgb) return true;
    const htree_status status = anim_shade(&a->image, &a->f, &slot->frame, slot->tree, &slot->view,
                                           args->samples, args->threads);
    if (status != HTREE_OK)
        return fail(a, status == HTREE_ERROR_MEMORY ? "out of memory" : htree_error_text());
    if (args->output) {
        anim_file_name(path, sizeof path, args->output, index);
        if (!picture_write(&a->image, path, a->f.name, a->error, sizeof a->error)) return false;
    }
    return !a->webp || webp_add(a->webp, &a->image, (double)index / SHOWN_PER_SECOND, a->error,
                                sizeof a->error);
}

/* Adds to *seconds what the pipeline would do too, and nothing else. */
static bool play_frame(animation *a, uint32_t index, double *seconds) {
    anim_slot *slot = &a->slots[0];
    const double start = clock_seconds();
    const bool traced = anim_build(slot, &a->stage, index) && anim_trace(slot, &a->stage);
    *seconds += clock_seconds() - start;
    if (!traced || !anim_count(slot, &a->stage)) return fail(a, slot->error);
    a->figures[index] = slot->figures;
    if (a->args.check)
        anim_check(&a->report.verdict, &a->f, &slot->frame, slot->rays, slot->hits,
                   (uint64_t)a->args.width * a->args.height, CHECK_STEP);
    return show(a, index);
}

static bool play(animation *a) {
    progress bar = progress_start("frames", a->args.quiet);
    bool ok = true;
    double seconds = 0;
    for (uint32_t i = 0; ok && i < a->stage.count; ++i) {
        progress_report(&bar, (double)i / a->stage.count);
        ok = play_frame(a, i, &seconds);
    }
    progress_end(&bar);
    a->report.sequential = a->stage.count / seconds;
    return ok;
}

/* ---- The whole ------------------------------------------------------------------------------ */

static bool play_pipeline(animation *a) {
    double seconds;
    if (!a->args.pipeline) return true;
    if (!anim_pipeline(a->slots, &a->stage, &seconds))
        return fail(a, a->slots[0].error[0] ? a->slots[0].error : a->slots[1].error);
    a->report.pipeline = a->stage.count / seconds;
    return true;
}

static bool finish(animation *a) {
    anim_report *r = &a->report;
    r->args = &a->args;
    r->f = &a->f;
    r->frames = a->figures;
    r->count = a->stage.count;
    if (a->webp && !webp_write(a->webp, (double)r->count / SHOWN_PER_SECOND, a->args.webp, a->error,
                               sizeof a->error))
        return false;
    if (a->args.json && !anim_report_write(r, a->args.json, a->error, sizeof a->error))
        return false;
    if (!a->args.quiet) anim_report_print(r);
    return r->verdict.wrong == 0 || fail(a, "the tree and the test of all triangles disagree");
}

static void close_all(animation *a) {
    webp_free(a->webp);
    picture_free(&a->image);
    for (int i = 0; i < 2; ++i) anim_slot_free(&a->slots[i]);
    free(a->times);
    free(a->figures);
    film_close(&a->f);
}

int main(int argc, char **argv) {
    animation a;
    memset(&a, 0, sizeof a);
    const args_result parsed = anim_args_parse(&a.args, argc, argv);
    if (parsed != ARGS_RUN) return parsed == ARGS_DONE ? EXIT_SUCCESS : EXIT_USAGE;
    const bool ok = open_all(&a) && play(&a) && play_pipeline(&a) && finish(&a);
    if (!ok) fprintf(stderr, "htree-animate: %s\n", a.error);
    close_all(&a);
    return ok ? EXIT_SUCCESS : EXIT_INPUT;
}
