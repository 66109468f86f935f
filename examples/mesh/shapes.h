/* shapes.h: the built-in scenes, made by rule from a name, a size and a seed.
 *
 * The same arguments give the same bits everywhere. Depends on libc and libm alone, because the
 * tests link it too. y is up. */
#ifndef EXAMPLES_SHAPES_H
#define EXAMPLES_SHAPES_H

#include <stdbool.h>
#include <stdint.h>

/* Triangles over shared vertices: x y z per vertex, three indices per triangle. */
typedef struct shape {
    float *positions;
    uint32_t *indices;
    uint64_t vertex_count, triangle_count;
} shape;

/* Makes scene `name`. soup, slivers, stack and same have exactly `triangles` triangles, one and
 * none have as many as they say, and every other scene the nearest size that its grid can take,
 * which for tiny requests is more. False: no such scene, or no memory; then *out is empty. */
bool shape_make(shape *out, const char *name, uint64_t triangles, uint32_t seed);

/* Frees the arrays and empties *s, which may be empty already. */
void shape_free(shape *s);

/* Names of all scenes, ending in NULL. */
const char *const *shape_names(void);

/* One line on scene `name`, and a good size for it; NULL and 0 if there is no such scene. */
const char *shape_text(const char *name);
uint64_t shape_default_triangles(const char *name);

#endif
