/* worlds.h: scenes whose changed twins have known hits: what must follow when space is scaled, mirrored or
 * turned, and triangles change their order, corners or company.
 *
 * A change is exact where float arithmetic is: powers of two, signs, the order of things. Where only the
 * order of a sum in double changes, t may move to the next float. */
#ifndef WORLDS_H
#define WORLDS_H

#include "rays.h"

enum { WORLD_TRIANGLES = 400, WORLD_RAYS = 64, WORLD_CHANGES = 15 };

/* A scene, rays and their hits; its changed twin has the hits that must follow. */
typedef struct world {
    uint32_t triangles;
    float xyz[WORLD_TRIANGLES][3][3];
    htree_ray rays[WORLD_RAYS];
    htree_hit hits[WORLD_RAYS];
    bool is_whole; /* whole numbers, small ones */
} world;

htree_mesh mesh_of_world(const world *w);
void draw_world(world *w, uint32_t number, dice *d);

/* Makes *x, the changed twin of *w, with the hits that follow. */
typedef void change_world(const world *w, world *x, dice *d);

typedef enum strictness { EXACT, NEXT_FLOAT, TIES } strictness;

typedef struct world_change {
    const char *name;
    change_world *change;
    strictness how; /* hits of the twin agree */
} world_change;

extern const world_change world_changes[WORLD_CHANGES];

#endif
