/* ply.h: a reader for the PLY polygon format: ascii, binary of either byte order, any properties in
 * any order. */
#ifndef EXAMPLES_PLY_H
#define EXAMPLES_PLY_H

#include "shapes.h"

#include <stddef.h>

/* Reads the file at `path`; polygons become fans of triangles, and everything but positions and
 * faces is skipped. The caller frees *out with shape_free. False: *out is empty, and `error` says
 * on one line which file, which line or byte, and why. The file's bytes are never trusted. */
bool ply_read(const char *path, shape *out, char *error, size_t size);

#endif
