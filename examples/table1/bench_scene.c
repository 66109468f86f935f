/* bench_scene.c: the paper's larger scans are not at hand in full, so smaller ones are subdivided
 * to nearly the same number of triangles. What is shown is labelled for what it is. */
#include "bench_scene.h"

#include "mesh_file.h"
#include "option.h"
#include "subdivide.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct entry {
    const char *name, *file, *paper;
    const char *label, *about;
    uint32_t levels;
    camera_mode view;
    const char *shape; /* without the file */
    uint64_t triangles;
} entry;

static const entry catalogue[] = {
    {"conference", "conference.ply", NULL, "other",
     "the conference room as remodelled since; the paper's has 17,936", 0, CAMERA_INSIDE, "crowd",
     331179},
    {"sibenik", "sibenik.ply", NULL, "other", "Sibenik cathedral, not in the paper", 0,
     CAMERA_INSIDE, "city", 75284},
    {"bunny", "bunny.ply", "Bunny", "exact", "the paper's mesh", 0, CAMERA_OUTSIDE, "knot", 69451},
    {"armadillo", "armadillo_86k.ply", "Armadillo", "stand-in", "Armadillo, reduced, subdivided x4",
     1, CAMERA_OUTSIDE, "knot", 345928},
    {"dragon", "dragon_res2.ply", "Dragon", "stand-in", "Dragon at half resolution, subdivided x4",
     1, CAMERA_OUTSIDE, "knot", 810080},
    {"buddha", "buddha_res3.ply", "Happy Buddha", "stand-in",
     "Happy Buddha at a third of its resolution, subdivided x16", 2, CAMERA_OUTSIDE, "terrain",
     1075840},
    {"lucy", "lucy_100k.ply", "Blade", "stand-in", "Lucy, reduced, subdivided x16, for the Blade",
     2, CAMERA_OUTSIDE, "knot", 1599520},
};

enum { ENTRY_COUNT = sizeof catalogue / sizeof *catalogue };

static const entry *find_entry(const char *name) {
    for (int i = 0; i < ENTRY_COUNT; ++i)
        if (strcmp(catalogue[i].name, name) == 0) return &catalogue[i];
    return NULL;
}

const char *bench_scene_name(uint32_t index) {
    return index < ENTRY_COUNT ? catalogue[index].name : NULL;
}

bool bench_scene_parse(scene_wish *wish, const char *text) {
    memset(wish, 0, sizeof *wish);
    if (find_entry(text)) {
        snprintf(wish->name, sizeof wish->name, "%s", text);
        return true;
    }
    wish->source = SCENE_SHAPE;
    return option_shape(text, wish->name, &wish->triangles);
}

scene_wish *bench_scene_next(const char *program, scene_wish *scenes, uint32_t *count,
                             uint32_t most) {
    if (*count < most) return &scenes[(*count)++];
    option_wrong(program, "more than %u scenes", most);
    return NULL;
}

bool bench_scene_add(const char *program, const char *text, scene_wish *scenes, uint32_t *count,
                     uint32_t most) {
    scene_wish *wish = bench_scene_next(program, scenes, count, most);
    if (!wish) return false;
    if (bench_scene_parse(wish, text)) return true;
    if (shape_text(wish->name))
        return option_wrong(program, "--scene %s: after ':' give a number of triangles up to 2^30",
                            text);
    char known[256] = "";
    for (uint32_t i = 0; bench_scene_name(i); ++i) {
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, " %s", bench_scene_name(i));
    }
    for (const char *const *name = shape_names(); *name; ++name) {
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, " %s", *name);
    }
    return option_wrong(program, "--scene %s: no such scene; choose from%s", text, known);
}

/* ---- Opening -------------------------------------------------------------------------------- */

static bool fail(char *error, size_t size, const char *text) {
    snprintf(error, size, "%s", text);
    return false;
}

static const char *view_name(const camera_wish *view) {
    return view->mode == CAMERA_INSIDE    ? "seen from inside"
           : view->mode == CAMERA_OUTSIDE ? "seen from outside"
                                          : "seen as given";
}

static bool open_shape(bench_scene *out, const char *name, uint64_t triangles, char *error,
                       size_t size) {
    out->label = "procedural";
    return shape_make(&out->mesh, name, triangles, 1) ||
           fail(error, size, "out of memory: try a smaller scene");
}

static bool open_mesh(bench_scene *out, const char *path, uint32_t levels, char *error,
                      size_t size) {
    if (!mesh_file_read(path, &out->mesh, error, size)) return false;
    if (subdivide_loop(&out->mesh, levels)) return true;
    shape_free(&out->mesh);
    return fail(error, size, "out of memory: try fewer levels of subdivision");
}

static bool exists(const char *path) {
    FILE *file = fopen(path, "rb");
    if (file) fclose(file);
    return file != NULL;
}

static bool open_entry(bench_scene *out, const entry *e, const char *folder, char *error,
                       size_t size) {
    const size_t length = strlen(folder) + strlen(e->file) + 2;
    char *path = (char *)malloc(length);
    if (!path) return fail(error, size, "out of memory");
    snprintf(path, length, "%s/%s", folder, e->file);
    out->label = e->label;
    bool ok;
    if (exists(path)) {
        out->camera.mode = e->view;
        out->paper = e->paper ? paper_find_scene(e->paper) : NULL;
        snprintf(out->note, sizeof out->note, "%s, %s", e->about, view_name(&out->camera));
        ok = open_mesh(out, path, e->levels, error, size);
    } else {
        snprintf(out->name, sizeof out->name, "%s:%llu", e->shape,
                 (unsigned long long)e->triangles);
        snprintf(out->note, sizeof out->note, "built-in, in place of %s, which is missing, %s",
                 e->file, view_name(&out->camera));
        ok = open_shape(out, e->shape, e->triangles, error, size);
    }
    free(path);
    return ok;
}

/* A mesh of the paper's count of triangles is taken for the paper's: the Bunny in full
 * resolution. */
static void recognise(bench_scene *out) {
    const paper_scene *bunny = paper_find_scene("Bunny");
    const bool same = out->mesh.triangle_count == bunny->primitives;
    if (same) out->paper = bunny;
    out->label = same ? "exact" : "other";
}

bool bench_scene_open(bench_scene *out, const scene_wish *wish, const char *folder, uint32_t levels,
                      const camera_wish *view, char *error, size_t size) {
    memset(out, 0, sizeof *out);
    out->camera.up = 1;
    snprintf(out->name, sizeof out->name, "%s", wish->name);
    if (wish->source == SCENE_CATALOGUE)
        return open_entry(out, find_entry(wish->name), folder, error, size);
    if (view) out->camera = *view;
    if (wish->source == SCENE_SHAPE) {
        snprintf(out->note, sizeof out->note, "built-in, %s", view_name(&out->camera));
        return open_shape(out, wish->name, wish->triangles, error, size);
    }
    const char *slash = strrchr(wish->path, '/');
    snprintf(out->name, sizeof out->name, "%s", slash && slash[1] ? slash + 1 : wish->path);
    if (!open_mesh(out, wish->path, levels, error, size)) return false;
    for (int i = 0; !view && i < ENTRY_COUNT; ++i)
        if (strcmp(catalogue[i].file, out->name) == 0) out->camera.mode = catalogue[i].view;
    const char *more = levels ? ", subdivided" : "";
    snprintf(out->note, sizeof out->note, "from a file%s, %s", more, view_name(&out->camera));
    recognise(out);
    return true;
}
