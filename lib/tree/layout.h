/* layout.h: the nodes of every structure, as builders write them and walks read them.
 *
 * Also read by OpenCL C: plain structs of float and uint, no pointers, no unions. A slot is an
 * index into the array of nodes. Words that a node type does not use are 0. */
#ifndef HT_LAYOUT_H
#define HT_LAYOUT_H

#ifndef __OPENCL_C_VERSION__
#include <stdint.h>
typedef uint32_t ht_word;
#else
typedef uint ht_word;
#endif

/* Levels of branching that builders stay within and that traversal stacks are made for. */
#define HT_MAX_DEPTH 96

/* ---- BVH: 32 bytes a node, children are neighbours ------------------------------------------ */

#define HT_BVH_LEAF 3u

typedef struct ht_bvh_node {
    float lo[3];
    ht_word child; /* interior: slot of the left child, the right one follows it; leaf: the prim */
    float hi[3];
    ht_word tag; /* interior: the axis that was split, 0 to 2; leaf: HT_BVH_LEAF */
} ht_bvh_node;

/* ---- H-tree: the paper's node types in 16 bytes (four planes or more: 32), depth first ------ */

/*   type        a          b          child               the node's child is
 *   LEAF        -          -          prim                none
 *   SKD_X..Z    left max   right min  slot of the right   the next slot: left; `child`: right
 *   BV2_X..Z    lo         hi         -                   the next slot
 *   BV6         planes 0 to 2, and 3 to 5 in the second   two slots on
 *   LINK        -          -          slot                `child`: nodes come in chunks (section 6.2)
 *   BVO         as many planes as its set has             one or two slots on
 *
 * Planes are numbered lo x, lo y, lo z, hi x, hi y, hi z. Three fit into a slot: a, b, and the word
 * `child` as a float. The tag's upper 28 bits are, of an SKD node, the slot of its ternary child, the
 * tree over its oversize shelf (section 7.2), or 0; of a BVO node, its set of planes. */
#define HT_H_LEAF 0u
#define HT_H_SKD  1u /* + axis */
#define HT_H_BV2  4u /* + axis */
#define HT_H_BV6  7u
#define HT_H_LINK 8u
#define HT_H_BVO  9u

#define HT_H_TYPE     15u
#define HT_H_TAG_BITS 4u
#define HT_H_SLOTS    0x10000000u

#define HT_H_CHUNK_SLOTS 1024u      /* 16 KiB */
#define HT_H_PRIMS       0x3fc0000u /* four slots each, and what chunks lose at their ends */
#define HT_ALL_PLANES    63u

typedef struct ht_h_node {
    float a, b;
    ht_word child;
    ht_word tag;
} ht_h_node;

/* ---- kd-tree: 8 bytes a node, depth first --------------------------------------------------- */

/* Interior: plane, and tag = slot of the right child << 2 | axis; the left child is the next
 * slot. Leaf: plane holds the bits of the index of its first reference, tag = references << 2 |
 * HT_KD_LEAF. */
#define HT_KD_LEAF  3u
#define HT_KD_SLOTS 0x40000000u

typedef struct ht_kd_node {
    float plane;
    ht_word tag;
} ht_kd_node;

/* ---- Uniform grid: a slot per cell, x fastest ----------------------------------------------- */

/* The references of cell i are refs[node i .. node i + 1); one more node than cells. */
typedef ht_word ht_ug_node;

typedef struct ht_ug_grid {
    float lo[3], hi[3]; /* the bounds, and a margin that no clipped ray leaves */
    float size[3];      /* of a cell */
    ht_word cells[3];   /* along each axis */
    float reach; /* rays that see the bounds from farther off are walked with their own pad */
} ht_ug_grid;

/* ---- Wide tree: eight children a node, eight triangles a leaf, lane by lane ------------------ */

#define HT_LANES     8u
#define HT_LANE_BITS 3u
#define HT_WIDE_LEAF 0x80000000u
#define HT_WIDE_NONE 0xffffffffu

/* Both upper bits: a subtree of a lazy tree, by its number, that may have to be built first. So a wide
 * tree holds fewer than HT_WIDE_PRIMS prims, and leaves. */
#define HT_WIDE_PENDING 0xc0000000u
#define HT_WIDE_PRIMS   0x3fffffffu

/* Levels of nodes that the builder stays within, and what may wait on a stack: seven a level. */
#define HT_WIDE_LEVELS 36u
#define HT_WIDE_STACK  256u

/* A lane holds a child: a slot, or HT_WIDE_LEAF | the index of a leaf; or HT_WIDE_NONE and a box that
 * no ray meets, lo > hi. Bit k of a lane's number is set for children on the upper side of axis k, as
 * far as there is room: a ray whose direction is negative along the axes of mask m meets lanes m,
 * m ^ 1, m ^ 2, ... from near to far, more or less. */
typedef struct ht_wide_node {
    float lo[3][8];
    float hi[3][8];
    ht_word child[8];
    ht_word unused[8];
} ht_wide_node;

/* Lane i holds a triangle, its corners v[0..2][axis][i]. Triangles come first, then user objects, then
 * idle lanes, whose prim is HT_WIDE_NONE; both hold zeros, which no ray meets. Prims are below
 * HT_WIDE_LEAF: the sign of the word tells. */
typedef struct ht_wide_leaf {
    float v[3][3][8];
    ht_word prim[8];
} ht_wide_leaf;

/* ---- Compact wide tree: the same tree in less than half of the memory ------------------------ */

#ifndef __OPENCL_C_VERSION__
typedef uint8_t ht_byte;
#else
typedef uchar ht_byte;
#endif

/* A plane is origin + q * step, rounded outward. */
typedef struct ht_compact_node {
    float origin[3], step[3];
    ht_byte lo[3][8], hi[3][8];
    ht_word child[8];
    ht_word unused[2];
} ht_compact_node;

/* Corner k of lane i is vertex first + corner[k][i]: neighbouring leaves share up to 256 vertices. */
typedef struct ht_compact_leaf {
    ht_word prim[8];
    ht_byte corner[3][8];
    ht_word first;
    ht_word unused;
} ht_compact_leaf;

/* ---- On devices: what a kernel is told beside the arrays ------------------------------------ */

typedef struct ht_scene {
    float lo[3], hi[3]; /* the bounds */
    ht_word prims;      /* 0: every ray misses, and there are no arrays */
    ht_ug_grid grid;
} ht_scene;

#endif
