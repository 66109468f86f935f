/* saved.h: small trees of every kind as files, for tests that keep them and for tests that break them.
 */
#ifndef SAVED_H
#define SAVED_H

#include "rays.h"
#include "suite.h"

/* A file in memory of its own size, at a multiple of 64 bytes. */
typedef struct saved {
    char *bytes;
    uint64_t size;
} saved;

saved saved_of(const htree *tree);
saved saved_copy(const void *bytes, uint64_t size);
void saved_free(saved *file);

/* Writes the checksum that the file should have. */
void saved_seal(saved *file);

/* Scenes for small files. Objects, if there are any, are balls in their boxes. */
enum { SEED_NONE, SEED_TRIANGLE, SEED_KNOT, SEED_BALLS, SEED_BOTH, SEED_SCENES };

typedef struct seed_scene {
    shape mesh;
    htree_box boxes[16];
    htree_objects objects;
    htree_mesh input;
    ray_target target;
} seed_scene;

/* The scene must not move: its parts refer to each other. */
void seed_scene_make(seed_scene *scene, int which, uint64_t triangles);
void seed_scene_free(seed_scene *scene);

/* The kinds that files are made of: those of the library, and compact wide trees. */
enum { SEED_COMPACT = HTREE_WIDE + 1 };
htree_kind next_seed_kind(htree_kind kind);

/* The tree of the scene: with any set of planes, where the kind knows them. */
htree *seed_tree(const seed_scene *scene, htree_kind kind);

/* The options that a file of any seed needs. */
htree_load_options seed_load_options(const seed_scene *scene);

#endif
