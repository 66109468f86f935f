/* visible.c: lines find what is large or near with little work: each asks for the closest hit. What
 * they miss is asked for by name: segments from the cell to points on a triangle, of which one that
 * is not occluded proves it visible. Neither calls a hidden triangle visible, unless it lies in the
 * very surface that hides it. */
#include "visible.h"

#include "numbers.h"
#include "primary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BATCH = 1 << 16, CANDIDATES = 48, PROBES = 192 };

typedef struct sampler {
    const visible_job *job;
    visible_result *result;
    htree_query query;
    htree_ray *rays;
    htree_hit *hits;
    uint8_t *blocked;
    uint32_t *prims; /* that the segments of a batch go to */
} sampler;

static void point_in(const htree_box *box, random_stream *random, float *out) {
    for (int k = 0; k < 3; ++k)
        out[k] = (float)random_range(random, (double)box->lo[k], (double)box->hi[k]);
}

/* A line is a random point of the cell and a random direction, evenly over the sphere. */
static htree_ray random_line(const htree_box *cell, random_stream *random) {
    htree_ray ray = {{0, 0, 0}, 0, {0, 0, 0}, INFINITY};
    point_in(cell, random, ray.org);
    const double z = random_range(random, -1, 1), turn = random_unit(random);
    const double r = sqrt(1 - z * z);
    ray.dir[0] = (float)(r * cos_turns(turn));
    ray.dir[1] = (float)(r * sin_turns(turn));
    ray.dir[2] = (float)z;
    return ray;
}

/* ---- The cell ------------------------------------------------------------------------------- */

