/* film_made.c: what the made films share: colours, light, a slow orbit of the eye. */
#include "film_made.h"

#include "numbers.h"

#include <stdlib.h>
#include <string.h>

static const film_material materials[] = {
    {{0.42f, 0.42f, 0.40f}}, /* 0: the ground */
    {{0.80f, 0.55f, 0.42f}}, /* 1: skin */
    {{0.15f, 0.17f, 0.25f}}, /* 2: trousers */
    {{0.75f, 0.16f, 0.12f}}, {{0.85f, 0.55f, 0.12f}}, {{0.16f, 0.42f, 0.66f}},
    {{0.22f, 0.52f, 0.26f}}, {{0.78f, 0.76f, 0.70f}}, /* 3 to 7: bright things */
};
static const film_light lights[] = {{{40, 90, 60}, {0.9f, 0.86f, 0.78f}}};

static void view(const film *f, double time, double aspect, camera *out) {
    static const double up[3] = {0, 1, 0};
    const film_made *made = (const film_made *)f->data;
    const double turns = made->orbit * (time - f->from) / (f->to - f->from);
    const double x = made->eye[0] - made->centre[0], z = made->eye[2] - made->centre[2];
    const double s = sin_turns(turns), c = cos_turns(turns);
    const double eye[3] = {made->centre[0] + c * x + s * z, made->eye[1],
                           made->centre[2] - s * x + c * z};
    double forward[3];
    for (int i = 0; i < 3; ++i) forward[i] = made->centre[i] - eye[i];
    camera_look(out, eye, forward, up, 40, aspect);
}

static void release(film *f) {
    film_made *made = (film_made *)f->data;
    if (!made) return;
    shape_free(&made->rest);
    free(made->material);
    free(made->parts);
    free(made);
    f->data = NULL;
}

const char *const *film_names(void) {
    static const char *const names[] = {"crowd", "explode", "cloth", NULL};
    return names;
}

static bool make_burst(film *f, film_made *made, uint64_t triangles, const shape *mesh) {
    shape knot;
    if (mesh) return film_make_burst(f, made, mesh);
    if (!shape_make(&knot, "knot", triangles, 1)) return false;
    const bool ok = film_make_burst(f, made, &knot);
    shape_free(&knot);
    return ok;
}

bool film_make(film *out, const char *name, uint64_t triangles, const shape *mesh) {
    film_made *made = (film_made *)calloc(1, sizeof *made);
    memset(out, 0, sizeof *out);
    if (!made) return false;
    out->data = made;
    out->release = release;
    out->view = view;
    out->to = 4;
    out->frames = 100;
    out->materials = materials;
    out->lights = lights;
    out->light_count = 1;
    out->ambient = 0.4f;
    for (int i = 0; i < 3; ++i) out->background[i] = 0.62f + 0.1f * (float)i;
    bool ok = false;
    if (strcmp(name, "crowd") == 0) ok = film_make_crowd(out, made, triangles);
    if (strcmp(name, "cloth") == 0) ok = film_make_cloth(out, made, triangles);
    if (strcmp(name, "explode") == 0) out->to = 2.5;
    if (strcmp(name, "explode") == 0) ok = make_burst(out, made, triangles, mesh);
    if (!ok) {
        release(out);
        return false;
    }
    out->vertex_count = made->rest.vertex_count;
    out->triangle_count = out->primitives = made->rest.triangle_count;
    out->indices = made->rest.indices;
    out->material = made->material;
    return true;
}
