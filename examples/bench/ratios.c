#include "ratios.h"

#include "bench_args.h"

#include <math.h>
#include <string.h>

/* Of one side: the figure of a row, or the best of all rows. */
typedef struct side {
    const char *config; /* NULL: any */
    figure of;
} side;

typedef struct comparison {
    const char *text;
    side ours, theirs;
    bool less; /* less is better */
} comparison;

static const comparison comparisons[] = {
    {"fast / LOW, fresh build", {"fast", FIGURE_FRESH}, {"low", FIGURE_FRESH}, true},
    {"fast / LOW, warm build", {"fast", FIGURE_WARM}, {"low", FIGURE_WARM}, true},
    {"fast / LOW, diffuse", {"fast", FIGURE_DIFFUSE}, {"low", FIGURE_DIFFUSE}, false},
    {"balanced / MEDIUM, fresh build", {"balanced", FIGURE_FRESH}, {"medium", FIGURE_FRESH}, true},
    {"balanced / MEDIUM, warm build", {"balanced", FIGURE_WARM}, {"medium", FIGURE_WARM}, true},
    {"balanced / MEDIUM, diffuse", {"balanced", FIGURE_DIFFUSE}, {"medium", FIGURE_DIFFUSE}, false},
    {"best / HIGH, diffuse", {"best", FIGURE_DIFFUSE}, {"high", FIGURE_DIFFUSE}, false},
    {"best / HIGH, ambient", {"best", FIGURE_AMBIENT}, {"high", FIGURE_AMBIENT}, false},
    {"best / HIGH, shadow", {"best", FIGURE_SHADOW}, {"high", FIGURE_SHADOW}, false},
    {"best / HIGH, primary", {"best", FIGURE_PRIMARY}, {"high", FIGURE_PRIMARY}, false},
    {"best / MEDIUM x16, primary", {"best", FIGURE_PRIMARY}, {"medium", FIGURE_PACKET}, false},
    {"T_T, fresh, best of each", {NULL, FIGURE_TOTAL}, {NULL, FIGURE_TOTAL}, true},
    {"T_T, warm, best of each", {NULL, FIGURE_TOTAL_WARM}, {NULL, FIGURE_TOTAL_WARM}, true},
    {"refit, best of each", {NULL, FIGURE_REFIT}, {NULL, FIGURE_REFIT}, true},
    {"balanced / MEDIUM, bytes", {"balanced", FIGURE_BYTES}, {"medium", FIGURE_BYTES}, true},
    {"balanced+compact / MEDIUM compact, bytes",
     {"balanced+compact", FIGURE_BYTES},
     {"medium-compact", FIGURE_BYTES},
     true},
    {"balanced / MEDIUM, peak bytes", {"balanced", FIGURE_PEAK}, {"medium", FIGURE_PEAK}, true},
};

static const comparison gains[] = {
    {"fast, fresh build", {"fast", FIGURE_FRESH}, {"fast", FIGURE_FRESH}, true},
    {"fast, warm build", {"fast", FIGURE_WARM}, {"fast", FIGURE_WARM}, true},
    {"balanced, fresh build", {"balanced", FIGURE_FRESH}, {"balanced", FIGURE_FRESH}, true},
    {"balanced, warm build", {"balanced", FIGURE_WARM}, {"balanced", FIGURE_WARM}, true},
    {"best, primary", {"best", FIGURE_PRIMARY}, {"best", FIGURE_PRIMARY}, false},
    {"best, ambient", {"best", FIGURE_AMBIENT}, {"best", FIGURE_AMBIENT}, false},
    {"best, diffuse", {"best", FIGURE_DIFFUSE}, {"best", FIGURE_DIFFUSE}, false},
};

enum {
    COMPARISONS = sizeof comparisons / sizeof *comparisons,
    GAINS = sizeof gains / sizeof *gains
};

/* ---- Finding figures ------------------------------------------------------------------------ */

/* Whose rows count. */
typedef struct choice {
    bool peer, robust;
    uint32_t threads;
} choice;

static bool suits(const bench_row *row, const choice *by, const char *config) {
    const size_t length = strlen(row->config);
    const char *tail = "-robust";
    const bool robust = length > 7 && strcmp(row->config + length - 7, tail) == 0;
    if (row->peer != by->peer || row->threads != by->threads || robust != by->robust) return false;
    const size_t name = robust ? length - 7 : length;
    return !config || (strlen(config) == name && strncmp(config, row->config, name) == 0);
}

