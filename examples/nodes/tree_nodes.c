/* tree_nodes.c: one walk for each layout of lib/tree/layout.h, each handing down the space that is left. */
#include "tree_nodes.h"

#include <layout.h>

#include <stdlib.h>
#include <string.h>

const char *node_type_name(node_type type) {
    static const char *const names[NODE_TYPES] = {"skd", "shelf", "bv2",  "bv6",  "split",
                                                  "box", "cell",  "leaf", "empty"};
    return names[type];
}

static void add(tree_nodes *out, node_type type, uint32_t level, const htree_box *box) {
    if (out->count == out->room) {
        const uint64_t room = out->room ? 2 * out->room : 1024;
        tree_node *more = (tree_node *)realloc(out->node, (size_t)room * sizeof *more);
        if (!more) {
            out->full = true;
            return;
        }
        out->node = more;
        out->room = room;
    }
    const tree_node node = {type, level, *box};
    out->node[out->count++] = node;
}

/* ---- Two children --------------------------------------------------------------------------- */

static void walk_bvh(tree_nodes *out, const ht_bvh_node *nodes, uint32_t slot, uint32_t level) {
    const ht_bvh_node *node = &nodes[slot];
    htree_box box;
    memcpy(box.lo, node->lo, sizeof box.lo);
    memcpy(box.hi, node->hi, sizeof box.hi);
    add(out, node->tag == HT_BVH_LEAF ? NODE_LEAF : NODE_BOX, level, &box);
    if (node->tag == HT_BVH_LEAF) return;
    walk_bvh(out, nodes, node->child, level + 1);
    walk_bvh(out, nodes, node->child + 1, level + 1);
}

static void walk_kd(tree_nodes *out, const ht_kd_node *nodes, uint32_t slot, htree_box voxel,
                    uint32_t level) {
    const ht_kd_node *node = &nodes[slot];
    const uint32_t axis = node->tag & 3, rest = node->tag >> 2;
    if (axis == HT_KD_LEAF) {
        add(out, rest ? NODE_LEAF : NODE_EMPTY, level, &voxel);
        return;
    }
    add(out, NODE_SPLIT, level, &voxel);
    htree_box left = voxel, right = voxel;
    left.hi[axis] = right.lo[axis] = node->plane;
    walk_kd(out, nodes, slot + 1, left, level + 1);
    walk_kd(out, nodes, rest, right, level + 1);
}

/* ---- H-tree --------------------------------------------------------------------------------- */

static void walk_h(tree_nodes *out, const ht_h_node *nodes, uint32_t slot, htree_box region,
                   uint32_t level);

static void walk_skd(tree_nodes *out, const ht_h_node *nodes, uint32_t slot, htree_box region,
                     uint32_t level) {
    const ht_h_node *node = &nodes[slot];
    const uint32_t axis = (node->tag & HT_H_TYPE) - HT_H_SKD, shelf = node->tag >> HT_H_TAG_BITS;
    htree_box left = region, right = region;
    if (node->a < left.hi[axis]) left.hi[axis] = node->a;
    if (node->b > right.lo[axis]) right.lo[axis] = node->b;
    add(out, shelf ? NODE_SHELF : NODE_SKD, level, &region);
    walk_h(out, nodes, slot + 1, left, level + 1);
    walk_h(out, nodes, node->child, right, level + 1);
    if (shelf) walk_h(out, nodes, shelf, region, level + 1);
}

static void walk_bound(tree_nodes *out, const ht_h_node *nodes, uint32_t slot, htree_box region,
                       uint32_t level) {
    const ht_h_node *node = &nodes[slot];
    const uint32_t type = node->tag & HT_H_TYPE;
    if (type == HT_H_BV6) {
        const float planes[6] = {node[0].a, node[0].b, 0, node[1].a, node[1].b, 0};
        memcpy(region.lo, planes, sizeof region.lo);
        memcpy(region.hi, planes + 3, sizeof region.hi);
        memcpy(&region.lo[2], &node[0].child, sizeof(float));
        memcpy(&region.hi[2], &node[1].child, sizeof(float));
    } else {
        region.lo[type - HT_H_BV2] = node->a;
        region.hi[type - HT_H_BV2] = node->b;
    }
    add(out, type == HT_H_BV6 ? NODE_BV6 : NODE_BV2, level, &region);
    walk_h(out, nodes, slot + (type == HT_H_BV6 ? 2 : 1), region, level);
}

