#include "h_nodes.h"

/* ---- Slots ---------------------------------------------------------------------------------- */

/* Three slots an object hold nearly every tree; four and the links of the chunks hold any
 * (section 6.2). */
static uint64_t usual_slots(uint64_t prims) {
    return 3 * prims + HT_H_CHUNK_SLOTS;
}

static uint64_t most_slots(uint64_t prims) {
    return (4 * prims + 2) / (HT_H_CHUNK_SLOTS - 2) * HT_H_CHUNK_SLOTS + 2 * HT_H_CHUNK_SLOTS;
}

htree_status ht_h_writer_begin(ht_h_writer *writer, ht_builder *builder, bool bounding) {
    const uint64_t prims = builder->tree->prim_count;
    memset(writer, 0, sizeof *writer);
    writer->builder = builder;
    writer->bounding = bounding;
    assert(most_slots(prims) <= HT_H_SLOTS);
    writer->capacity = (uint32_t)usual_slots(prims);
    writer->nodes =
        (ht_h_node *)ht_allocate(&builder->tree->memory, writer->capacity * sizeof(ht_h_node));
    return writer->nodes ? HTREE_OK : HTREE_ERROR_MEMORY;
}

void ht_h_writer_end(ht_h_writer *writer) {
    ht_release(&writer->builder->tree->memory, writer->nodes, writer->capacity * sizeof(ht_h_node));
    writer->nodes = NULL;
}

void ht_h_writer_finish(ht_h_writer *writer) {
    htree *tree = writer->builder->tree;
    tree->nodes = writer->nodes;
    tree->node_slots = writer->used;
    tree->node_bytes = writer->capacity * sizeof(ht_h_node);
    tree->stack = writer->deepest;
    writer->nodes = NULL;
}

static htree_status grow(ht_h_writer *writer) {
    htree *tree = writer->builder->tree;
    const uint32_t capacity = (uint32_t)most_slots(tree->prim_count);
    ht_h_node *nodes = (ht_h_node *)ht_allocate(&tree->memory, capacity * sizeof *nodes);
    if (!nodes) return HTREE_ERROR_MEMORY;
    memcpy(nodes, writer->nodes, writer->used * sizeof *nodes);
    ht_h_writer_end(writer);
    writer->nodes = nodes;
    writer->capacity = capacity;
    return HTREE_OK;
}

/* Takes `slots` slots in a row. A node does not straddle chunks: the last slot of each links to
 * the next, so that a chunk may lie anywhere. */
static htree_status take_slots(ht_h_writer *writer, uint32_t slots, uint32_t *first) {
    /* A link takes two slots at most, and a node as many. */
    if (writer->used + 4 > writer->capacity) HT_TRY(grow(writer));
    const uint32_t room = HT_H_CHUNK_SLOTS - writer->used % HT_H_CHUNK_SLOTS;
    if (slots >= room) {
        ht_h_node *link = &writer->nodes[writer->used];
        memset(link, 0, room * sizeof *link);
        writer->used += room;
        link->child = writer->used;
        link->tag = HT_H_LINK;
    }
    *first = writer->used;
    writer->used += slots;
    assert(writer->used <= writer->capacity);
    memset(&writer->nodes[*first], 0, slots * sizeof *writer->nodes);
    return HTREE_OK;
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

htree_status ht_h_write_skd(ht_h_writer *writer, uint32_t axis, uint32_t *slot) {
    HT_TRY(take_slots(writer, 1, slot));
    ht_h_node_at(writer, *slot)->tag = HT_H_SKD + axis;
    return HTREE_OK;
}

htree_status ht_h_write_leaf(ht_h_writer *writer, uint32_t prim, uint32_t level) {
    uint32_t slot;
    HT_TRY(take_slots(writer, 1, &slot));
    ht_h_node *node = ht_h_node_at(writer, slot);
    node->child = prim;
    node->tag = HT_H_LEAF;
    if (level > writer->deepest) writer->deepest = level;
    return ht_progress_step(&writer->builder->progress, 1) ? HTREE_OK : HTREE_ERROR_CANCELLED;
}

htree_status ht_h_write_bound(ht_h_writer *writer, uint32_t planes, const htree_box *box,
                              uint32_t *slot) {
    const uint32_t axis = ht_slab_axis(planes);
    HT_TRY(take_slots(writer, ht_plane_count(planes) > 3 ? 2 : 1, slot));
    ht_h_node *node = ht_h_node_at(writer, *slot);
    node->tag = axis < 3                  ? HT_H_BV2 + axis
                : planes == HT_ALL_PLANES ? HT_H_BV6
                                          : HT_H_BVO | planes << HT_H_TAG_BITS;
    ht_h_rebound(node, box);
    return HTREE_OK;
}

void ht_h_rebound(ht_h_node *node, const htree_box *box) {
    const uint32_t type = node->tag & HT_H_TYPE;
    if (type == HT_H_BVO) {
        const float plane[6] = {box->lo[0], box->lo[1], box->lo[2],
                                box->hi[0], box->hi[1], box->hi[2]};
        uint32_t planes = node->tag >> HT_H_TAG_BITS;
        for (uint32_t i = 0, k = 0; i < 6; ++i) {
            if (planes >> i & 1) ht_h_set_plane(node, k++, plane[i]);
        }
    } else if (type == HT_H_BV6) {
        for (uint32_t i = 0; i < 3; ++i) {
            ht_h_set_plane(node, i, box->lo[i]);
            ht_h_set_plane(node, 3 + i, box->hi[i]);
        }
    } else {
        node->a = box->lo[type - HT_H_BV2];
        node->b = box->hi[type - HT_H_BV2];
    }
}
