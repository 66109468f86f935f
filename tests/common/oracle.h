/* oracle.h: the answer without any tree: every triangle and every object is asked, in order.
 *
 * The oracle shares the triangle test of lib/trace/triangle.h with the library, and nothing else,
 * so a tree that prunes too much, visits too little or breaks a tie wrongly differs in some bit. */
#ifndef ORACLE_H
#define ORACLE_H

#include "suite.h"

typedef struct oracle {
    float *corners;  /* nine floats for each triangle that can be hit */
    uint32_t *prims; /* its index in the mesh, ascending */
    uint64_t count;
    uint64_t invalid;    /* left out: a NaN, an infinity or an oversize coordinate */
    uint64_t degenerate; /* left out: no area */
    uint64_t triangle_count;
    htree_objects objects; /* the caller's arrays, borrowed */
} oracle;

/* Copies the triangles; the objects of the mesh, if any, are borrowed. */
oracle oracle_of(const htree_mesh *mesh);
void oracle_free(oracle *o);

htree_hit oracle_closest(const oracle *o, const htree_ray *ray);

/* hits[i] of rays[i]; returns how many rays hit something. */
uint64_t oracle_batch(const oracle *o, const htree_ray *rays, uint64_t count, htree_hit *hits);

/* Fails the test unless the tree over the mesh answers so many rays, of all families, as the
 * oracle. */
void oracle_compare(const htree *tree, const htree_mesh *mesh, uint64_t rays, uint64_t seed);

/* Bounds of everything that can be hit, as htree_get_bounds promises them. */
htree_box oracle_bounds(const oracle *o);

#endif
