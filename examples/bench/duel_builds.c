/* duel_builds.c: every contender builds, round by round: as in an animation, positions are written,
 * it builds, it answers the frame, and again until its time is up. */
#include "duel_run.h"

#include "device.h"
#include "figures.h"
#include "numbers.h"
#include "primary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Positions ------------------------------------------------------------------------------ */

/* The mesh, gently swung: every vertex moves by up to a hundredth of the scene. It shares the
 * indices. */
static bool swing(shape *out, const shape *mesh, const htree_box *box) {
    *out = *mesh;
    out->positions = (float *)malloc(12 * (size_t)mesh->vertex_count + 12);
    if (!out->positions) return false;
    for (uint64_t i = 0; i < mesh->vertex_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const int other = (k + 1) % 3;
            const double side = (double)box->hi[other] - (double)box->lo[other];
            const double extent = (double)box->hi[k] - (double)box->lo[k];
            const double at = (double)mesh->positions[3 * i + (uint64_t)other];
            const double turn = side > 0 ? (at - (double)box->lo[other]) / side : 0;
            out->positions[3 * i + (uint64_t)k] =
                (float)((double)mesh->positions[3 * i + (uint64_t)k] +
                        0.01 * extent * sin_turns(2 * turn));
        }
    }
    return true;
}

/* ---- Rounds --------------------------------------------------------------------------------- */

/* Positions a and b in turn: an update to the same positions would prove nothing. Builds read them
 * where an animation has just written them. */
typedef struct stage {
    build_way way;
    shape at[2], now;
} stage;

static void put(const stage *s, uint32_t which) {
    memcpy(s->now.positions, s->at[which].positions, 12 * (size_t)s->now.vertex_count);
}

/* What is to be updated starts from a, and once untimed, after which all memory is there. */
static bool prepare(duel_runner *r, const stage *s) {
    double seconds;
    for (uint32_t i = 0; i < r->d->count; ++i) {
        contender *c = &r->d->all[i];
        if (s->way == BUILD_FRESH || !contender_builds(c) || !contender_can(c, s->way)) continue;
        put(s, 0);
        if (!contender_build(c, &s->now, r->job->threads, true, &seconds, r->error)) return false;
        put(s, 1);
        if (!contender_update(c, s->way, &s->now, &seconds, r->error)) return false;
    }
    return true;
}

/* The last fresh trees stay, and lazy ones go on reading the mesh: theirs is the caller's own, which
 * being copied from warms as being written to does. */
static bool build(duel_runner *r, const stage *s, contender *c, uint32_t call, double *seconds) {
    put(s, s->way == BUILD_FRESH ? 0 : call % 2);
    return s->way == BUILD_FRESH
               ? contender_build(c, &s->at[0], r->job->threads, false, seconds, r->error)
               : contender_update(c, s->way, &s->now, seconds, r->error);
}

/* Frame after frame, each with its build, until the time is up: once at least, and updates twice, so
 * that all end at the same positions. Packets answer the frame after what their peer has built. */
static bool play_turn(duel_runner *r, const stage *s, uint32_t index, uint32_t round,
                      double *built) {
    contender *c = &r->d->all[index];
    const bool builds = contender_builds(c), pairs = s->way != BUILD_FRESH;
    double building = 0, tracing = 0;
    uint32_t calls = 0;
    for (; !calls || (pairs && calls % 2) || building + tracing < r->job->seconds; ++calls) {
        double one = 0, frame = 0;
        if (builds && !build(r, s, c, calls, &one)) return false;
        if (!duel_trace(r, c, RAYS_FRAME, &frame)) return false;
        building += one;
        tracing += frame;
    }
    if (builds) *built = building / calls;
    r->seconds[index][round] = *built;
    r->more[index][round] = *built + tracing / calls;
    return true;
}

static bool play_round(duel_runner *r, const stage *s, uint32_t round) {
    double built = 0;
    for (uint32_t i = 0; i < r->d->count; ++i) {
        duel_step(r);
        if (contender_can(&r->d->all[i], s->way) && !play_turn(r, s, i, round, &built))
            return false;
    }
    return true;
}

/* After the last round all are at the same positions. */
static bool compare(duel_runner *r, build_way way) {
    const ray_set *set = &r->d->sets[RAYS_FRAME];
    double seconds;
    bool first = true;
    for (uint32_t i = 0; i < r->d->count; ++i) {
        contender *c = &r->d->all[i];
        if (!contender_can(c, way)) continue;
        if (!duel_trace(r, c, RAYS_FRAME, &seconds)) return false;
        if (first)
            memcpy(r->expected, r->answers, (size_t)set->count * sizeof(htree_hit));
        else
            c->update_differ[way] =
                contender_differ(c, set, RAYS_FRAME, r->largest, r->answers, r->expected);
        first = false;
    }
    return true;
}

static void summarise(duel_runner *r, build_way way) {
    for (uint32_t i = 0; i < r->d->count; ++i) {
        contender *c = &r->d->all[i];
        const bool can = contender_can(c, way);
        c->build_seconds[way] = can ? figures_median(r->seconds[i], r->job->rounds) : (double)NAN;
        c->frame_seconds[way] = can ? figures_median(r->more[i], r->job->rounds) : (double)NAN;
    }
}

static bool play(duel_runner *r, const stage *s) {
    bool ok = prepare(r, s);
    for (uint32_t round = 0; ok && round < r->job->rounds; ++round) ok = play_round(r, s, round);
    ok = ok && compare(r, s->way);
    summarise(r, s->way);
    for (uint32_t i = 0; s->way != BUILD_FRESH && i < r->d->count; ++i)
        contender_drop(&r->d->all[i]);
    return ok;
}

/* ---- All of it ------------------------------------------------------------------------------ */

/* The tree of a device is that of the contender before it. */
static bool upload(const duel_runner *r, contender *c) {
    struct htree_cl *device = r->job->device;
    const double compiled = device_compile_seconds(device), start = clock_seconds();
    const htree_status status = tracer_upload(&c->by, device, c[-1].tree, r->job->threads);
    c->upload_seconds = clock_seconds() - start;
    c->compile_seconds = device_compile_seconds(device) - compiled;
    if (status == HTREE_OK) return true;
    snprintf(r->error.text, r->error.size, "%s", tracer_error_text(&c->by));
    return false;
}

bool duel_build_all(duel_runner *r) {
    const htree_box box = mesh_bounds(r->job->mesh);
    stage s = {BUILD_REFIT, {*r->job->mesh, {NULL, NULL, 0, 0}}, {NULL, NULL, 0, 0}};
    bool ok = swing(&s.at[1], r->job->mesh, &box) && swing(&s.now, r->job->mesh, &box);
    if (!ok) snprintf(r->error.text, r->error.size, "out of memory: try a smaller scene");
    for (int way = BUILD_REFIT; ok && way < BUILD_WAYS; ++way) {
        s.way = (build_way)way;
        ok = play(r, &s);
    }
    free(s.at[1].positions);
    free(s.now.positions);
    for (uint32_t i = 0; ok && i < r->d->count; ++i) {
        contender *c = &r->d->all[i];
        ok = c->place == PLACE_DEVICE ? upload(r, c)
                                      : !contender_builds(c) || contender_weigh(c, r->error);
    }
    return ok;
}
