/* ray_sets.h: the rays of a scene: made once, and the same for every contender. */
#ifndef EXAMPLES_RAY_SETS_H
#define EXAMPLES_RAY_SETS_H

#include "camera.h"

typedef enum ray_set_name {
    RAYS_PRIMARY, /* one through the centre of every pixel, tile by tile */
    RAYS_AMBIENT, /* from every primary hit, cosine-distributed, as far as the reach: any hit */
    RAYS_DIFFUSE, /* from every primary hit, cosine-distributed, without end: the closest hit */
    RAY_SETS
} ray_set_name;

typedef struct ray_set {
    uint64_t count;
    uint32_t row; /* rays in a row of the picture, or of a tile; 0: neighbours do not agree */
    htree_ray *rays;
} ray_set;

typedef struct ray_wish {
    uint32_t width, height;
    uint32_t tile; /* pixels along its side; 1: row by row */
    uint32_t seed;
    double reach; /* of the ambient rays, in diagonals of the scene */
} ray_wish;

/* "primary", "ambient" or "diffuse". */
const char *ray_set_text(ray_set_name name);

/* The diagonal of the mesh's bounds. */
double ray_sets_diagonal(const shape *mesh);

/* `sets` are RAY_SETS. A tree over the mesh, of any kind, says what the primary rays hit. The caller
 * frees them in any case; on failure htree_error_text() or, for HTREE_ERROR_MEMORY, the status says
 * why. */
htree_status ray_sets_make(ray_set *sets, const ray_wish *wish, const shape *mesh,
                           const camera *view, const htree *tree);
void ray_sets_free(ray_set *sets);

#endif
