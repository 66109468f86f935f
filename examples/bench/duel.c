#include "duel.h"

#include "device.h"
#include "figures.h"
#include "primary.h"
#include "progress.h"
#include "shape_mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct run {
    const duel_job *job;
    duel *d;
    void *answers, *expected; /* of a set; expected: of the first contender */
    double seconds[DUEL_MAX][BENCH_MAX_ROUNDS], kernel[DUEL_MAX][BENCH_MAX_ROUNDS];
    progress bar;
    uint32_t done, steps; /* of the bar */
    char *error;
    size_t size;
} run;

static bool fail_status(const run *r, const char *text, htree_status status) {
    const bool own = status == HTREE_ERROR_MEMORY || !*text;
    snprintf(r->error, r->size, "%s", own ? "out of memory: try a smaller scene or --size" : text);
    return false;
}

static void step(run *r) {
    progress_report(&r->bar, (double)r->done++ / (double)r->steps);
}

/* ---- Contenders ----------------------------------------------------------------------------- */

static contender *add(duel *d, contender_place place, htree_kind kind, const char *name) {
    contender *c = &d->all[d->count++];
    c->place = place;
    c->kind = kind;
    c->build_seconds = NAN;
    snprintf(c->name, sizeof c->name, "%s%s", name, place == PLACE_DEVICE ? " @device" : "");
    return c;
}

static bool enlist(run *r) {
    const duel_job *job = r->job;
    duel *d = r->d;
    for (uint32_t i = 0; i < job->kind_count; ++i) {
        add(d, PLACE_CPU, job->kinds[i], htree_kind_name(job->kinds[i]));
        if (job->device) add(d, PLACE_DEVICE, job->kinds[i], htree_kind_name(job->kinds[i]));
    }
    for (uint32_t i = 0; i < job->peer_count; ++i) {
        contender *c = add(d, PLACE_PEER, 0, job->peers[i]);
        c->other = peer_open(job->peers[i], job->mesh, job->threads, r->error, r->size);
        if (!c->other) return false;
        peer_describe(c->other, d->peer_text[i], sizeof d->peer_text[i]);
    }
    return true;
}

/* ---- Builds --------------------------------------------------------------------------------- */

static bool build_tree_of(const run *r, contender *c, double *seconds) {
    const htree_mesh mesh = shape_mesh(r->job->mesh);
    htree_options options;
    htree_status status = htree_options_init(&options, sizeof options, c->kind);
    options.threads = r->job->threads;
    htree_free(c->tree);
    c->tree = NULL;
    const double start = clock_seconds();
    if (status == HTREE_OK) status = htree_build(&c->tree, &mesh, &options);
    *seconds = clock_seconds() - start;
    return status == HTREE_OK || fail_status(r, htree_error_text(), status);
}

static bool finish_tree(const run *r, contender *c) {
    htree_stats stats;
    stats.size = sizeof stats;
    const htree_status status = htree_get_stats(c->tree, &stats);
    if (status != HTREE_OK) return fail_status(r, htree_error_text(), status);
    c->bytes = stats.bytes;
    c->by = tracer_cpu(c->tree, r->job->threads);
    return true;
}

/* The tree of a device is that of the contender before it. */
static bool upload(const run *r, contender *c) {
    struct htree_cl *device = r->job->device;
    const double compiled = device_compile_seconds(device), start = clock_seconds();
    c->tree = c[-1].tree;
    const htree_status status = tracer_upload(&c->by, device, c->tree, r->job->threads);
    c->upload_seconds = clock_seconds() - start;
    c->compile_seconds = device_compile_seconds(device) - compiled;
    return status == HTREE_OK || fail_status(r, tracer_error_text(&c->by), status);
}

static bool build_all(run *r) {
    duel *d = r->d;
    for (uint32_t round = 0; round < r->job->rounds; ++round) {
        for (uint32_t i = 0; i < d->count; ++i) {
            contender *c = &d->all[i];
            double *seconds = &r->seconds[i][round];
            step(r);
            if (c->place == PLACE_CPU && !build_tree_of(r, c, seconds)) return false;
            if (c->place == PLACE_PEER && !peer_build(c->other, seconds, r->error, r->size))
                return false;
        }
    }
    for (uint32_t i = 0; i < d->count; ++i) {
        contender *c = &d->all[i];
        if (c->place != PLACE_DEVICE)
            c->build_seconds = figures_median(r->seconds[i], r->job->rounds);
        if (c->place == PLACE_CPU && !finish_tree(r, c)) return false;
        if (c->place == PLACE_DEVICE && !upload(r, c)) return false;
    }
    return true;
}

/* ---- Rays ----------------------------------------------------------------------------------- */

static uint64_t count_hits(const ray_set *set, ray_set_name name, const void *answers) {
    uint64_t hits = 0;
    for (uint64_t i = 0; i < set->count; ++i)
        hits += name == RAYS_AMBIENT ? ((const uint8_t *)answers)[i]
                                     : ((const htree_hit *)answers)[i].prim != HTREE_NONE;
    return hits;
}

static bool trace_once(const run *r, contender *c, ray_set_name name, double *seconds) {
    const double start = clock_seconds();
    const htree_status status = contender_trace(c, &r->d->sets[name], name, r->answers);
    *seconds = clock_seconds() - start;
    return status == HTREE_OK || fail_status(r, tracer_error_text(&c->by), status);
}