static int compare_prims(const void *a, const void *b) {
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static const float *corner(const shape *mesh, uint64_t prim, uint64_t k) {
    return mesh->positions + 3 * (size_t)mesh->indices[3 * prim + k];
}

/* Twice the area vector: at right angles to the triangle, towards where its corners turn left. */
static void find_normal(const shape *mesh, uint64_t prim, double *out) {
    double a[3], b[3];
    for (int k = 0; k < 3; ++k) {
        a[k] = (double)corner(mesh, prim, 1)[k] - (double)corner(mesh, prim, 0)[k];
        b[k] = (double)corner(mesh, prim, 2)[k] - (double)corner(mesh, prim, 0)[k];
    }
    for (int k = 0; k < 3; ++k)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static bool hits_back(const shape *mesh, const htree_ray *ray, uint32_t prim) {
    double normal[3], along = 0;
    find_normal(mesh, prim, normal);
    for (int k = 0; k < 3; ++k) along += normal[k] * (double)ray->dir[k];
    return along > 0;
}

/* How many different triangles some lines from the cell hit. A cell in a solid is worth nothing:
 * from there no line gets away, or, if the solid has holes, most meet triangles from behind. */
static uint32_t rate_cell(const htree *tree, const shape *mesh, const htree_box *cell,
                          uint32_t seed) {
    htree_ray rays[PROBES];
    htree_hit hits[PROBES];
    uint32_t prims[PROBES], count = 0, different = 0, behind = 0;
    random_stream random = random_start(seed);
    for (int i = 0; i < PROBES; ++i) rays[i] = random_line(cell, &random);
    if (htree_intersect(tree, rays, PROBES, hits, NULL) != HTREE_OK) return 0;
    for (int i = 0; i < PROBES; ++i) {
        if (hits[i].prim == HTREE_NONE) continue;
        behind += hits_back(mesh, &rays[i], hits[i].prim);
        prims[count++] = hits[i].prim;
    }
    if (count == PROBES || 2 * behind > count) return 0;
    qsort(prims, count, sizeof *prims, compare_prims);
    for (uint32_t i = 0; i < count; ++i) different += i == 0 || prims[i] != prims[i - 1];
    return different;
}

static htree_box cell_around(const double *centre, double half) {
    htree_box cell;
    for (int k = 0; k < 3; ++k) {
        cell.lo[k] = (float)(centre[k] - half);
        cell.hi[k] = (float)(centre[k] + half);
    }
    return cell;
}

htree_box visible_place_cell(const htree *tree, const shape *mesh, const camera *view, bool inside,
                             uint32_t seed) {
    const htree_box box = mesh_bounds(mesh);
    double extent[3], size = 0;
    for (int k = 0; k < 3; ++k) extent[k] = (double)box.hi[k] - (double)box.lo[k];
    for (int k = 0; k < 3; ++k) size = fmax(size, extent[k]);
    const double half = size > 0 ? 0.02 * size : 1;
    htree_box best = cell_around(view->eye, half);
    if (inside) return best;
    uint32_t best_rate = 0;
    random_stream random = random_start(seed);
    for (int i = 0; i < CANDIDATES; ++i) {
        double centre[3];
        for (int k = 0; k < 3; ++k)
            centre[k] = (double)box.lo[k] + random_range(&random, -0.15, 1.15) * extent[k];
        const htree_box cell = cell_around(centre, half);
        const uint32_t rate = rate_cell(tree, mesh, &cell, seed);
        if (rate <= best_rate) continue;
        best_rate = rate;
        best = cell;
    }
    return best;
}

/* ---- Lines ---------------------------------------------------------------------------------- */

static void mark(sampler *s, uint32_t prim, uint8_t how) {
    uint8_t *marks = &s->result->marks[prim];
    if (!*marks) ++*(how == VISIBLE_BY_LINE ? &s->result->by_line : &s->result->by_segment);
    *marks |= how;
}

static htree_status trace_lines(sampler *s, uint64_t first, uint32_t count) {
    random_stream random = {hash_pair(s->job->seed, first)};
    for (uint32_t i = 0; i < count; ++i) s->rays[i] = random_line(&s->job->cell, &random);
    const double start = clock_seconds();
    const htree_status status = htree_intersect(s->job->tree, s->rays, count, s->hits, &s->query);
    s->result->line_seconds += clock_seconds() - start;
    for (uint32_t i = 0; status == HTREE_OK && i < count; ++i)
        if (s->hits[i].prim != HTREE_NONE) mark(s, s->hits[i].prim, VISIBLE_BY_LINE);
    return status;
}

/* Lines come in batches that end wherever their number is a power of two, so that the report does
 * not depend on how many were asked for. */
static htree_status sample_lines(sampler *s) {
    const visible_job *job = s->job;
    htree_status status = HTREE_OK;
    uint64_t done = 0, next = 1024, before = 0;
    progress bar = progress_start("lines", job->quiet);
    while (done < job->lines && status == HTREE_OK) {
        const uint64_t stop = next < job->lines ? next : job->lines;
        const uint64_t left = stop - done;
        const uint32_t count = left < BATCH ? (uint32_t)left : BATCH;
        progress_report(&bar, (double)done / (double)job->lines);
        status = trace_lines(s, done, count);
        done += count;
        if (done != stop || status != HTREE_OK) continue;
        progress_end(&bar);
        const uint64_t seen = s->result->by_line;
        if (job->report)
            fprintf(job->report, "%12llu %10llu %8.3f %10llu\n", (unsigned long long)done,
                    (unsigned long long)seen,
                    100 * (double)seen /
                        (double)(job->mesh->triangle_count + !job->mesh->triangle_count),
                    (unsigned long long)(seen - before));
        before = seen;
        next *= 2;
    }
    progress_end(&bar);
    return status;
}

/* ---- Segments ------------------------------------------------------------------------------- */

/* A segment from the cell to a random point of the triangle. It stops short of it by some
 * roundings: the triangle must not count as being in its own way, but a layer of paint upon it
 * must. */
static htree_ray random_segment(const visible_job *job, uint64_t prim, uint32_t round) {
    random_stream random = {hash_pair(hash_pair(hash_pair(job->seed, UINT64_MAX), prim), round)};
    htree_ray ray = {{0, 0, 0}, 0, {0, 0, 0}, 0.999998f};
    point_in(&job->cell, &random, ray.org);
    double u = random_unit(&random), v = random_unit(&random);
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    for (int k = 0; k < 3; ++k) {
        const double a = (double)corner(job->mesh, prim, 0)[k];
        const double b = (double)corner(job->mesh, prim, 1)[k] - a;
        const double c = (double)corner(job->mesh, prim, 2)[k] - a;
        ray.dir[k] = (float)(a + u * b + v * c - (double)ray.org[k]);
    }
    return ray;
}

/* Triangles without area have no side to be seen from. */
static bool has_area(const shape *mesh, uint64_t prim) {
    double normal[3];
    find_normal(mesh, prim, normal);
    return fabs(normal[0]) + fabs(normal[1]) + fabs(normal[2]) > 0;
}

static htree_status trace_segments(sampler *s, uint32_t count) {
    const double start = clock_seconds();
    const htree_status status = htree_occluded(s->job->tree, s->rays, count, s->blocked, &s->query);
    s->result->segment_seconds += clock_seconds() - start;
    s->result->segment_count += count;
    for (uint32_t i = 0; status == HTREE_OK && i < count; ++i)
        if (!s->blocked[i]) mark(s, s->prims[i], VISIBLE_BY_SEGMENT);
    return status;
}

/* A round sends one segment to every triangle that is not known to be visible: each round has
 * fewer. */
static htree_status sample_segments(sampler *s) {
    const visible_job *job = s->job;
    const uint64_t triangles = job->mesh->triangle_count;
    htree_status status = HTREE_OK;
    progress bar = progress_start("segments", job->quiet);
    for (uint32_t round = 0; round < job->segments && status == HTREE_OK; ++round) {
        uint32_t count = 0;
        progress_report(&bar, (double)round / job->segments);
        for (uint64_t prim = 0; prim < triangles && status == HTREE_OK; ++prim) {
            if (s->result->marks[prim] || !has_area(job->mesh, prim)) continue;
            s->prims[count] = (uint32_t)prim;
            s->rays[count++] = random_segment(job, prim, round);
            if (count < BATCH) continue;
            status = trace_segments(s, count);
            count = 0;
        }
        if (status == HTREE_OK) status = trace_segments(s, count);
    }
    progress_end(&bar);
    return status;
}

/* ---- Together ------------------------------------------------------------------------------- */

htree_status visible_sample(visible_result *out, const visible_job *job) {
    sampler s;
    memset(&s, 0, sizeof s);
    memset(out, 0, sizeof *out);
    s.job = job;
    s.result = out;
    htree_status status = htree_query_init(&s.query, sizeof s.query);
    s.query.threads = job->threads;
    out->marks = (uint8_t *)calloc((size_t)job->mesh->triangle_count + 1, 1);
    s.rays = (htree_ray *)malloc(BATCH * sizeof *s.rays);
    s.hits = (htree_hit *)malloc(BATCH * sizeof *s.hits);
    s.blocked = (uint8_t *)malloc(BATCH);
    s.prims = (uint32_t *)malloc(BATCH * sizeof *s.prims);
    if (!out->marks || !s.rays || !s.hits || !s.blocked || !s.prims) status = HTREE_ERROR_MEMORY;
    if (status == HTREE_OK) status = sample_lines(&s);
    if (status == HTREE_OK) status = sample_segments(&s);
    free(s.rays);
    free(s.hits);
    free(s.blocked);
    free(s.prims);
    if (status != HTREE_OK) visible_free(out);
    return status;
}

void visible_free(visible_result *result) {
    free(result->marks);
    memset(result, 0, sizeof *result);
}
