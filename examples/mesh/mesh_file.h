/* mesh_file.h: a mesh from a file of any format: PLY by our own reader, the others by assimp. */
#ifndef EXAMPLES_MESH_FILE_H
#define EXAMPLES_MESH_FILE_H

#include "shapes.h"

#include <stddef.h>

/* As ply_read: false writes one line to `error` and leaves *out empty. */
bool mesh_file_read(const char *path, shape *out, char *error, size_t size);

#endif
