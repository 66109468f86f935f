/* table.c: one list of figures serves JSON and CSV; the text keeps to the columns of the paper. */
#include "table.h"

#include "figures.h"
#include "report.h"
#include "whole_file.h"

#include <math.h>
#include <string.h>

const char *table_method_name(htree_kind kind) {
    switch (kind) {
    case HTREE_UG: return "UG";
    case HTREE_KD: return "kd-tree";
    case HTREE_BVH_MEDIAN: return "BVH-Med";
    case HTREE_BVH_SAH: return "BVH-SAH";
    case HTREE_SKD: return "SKD-tree";
    case HTREE_H: return "H-tree";
    case HTREE_AH: return "AH-tree";
    default: return htree_kind_name(kind) ? htree_kind_name(kind) : "?";
    }
}

/* ---- Text ----------------------------------------------------------------------------------- */

static void print_speedup(FILE *out, double x) {
    if (isnan(x))
        fprintf(out, " %7s", "-");
    else
        fprintf(out, " %7.2f", x);
}

static void print_row(FILE *out, const measure_row *row) {
    const htree_stats *s = &row->stats;
    fprintf(out, "%-9s %9.1f %9.1f %9.1f %8.2f %7.2f %7.2f %8.4f %8.4f %8.4f",
            table_method_name(row->way.kind), (double)s->nodes / 1e3, (double)s->leaves / 1e3,
            (double)s->references / 1e3, row->intersections, row->traversal_steps, row->leaf_steps,
            row->build, row->trace, row->build + row->trace);
    print_speedup(out, row->build_speedup);
    print_speedup(out, row->trace_speedup);
    print_speedup(out, row->total_speedup);
    fputc('\n', out);
}

static void print_paper_row(FILE *out, const paper_row *row) {
    fprintf(out, "%9s %9.1f %9.1f %9.1f %8.2f %7.2f %7.2f %8.2f %8.2f %8.2f %7.2f %7.2f %7.2f\n",
            "paper", row->nodes, row->leaves, row->references, row->intersections,
            row->traversal_steps, row->leaf_steps, row->build, row->trace, row->total,
            row->build_speedup, row->trace_speedup, row->total_speedup);
}

void table_print_block(FILE *out, const table_block *block) {
    char count[32], papers[32];
    fprintf(out, "\nScene %s - %s triangles, %ux%u pixels - %s: %s\n", block->name,
            figures_commas(count, sizeof count, block->triangles), block->width, block->height,
            block->label, block->note);
    if (block->paper)
        fprintf(out, "  rows \"paper\": %s, %s triangles, %ux%u pixels\n", block->paper->name,
                figures_commas(papers, sizeof papers, block->paper->primitives),
                block->paper->width, block->paper->height);
    fprintf(out, "%-9s %9s %9s %9s %8s %7s %7s %8s %8s %8s %7s %7s %7s\n", "Method", "N_NS[k]",
            "N_E[k]", "N_ER[k]", "N_IT", "N_TS", "N_ETS", "T_C[s]", "T_R[s]", "T_T[s]", "s(T_C)",
            "s(T_R)", "s(T_T)");
    for (uint32_t i = 0; i < block->row_count; ++i) {
        const paper_row *paper = paper_find_row(block->paper, block->rows[i].way.kind);
        print_row(out, &block->rows[i]);
        if (paper) print_paper_row(out, paper);
    }
}

/* ---- Averages ------------------------------------------------------------------------------- */

static double speedup(const measure_row *row, int which) {
    return which == 0 ? row->build_speedup : which == 1 ? row->trace_speedup : row->total_speedup;
}

static void print_average(FILE *out, const table_block *blocks, uint32_t count, uint32_t row,
                          int which) {
    double sum = 0, lo = INFINITY, hi = -INFINITY;
    for (uint32_t i = 0; i < count; ++i) {
        const double x = speedup(&blocks[i].rows[row], which);
        sum += x;
        lo = fmin(lo, x);
        hi = fmax(hi, x);
    }
    fprintf(out, "  %7.2f (%6.2f ..%6.2f)", sum / count, lo, hi);
}

