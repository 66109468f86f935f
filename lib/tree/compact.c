/* compact.c: nodes and leaves of compact wide trees, expanded for those who read them. */
#include "tree.h"

/* The builder rounds by the same expression, so the boxes contain what they should. */
void ht_expand_node(const htree *tree, uint32_t slot, ht_wide_node *node) {
    const ht_compact_node *from = (const ht_compact_node *)tree->nodes + slot;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const float origin = from->origin[axis], step = from->step[axis];
        for (uint32_t i = 0; i < HT_LANES; ++i) {
            const bool idle = from->child[i] == HT_WIDE_NONE;
            const float lo = origin + (float)from->lo[axis][i] * step;
            const float hi = origin + (float)from->hi[axis][i] * step;
            node->lo[axis][i] = idle ? INFINITY : lo;
            node->hi[axis][i] = idle ? -INFINITY : hi;
        }
    }
    memcpy(node->child, from->child, sizeof node->child);
}

void ht_expand_leaf(const htree *tree, uint32_t index, ht_wide_leaf *leaf) {
    const ht_compact_leaf *from = &tree->compact_leaves[index];
    memcpy(leaf->prim, from->prim, sizeof leaf->prim);
    memset(leaf->v, 0, sizeof leaf->v);
    for (uint32_t i = 0; i < HT_LANES && from->prim[i] < tree->triangle_count; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            const float *v = tree->vertices + 3 * ((uint64_t)from->first + from->corner[k][i]);
            for (uint32_t axis = 0; axis < 3; ++axis) leaf->v[k][axis][i] = v[axis];
        }
    }
}
