/* subdivide.h: Loop subdivision of triangle meshes: each triangle becomes four, and the surface
 * gets smoother. Makes large meshes of small ones. */
#ifndef EXAMPLES_SUBDIVIDE_H
#define EXAMPLES_SUBDIVIDE_H

#include "shapes.h"

/* Subdivides *mesh `levels` times in place: 4^levels times the triangles. Edges with one
 * triangle, or with more than two, stay where they are as a curve; vertices where several sheets
 * meet stay as points. Every edge gets one new vertex, so a closed mesh stays closed. Expected
 * O(N), by a hash of the edges. False: no memory, or more vertices than 32 bits can count; then
 * *mesh is unchanged but for whole levels. */
bool subdivide_loop(shape *mesh, uint32_t levels);

#endif