/* Default options make no BVO nodes. */
static void walk_h(tree_nodes *out, const ht_h_node *nodes, uint32_t slot, htree_box region,
                   uint32_t level) {
    const uint32_t type = nodes[slot].tag & HT_H_TYPE;
    if (type == HT_H_LEAF) {
        add(out, NODE_LEAF, level, &region);
    } else if (type == HT_H_LINK) {
        walk_h(out, nodes, nodes[slot].child, region, level);
    } else if (type >= HT_H_BV2) {
        walk_bound(out, nodes, slot, region, level);
    } else {
        walk_skd(out, nodes, slot, region, level);
    }
}

/* ---- Many children -------------------------------------------------------------------------- */

static void walk_wide(tree_nodes *out, const ht_wide_node *nodes, uint32_t slot, uint32_t level) {
    const ht_wide_node *node = &nodes[slot];
    for (uint32_t lane = 0; lane < HT_LANES; ++lane) {
        const uint32_t child = node->child[lane];
        htree_box box;
        if (child == HT_WIDE_NONE) continue;
        for (int k = 0; k < 3; ++k) {
            box.lo[k] = node->lo[k][lane];
            box.hi[k] = node->hi[k][lane];
        }
        add(out, child & HT_WIDE_LEAF ? NODE_LEAF : NODE_BOX, level, &box);
        if (!(child & HT_WIDE_LEAF)) walk_wide(out, nodes, child, level + 1);
    }
}

static void walk_grid(tree_nodes *out, const ht_ug_node *first, const ht_ug_grid *grid) {
    const uint32_t nx = grid->cells[0], ny = grid->cells[1], nz = grid->cells[2];
    for (uint32_t i = 0; i < nx * ny * nz; ++i) {
        const uint32_t at[3] = {i % nx, i / nx % ny, i / nx / ny};
        htree_box box;
        for (int k = 0; k < 3; ++k) {
            box.lo[k] = grid->lo[k] + (float)at[k] * grid->size[k];
            box.hi[k] = box.lo[k] + grid->size[k];
        }
        add(out, first[i] == first[i + 1] ? NODE_EMPTY : NODE_CELL, 0, &box);
    }
}

/* ---- All ------------------------------------------------------------------------------------ */

htree_status tree_nodes_list(tree_nodes *out, const htree *tree) {
    htree_view view = {.size = sizeof view};
    memset(out, 0, sizeof *out);
    const htree_status status = htree_get_view(tree, &view);
    if (status != HTREE_OK || !view.prims) return status;
    switch (view.kind) {
    case HTREE_UG:
        walk_grid(out, (const ht_ug_node *)view.nodes, (const ht_ug_grid *)view.grid);
        break;
    case HTREE_KD: walk_kd(out, (const ht_kd_node *)view.nodes, 0, view.bounds, 0); break;
    case HTREE_BVH_MEDIAN:
    case HTREE_BVH_SAH: walk_bvh(out, (const ht_bvh_node *)view.nodes, 0, 0); break;
    case HTREE_WIDE:
        add(out, NODE_BOX, 0, &view.bounds);
        walk_wide(out, (const ht_wide_node *)view.nodes, 0, 1);
        break;
    default: walk_h(out, (const ht_h_node *)view.nodes, 0, view.bounds, 0);
    }
    return out->full ? HTREE_ERROR_MEMORY : HTREE_OK;
}

void tree_nodes_free(tree_nodes *list) {
    free(list->node);
    memset(list, 0, sizeof *list);
}

uint32_t tree_nodes_levels(const tree_nodes *list) {
    uint32_t levels = 0;
    for (uint64_t i = 0; i < list->count; ++i)
        if (list->node[i].level >= levels) levels = list->node[i].level + 1;
    return levels;
}
