/* aff_scene.h: what aff_read.c collects and aff_film.c plays. */
#ifndef EXAMPLES_AFF_SCENE_H
#define EXAMPLES_AFF_SCENE_H

#include "aff.h"
#include "list.h"
#include "spline.h"

enum { AFF_NO_MOTION = -1 };

/* Keys of one name: `x name` moves by them, wherever in the text they stand. */
typedef struct aff_motion {
    char *name;
    bool given; /* a `k` block was read; the first one counts */
    spline move, turn, scale;
} aff_motion;

/* A transform in the tree of transforms; parents come before their children. */
typedef struct aff_node {
    uint32_t parent;
    int32_t motion; /* AFF_NO_MOTION: `local` for all times */
    affine local;
} aff_node;

/* Vertices from `first` up to the next part's belong to one node. */
typedef struct aff_part {
    uint32_t node;
    size_t first;
} aff_part;

typedef struct aff_cone {
    uint32_t node;
    double base[3], base_radius, top[3], top_radius;
} aff_cone;

/* A triangle with corners of its own at every key. */
typedef struct aff_patch {
    uint32_t node, material, key_count;
    size_t first_key;
} aff_patch;

typedef struct aff_key {
    double time, corners[9];
} aff_key;

typedef struct aff_view {
    double from[3], at[3], up[3], angle;
} aff_view;

LIST_OF(aff_motion, aff_motion)
LIST_OF(aff_node, aff_node)
LIST_OF(aff_part, aff_part)
LIST_OF(aff_cone, aff_cone)
LIST_OF(aff_patch, aff_patch)
LIST_OF(aff_key, aff_key)
LIST_OF(aff_number, double)
LIST_OF(aff_index, uint32_t)
LIST_OF(aff_material, film_material)
LIST_OF(aff_light, film_light)

struct aff_scene {
    aff_motion_list motions;
    aff_node_list nodes; /* 0 is the root: the identity */
    aff_part_list parts;
    aff_number_list vertices; /* x y z, in the space of their node */
    aff_index_list corners;   /* three per triangle */
    aff_index_list surface;   /* the material of every triangle; in the end of every cone too */
    aff_index_list cone_surface;
    aff_cone_list cones;
    aff_patch_list patches;
    aff_key_list keys;
    aff_material_list materials;
    aff_light_list lights;
    aff_view view;
    float background[3];
    double from, to;
    uint32_t frames, split;
    aff_counts counts;
};

/* Corners of a grid over a triangle that is split 4-way `split` times, and its triangles. */
uint32_t aff_grid_vertices(uint32_t split);
uint32_t aff_grid_triangles(uint32_t split);

/* The matrix of a motion's keys; what has no keys does nothing. */
affine aff_motion_at(const aff_motion *motion, double time);

#endif
