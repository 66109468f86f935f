#include "rows.h"

#include "report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double mrays(const duel *d, const contender *c, ray_set_name name) {
    const bool any = d->sets[name].count && c->rows[name].seconds > 0;
    return any ? 1e-6 * (double)d->sets[name].count / c->rows[name].seconds : (double)NAN;
}

static double disagreements(const contender *c) {
    double sum = 0;
    for (int name = 0; name < RAY_SETS; ++name) sum += (double)c->rows[name].differ;
    for (int way = 0; way < BUILD_WAYS; ++way) sum += (double)c->update_differ[way];
    return sum;
}

static void add_builds(bench_row *row, const contender *c) {
    const double n = (double)row->triangles;
    row->figures[FIGURE_FRESH] = 1e9 * c->build_seconds[BUILD_FRESH] / n;
    row->figures[FIGURE_WARM] = 1e9 * c->build_seconds[BUILD_WARM] / n;
    row->figures[FIGURE_REFIT] = 1e9 * c->build_seconds[BUILD_REFIT] / n;
    row->figures[FIGURE_BYTES] = c->bytes ? (double)c->bytes / n : (double)NAN;
    row->figures[FIGURE_PEAK] = c->peak ? (double)c->peak / n : (double)NAN;
    row->figures[FIGURE_TOTAL] = row->figures[FIGURE_TOTAL_SINGLE] =
        1e3 * c->frame_seconds[BUILD_FRESH];
    row->figures[FIGURE_TOTAL_WARM] = 1e3 * c->frame_seconds[BUILD_WARM];
}

/* fmin takes the number where one of two is none. */
static void add_packets(bench_row *row, const duel *d, const contender *packets) {
    double *f = row->figures;
    f[FIGURE_PACKET] = mrays(d, packets, RAYS_PRIMARY);
    f[FIGURE_TOTAL_PACKET] = 1e3 * packets->frame_seconds[BUILD_FRESH];
    f[FIGURE_TOTAL] = fmin(f[FIGURE_TOTAL], f[FIGURE_TOTAL_PACKET]);
    f[FIGURE_TOTAL_WARM] = fmin(f[FIGURE_TOTAL_WARM], 1e3 * packets->frame_seconds[BUILD_WARM]);
    f[FIGURE_DISAGREE] += disagreements(packets);
}

static void fill(bench_row *row, const duel *d, const contender *c) {
    for (int i = 0; i < FIGURES; ++i) row->figures[i] = (double)NAN;
    row->peer = c->other != NULL;
    snprintf(row->config, sizeof row->config, "%s", row->peer ? c->by_peer.name : c->name);
    add_builds(row, c);
    row->figures[FIGURE_PRIMARY] = mrays(d, c, RAYS_PRIMARY);
    row->figures[FIGURE_FRAME] = mrays(d, c, RAYS_FRAME);
    row->figures[FIGURE_AMBIENT] = mrays(d, c, RAYS_AMBIENT);
    row->figures[FIGURE_DIFFUSE] = mrays(d, c, RAYS_DIFFUSE);
    row->figures[FIGURE_SHADOW] = mrays(d, c, RAYS_SHADOW);
    row->figures[FIGURE_DISAGREE] = disagreements(c);
    if (c->place == PLACE_DEVICE) {
        row->figures[FIGURE_UPLOAD] = c->upload_seconds;
        row->figures[FIGURE_COMPILE] = c->compile_seconds;
    }
}

bool rows_add(bench_rows *rows, const duel *d, const char *scene, uint64_t triangles,
              uint32_t threads) {
    const size_t most = (size_t)rows->count + d->count;
    bench_row *more = (bench_row *)realloc(rows->all, (most + 1) * sizeof *more);
    if (!more) return false;
    rows->all = more;
    for (uint32_t i = 0; i < d->count; ++i) {
        const contender *c = &d->all[i];
        if (c->place == PLACE_PACKET) {
            add_packets(&more[rows->count - 1], d, c);
            continue;
        }
        bench_row *row = &more[rows->count++];
        memset(row, 0, sizeof *row);
        snprintf(row->scene, sizeof row->scene, "%s", scene);
        row->triangles = triangles;
        row->threads = threads;
        fill(row, d, c);
    }
    return true;
}

/* ---- Writing -------------------------------------------------------------------------------- */

void rows_write(FILE *file, const bench_rows *rows) {
    static const char *const keys[FIGURES] = {"ns_per_triangle",
                                              "warm_ns_per_triangle",
                                              "refit_ns_per_triangle",
                                              "bytes_per_triangle",
                                              "peak_bytes_per_triangle",
                                              "mrays_primary",
                                              "mrays_primary_packet",
                                              "mrays_frame",
                                              "mrays_ao",
                                              "mrays_diffuse",
                                              "mrays_shadow",
                                              "T_T_ms",
                                              "T_T_single_ms",
                                              "T_T_packet_ms",
                                              "T_T_warm_ms",
                                              "upload_seconds",
                                              "compile_seconds",
                                              "disagreements"};
    for (uint32_t i = 0; i < rows->count; ++i) {
        const bench_row *row = &rows->all[i];
        fputs(i ? ",\n  {\"scene\": " : "\n  {\"scene\": ", file);
        report_write_string(file, row->scene);
        fprintf(file, ", \"peer\": \"%s\", \"config\": ", row->peer ? "embree" : "htree");
        report_write_string(file, row->config);
        fprintf(file, ", \"threads\": %u, \"triangles\": %llu", row->threads,
                (unsigned long long)row->triangles);
        for (int k = 0; k < FIGURES; ++k) {
            fprintf(file, ", \"%s\": ", keys[k]);
            fprintf(file, isfinite(row->figures[k]) ? "%.15g" : "null", row->figures[k]);
        }
        fputc('}', file);
    }
}

void rows_print_number(FILE *out, int width, int digits, double x) {
    if (isfinite(x))
        fprintf(out, " %*.*f", width, digits, x);
    else
        fprintf(out, " %*s", width, "-");
}
