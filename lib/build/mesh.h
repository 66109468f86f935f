/* mesh.h: the caller's mesh: its check, and its way into a tree. */
#ifndef HT_MESH_H
#define HT_MESH_H

#include "source.h"

htree_status ht_verify_mesh(const htree_mesh *mesh);

/* Copies the boxes of user objects into the tree; those that are skipped become empty. */
htree_status ht_copy_objects(ht_builder *builder);

/* Copies the triangles into the tree, and what can be hit into builder->prims, in order of id; sets
 * the tree's bounds and counts. On all cores. */
htree_status ht_load_mesh(ht_builder *builder);

#endif