/* NaN if no row has it. */
static double find(const bench_rows *rows, const char *scene, const choice *by, const side *which,
                   bool less) {
    double best = (double)NAN;
    for (uint32_t i = 0; i < rows->count; ++i) {
        const bench_row *row = &rows->all[i];
        const double x = row->figures[which->of];
        if (strcmp(row->scene, scene) != 0 || !suits(row, by, which->config)) continue;
        best = less ? fmin(best, x) : fmax(best, x);
    }
    return best;
}

/* ---- Tables --------------------------------------------------------------------------------- */

/* The scene of row i, if no row before has it. */
static const char *new_scene(const bench_rows *rows, uint32_t i) {
    for (uint32_t k = 0; k < i; ++k)
        if (strcmp(rows->all[k].scene, rows->all[i].scene) == 0) return NULL;
    return rows->all[i].scene;
}

/* Of both sides, for a scene. */
typedef struct match {
    const bench_rows *rows;
    choice ours, theirs;
} match;

/* Above 1: ours is better. NaN without both figures. */
static double ratio_of(const match *m, const comparison *c, const char *scene) {
    const double a = find(m->rows, scene, &m->ours, &c->ours, c->less);
    const double b = find(m->rows, scene, &m->theirs, &c->theirs, c->less);
    const double ratio = c->less ? b / a : a / b;
    return ratio > 0 && ratio < INFINITY ? ratio : (double)NAN;
}

/* Nothing if there is no ratio for any scene. */
static void print_line(FILE *out, const match *m, const comparison *c) {
    double ratios[BENCH_MAX_SCENES], sum = 0, least = INFINITY;
    uint32_t scenes = 0, count = 0;
    for (uint32_t i = 0; i < m->rows->count; ++i) {
        const char *scene = new_scene(m->rows, i);
        if (!scene) continue;
        const double ratio = ratios[scenes++] = ratio_of(m, c, scene);
        if (isnan(ratio)) continue;
        sum += log(ratio);
        least = fmin(least, ratio);
        ++count;
    }
    if (!count) return;
    fprintf(out, "%-42s", c->text);
    for (uint32_t i = 0; i < scenes; ++i) rows_print_number(out, 12, 2, ratios[i]);
    rows_print_number(out, 8, 2, exp(sum / count));
    rows_print_number(out, 8, 2, least);
    fputc('\n', out);
}

/* Names of scenes without the ends of files. */
static void print_table(FILE *out, const match *m, const comparison *all, int count) {
    fprintf(out, "%-42s", "better by a factor of");
    for (uint32_t i = 0; i < m->rows->count; ++i) {
        const char *scene = new_scene(m->rows, i);
        const size_t length = scene ? strcspn(scene, ".") : 0;
        if (scene) fprintf(out, " %12.*s", (int)(length < 12 ? length : 12), scene);
    }
    fprintf(out, " %8s %8s\n", "geomean", "least");
    for (int i = 0; i < count; ++i) print_line(out, m, &all[i]);
}

static bool exists(const bench_rows *rows, const choice *by) {
    for (uint32_t i = 0; i < rows->count; ++i)
        if (suits(&rows->all[i], by, NULL)) return true;
    return false;
}

static void print_peers(FILE *out, const bench_rows *rows, uint32_t threads) {
    for (int robust = 0; robust < 2; ++robust) {
        const match m = {rows, {false, false, threads}, {true, robust != 0, threads}};
        if (!exists(rows, &m.theirs)) continue;
        fprintf(out, "\nhtree against Embree%s, %u thread%s\n", robust ? " in robust mode" : "",
                threads, threads == 1 ? "" : "s");
        print_table(out, &m, comparisons, COMPARISONS);
    }
}

/* The least number of threads above `above`, 0 if there is none. */
static uint32_t next_threads(const bench_rows *rows, uint32_t above) {
    uint32_t next = 0;
    for (uint32_t i = 0; i < rows->count; ++i) {
        const uint32_t threads = rows->all[i].threads;
        if (threads > above && (!next || threads < next)) next = threads;
    }
    return next;
}

void ratios_print(FILE *out, const bench_rows *rows) {
    const uint32_t least = next_threads(rows, 0);
    for (uint32_t n = least; n; n = next_threads(rows, n)) print_peers(out, rows, n);
    for (uint32_t n = next_threads(rows, least); n; n = next_threads(rows, n)) {
        const match m = {rows, {false, false, n}, {false, false, least}};
        fprintf(out, "\nhtree with %u threads against %u\n", n, least);
        print_table(out, &m, gains, GAINS);
    }
}
