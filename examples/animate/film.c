/* film.c: films of either kind behind one door, and the frames that all of them fill. */
#include "film.h"

#include "aff.h"
#include "film_made.h"
#include "mesh_file.h"
#include "option.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DEFAULT_TRIANGLES = 100000 };

/* ---- Opening -------------------------------------------------------------------------------- */

static void release_aff(film *f) {
    aff_free((aff_scene *)f->data);
    f->data = NULL;
}

static bool open_aff(film *out, const film_wish *wish, char *error, size_t size) {
    const aff_options options = {wish->keep_coincident, wish->split};
    const char *slash = strrchr(wish->scene, '/');
    aff_scene *scene;
    if (!aff_read(&scene, wish->scene, &options, error, size)) return false;
    aff_film(scene, out);
    out->release = release_aff;
    out->name = slash && slash[1] ? slash + 1 : wish->scene;
    return true;
}

/* The made film that `text` names, NAME or NAME:TRIANGLES, or NULL. */
static const char *made_name(const char *text, uint64_t *triangles) {
    const size_t length = strcspn(text, ":");
    *triangles = DEFAULT_TRIANGLES;
    for (const char *const *name = film_names(); *name; ++name) {
        if (strlen(*name) != length || memcmp(*name, text, length) != 0) continue;
        if (!text[length] || option_number(text + length + 1, 0, 1, 1 << 28, triangles))
            return *name;
    }
    return NULL;
}

bool film_open(film *out, const film_wish *wish, char *error, size_t size) {
    uint64_t triangles;
    shape mesh;
    const char *name = made_name(wish->scene, &triangles);
    memset(out, 0, sizeof *out);
    if (!name) {
        char cause[400];
        if (open_aff(out, wish, cause, sizeof cause)) return true;
        snprintf(error, size, "%s; give an AFF file, or crowd, explode or cloth", cause);
        return false;
    }
    memset(&mesh, 0, sizeof mesh);
    if (wish->mesh && !mesh_file_read(wish->mesh, &mesh, error, size)) return false;
    const bool ok = film_make(out, name, triangles, wish->mesh ? &mesh : NULL);
    shape_free(&mesh);
    if (!ok) snprintf(error, size, "out of memory: try a smaller scene");
    return ok;
}

void film_close(film *f) {
    if (f->release) f->release(f);
    memset(f, 0, sizeof *f);
}

/* ---- Frames --------------------------------------------------------------------------------- */

bool film_frame_make(film_frame *out, const film *f) {
    memset(out, 0, sizeof *out);
    out->positions = (float *)calloc((size_t)f->vertex_count + 1, 3 * sizeof(float));
    out->cones = (cone *)calloc((size_t)f->cone_count + 1, sizeof(cone));
    out->boxes = (htree_box *)calloc((size_t)f->cone_count + 1, sizeof(htree_box));
    if (!out->positions || !out->cones || !out->boxes) {
        film_frame_free(out);
        return false;
    }
    out->objects.boxes = out->boxes;
    out->objects.count = f->cone_count;
    out->objects.intersect = cone_intersect;
    out->objects.user = out->cones;
    return true;
}

void film_frame_free(film_frame *frame) {
    free(frame->positions);
    free(frame->cones);
    free(frame->boxes);
    memset(frame, 0, sizeof *frame);
}

htree_mesh film_mesh(const film *f, const film_frame *frame) {
    htree_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = frame->positions;
    mesh.vertex_count = f->vertex_count;
    mesh.indices = f->indices;
    mesh.triangle_count = f->triangle_count;
    if (f->cone_count > 0) mesh.objects = &frame->objects;
    return mesh;
}
