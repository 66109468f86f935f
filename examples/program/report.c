/* report.c: one list of figures serves the table and the JSON, so that both always agree. */
#include "report.h"
#include "whole_file.h"

#include <math.h>
#include <string.h>

enum { FIGURE_COUNT = 16 };

typedef struct figure {
    const char *key;
    double value;
    int digits; /* after the point in the table */
    const char *text;
} figure;

static void list_figures(const report *r, figure *out) {
    const htree_stats *s = &r->stats;
    const primary *p = r->rays;
    const double traced = p->seconds, built = s->build_seconds;
    const figure list[FIGURE_COUNT] = {
        {"triangles", (double)s->triangles, 0, "in the mesh"},
        {"threads", r->threads, 0, "for building and for rays"},
        {"hit_fraction", p->hit_fraction, 4, "of the primary rays, one per pixel"},
        {"N_NS", (double)s->nodes, 0, "nodes of the tree"},
        {"N_E", (double)s->leaves, 0, "leaves among them"},
        {"N_ER", (double)s->references, 0, "references from leaves to triangles"},
        {"N_IT", p->intersections, 3, "triangles tested per ray"},
        {"N_TS", p->traversal_steps, 3, "nodes visited per ray"},
        {"N_ETS", p->leaf_steps, 3, "leaves visited per ray"},
        {"T_C", built, 4, "seconds to build"},
        {"T_R", traced, 4, "seconds to trace the primary rays, median of 3"},
        {"T_T", built + traced, 4, "seconds in total, T_C + T_R"},
        {"depth", s->depth, 0, "nodes on the longest way to a leaf"},
        {"bytes", (double)s->bytes, 0, "of memory for the tree, geometry included"},
        {"sah_cost", s->sah_cost, 3, "expected cost of a random ray"},
        {NULL, 0, 0, NULL},
    };
    memcpy(out, list, sizeof list);
}

void report_print(const report *r) {
    figure figures[FIGURE_COUNT];
    list_figures(r, figures);
    printf("%-12s %14s\n%-12s %14s\n", "scene", r->scene, "kind", htree_kind_name(r->stats.kind));
    if (r->device) printf("%-12s %s\n", "device", r->device);
    for (const figure *f = figures; f->key; ++f)
        printf("%-12s %14.*f  %s\n", f->key, f->digits, f->value, f->text);
    if (r->stats.invalid || r->stats.degenerate)
        printf("note: skipped %llu triangles with bad numbers and %llu without area\n",
               (unsigned long long)r->stats.invalid, (unsigned long long)r->stats.degenerate);
}

void report_write_string(FILE *file, const char *text) {
    fputc('"', file);
    for (; *text; ++text) {
        const unsigned char c = (unsigned char)*text;
        if (c < ' ')
            fprintf(file, "\\u%04x", c);
        else
            fprintf(file, c == '"' || c == '\\' ? "\\%c" : "%c", c);
    }
    fputc('"', file);
}

bool report_write_json(const report *r, const char *path, char *error, size_t size) {
    figure figures[FIGURE_COUNT];
    list_figures(r, figures);
    whole_file out;
    if (!whole_file_open(&out, path, error, size)) return false;
    fputs("{\"scene\": ", out.file);
    report_write_string(out.file, r->scene);
    fprintf(out.file, ",\n \"kind\": \"%s\"", htree_kind_name(r->stats.kind));
    if (r->device) {
        fputs(",\n \"device\": ", out.file);
        report_write_string(out.file, r->device);
    }
    for (const figure *f = figures; f->key; ++f) {
        /* 15 digits keep every count exact; JSON has no word for infinity. */
        fprintf(out.file, ",\n \"%s\": ", f->key);
        fprintf(out.file, isfinite(f->value) ? "%.15g" : "null", f->value);
    }
    fputs("}\n", out.file);
    return whole_file_close(&out, true, error, size);
}
