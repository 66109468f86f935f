/* shape_mesh.h: a shape as the library takes it. */
#ifndef EXAMPLES_SHAPE_MESH_H
#define EXAMPLES_SHAPE_MESH_H

#include "htree.h"
#include "shapes.h"

/* Borrows the arrays of the shape. */
static inline htree_mesh shape_mesh(const shape *s) {
    htree_mesh mesh = {0};
    mesh.positions = s->positions;
    mesh.vertex_count = s->vertex_count;
    mesh.indices = s->indices;
    mesh.triangle_count = s->triangle_count;
    return mesh;
}

#endif
