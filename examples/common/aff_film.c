/* aff_film.c: a scene at a moment. Vertices keep their places in the arrays, so a frame is one pass
 * over the transforms and one over the vertices. */
#include "aff_read.h"

#include <stdlib.h>
#include <string.h>

/* ---- Split triangles ---------------------------------------------------------------------------
 */

uint32_t aff_grid_vertices(uint32_t split) {
    const uint32_t n = 1u << split;
    return (n + 1) * (n + 2) / 2;
}

uint32_t aff_grid_triangles(uint32_t split) {
    return 1u << (2 * split);
}

/* Row j of the grid has n - j + 1 vertices, from the side a-b to the corner c. */
static bool push_grid(aff_scene *s, uint32_t first, uint32_t material) {
    const uint32_t n = 1u << s->split;
    bool ok = true;
    for (uint32_t j = 0, row = first; j < n; row += n - j + 1, ++j) {
        for (uint32_t i = 0; i < n - j; ++i) {
            const uint32_t a = row + i, c = row + n - j + 1 + i;
            const uint32_t corner[6] = {a, a + 1, c, a + 1, c + 1, c};
            for (int k = 0; k < (i + 1 < n - j ? 6 : 3); ++k)
                ok = ok && aff_index_push(&s->corners, corner[k]);
            for (int k = 0; k < (i + 1 < n - j ? 2 : 1); ++k)
                ok = ok && aff_index_push(&s->surface, material);
        }
    }
    return ok;
}

static bool push_patches(aff_scene *s) {
    uint64_t first = s->vertices.count / 3;
    bool ok = true;
    for (size_t i = 0; ok && i < s->patches.count; ++i) {
        ok = first < UINT32_MAX / 2 && push_grid(s, (uint32_t)first, s->patches.at[i].material);
        first += aff_grid_vertices(s->split);
    }
    for (size_t i = 0; ok && i < s->cone_surface.count; ++i)
        ok = aff_index_push(&s->surface, s->cone_surface.at[i]);
    return ok;
}

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

/* ---- Frames --------------------------------------------------------------------------------------
 */

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

static bool pose(const film *f, double time, film_frame *frame) {
    const aff_scene *s = (const aff_scene *)f->data;
    affine *world = (affine *)malloc(s->nodes.count * sizeof *world);
    if (!world) return false;
    place_nodes(s, time, world);
    float *out = frame->positions;
    for (size_t i = 0; i < s->parts.count; ++i) {
        const aff_part *part = &s->parts.at[i];
        const size_t end = i + 1 < s->parts.count ? part[1].first : s->vertices.count / 3;
        for (size_t v = part->first; v < end; ++v) {
            double p[3];
            affine_point(&world[part->node], s->vertices.at + 3 * v, p);
            for (int k = 0; k < 3; ++k) *out++ = (float)p[k];
        }
    }
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

/* ---- The view ------------------------------------------------------------------------------------
 */

static const aff_motion *find(const aff_scene *s, const char *name) {
    for (size_t i = 0; i < s->motions.count; ++i)
        if (strcmp(s->motions.at[i].name, name) == 0) return &s->motions.at[i];
    return NULL;
}

static bool unit(double *v) {
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0 && isfinite(length))) return false;
    for (int i = 0; i < 3; ++i) v[i] /= length;
    return true;
}

static void across(const double *a, const double *b, double *out) {
    for (int i = 0; i < 3; ++i)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* `k camera` moves the eye and turns a view along -z with y up; what it does not say `v` does. */
static void view(const film *f, double time, double aspect, camera *out) {
    const aff_scene *s = (const aff_scene *)f->data;
    const aff_motion *motion = find(s, "camera");
    double up[3];
    memcpy(out->eye, s->view.from, sizeof out->eye);
    memcpy(up, s->view.up, sizeof up);
    for (int i = 0; i < 3; ++i) out->forward[i] = s->view.at[i] - s->view.from[i];
    if (motion && motion->move.count) spline_point(&motion->move, time, out->eye);
    if (motion && motion->turn.count) {
        const affine turn = aff_motion_at(motion, time);
        for (int i = 0; i < 3; ++i) {
            up[i] = turn.m[i][1];
            out->forward[i] = -turn.m[i][2];
        }
    }
    static const double spare[3][3] = {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}};
    if (!unit(out->forward)) memcpy(out->forward, spare[0], sizeof spare[0]);
    across(out->forward, up, out->right);
    for (int i = 1; i < 3 && !unit(out->right); ++i) across(out->forward, spare[i], out->right);
    across(out->right, out->forward, out->up);
    out->slope_y = tan(s->view.angle * 3.14159265358979323846 / 360);
    out->slope_x = out->slope_y * aspect;
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

/* ---- Scenes --------------------------------------------------------------------------------------
 */

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
    out->ambient = 0.35f;
    out->pose = pose;
    out->view = view;
    /* The callbacks only read it; `data` is not const for films that own theirs. */
    memcpy(&out->data, &scene, sizeof out->data);
}

aff_counts aff_count(const aff_scene *scene) {
    return scene->counts;
}

static aff_scene *start(const aff_options *options) {
    const aff_node root = {0, AFF_NO_MOTION, affine_identity()};
    const film_material grey = {{0.7f, 0.7f, 0.7f}};
    const aff_view front = {{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 45};
    aff_scene *s = (aff_scene *)calloc(1, sizeof *s);
    if (!s) return NULL;
    s->split = options->split < 6 ? options->split : 6;
    s->frames = 1;
    s->view = front;
    if (aff_node_push(&s->nodes, root) && aff_material_push(&s->materials, grey)) return s;
    aff_free(s);
    return NULL;
}

static bool finish(aff_scene *s) {
    aff_counts *c = &s->counts;
    c->primitives =
        c->mesh_triangles + c->polygons + c->cones + c->animated * aff_grid_triangles(s->split);
    return push_patches(s);
}

bool aff_read(aff_scene **out, const char *path, const aff_options *options, char *error,
              size_t size) {
    aff_error why = {error, size};
    aff_reader r;
    memset(&r, 0, sizeof r);
    if (size > 0) error[0] = 0;
    r.scene = *out = start(options);
    r.options = options;
    r.error = &why;
    bool ok = r.scene && aff_read_file(&r, path);
    if (ok && !finish(r.scene)) ok = false;
    if (ok) return true;
    if (size > 0 && !error[0]) snprintf(error, size, "%s: out of memory", path);
    aff_free(r.scene);
    *out = NULL;
    return false;
}

void aff_free(aff_scene *s) {
    if (!s) return;
    for (size_t i = 0; i < s->motions.count; ++i) {
        aff_motion *motion = &s->motions.at[i];
        free(motion->name);
        free(motion->move.keys);
        free(motion->turn.keys);
        free(motion->scale.keys);
    }
    free(s->motions.at);
    free(s->nodes.at);
    free(s->parts.at);
    free(s->vertices.at);
    free(s->corners.at);
    free(s->surface.at);
    free(s->cone_surface.at);
    free(s->cones.at);
    free(s->patches.at);
    free(s->keys.at);
    free(s->materials.at);
    free(s->lights.at);
    free(s);
}
