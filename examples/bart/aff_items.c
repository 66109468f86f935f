/* aff_items.c: the statements that make something to be seen. Counts in the text are never trusted
 * with memory: lists grow by what is really there. */
#include "aff_read.h"

#include <string.h>

/* ---- Vertices and triangles ----------------------------------------------------------------- */

static uint32_t current_material(const aff_reader *r) {
    return (uint32_t)r->scene->materials.count - 1;
}

static bool add_vertex(aff_reader *r, const double *xyz) {
    aff_scene *s = r->scene;
    const size_t first = s->vertices.count / 3;
    /* A quarter of what indices could name: split patches come on top. */
    if (first >= UINT32_MAX / 4) return aff_fail(r->lexer, "more than 2^30 vertices");
    if (s->parts.count == 0 || s->parts.at[s->parts.count - 1].node != r->node) {
        const aff_part part = {r->node, first};
        if (!aff_part_push(&s->parts, part)) return aff_no_memory(r);
    }
    for (int i = 0; i < 3; ++i)
        if (!aff_number_push(&s->vertices, xyz[i])) return aff_no_memory(r);
    return true;
}

static bool same_place(const aff_scene *s, uint32_t a, uint32_t b) {
    const double *p = s->vertices.at + 3 * (size_t)a, *q = s->vertices.at + 3 * (size_t)b;
    return p[0] == q[0] && p[1] == q[1] && p[2] == q[2];
}

static bool add_triangle(aff_reader *r, uint32_t a, uint32_t b, uint32_t c, uint64_t *counter) {
    aff_scene *s = r->scene;
    const bool flat = same_place(s, a, b) || same_place(s, b, c) || same_place(s, c, a);
    if (flat && !r->options->keep_coincident) {
        ++s->counts.dropped;
        return true;
    }
    if (s->surface.count >= UINT32_MAX / 4) return aff_fail(r->lexer, "more than 2^30 triangles");
    ++*counter;
    return (aff_index_push(&s->corners, a) && aff_index_push(&s->corners, b) &&
            aff_index_push(&s->corners, c) && aff_index_push(&s->surface, current_material(r))) ||
           aff_no_memory(r);
}

/* ---- Meshes --------------------------------------------------------------------------------- */

enum { VERTICES, NORMALS, TEXTURE, ARRAYS };

/* `vertices n`, `normals n`, `texturecoords n file` and what they list; only positions are kept. */
static bool read_array(aff_reader *r, int which, uint32_t *count) {
    double n[3];
    if (!aff_whole(r->lexer, 0, UINT32_MAX / 4, count, "a number of entries")) return false;
    if (which == TEXTURE && !aff_is_number(aff_peek(r->lexer))) aff_next(r->lexer);
    for (uint32_t i = 0; i < *count; ++i) {
        if (!aff_numbers(r->lexer, n, which == TEXTURE ? 2 : 3, "a number of a mesh")) return false;
        if (which == VERTICES && !add_vertex(r, n)) return false;
    }
    return true;
}

/* Three indices into the vertices, then three into every other array that there is. */
static bool read_mesh_triangles(aff_reader *r, uint32_t first, const uint32_t *counts) {
    uint32_t triangles, corner[3], ignored;
    if (!aff_whole(r->lexer, 0, UINT32_MAX / 4, &triangles, "a number of triangles")) return false;
    for (uint32_t i = 0; i < triangles; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (counts[VERTICES] == 0 ||
                !aff_whole(r->lexer, 0, counts[VERTICES] - 1, &corner[k], "a vertex of the mesh"))
                return aff_fail(r->lexer, "a triangle in a mesh without vertices");
            corner[k] += first;
        }
        for (int array = NORMALS; array < ARRAYS; ++array)
            for (int k = 0; counts[array] > 0 && k < 3; ++k)
                if (!aff_whole(r->lexer, 0, counts[array] - 1, &ignored, "an index of the mesh"))
                    return false;
        if (!add_triangle(r, corner[0], corner[1], corner[2], &r->scene->counts.mesh_triangles))
            return false;
    }
    return true;
}