static void compare(const run *r, contender *c, ray_set_name name) {
    const uint64_t differ =
        contender_differ(c, r->d->sets[name].count, name, r->answers, r->expected);
    if (differ > c->rows[name].differ) c->rows[name].differ = differ;
}

/* The first calls: they compile what is still to be compiled, bring everything into memory, and say
 * what the answers are. */
static bool trace_first(run *r, ray_set_name name) {
    duel *d = r->d;
    const ray_set *set = &d->sets[name];
    for (uint32_t i = 0; i < d->count; ++i) {
        contender_row *row = &d->all[i].rows[name];
        step(r);
        if (!trace_once(r, &d->all[i], name, &row->first_seconds)) return false;
        row->hits = count_hits(set, name, r->answers);
        if (i == 0)
            memcpy(r->expected, r->answers, (size_t)set->count * sizeof(htree_hit));
        else
            compare(r, &d->all[i], name);
    }
    return true;
}

/* A set is traced again and again until the time is up. */
static bool trace_round(run *r, uint32_t index, uint32_t round, ray_set_name name) {
    contender *c = &r->d->all[index];
    double total = 0, kernel = 0;
    uint32_t calls = 0;
    for (; calls == 0 || total < r->job->seconds; ++calls) {
        double seconds;
        if (!trace_once(r, c, name, &seconds)) return false;
        total += seconds;
        kernel += c->place == PLACE_DEVICE ? c->by.kernel_seconds : 0;
    }
    r->seconds[index][round] = total / calls;
    r->kernel[index][round] = kernel / calls;
    compare(r, c, name);
    return true;
}

static void summarise(run *r, ray_set_name name) {
    duel *d = r->d;
    const contender *first_peer = NULL;
    for (uint32_t i = 0; i < d->count; ++i) {
        contender_row *row = &d->all[i].rows[name];
        const uint32_t rounds = r->job->rounds;
        row->seconds = figures_median(r->seconds[i], rounds);
        row->kernel_seconds = figures_median(r->kernel[i], rounds);
        row->spread = (r->seconds[i][rounds - 1] - r->seconds[i][0]) / row->seconds;
        if (d->all[i].place == PLACE_PEER && !first_peer) first_peer = &d->all[i];
    }
    for (uint32_t i = 0; i < d->count; ++i) {
        contender_row *row = &d->all[i].rows[name];
        row->versus_cpu = d->all[i].place == PLACE_DEVICE
                              ? d->all[i - 1].rows[name].seconds / row->seconds
                              : (double)NAN;
        row->versus_peer = first_peer ? first_peer->rows[name].seconds / row->seconds : (double)NAN;
    }
}

static bool trace_set(run *r, ray_set_name name) {
    if (!r->d->sets[name].count) return true;
    if (!trace_first(r, name)) return false;
    for (uint32_t round = 0; round < r->job->rounds; ++round) {
        for (uint32_t i = 0; i < r->d->count; ++i) {
            step(r);
            if (!trace_round(r, i, round, name)) return false;
        }
    }
    summarise(r, name);
    return true;
}

static bool make_rays(run *r) {
    const duel_job *job = r->job;
    const htree_status status =
        ray_sets_make(r->d->sets, &job->wish, job->mesh, job->view, r->d->all[0].tree);
    if (status != HTREE_OK) return fail_status(r, htree_error_text(), status);
    const size_t bytes = (size_t)(r->d->sets[RAYS_PRIMARY].count + 1) * sizeof(htree_hit);
    r->answers = calloc(1, bytes);
    r->expected = calloc(1, bytes);
    return (r->answers && r->expected) || fail_status(r, "", HTREE_ERROR_MEMORY);
}

bool duel_run(duel *out, const duel_job *job, char *error, size_t size) {
    memset(out, 0, sizeof *out);
    run *r = (run *)calloc(1, sizeof *r);
    if (!r) return snprintf(error, size, "out of memory"), false;
    r->job = job;
    r->d = out;
    r->error = error;
    r->size = size;
    r->bar = progress_start(job->label, job->quiet);
    bool ok = enlist(r);
    r->steps = out->count * (job->rounds + RAY_SETS * (job->rounds + 1)) + 1;
    ok = ok && build_all(r) && make_rays(r);
    for (int name = 0; ok && name < RAY_SETS; ++name) ok = trace_set(r, (ray_set_name)name);
    progress_end(&r->bar);
    free(r->answers);
    free(r->expected);
    free(r);
    return ok;
}

void duel_end(duel *d) {
    for (uint32_t i = 0; i < d->count; ++i) {
        tracer_end(&d->all[i].by);
        peer_close(d->all[i].other);
    }
    for (uint32_t i = 0; i < d->count; ++i)
        if (d->all[i].place == PLACE_CPU) htree_free(d->all[i].tree);
    ray_sets_free(d->sets);
    d->count = 0;
}

bool duel_agrees(const duel *d, char *error, size_t size) {
    for (uint32_t i = 1; i < d->count; ++i) {
        for (int name = 0; name < RAY_SETS; ++name) {
            const contender *c = &d->all[i];
            const uint64_t differ = c->rows[name].differ;
            const uint64_t allowed = c->place == PLACE_PEER ? d->sets[name].count / 1000 : 0;
            if (differ <= allowed) continue;
            snprintf(error, size, "%s: %llu of %llu %s rays are not answered as by %s", c->name,
                     (unsigned long long)differ, (unsigned long long)d->sets[name].count,
                     ray_set_text((ray_set_name)name), d->all[0].name);
            return false;
        }
    }
    return true;
}
