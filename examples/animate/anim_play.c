/* anim_play.c: the two-core pipeline of the paper's section 9: tree n + 1 is built while frame n is
 * traced. Builder and tracer take turns on two slots; a slot is being filled or being read. */
#include "anim_play.h"

#include "loop.h"
#include "primary.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- One frame ------------------------------------------------------------------------------ */

static uint64_t pixels(const anim_stage *stage) {
    return (uint64_t)stage->args->width * stage->args->height;
}

bool anim_slot_make(anim_slot *slot, const anim_stage *stage) {
    const size_t count = (size_t)pixels(stage);
    memset(slot, 0, sizeof *slot);
    slot->rays = (htree_ray *)malloc(count * sizeof *slot->rays);
    slot->hits = (htree_hit *)malloc(count * sizeof *slot->hits);
    return slot->rays && slot->hits && film_frame_make(&slot->frame, stage->f);
}

void anim_slot_free(anim_slot *slot) {
    film_frame_free(&slot->frame);
    htree_free(slot->tree);
    free(slot->rays);
    free(slot->hits);
    memset(slot, 0, sizeof *slot);
}

static bool fail(anim_slot *slot, htree_status status) {
    const bool memory = status == HTREE_ERROR_MEMORY;
    snprintf(slot->error, sizeof slot->error, "%s", memory ? "out of memory" : htree_error_text());
    return false;
}

static void take_stats(anim_slot *slot) {
    htree_stats stats;
    stats.size = sizeof stats;
    if (htree_get_stats(slot->tree, &stats) != HTREE_OK) return;
    slot->figures.build = stats.build_seconds;
    slot->figures.nodes = (double)stats.nodes;
    slot->figures.leaves = (double)stats.leaves;
    slot->figures.references = (double)stats.references;
}

typedef struct shooting {
    const camera *view;
    uint32_t width, height;
    htree_ray *rays;
} shooting;

static void make_some(void *data, uint64_t first, uint64_t end) {
    const shooting *s = (const shooting *)data;
    for (uint64_t i = first; i < end; ++i)
        s->rays[i] = camera_ray(s->view, (double)(i % s->width) + 0.5, (double)(i / s->width) + 0.5,
                                s->width, s->height);
}

static void make_rays(anim_slot *slot, const anim_stage *stage) {
    const uint32_t width = stage->args->width, height = stage->args->height;
    shooting s = {&slot->view, width, height, slot->rays};
    stage->f->view(stage->f, slot->figures.time, (double)width / height, &slot->view);
    loop_run(stage->args->threads, pixels(stage), make_some, &s);
}

/* From the second frame of a slot on its tree is built in the memory of the one before. */
static htree_status build(anim_slot *slot, const anim_stage *stage, const htree_mesh *mesh) {
    htree_options options;
    if (slot->tree) return htree_update(slot->tree, mesh, HTREE_REBUILD, NULL);
    const htree_status status = htree_options_init(&options, sizeof options, stage->args->kind);
    if (status != HTREE_OK) return status;
    options.threads = stage->args->threads;
    if (stage->args->lazy) options.flags |= HTREE_LAZY;
    return htree_build(&slot->tree, mesh, &options);
}

bool anim_build(anim_slot *slot, const anim_stage *stage, uint32_t index) {
    memset(&slot->figures, 0, sizeof slot->figures);
    slot->figures.time = stage->times[index];
    const double start = clock_seconds();
    if (!stage->f->pose(stage->f, slot->figures.time, stage->args->threads, &slot->frame))
        return fail(slot, HTREE_ERROR_MEMORY);
    slot->figures.pose = clock_seconds() - start;
    const htree_mesh mesh = film_mesh(stage->f, &slot->frame);
    const htree_status status = build(slot, stage, &mesh);
    if (status != HTREE_OK) return fail(slot, status);
    make_rays(slot, stage);
    return true;
}

static htree_status query(anim_slot *slot, const anim_stage *stage, htree_counters *counters) {
    htree_query q;
    const htree_status status = htree_query_init(&q, sizeof q);
    q.threads = stage->args->threads;
    q.counters = counters;
    if (status != HTREE_OK) return status;
    return htree_intersect(slot->tree, slot->rays, pixels(stage), slot->hits, &q);
}

bool anim_trace(anim_slot *slot, const anim_stage *stage) {
    const double start = clock_seconds();
    const htree_status status = query(slot, stage, NULL);
    slot->figures.trace = clock_seconds() - start;
    return status == HTREE_OK || fail(slot, status);
}

bool anim_count(anim_slot *slot, const anim_stage *stage) {
    const uint64_t count = pixels(stage);
    anim_figures *a = &slot->figures;
    htree_counters *c = (htree_counters *)malloc((size_t)count * sizeof *c);
    const htree_status status = c ? query(slot, stage, c) : HTREE_ERROR_MEMORY;
    for (uint64_t i = 0; status == HTREE_OK && i < count; ++i) {
        a->intersections += c[i].intersections;
        a->traversal_steps += c[i].traversal_steps;
        a->leaf_steps += c[i].leaf_steps;
        a->hit_fraction += slot->hits[i].prim != HTREE_NONE;
    }
    free(c);
    if (status != HTREE_OK) return fail(slot, status);
    a->intersections /= (double)count;
    a->traversal_steps /= (double)count;
    a->leaf_steps /= (double)count;
    a->hit_fraction /= (double)count;
    take_stats(slot);
    return true;
}

/* ---- Two at once ---------------------------------------------------------------------------- */

typedef struct belt {
    anim_slot *slots;
    const anim_stage *stage;
    pthread_mutex_t lock;
    pthread_cond_t moved;
    uint32_t built, traced; /* frames that are done; built - traced is at most 2 */
    bool stop;
} belt;

/* Waits until frame `index` may be built, or may be traced. False: the other side failed. */
static bool wait_for(belt *b, uint32_t index, bool build) {
    pthread_mutex_lock(&b->lock);
    while (!b->stop && (build ? index >= b->traced + 2 : index >= b->built))
        pthread_cond_wait(&b->moved, &b->lock);
    const bool go = !b->stop;
    pthread_mutex_unlock(&b->lock);
    return go;
}

static void done(belt *b, bool build, bool ok) {
    pthread_mutex_lock(&b->lock);
    if (build)
        ++b->built;
    else
        ++b->traced;
    if (!ok) b->stop = true;
    pthread_cond_broadcast(&b->moved);
    pthread_mutex_unlock(&b->lock);
}

static void *run_builder(void *data) {
    belt *b = (belt *)data;
    for (uint32_t i = 0; i < b->stage->count && wait_for(b, i, true); ++i)
        done(b, true, anim_build(&b->slots[i % 2], b->stage, i));
    return NULL;
}

bool anim_pipeline(anim_slot *slots, const anim_stage *stage, double *seconds) {
    belt b;
    pthread_t builder;
    memset(&b, 0, sizeof b);
    b.slots = slots;
    b.stage = stage;
    pthread_mutex_init(&b.lock, NULL);
    pthread_cond_init(&b.moved, NULL);
    const double start = clock_seconds();
    const bool started = pthread_create(&builder, NULL, run_builder, &b) == 0;
    if (!started) snprintf(slots->error, sizeof slots->error, "cannot start a second thread");
    for (uint32_t i = 0; started && i < stage->count && wait_for(&b, i, false); ++i)
        done(&b, false, anim_trace(&slots[i % 2], stage));
    if (started) pthread_join(builder, NULL);
    *seconds = clock_seconds() - start;
    pthread_cond_destroy(&b.moved);
    pthread_mutex_destroy(&b.lock);
    return started && !b.stop;
}