bool aff_read_mesh(aff_reader *r) {
    static const char *const names[ARRAYS] = {"vertices", "normals", "texturecoords"};
    uint32_t counts[ARRAYS] = {0, 0, 0};
    const uint32_t first = (uint32_t)(r->scene->vertices.count / 3);
    ++r->scene->counts.meshes;
    for (int i = 0; i < ARRAYS; ++i) {
        if (!aff_is(aff_peek(r->lexer), names[i])) continue;
        aff_next(r->lexer);
        if (!read_array(r, i, &counts[i])) return false;
    }
    return aff_expect(r->lexer, "triangles", "'triangles'") &&
           read_mesh_triangles(r, first, counts);
}

/* ---- Polygons ------------------------------------------------------------------------------- */

/* A fan around the first corner, as they come, so that any number of them needs no memory here. */
static bool read_corners(aff_reader *r, uint32_t count, uint32_t numbers) {
    const uint32_t first = (uint32_t)(r->scene->vertices.count / 3);
    double n[8];
    ++r->scene->counts.polygons;
    for (uint32_t i = 0; i < count; ++i) {
        if (!aff_numbers(r->lexer, n, numbers, "a number of a polygon") || !add_vertex(r, n))
            return false;
        if (i >= 2 &&
            !add_triangle(r, first, first + i - 1, first + i, &r->scene->counts.polygon_triangles))
            return false;
    }
    return true;
}

bool aff_read_polygon(aff_reader *r, uint32_t numbers) {
    uint32_t count;
    return aff_whole(r->lexer, 3, UINT32_MAX / 4, &count, "a number of corners from 3 on") &&
           read_corners(r, count, numbers);
}

bool aff_read_textured(aff_reader *r, uint32_t numbers) {
    aff_next(r->lexer); /* the texture */
    return read_corners(r, 3, numbers);
}

/* ---- Cones and patches ---------------------------------------------------------------------- */

bool aff_read_cone(aff_reader *r) {
    aff_scene *s = r->scene;
    double n[8];
    if (!aff_numbers(r->lexer, n, 8, "a number of a cone")) return false;
    if (!(n[3] >= 0 && n[7] >= 0)) return aff_fail(r->lexer, "a cone with a negative radius");
    aff_cone item;
    item.node = r->node;
    memcpy(item.base, n, sizeof item.base);
    memcpy(item.top, n + 4, sizeof item.top);
    item.base_radius = n[3];
    item.top_radius = n[7];
    ++s->counts.cones;
    return (aff_cone_push(&s->cones, item) &&
            aff_index_push(&s->cone_surface, current_material(r))) ||
           aff_no_memory(r);
}

/* `tpa k`: k times, each with three corners of a position and a normal. */
bool aff_read_patch(aff_reader *r) {
    aff_scene *s = r->scene;
    aff_patch patch = {r->node, current_material(r), 0, s->keys.count};
    if (!aff_whole(r->lexer, 1, 1 << 20, &patch.key_count, "a number of keys")) return false;
    for (uint32_t i = 0; i < patch.key_count; ++i) {
        aff_key key;
        double corner[6];
        if (!aff_numbers(r->lexer, &key.time, 1, "the time of a key")) return false;
        if (i > 0 && key.time < s->keys.at[s->keys.count - 1].time)
            return aff_fail(r->lexer, "the keys of an animated triangle are not in order of time");
        for (int k = 0; k < 3; ++k) {
            if (!aff_numbers(r->lexer, corner, 6, "a number of an animated triangle")) return false;
            memcpy(key.corners + 3 * k, corner, 3 * sizeof *corner);
        }
        if (!aff_key_push(&s->keys, key)) return aff_no_memory(r);
    }
    if (s->patches.count >= (UINT32_MAX / 4) >> (2 * s->split))
        return aff_fail(r->lexer, "more than 2^30 triangles when all are split");
    ++s->counts.animated;
    return aff_patch_push(&s->patches, patch) || aff_no_memory(r);
}
