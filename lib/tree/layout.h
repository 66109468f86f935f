/* layout.h: the nodes of every structure, as builders write them and walks read them.
 *
 * Also read by OpenCL C: plain structs of float and uint, no pointers, no unions. A slot is an
 * index into the array of nodes. Words that a node type does not use are 0. */
#ifndef HT_LAYOUT_H
#define HT_LAYOUT_H

#ifndef __OPENCL_VERSION__
#include <stdint.h>
typedef uint32_t ht_word;
#else
typedef uint ht_word;
#endif

/* Levels of branching that builders stay within and that traversal stacks are made for. */
#define HT_MAX_DEPTH 96

/* ---- BVH: 32 bytes a node, children are neighbours ---------------------------------------- */

#define HT_BVH_LEAF 3u

typedef struct ht_bvh_node {
    float lo[3];
    ht_word child; /* interior: slot of the left child, the right one follows it; leaf: the prim */
    float hi[3];
    ht_word tag; /* interior: the axis that was split, 0 to 2; leaf: HT_BVH_LEAF */
} ht_bvh_node;

/* ---- H-tree: the paper's nine node types in 16 bytes (BV6: two slots), depth first
 * --------------- */

/*   type        a          b          child               the node's child is
 *   LEAF        -          -          prim                none
 *   SKD_X..Z    left max   right min  slot of the right   the next slot: left; `child`: right
 *   BV2_X..Z    lo         hi         -                   the next slot
 *   BV6         lo x       lo y       lo z (float bits)   two slots on; the second slot is hi x y z
 *   LINK        -          -          slot                `child`: nodes come in chunks
 * (section 6.2) */
#define HT_H_LEAF 0u
#define HT_H_SKD  1u /* + axis */
#define HT_H_BV2  4u /* + axis */
#define HT_H_BV6  7u
#define HT_H_LINK 8u

#define HT_H_CHUNK_SLOTS 1024u /* 16 KiB */

typedef struct ht_h_node {
    float a, b;
    ht_word child;
    ht_word tag; /* the type */
} ht_h_node;

typedef struct ht_h_bv6 {
    float lo[3];
    ht_word tag; /* HT_H_BV6, at the offset of ht_h_node's */
    float hi[3];
    ht_word unused;
} ht_h_bv6;

/* ---- kd-tree: 8 bytes a node, depth first ------------------------------------------------- */

/* Interior: plane, and tag = slot of the right child << 2 | axis; the left child is the next slot.
 * Leaf: plane holds the bits of the index of its first reference, tag = references << 2 | HT_KD_LEAF. */
#define HT_KD_LEAF  3u
#define HT_KD_SLOTS 0x40000000u

typedef struct ht_kd_node {
    float plane;
    ht_word tag;
} ht_kd_node;

/* ---- Uniform grid: a slot per cell, x fastest --------------------------------------------- */

/* The references of cell i are refs[node i .. node i + 1); one more node than cells. */
typedef ht_word ht_ug_node;

typedef struct ht_ug_grid {
    float lo[3], hi[3]; /* the bounds, and a margin that no clipped ray leaves */
    float size[3];      /* of a cell */
    ht_word cells[3];   /* along each axis */
    float reach; /* rays that see the bounds from farther off are walked with their own pad */
} ht_ug_grid;

#endif