void table_print_averages(FILE *out, const table_block *blocks, uint32_t count) {
    if (!count || isnan(blocks[0].rows[0].build_speedup)) return;
    fprintf(out, "\nSpeed-ups over %u scenes: mean (least .. greatest)\n%-9s  %-25s  %-25s  %s\n",
            count, "Method", "s(T_C)", "s(T_R)", "s(T_T)");
    for (uint32_t row = 0; row < blocks[0].row_count; ++row) {
        fprintf(out, "%-9s", table_method_name(blocks[0].rows[row].way.kind));
        for (int which = 0; which < 3; ++which) print_average(out, blocks, count, row, which);
        fputc('\n', out);
    }
}

/* ---- Files ---------------------------------------------------------------------------------- */

enum { FIGURE_COUNT = 18 };

typedef struct figure {
    const char *key;
    double value;
} figure;

static void list_figures(const table_block *block, const measure_row *row, figure *out) {
    const htree_stats *s = &row->stats;
    const figure list[FIGURE_COUNT] = {
        {"triangles", (double)block->triangles},
        {"threads", block->threads},
        {"hit_fraction", row->hit_fraction},
        {"N_NS", (double)s->nodes},
        {"N_E", (double)s->leaves},
        {"N_ER", (double)s->references},
        {"N_IT", row->intersections},
        {"N_TS", row->traversal_steps},
        {"N_ETS", row->leaf_steps},
        {"T_C", row->build},
        {"T_R", row->trace},
        {"T_T", row->build + row->trace},
        {"depth", s->depth},
        {"bytes", (double)s->bytes},
        {"sah_cost", s->sah_cost},
        {"s_T_C", row->build_speedup},
        {"s_T_R", row->trace_speedup},
        {"s_T_T", row->total_speedup},
    };
    memcpy(out, list, sizeof list);
}

static void write_json_row(FILE *file, const table_block *block, const measure_row *row) {
    figure figures[FIGURE_COUNT];
    list_figures(block, row, figures);
    fputs("{\"scene\": ", file);
    report_write_string(file, block->name);
    fprintf(file, ", \"kind\": \"%s\", \"label\": \"%s\"", htree_kind_name(row->way.kind),
            block->label);
    for (int i = 0; i < FIGURE_COUNT; ++i) {
        fprintf(file, ", \"%s\": ", figures[i].key);
        fprintf(file, isfinite(figures[i].value) ? "%.15g" : "null", figures[i].value);
    }
    fputc('}', file);
}

bool table_write_json(const table_block *blocks, uint32_t count, const char *machine,
                      const char *command, const char *path, char *error, size_t size) {
    whole_file out;
    bool first = true;
    if (!whole_file_open(&out, path, error, size)) return false;
    fputs("{\"machine\": ", out.file);
    report_write_string(out.file, machine);
    fputs(",\n \"command\": ", out.file);
    report_write_string(out.file, command);
    fputs(",\n \"rows\": [", out.file);
    for (uint32_t i = 0; i < count; ++i) {
        for (uint32_t k = 0; k < blocks[i].row_count; ++k) {
            fputs(first ? "\n  " : ",\n  ", out.file);
            write_json_row(out.file, &blocks[i], &blocks[i].rows[k]);
            first = false;
        }
    }
    fputs("]}\n", out.file);
    return whole_file_close(&out, true, error, size);
}

/* Names may hold commas and quotes. */
static void write_csv_string(FILE *file, const char *text) {
    fputc('"', file);
    for (; *text; ++text) {
        if (*text == '"') fputc('"', file);
        fputc(*text, file);
    }
    fputc('"', file);
}

bool table_write_csv(const table_block *blocks, uint32_t count, const char *path, char *error,
                     size_t size) {
    figure figures[FIGURE_COUNT];
    whole_file out;
    if (!whole_file_open(&out, path, error, size)) return false;
    for (uint32_t i = 0; i < count; ++i) {
        for (uint32_t k = 0; k < blocks[i].row_count; ++k) {
            const measure_row *row = &blocks[i].rows[k];
            list_figures(&blocks[i], row, figures);
            if (i + k == 0) {
                fputs("scene,kind,label", out.file);
                for (int f = 0; f < FIGURE_COUNT; ++f) fprintf(out.file, ",%s", figures[f].key);
                fputc('\n', out.file);
            }
            write_csv_string(out.file, blocks[i].name);
            fprintf(out.file, ",%s,%s", htree_kind_name(row->way.kind), blocks[i].label);
            for (int f = 0; f < FIGURE_COUNT; ++f)
                fprintf(out.file, isfinite(figures[f].value) ? ",%.15g" : ",", figures[f].value);
            fputc('\n', out.file);
        }
    }
    return whole_file_close(&out, true, error, size);
}
