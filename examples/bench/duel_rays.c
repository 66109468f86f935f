/* duel_rays.c: every contender answers a set of rays, round by round. */
#include "duel_run.h"

#include "figures.h"

#include <math.h>
#include <string.h>

static uint64_t count_hits(const ray_set *set, ray_set_name name, const void *answers) {
    uint64_t hits = 0;
    for (uint64_t i = 0; i < set->count; ++i)
        hits += ray_set_any(name) ? ((const uint8_t *)answers)[i]
                                  : ((const htree_hit *)answers)[i].prim != HTREE_NONE;
    return hits;
}

static void compare(const duel_runner *r, contender *c, ray_set_name name) {
    const uint64_t differ =
        contender_differ(c, &r->d->sets[name], name, r->largest, r->answers, r->expected);
    if (differ > c->rows[name].differ) c->rows[name].differ = differ;
}

/* The first calls: they compile what is still to be compiled, bring everything into memory, and say
 * what the answers are. */
static bool trace_first(duel_runner *r, ray_set_name name) {
    duel *d = r->d;
    const ray_set *set = &d->sets[name];
    for (uint32_t i = 0; i < d->count; ++i) {
        contender_row *row = &d->all[i].rows[name];
        duel_step(r);
        if (!contender_takes(&d->all[i], &d->sets[name])) continue;
        if (!duel_trace(r, &d->all[i], name, &row->first_seconds)) return false;
        row->hits = count_hits(set, name, r->answers);
        if (i == 0)
            memcpy(r->expected, r->answers, (size_t)set->count * sizeof(htree_hit));
        else
            compare(r, &d->all[i], name);
    }
    return true;
}

/* A set is traced again and again until the time is up. */
static bool trace_round(duel_runner *r, uint32_t index, uint32_t round, ray_set_name name) {
    contender *c = &r->d->all[index];
    double total = 0, kernel = 0;
    uint32_t calls = 0;
    for (; calls == 0 || total < r->job->seconds; ++calls) {
        double seconds;
        if (!duel_trace(r, c, name, &seconds)) return false;
        total += seconds;
        kernel += c->place == PLACE_DEVICE ? c->by.kernel_seconds : 0;
    }
    r->seconds[index][round] = total / calls;
    r->more[index][round] = kernel / calls;
    compare(r, c, name);
    return true;
}

static void summarise(duel_runner *r, ray_set_name name) {
    duel *d = r->d;
    const contender *first_peer = NULL;
    const uint32_t rounds = r->job->rounds;
    for (uint32_t i = 0; i < d->count; ++i) {
        contender_row *row = &d->all[i].rows[name];
        row->seconds = row->spread = row->versus_cpu = row->versus_peer = (double)NAN;
        if (!contender_takes(&d->all[i], &d->sets[name])) continue;
        row->seconds = figures_median(r->seconds[i], rounds);
        row->kernel_seconds = figures_median(r->more[i], rounds);
        row->spread = (r->seconds[i][rounds - 1] - r->seconds[i][0]) / row->seconds;
        if (d->all[i].place == PLACE_PEER && !first_peer) first_peer = &d->all[i];
    }
    for (uint32_t i = 0; i < d->count; ++i) {
        contender_row *row = &d->all[i].rows[name];
        if (d->all[i].place == PLACE_DEVICE)
            row->versus_cpu = d->all[i - 1].rows[name].seconds / row->seconds;
        if (first_peer) row->versus_peer = first_peer->rows[name].seconds / row->seconds;
    }
}

bool duel_trace_set(duel_runner *r, ray_set_name name) {
    if (!r->d->sets[name].count) return true;
    if (!trace_first(r, name)) return false;
    for (uint32_t round = 0; round < r->job->rounds; ++round) {
        for (uint32_t i = 0; i < r->d->count; ++i) {
            duel_step(r);
            if (contender_takes(&r->d->all[i], &r->d->sets[name]) &&
                !trace_round(r, i, round, name))
                return false;
        }
    }
    summarise(r, name);
    return true;
}
