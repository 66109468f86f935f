/* anim_report.c: one list of figures serves the table, the list and the JSON. */
#include "anim_report.h"
#include "whole_file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { FIGURES = 12 };

typedef struct figure {
    const char *key;
    double value;
    int digits; /* after the point */
    const char *text;
} figure;

static void list_figures(const anim_figures *a, figure *out) {
    const figure list[FIGURES] = {
        {"N_NS", a->nodes, 0, "nodes of the tree"},
        {"N_E", a->leaves, 0, "leaves among them"},
        {"N_ER", a->references, 0, "references from leaves"},
        {"N_IT", a->intersections, 2, "triangles tested per ray"},
        {"N_TS", a->traversal_steps, 2, "nodes visited per ray"},
        {"N_ETS", a->leaf_steps, 2, "leaves visited per ray"},
        {"T_C", a->build, 4, "seconds to build the tree"},
        {"T_R", a->trace, 4, "seconds to trace one ray per pixel"},
        {"T_T", a->build + a->trace, 4, "seconds in total, T_C + T_R"},
        {"T_pose", a->pose, 4, "seconds to move the vertices, not part of T_T"},
        {"hit_fraction", a->hit_fraction, 4, "of the rays"},
        {NULL, 0, 0, NULL},
    };
    memcpy(out, list, sizeof list);
}

anim_figures anim_mean(const anim_figures *frames, uint32_t count) {
    anim_figures mean;
    memset(&mean, 0, sizeof mean);
    for (uint32_t i = 0; i < count; ++i) {
        const anim_figures *a = &frames[i];
        mean.time += a->time / count;
        mean.pose += a->pose / count;
        mean.build += a->build / count;
        mean.trace += a->trace / count;
        mean.nodes += a->nodes / count;
        mean.leaves += a->leaves / count;
        mean.references += a->references / count;
        mean.intersections += a->intersections / count;
        mean.traversal_steps += a->traversal_steps / count;
        mean.leaf_steps += a->leaf_steps / count;
        mean.hit_fraction += a->hit_fraction / count;
    }
    return mean;
}

/* ---- Text ----------------------------------------------------------------------------------- */

static void print_table(const figure *list) {
    for (const figure *f = list; f->key && f - list < 9; ++f)
        printf("%*s", f - list < 3 ? 9 : 8, f->key);
    putchar('\n');
    for (const figure *f = list; f->key && f - list < 9; ++f)
        printf("%*.*f", f - list < 3 ? 9 : 8, f->digits, f->value);
    putchar('\n');
}

void anim_report_print(const anim_report *r) {
    figure list[FIGURES];
    const anim_figures mean = anim_mean(r->frames, r->count);
    list_figures(&mean, list);
    printf("%s: %llu primitives, %s, %u frames of %ux%u, threads %u, averages per frame\n",
           r->f->name, (unsigned long long)r->f->primitives, htree_kind_name(r->args->kind),
           (unsigned)r->count, (unsigned)r->args->width, (unsigned)r->args->height,
           (unsigned)r->args->threads);
    if (r->args->stats)
        for (const figure *f = list; f->key; ++f)
            printf("%-12s %14.*f  %s\n", f->key, f->digits, f->value, f->text);
    else
        print_table(list);
    printf("frames per second, one after the other: %.2f\n", r->sequential);
    if (r->args->pipeline)
        printf("frames per second, build and trace side by side: %.2f (%.2f times)\n", r->pipeline,
               r->pipeline / r->sequential);
    if (r->args->check)
        printf("check: %llu rays, %llu hits, %llu too near to an edge to say, %llu wrong\n",
               (unsigned long long)r->verdict.rays, (unsigned long long)r->verdict.hits,
               (unsigned long long)r->verdict.edges, (unsigned long long)r->verdict.wrong);
}

/* ---- JSON ----------------------------------------------------------------------------------- */

/* Counts are exact with 15 digits; JSON has no word for infinity. */
static void write_number(FILE *file, const char *key, double value) {
    fprintf(file, isfinite(value) ? ", \"%s\": %.15g" : ", \"%s\": null", key, value);
}

/* File names may hold anything; what JSON cannot hold as it is becomes a question mark. */
static void write_name(FILE *file, const char *text) {
    for (; *text; ++text) {
        const unsigned char c = (unsigned char)*text;
        fprintf(file, c == '"' || c == '\\' ? "\\%c" : "%c", c < ' ' || c > '~' ? '?' : c);
    }
}

static void write_figures(FILE *file, const anim_figures *a) {
    figure list[FIGURES];
    list_figures(a, list);
    for (const figure *f = list; f->key; ++f) write_number(file, f->key, f->value);
}

static void write_all(FILE *file, const anim_report *r) {
    const anim_figures mean = anim_mean(r->frames, r->count);
    fputs("{\"scene\": \"", file);
    write_name(file, r->f->name);
    fprintf(file, "\", \"kind\": \"%s\"", htree_kind_name(r->args->kind));
    write_number(file, "primitives", (double)r->f->primitives);
    write_number(file, "triangles", (double)r->f->triangle_count);
    write_number(file, "objects", (double)r->f->cone_count);
    write_number(file, "frames", r->count);
    write_number(file, "width", r->args->width);
    write_number(file, "height", r->args->height);
    write_number(file, "threads", r->args->threads);
    write_figures(file, &mean);
    write_number(file, "fps_sequential", r->sequential);
    if (r->args->pipeline) write_number(file, "fps_pipeline", r->pipeline);
    if (r->args->check) {
        write_number(file, "checked", (double)r->verdict.rays);
        write_number(file, "wrong", (double)r->verdict.wrong);
    }
    fputs(",\n \"per_frame\": [", file);
    for (uint32_t i = 0; i < r->count; ++i) {
        fprintf(file, "%s\n  {\"frame\": %u", i ? "," : "", (unsigned)i);
        write_number(file, "time", r->frames[i].time);
        write_figures(file, &r->frames[i]);
        fputc('}', file);
    }
    fputs("]}\n", file);
}

bool anim_report_write(const anim_report *r, const char *path, char *error, size_t size) {
    whole_file out;
    if (!whole_file_open(&out, path, error, size)) return false;
    write_all(out.file, r);
    return whole_file_close(&out, true, error, size);
}
