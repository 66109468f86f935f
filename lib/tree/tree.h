/* tree.h: the finished tree: geometry in the order of the mesh, nodes in the layout of its kind. */
#ifndef HT_TREE_H
#define HT_TREE_H

#include "base/isa.h"
#include "base/memory.h"
#include "base/progress.h"
#include "base/tasks.h"
#include "base/vec.h"
#include "planes.h"

typedef struct ht_triangle {
    float v[3][3];
} ht_triangle;

/* What a lazy tree can do, until it is complete: see build/wide_order.c, which has the rest of it. */
typedef struct ht_lazy {
    uint32_t subtrees;
    uint32_t (*touch)(const htree *tree, uint32_t subtree); /* builds if need be; its child word */
    uint32_t (*prims)(const htree *tree, uint32_t subtree);
    uint32_t (*child)(const htree *tree, uint32_t subtree); /* HT_WIDE_NONE: not built */
    uint32_t (*built)(const htree *tree);
    void (*complete)(htree *tree);
    void (*end)(htree *tree);
} ht_lazy;

struct htree {
    htree_kind kind;
    uint32_t threads;
    htree_tasks tasks;
    ht_memory memory;
    ht_isa isa; /* that queries may use */

    htree_box bounds;    /* of all prims that can be hit */
    uint32_t prim_count; /* prims that can be hit; ids run over triangles, then objects */
    uint32_t triangle_count, object_count;
    ht_triangle *triangles; /* by prim; a skipped one is all 0 and no leaf refers to it; WIDE: none,
                               its leaves hold them */
    htree_box *object_boxes;
    htree_object_intersect intersect;
    void *intersect_user;

    void *nodes; /* of the kind's type in layout.h, root first; none if prim_count is 0 */
    uint32_t node_slots;
    uint64_t node_bytes; /* allocated */
    uint32_t *refs;      /* UG, KD: prims by leaf */
    uint32_t ref_count;
    ht_wide_leaf *leaves; /* WIDE */
    uint32_t leaf_count;
    ht_compact_leaf
        *compact_leaves; /* WIDE, compact: instead of leaves, and nodes are compact too */
    float *vertices;
    uint32_t vertex_count;
    ht_lazy *lazy; /* NULL: all is built */
    ht_ug_grid grid;
    uint32_t stack; /* traversal stack entries needed at most, <= ht_stack_limit */

    htree_options options; /* of the build, for the next one */
    double area;           /* of all boxes over that of the bounds, when it was built; 0: unknown */
    uint32_t *skipped;     /* prims that no leaf refers to, once a refit has asked for them */
    uint32_t skipped_count;
    uint64_t invalid, degenerate;
    float cost_skd, cost_bv2, cost_bv6, cost_intersect;
    double build_seconds;
    bool borrowed; /* the arrays are the caller's: htree_load with HTREE_BORROW */
};

/* Prims of a wide leaf: the lanes before the idle ones. */
HT_INLINE uint32_t ht_wide_leaf_count(const ht_wide_leaf *leaf) {
    uint32_t count = 0;
    while (count < HT_LANES && leaf->prim[count] != HT_WIDE_NONE) ++count;
    return count;
}

HT_INLINE bool ht_wide_is_pending(uint32_t child) {
    return child >= HT_WIDE_PENDING;
}

/* Nodes and leaves of a compact tree as those of any other, in memory of the caller's. */
void ht_expand_node(const htree *tree, uint32_t slot, ht_wide_node *node);
void ht_expand_leaf(const htree *tree, uint32_t index, ht_wide_leaf *leaf);

HT_INLINE bool ht_is_compact(const htree *tree) {
    return tree->compact_leaves != NULL;
}

/* Whether there are the vertices that a compact leaf may refer to: any byte is the number of one. */
HT_INLINE bool ht_has_vertices(const htree *tree, uint32_t leaf) {
    return !ht_is_compact(tree) ||
           (uint64_t)tree->compact_leaves[leaf].first + UINT8_MAX < tree->vertex_count;
}

/* The node or leaf to read: in the tree, or expanded into *room. */
HT_INLINE const ht_wide_node *ht_wide_node_at(const htree *tree, uint32_t slot,
                                              ht_wide_node *room) {
    if (!ht_is_compact(tree)) return (const ht_wide_node *)tree->nodes + slot;
    ht_expand_node(tree, slot, room);
    return room;
}

HT_INLINE const ht_wide_leaf *ht_wide_leaf_at(const htree *tree, uint32_t index,
                                              ht_wide_leaf *room) {
    if (!ht_is_compact(tree)) return &tree->leaves[index];
    ht_expand_leaf(tree, index, room);
    return room;
}

/* The child that a walk goes on with. */
HT_INLINE uint32_t ht_wide_resolve(const htree *tree, uint32_t child) {
    if (HT_UNLIKELY(ht_wide_is_pending(child)))
        return tree->lazy->touch(tree, child & ~HT_WIDE_PENDING);
    return child;
}

/* False if a coordinate is NaN, infinite or oversize. */
bool ht_triangle_is_valid(const ht_triangle *triangle);

/* Bytes of a slot of the kind. */
uint64_t ht_slot_bytes(htree_kind kind);

/* What may wait on the stack that walks of the kind have. */
uint32_t ht_stack_limit(htree_kind kind);

/* Gives back all arrays, but not the tree itself. */
void ht_tree_release(htree *tree);

/* Fails with ARGUMENT if tree is NULL. */
htree_status ht_tree_verify(const htree *tree);

#endif
