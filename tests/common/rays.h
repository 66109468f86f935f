/* rays.h: seeded families of rays, most of them aimed at what breaks traversals. */
#ifndef RAYS_H
#define RAYS_H

#include "suite.h"

/* Families are numbered 0 to RAY_FAMILIES - 1; see the table in rays.c. */
enum { RAY_FAMILIES = 14 };

/* Where rays are aimed: the mesh and the box of its valid vertices (a unit box if it has none). */
typedef struct ray_target {
    const htree_mesh *mesh;
    htree_box box;
    float size; /* largest extent of the box, never 0 */
} ray_target;

ray_target ray_target_of(const htree_mesh *mesh);

const char *ray_family_name(uint32_t family);

void rays_make(const ray_target *target, uint32_t family, dice *d, htree_ray *rays, uint64_t count);

/* `count` rays, the families in turn. */
void rays_make_mixed(const ray_target *target, dice *d, htree_ray *rays, uint64_t count);

/* A ray from org towards a point, t from 0 to infinity; the point is near t = 1. */
htree_ray ray_through(const float *org, const float *point);

void random_unit(dice *d, float *out);
void random_in_box(const htree_box *box, float margin, dice *d, float *out);

#endif
