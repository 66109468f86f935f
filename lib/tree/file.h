/* file.h: a tree as bytes: a header, then the tree's arrays as they lie in memory, so that a mapped file
 * is a tree that needs no copy.
 *
 * Numbers are in the byte order of the machine that wrote them, which is marked. Triangles, boxes of
 * objects, nodes, leaves, references and vertices follow each other at multiples of HT_ALIGNMENT, zeros between
 * them. Where they lie follows from the counts, and what the arrays tell is not in the header: the
 * bounds, and how many prims can be hit. The leaves of a wide tree hold its triangles. So there is one file for a tree, and what htree_load takes
 * htree_save gives back byte for byte. */
#ifndef HT_FILE_H
#define HT_FILE_H

#include "tree.h"

#define HT_FILE_ORDER  0x01020304u
#define HT_FILE_FORMAT 2u /* one more for every change of the header or of layout.h */

typedef struct ht_file_header {
    char magic[8];
    uint32_t order;    /* HT_FILE_ORDER as the writer's machine stores it */
    uint32_t format;   /* HT_FILE_FORMAT */
    uint64_t bytes;    /* of the file */
    uint64_t checksum; /* of all that follows this word */
    int32_t kind;
    uint32_t stack;
    uint32_t triangle_count, object_count;
    uint32_t node_slots, leaf_count, ref_count;
    uint32_t vertex_count; /* of a compact tree, else 0 */
    uint64_t invalid, degenerate;
    float cost[4]; /* skd, bv2, bv6, intersect */
    ht_ug_grid grid;
    htree_kind built_as; /* options.kind, which is another than the tree's when it was collapsed */
    uint32_t flags, buckets, axes, few_prims;
    float cells_per_prim;
    uint32_t spare[5];
} ht_file_header;

extern const char ht_file_magic[8];

/* The arrays of a tree, in the order of the file. */
enum { HT_FILE_PARTS = 6 };

typedef struct ht_file_plan {
    uint64_t offset[HT_FILE_PARTS], bytes[HT_FILE_PARTS];
    uint64_t end; /* of the file: a multiple of HT_ALIGNMENT, and an eighth of the prims at least */
} ht_file_plan;

/* Where the counts of the header put the arrays. Any counts: 2^45 bytes are the most. */
ht_file_plan ht_file_plan_of(const ht_file_header *header);

/* Of a whole file; finds every change that lies within eight bytes. Against accidents, not against
 * intent: who loads a file proves it. */
uint64_t ht_file_checksum(const void *file, uint64_t bytes);

#endif
