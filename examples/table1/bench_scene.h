/* bench_scene.h: what a table is made over: the catalogue of Table 1's scenes and of what stands in
 * for them, built-in scenes, and meshes from files. */
#ifndef EXAMPLES_BENCH_SCENE_H
#define EXAMPLES_BENCH_SCENE_H

#include "camera.h"
#include "paper_table.h"

#include <stddef.h>

typedef enum scene_source { SCENE_CATALOGUE, SCENE_SHAPE, SCENE_MESH } scene_source;

typedef struct scene_wish {
    scene_source source;
    char name[32];      /* in the catalogue or of the shape */
    uint64_t triangles; /* of the shape */
    const char *path;   /* of the mesh */
} scene_wish;

typedef struct bench_scene {
    char name[64];
    const char *label;        /* exact, stand-in, procedural or other */
    char note[160];           /* where the mesh comes from, and which view is shown */
    const paper_scene *paper; /* NULL: not one of the paper's */
    camera_wish camera;
    shape mesh;
} bench_scene;

/* Name `index` of the catalogue, in the order of the paper's table; NULL beyond its end. */
const char *bench_scene_name(uint32_t index);

/* Reads "NAME" of the catalogue, or a built-in scene "NAME[:N]". */
bool bench_scene_parse(scene_wish *wish, const char *text);

/* A place for one more scene; NULL, after a line on stderr, where there are `most`. */
scene_wish *bench_scene_next(const char *program, scene_wish *scenes, uint32_t *count,
                             uint32_t most);

/* The value of --scene, as one scene more. */
bool bench_scene_add(const char *program, const char *text, scene_wish *scenes, uint32_t *count,
                     uint32_t most);

/* Loads or makes the mesh, and subdivides meshes from paths `levels` times. Catalogue scenes whose
 * file is not in `folder` become built-in scenes of the same size, and the note says so. `view` is
 * for meshes and shapes; the catalogue knows its own, which NULL asks for where a mesh has the name
 * of one of its files, and the view from outside elsewhere. The caller frees mesh. False writes one
 * line to `error`. */
bool bench_scene_open(bench_scene *out, const scene_wish *wish, const char *folder, uint32_t levels,
                      const camera_wish *view, char *error, size_t size);

#endif
