#include "duel_run.h"

#include "build_tree.h"
#include "primary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool fail_status(const duel_runner *r, htree_status status) {
    const char *text = status == HTREE_ERROR_MEMORY ? "out of memory: try a smaller scene or --size"
                                                    : htree_error_text();
    snprintf(r->error.text, r->error.size, "%s", text);
    return false;
}

void duel_step(duel_runner *r) {
    progress_report(&r->bar, (double)r->done++ / (double)r->steps);
}

bool duel_trace(const duel_runner *r, contender *c, ray_set_name name, double *seconds) {
    return contender_trace(c, &r->d->sets[name], r->d->packed[name], name, r->answers, seconds,
                           r->error);
}

/* ---- Contenders ----------------------------------------------------------------------------- */

static contender *add(duel *d, contender_place place, const char *prefix, const char *name) {
    static const char *const suffix[] = {"", " @device", "", " x16"};
    contender *c = &d->all[d->count++];
    c->place = place;
    snprintf(c->name, sizeof c->name, "%s%s%s", prefix, name, suffix[place]);
    return c;
}

static bool enlist(duel_runner *r) {
    const duel_job *job = r->job;
    duel *d = r->d;
    for (uint32_t i = 0; i < job->tree_count; ++i) {
        add(d, PLACE_CPU, "", job->trees[i].name)->config = job->trees[i];
        if (job->device) add(d, PLACE_DEVICE, "", job->trees[i].name)->config = job->trees[i];
    }
    for (uint32_t i = 0; i < job->peer_count; ++i) {
        const peer_config *config = &job->peers[i];
        contender *c = add(d, PLACE_PEER, "embree-", config->name);
        c->by_peer = *config;
        c->other = peer_open(config, job->mesh, job->threads, r->error.text, r->error.size);
        if (!c->other) return false;
        peer_describe(c->other, d->peer_text[i], sizeof d->peer_text[i]);
        contender *packets = add(d, PLACE_PACKET, "embree-", config->name);
        packets->by_peer = *config;
        packets->other = c->other;
    }
    return true;
}

/* ---- Rays ----------------------------------------------------------------------------------- */

/* A tree that says where rays go on from, and is no contender. */
static bool make_rays(duel_runner *r) {
    const duel_job *job = r->job;
    htree *tree = NULL;
    htree_status status = build_tree(&tree, job->mesh, HTREE_BALANCED, job->threads, true);
    if (status == HTREE_OK)
        status = ray_sets_make(r->d->sets, &job->wish, job->mesh, job->view, tree);
    htree_free(tree);
    return status == HTREE_OK || fail_status(r, status);
}

static bool get_rays(duel_runner *r) {
    const duel_job *job = r->job;
    const uint64_t triangles = job->mesh->triangle_count;
    ray_set *sets = r->d->sets;
    char *text = r->error.text;
    uint64_t most = 0;
    if (job->load_rays ? !ray_sets_load(sets, triangles, job->load_rays, text, r->error.size)
                       : !make_rays(r))
        return false;
    if (job->save_rays && !ray_sets_save(sets, triangles, job->save_rays, text, r->error.size))
        return false;
    for (int i = 0; i < RAY_SETS; ++i) {
        if (sets[i].count > most) most = sets[i].count;
        if (!job->peer_count || !sets[i].row) continue;
        r->d->packed[i] = peer_pack(sets[i].rays, sets[i].count, sets[i].row);
        if (!r->d->packed[i]) return fail_status(r, HTREE_ERROR_MEMORY);
    }
    r->answers = calloc((size_t)most + 1, sizeof(htree_hit));
    r->expected = calloc((size_t)most + 1, sizeof(htree_hit));
    return (r->answers && r->expected) || fail_status(r, HTREE_ERROR_MEMORY);
}

static double largest_coordinate(const shape *mesh) {
    const htree_box box = mesh_bounds(mesh);
    double largest = 0;
    for (int i = 0; i < 3; ++i)
        largest = fmax(largest, fmax(fabs((double)box.lo[i]), fabs((double)box.hi[i])));
    return largest;
}

/* ---- From begin to end ---------------------------------------------------------------------- */

bool duel_run(duel *out, const duel_job *job, char *error, size_t size) {
    memset(out, 0, sizeof *out);
    duel_runner *r = (duel_runner *)calloc(1, sizeof *r);
    if (!r) return snprintf(error, size, "out of memory"), false;
    r->job = job;
    r->d = out;
    r->error.text = error;
    r->error.size = size;
    r->largest = largest_coordinate(job->mesh);
    r->bar = progress_start(job->label, job->quiet);
    bool ok = enlist(r) && get_rays(r);
    r->steps = out->count * (BUILD_WAYS * job->rounds + RAY_SETS * (job->rounds + 1)) + 1;
    ok = ok && duel_build_all(r);
    for (int name = 0; ok && name < RAY_SETS; ++name) ok = duel_trace_set(r, (ray_set_name)name);
    progress_end(&r->bar);
    free(r->answers);
    free(r->expected);
    free(r);
    return ok;
}

void duel_end(duel *d) {
    for (uint32_t i = 0; i < d->count; ++i) {
        tracer_end(&d->all[i].by);
        if (d->all[i].place == PLACE_PEER) peer_close(d->all[i].other);
    }
    for (uint32_t i = 0; i < d->count; ++i)
        if (d->all[i].place == PLACE_CPU) contender_drop(&d->all[i]);
    for (int i = 0; i < RAY_SETS; ++i) peer_packets_free(d->packed[i]);
    ray_sets_free(d->sets);
    d->count = 0;
}

static bool agrees(const duel *d, const contender *c, uint64_t differ, ray_set_name name,
                   char *error, size_t size) {
    const uint64_t allowed = c->other ? d->sets[name].count / 1000 : 0;
    if (differ <= allowed) return true;
    snprintf(error, size, "%s: %llu of %llu %s rays are not answered as by %s", c->name,
             (unsigned long long)differ, (unsigned long long)d->sets[name].count,
             ray_set_text(name), d->all[0].name);
    return false;
}

bool duel_agrees(const duel *d, char *error, size_t size) {
    for (uint32_t i = 1; i < d->count; ++i) {
        const contender *c = &d->all[i];
        for (int name = 0; name < RAY_SETS; ++name)
            if (!agrees(d, c, c->rows[name].differ, (ray_set_name)name, error, size)) return false;
        for (int way = 0; way < BUILD_WAYS; ++way)
            if (!agrees(d, c, c->update_differ[way], RAYS_FRAME, error, size)) return false;
    }
    return true;
}
