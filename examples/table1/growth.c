/* growth.c: a growth claim is about ratios, so small builds are repeated until their medians are
 * worth dividing by. */
#include "growth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_KINDS = 16, MAX_SIZES = 24 };

typedef struct growth_table {
    uint32_t size_count;
    uint64_t wished[MAX_SIZES], triangles[MAX_SIZES];
    double seconds[MAX_KINDS][MAX_SIZES]; /* 0: not built */
} growth_table;

/* Ten thousand triangles take a few milliseconds: measure those more often, odd times for a median
 * that was measured. */
static uint32_t repeat_for(const growth_job *job, uint64_t triangles) {
    const uint64_t wish = 1000000 / (triangles + 1) | 1;
    const uint64_t most = wish < 31 ? wish : 31;
    return most > job->repeat ? (uint32_t)most : job->repeat;
}

static htree_status grow_once(const growth_job *job, growth_table *table, uint32_t at) {
    measure_way ways[MAX_KINDS];
    measure_row rows[MAX_KINDS];
    uint32_t which[MAX_KINDS], count = 0;
    char label[64];
    shape mesh;
    memset(ways, 0, sizeof ways);
    for (uint32_t i = 0; i < job->kind_count; ++i) {
        if (at && !(table->seconds[i][at - 1] > 0)) continue;
        if (at && table->seconds[i][at - 1] > (double)job->patience) continue;
        ways[count].kind = job->kinds[i];
        which[count++] = i;
    }
    if (!count) return HTREE_OK;
    if (!shape_make(&mesh, job->scene, table->wished[at], 1)) return HTREE_ERROR_MEMORY;
    measure_job builds;
    memset(&builds, 0, sizeof builds);
    snprintf(label, sizeof label, "%s %.3g", job->scene, (double)table->wished[at]);
    builds.mesh = &mesh;
    builds.threads = job->threads;
    builds.repeat = repeat_for(job, table->wished[at]);
    builds.keep_memory = true; /* the growth of the algorithm, not that of page faults */
    builds.label = label;
    builds.quiet = job->quiet;
    const htree_status status = measure_run(&builds, ways, count, rows);
    table->triangles[at] = mesh.triangle_count;
    for (uint32_t i = 0; status == HTREE_OK && i < count; ++i)
        table->seconds[which[i]][at] = rows[i].build;
    shape_free(&mesh);
    return status;
}

static double nanoseconds(const growth_table *table, uint32_t kind, uint32_t at) {
    return 1e9 * table->seconds[kind][at] / (double)table->triangles[at];
}

static void print_kind(FILE *out, const growth_job *job, const growth_table *table, uint32_t kind) {
    double base = NAN;
    for (uint32_t i = 0; i < table->size_count; ++i)
        if (table->wished[i] == 100000 && table->seconds[kind][i] > 0)
            base = nanoseconds(table, kind, i);
    fprintf(out, "\n\n# %s-%s\n# %10s %12s %12s %12s\n", job->scene,
            htree_kind_name(job->kinds[kind]), "triangles", "T_C[s]", "ns/triangle", "to_10^5");
    for (uint32_t i = 0; i < table->size_count; ++i) {
        if (!(table->seconds[kind][i] > 0)) break;
        const double each = nanoseconds(table, kind, i);
        fprintf(out, "%12llu %12.6f %12.2f", (unsigned long long)table->triangles[i],
                table->seconds[kind][i], each);
        if (isnan(base))
            fprintf(out, " %12s\n", "-");
        else
            fprintf(out, " %12.3f\n", each / base);
    }
}

htree_status growth_print(FILE *out, const growth_job *job) {
    growth_table *table = (growth_table *)calloc(1, sizeof *table);
    htree_status status = table && job->kind_count <= MAX_KINDS ? HTREE_OK : HTREE_ERROR_MEMORY;
    for (uint32_t i = 0; status == HTREE_OK && i < MAX_SIZES; ++i) {
        const double size = (double)job->from * pow(10, i / 2.0);
        if (size > 1.001 * (double)job->to) break;
        table->wished[i] = (uint64_t)(size + 0.5);
        table->size_count = i + 1;
        status = grow_once(job, table, i);
    }
    for (uint32_t i = 0; status == HTREE_OK && i < job->kind_count; ++i)
        print_kind(out, job, table, i);
    fflush(out);
    free(table);
    return status;
}

/* ---- Precision ------------------------------------------------------------------------------ */

static void print_sweep(FILE *out, const char *name, const char *what, const measure_row *rows,
                        uint32_t count) {
    fprintf(out, "\n\n# %s-%s\n# %8s %10s %10s %10s %9s %9s %12s\n", name, what, "value", "T_C[s]",
            "T_R[s]", "T_T[s]", "N_TS", "N_IT", "N_NS");
    for (uint32_t i = 0; i < count; ++i) {
        const measure_row *row = &rows[i];
        const double value = row->way.buckets ? row->way.buckets : (double)row->way.cells_per_prim;
        fprintf(out, "%10.6g %10.5f %10.5f %10.5f %9.3f %9.3f %12llu\n", value, row->build,
                row->trace, row->build + row->trace, row->traversal_steps, row->intersections,
                (unsigned long long)row->stats.nodes);
    }
}

htree_status precision_print(FILE *out, const measure_job *job, const char *name) {
    enum { BUCKETS = 6, CELLS = 9 };
    measure_way ways[BUCKETS + CELLS];
    measure_row rows[BUCKETS + CELLS];
    memset(ways, 0, sizeof ways);
    for (uint32_t i = 0; i < BUCKETS; ++i) {
        ways[i].kind = HTREE_H;
        ways[i].buckets = 2u << i;
    }
    for (uint32_t i = 0; i < CELLS; ++i) {
        ways[BUCKETS + i].kind = HTREE_AH;
        ways[BUCKETS + i].cells_per_prim = (float)(1u << i) / 16;
    }
    const htree_status status = measure_run(job, ways, BUCKETS + CELLS, rows);
    if (status != HTREE_OK) return status;
    print_sweep(out, name, "h-buckets", rows, BUCKETS);
    print_sweep(out, name, "ah-cells", rows + BUCKETS, CELLS);
    fflush(out);
    return HTREE_OK;
}
