/* ray_sets.h: the rays of a scene: made once, or loaded, and the same for every contender. */
#ifndef EXAMPLES_RAY_SETS_H
#define EXAMPLES_RAY_SETS_H

#include "camera.h"

#include <stddef.h>

typedef enum ray_set_name {
    RAYS_PRIMARY, /* one through the centre of every pixel, tile by tile */
    RAYS_FRAME,   /* the same for a smaller picture: the frame of T_T */
    RAYS_AMBIENT, /* several from every hit of the frame, cosine-distributed, as far as the reach: any
                     hit */
    RAYS_DIFFUSE, /* from every primary hit, cosine-distributed, without end: the closest hit */
    RAYS_SHADOW,  /* from every primary hit to the lamp: any hit */
    RAY_SETS
} ray_set_name;

typedef struct ray_set {
    uint64_t count;
    uint32_t row; /* rays in a row of the picture, or of a tile; 0: neighbours do not agree */
    char note[120];
    htree_ray *rays;
} ray_set;

typedef struct ray_wish {
    uint32_t width, height; /* of the picture; the primary hits are its */
    uint32_t frame;         /* the frame's side, in pixels */
    uint32_t tile;          /* pixels along its side; 1: row by row */
    uint32_t ambient;       /* rays a hit */
    uint32_t seed;
    double reach; /* of the ambient rays, in diagonals of the scene */
} ray_wish;

/* "primary", "frame", "ambient", "diffuse" or "shadow"; and whether any hit will do. */
const char *ray_set_text(ray_set_name name);
bool ray_set_any(ray_set_name name);

/* `sets` are RAY_SETS. A tree over the mesh, of any kind, says what the primary rays hit. The caller
 * frees them in any case; on failure htree_error_text() or, for HTREE_ERROR_MEMORY, the status says
 * why. */
htree_status ray_sets_make(ray_set *sets, const ray_wish *wish, const shape *mesh,
                           const camera_wish *view, const htree *tree);
void ray_sets_free(ray_set *sets);

/* A file that others can read: lines of text up to "end", which say what is in it, then 32 bytes a ray,
 * as in memory. `triangles` are the scene's: rays of another scene are refused. False writes one line
 * to `error`; sets that could not be loaded are empty. */
bool ray_sets_save(const ray_set *sets, uint64_t triangles, const char *path, char *error,
                   size_t size);
bool ray_sets_load(ray_set *sets, uint64_t triangles, const char *path, char *error, size_t size);

#endif
