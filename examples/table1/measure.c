/* measure.c: a round builds each tree, traces it once with counters, which also brings it into the
 * caches, and then once against the clock. */
#include "measure.h"

#include "figures.h"
#include "numbers.h"
#include "pool.h"
#include "primary.h"
#include "shape_mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct bench {
    const measure_job *job;
    uint64_t count; /* rays */
    htree_ray *rays;
    htree_hit *hits;
    htree_counters *counters;
    double *builds, *traces; /* by way and round */
    pool memory;
} bench;

static bool bench_make(bench *b, const measure_job *job, uint32_t ways) {
    memset(b, 0, sizeof *b);
    b->job = job;
    b->count = (uint64_t)job->width * job->height;
    const size_t rays = (size_t)b->count + 1, times = (size_t)ways * job->repeat + 1;
    b->rays = (htree_ray *)malloc(rays * sizeof *b->rays);
    b->hits = (htree_hit *)malloc(rays * sizeof *b->hits);
    b->counters = (htree_counters *)malloc(rays * sizeof *b->counters);
    b->builds = (double *)malloc(times * sizeof *b->builds);
    b->traces = (double *)malloc(times * sizeof *b->traces);
    if (!b->rays || !b->hits || !b->counters || !b->builds || !b->traces) return false;
    for (uint64_t i = 0; i < b->count; ++i)
        b->rays[i] = camera_ray(&job->view, (double)(i % job->width) + 0.5,
                                (double)(i / job->width) + 0.5, job->width, job->height);
    return true;
}

static void bench_free(bench *b) {
    free(b->rays);
    free(b->hits);
    free(b->counters);
    free(b->builds);
    free(b->traces);
    pool_free(&b->memory);
}

static htree_status build(bench *b, const measure_way *way, htree **tree) {
    const measure_job *job = b->job;
    const htree_mesh mesh = shape_mesh(job->mesh);
    htree_options options;
    const htree_status status = htree_options_init(&options, sizeof options, way->kind);
    if (status != HTREE_OK) return status;
    options.threads = job->threads;
    if (job->keep_memory) options.allocator = pool_allocator(&b->memory);
    if (way->buckets) options.buckets = way->buckets;
    if (way->cells_per_prim > 0) options.cells_per_prim = way->cells_per_prim;
    return htree_build(tree, &mesh, &options);
}

static void take_means(const bench *b, measure_row *row) {
    uint64_t hits = 0, tests = 0, steps = 0, leaves = 0, answer = 0;
    for (uint64_t i = 0; i < b->count; ++i) {
        uint64_t words[2];
        memcpy(words, &b->hits[i], sizeof words);
        answer = hash_pair(hash_pair(answer, words[0]), words[1]);
        hits += b->hits[i].prim != HTREE_NONE;
        tests += b->counters[i].intersections;
        steps += b->counters[i].traversal_steps;
        leaves += b->counters[i].leaf_steps;
    }
    const double count = b->count ? (double)b->count : 1;
    row->hit_fraction = (double)hits / count;
    row->intersections = (double)tests / count;
    row->traversal_steps = (double)steps / count;
    row->leaf_steps = (double)leaves / count;
    row->answer = answer;
}

static htree_status trace(const bench *b, const htree *tree, measure_row *row, double *seconds) {
    htree_query query;
    htree_status status = htree_query_init(&query, sizeof query);
    query.threads = b->job->threads;
    query.counters = b->counters;
    if (status == HTREE_OK) status = htree_intersect(tree, b->rays, b->count, b->hits, &query);
    if (status != HTREE_OK) return status;
    take_means(b, row);
    query.counters = NULL;
    const double start = clock_seconds();
    status = htree_intersect(tree, b->rays, b->count, b->hits, &query);
    *seconds = clock_seconds() - start;
    return status;
}

/* The figures of the tree are the same in every round, and counting them is a walk: once is
 * enough. */
static htree_status measure_once(bench *b, measure_row *row, double *built, double *traced) {
    htree *tree = NULL;
    const double start = clock_seconds();
    htree_status status = build(b, &row->way, &tree);
    *built = clock_seconds() - start;
    if (status == HTREE_OK && !row->stats.size) {
        row->stats.size = sizeof row->stats;
        status = htree_get_stats(tree, &row->stats);
    }
    if (status == HTREE_OK) status = trace(b, tree, row, traced);
    htree_free(tree);
    return status;
}

static void summarise(const bench *b, measure_row *rows, uint32_t count) {
    const uint32_t repeat = b->job->repeat;
    const measure_row *reference = NULL;
    for (uint32_t i = 0; i < count; ++i) {
        rows[i].build = figures_median(b->builds + (size_t)i * repeat, repeat);
        rows[i].trace = figures_median(b->traces + (size_t)i * repeat, repeat);
        if (rows[i].way.kind == HTREE_KD) reference = &rows[i];
    }
    for (uint32_t i = 0; i < count; ++i) {
        measure_row *row = &rows[i];
        row->build_speedup = reference ? reference->build / row->build : (double)NAN;
        row->trace_speedup = reference ? reference->trace / row->trace : (double)NAN;
        row->total_speedup = reference
                                 ? (reference->build + reference->trace) / (row->build + row->trace)
                                 : (double)NAN;
    }
}

htree_status measure_run(const measure_job *job, const measure_way *ways, uint32_t count,
                         measure_row *rows) {
    bench b;
    progress bar = progress_start(job->label, job->quiet);
    htree_status status = bench_make(&b, job, count) ? HTREE_OK : HTREE_ERROR_MEMORY;
    memset(rows, 0, count * sizeof *rows);
    for (uint32_t i = 0; i < count * job->repeat && status == HTREE_OK; ++i) {
        const uint32_t way = i % count, round = i / count;
        const size_t place = (size_t)way * job->repeat + round;
        rows[way].way = ways[way];
        progress_report(&bar, (double)i / (double)(count * job->repeat));
        status = measure_once(&b, &rows[way], &b.builds[place], &b.traces[place]);
    }
    progress_end(&bar);
    if (status == HTREE_OK) summarise(&b, rows, count);
    bench_free(&b);
    return status;
}
