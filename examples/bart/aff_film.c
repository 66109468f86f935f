/* aff_film.c: a scene at a moment. Vertices keep their places in the arrays, so a frame is one pass
 * over the transforms and one over the vertices. */
#include "aff_read.h"
#include "loop.h"

#include <stdlib.h>
#include <string.h>

/* ---- Split triangles ------------------------------------------------------------------------ */

/* The corners of a patch at a time, in its node's space: straight lines between the keys. */
static void patch_corners(const aff_scene *s, const aff_patch *patch, double time, double *out) {
    const aff_key *keys = s->keys.at + patch->first_key;
    uint32_t i = 0;
    while (i + 1 < patch->key_count && !(time < keys[i + 1].time)) ++i;
    const aff_key *from = &keys[i], *to = &keys[i + 1 < patch->key_count ? i + 1 : i];
    const double length = to->time - from->time;
    const double u = length > 0 && time > from->time ? (time - from->time) / length : 0;
    for (int k = 0; k < 9; ++k) out[k] = (1 - u) * from->corners[k] + u * to->corners[k];
}

static float *pose_patch(const aff_scene *s, const aff_patch *patch, const affine *world,
                         double time, float *out) {
    const uint32_t n = 1u << s->split;
    double corners[9], p[3], q[3];
    patch_corners(s, patch, time, corners);
    for (uint32_t j = 0; j <= n; ++j) {
        for (uint32_t i = 0; i <= n - j; ++i) {
            const double b = (double)i / n, c = (double)j / n, a = (double)(n - i - j) / n;
            for (int k = 0; k < 3; ++k)
                p[k] = a * corners[k] + b * corners[3 + k] + c * corners[6 + k];
            affine_point(world, p, q);
            for (int k = 0; k < 3; ++k) *out++ = (float)q[k];
        }
    }
    return out;
}

/* ---- Frames --------------------------------------------------------------------------------- */

static void place_nodes(const aff_scene *s, double time, affine *world) {
    world[0] = s->nodes.at[0].local;
    for (size_t i = 1; i < s->nodes.count; ++i) {
        const aff_node *node = &s->nodes.at[i];
        const affine local = node->motion == AFF_NO_MOTION
                                 ? node->local
                                 : aff_motion_at(&s->motions.at[node->motion], time);
        world[i] = affine_multiply(&world[node->parent], &local);
    }
}

typedef struct posing {
    const aff_scene *scene;
    const affine *world;
    float *out;
} posing;

/* The part that a vertex belongs to. */
static size_t find_part(const aff_scene *s, uint64_t vertex) {
    size_t lo = 0, hi = s->parts.count;
    while (hi - lo > 1) {
        const size_t middle = lo + (hi - lo) / 2;
        if (s->parts.at[middle].first <= vertex)
            lo = middle;
        else
            hi = middle;
    }
    return lo;
}

static void pose_vertices(void *data, uint64_t first, uint64_t end) {
    const posing *p = (const posing *)data;
    const aff_scene *s = p->scene;
    size_t part = find_part(s, first);
    for (uint64_t v = first; v < end; ++v) {
        double at[3];
        while (part + 1 < s->parts.count && s->parts.at[part + 1].first <= v) ++part;
        affine_point(&p->world[s->parts.at[part].node], s->vertices.at + 3 * v, at);
        for (int k = 0; k < 3; ++k) p->out[3 * v + (uint64_t)k] = (float)at[k];
    }
}

static bool pose(const film *f, double time, uint32_t threads, film_frame *frame) {
    const aff_scene *s = (const aff_scene *)f->data;
    affine *world = (affine *)malloc(s->nodes.count * sizeof *world);
    if (!world) return false;
    place_nodes(s, time, world);
    posing p = {s, world, frame->positions};
    loop_run(threads, s->vertices.count / 3, pose_vertices, &p);
    float *out = frame->positions + s->vertices.count;
    for (size_t i = 0; i < s->patches.count; ++i)
        out = pose_patch(s, &s->patches.at[i], &world[s->patches.at[i].node], time, out);
    for (size_t i = 0; i < s->cones.count; ++i) {
        const aff_cone *c = &s->cones.at[i];
        cone_place(&frame->cones[i], &frame->boxes[i], &world[c->node], c->base, c->base_radius,
                   c->top, c->top_radius);
    }
    free(world);
    return true;
}

/* ---- The view ------------------------------------------------------------------------------- */

static const aff_motion *find(const aff_scene *s, const char *name) {
    for (size_t i = 0; i < s->motions.count; ++i)
        if (strcmp(s->motions.at[i].name, name) == 0) return &s->motions.at[i];
    return NULL;
}

/* `k camera` moves the eye and turns a view along -z with y up; what it does not say `v` does. */
static void view(const film *f, double time, double aspect, camera *out) {
    const aff_scene *s = (const aff_scene *)f->data;
    const aff_motion *motion = find(s, "camera");
    double eye[3], forward[3], up[3];
    for (int i = 0; i < 3; ++i) {
        eye[i] = s->view.from[i];
        forward[i] = s->view.at[i] - s->view.from[i];
        up[i] = s->view.up[i];
    }
    if (motion && motion->move.count) spline_point(&motion->move, time, eye);
    if (motion && motion->turn.count) {
        const affine turn = aff_motion_at(motion, time);
        for (int i = 0; i < 3; ++i) {
            up[i] = turn.m[i][1];
            forward[i] = -turn.m[i][2];
        }
    }
    camera_look(out, eye, forward, up, s->view.angle, aspect);
}

bool aff_placed(const aff_scene *scene, const char *name, double time, affine *out) {
    affine *world = (affine *)malloc(scene->nodes.count * sizeof *world);
    size_t i = 0;
    if (!world) return false;
    place_nodes(scene, time, world);
    for (i = 1; i < scene->nodes.count; ++i) {
        const int32_t motion = scene->nodes.at[i].motion;
        if (motion != AFF_NO_MOTION && strcmp(scene->motions.at[motion].name, name) == 0) break;
    }
    const bool found = i < scene->nodes.count;
    if (found) *out = world[i];
    free(world);
    return found;
}

/* ---- The film ------------------------------------------------------------------------------- */

void aff_film(const aff_scene *scene, film *out) {
    memset(out, 0, sizeof *out);
    out->from = scene->from;
    out->to = scene->to;
    out->frames = scene->frames;
    out->primitives = scene->counts.primitives;
    out->vertex_count =
        scene->vertices.count / 3 + scene->patches.count * aff_grid_vertices(scene->split);
    out->triangle_count = scene->corners.count / 3;
    out->cone_count = scene->cones.count;
    out->indices = scene->corners.at;
    out->material = scene->surface.at;
    out->materials = scene->materials.at;
    out->lights = scene->lights.at;
    out->light_count = (uint32_t)scene->lights.count;
    memcpy(out->background, scene->background, sizeof out->background);
    /* The one lamp of a large scene leaves most of it dark. */
    out->ambient = scene->lights.count > 1 ? 0.4f : 0.8f;
    out->pose = pose;
    out->view = view;
    /* The callbacks only read it; `data` is not const for films that own theirs. */
    memcpy(&out->data, &scene, sizeof out->data);
}
