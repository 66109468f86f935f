/* aff.h: a reader for AFF, the text format of the BART scenes: includes, transforms that stand or
 * move, meshes, polygons, cones and triangles that move by themselves.
 *
 * Textures are left out: a surface has its material's colour. Needs nothing but libc and libm, as
 * the tests link this too. */
#ifndef EXAMPLES_AFF_H
#define EXAMPLES_AFF_H

#include "affine.h"
#include "film.h"

typedef struct aff_options {
    /* Triangles of meshes with two corners in one place have no area and are dropped, unless this
     * is set: it is how the published counts of the BART scenes come about. */
    bool keep_coincident;
    uint32_t split; /* animated triangles are split 4-way so many times, 0 to 6 */
} aff_options;

typedef struct aff_counts {
    uint64_t primitives; /* as published: a polygon is one, an animated triangle its parts */
    uint64_t meshes, mesh_triangles, polygons, polygon_triangles, cones, animated, dropped;
} aff_counts;

typedef struct aff_scene aff_scene;

/* Reads the file at `path` and what it includes, relative to the file that says so. False writes
 * one line, `file:line: what`, to `error`, and *out is NULL. The caller frees with aff_free. */
bool aff_read(aff_scene **out, const char *path, const aff_options *options, char *error,
              size_t size);
void aff_free(aff_scene *scene);

aff_counts aff_count(const aff_scene *scene);

/* Where the transform `x name` that comes first stands at a time; false: there is none. */
bool aff_placed(const aff_scene *scene, const char *name, double time, affine *out);

/* A film of the scene, which stays the caller's and must live as long; the film's name is NULL. */
void aff_film(const aff_scene *scene, film *out);

#endif
