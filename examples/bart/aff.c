/* aff.c: scenes from start to end. The triangles of split patches come behind those of the meshes,
 * when the number of vertices before them is known. */
#include "aff_read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- Split triangles ------------------------------------------------------------------------ */

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

/* ---- Scenes --------------------------------------------------------------------------------- */

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
