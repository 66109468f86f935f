#include "h_nodes.h"

/* ---- Chunks ---- */

static htree_status chunk_begin(ht_h_writer *writer) {
    assert(writer->chunk_count < writer->chunk_capacity);
    const uint64_t bytes = HT_H_CHUNK_SLOTS * sizeof(ht_h_node);
    ht_h_node *chunk = (ht_h_node *)ht_allocate(&writer->builder->tree->memory, bytes);
    if (!chunk) return HTREE_ERROR_MEMORY;
    writer->chunks[writer->chunk_count++] = chunk;
    writer->used = 0;
    return HTREE_OK;
}

uint32_t ht_h_next_slot(const ht_h_writer *writer) {
    return (writer->chunk_count - 1) * HT_H_CHUNK_SLOTS + writer->used;
}

/* Takes `slots` slots in a row; the last slot of a chunk is kept for the link to the next one. */
static htree_status take_slots(ht_h_writer *writer, uint32_t slots, ht_h_node **node) {
    if (writer->used + slots >= HT_H_CHUNK_SLOTS) {
        ht_h_node *link = &writer->chunks[writer->chunk_count - 1][writer->used];
        const uint32_t unused = HT_H_CHUNK_SLOTS - writer->used - 1;
        memset(link, 0, (unused + 1) * sizeof *link);
        HT_TRY(chunk_begin(writer));
        link->child = ht_h_next_slot(writer);
        link->tag = HT_H_LINK;
    }
    *node = &writer->chunks[writer->chunk_count - 1][writer->used];
    memset(*node, 0, slots * sizeof **node);
    writer->used += slots;
    return HTREE_OK;
}

htree_status ht_h_writer_begin(ht_h_writer *writer, ht_builder *builder, bool bounding) {
    memset(writer, 0, sizeof *writer);
    writer->builder = builder;
    writer->bounding = bounding;
    /* At most 4 slots an object (section 6.2). Slots of shelves have 28 bits beside the tag. */
    const uint64_t most_slots = 4 * (uint64_t)builder->tree->prim_count + 2;
    const uint64_t most_chunks = most_slots / (HT_H_CHUNK_SLOTS - 2) + 1;
    if (most_chunks * HT_H_CHUNK_SLOTS > HT_H_SLOTS) {
        return ht_fail(HTREE_ERROR_LIMIT, "an H-tree holds at most 2^26 - 2^18 objects");
    }
    writer->chunk_capacity = (uint32_t)most_chunks;
    writer->chunks =
        (ht_h_node **)ht_allocate(&builder->tree->memory, most_chunks * sizeof *writer->chunks);
    return writer->chunks ? chunk_begin(writer) : HTREE_ERROR_MEMORY;
}

void ht_h_writer_end(ht_h_writer *writer) {
    ht_memory *memory = &writer->builder->tree->memory;
    for (uint32_t i = 0; i < writer->chunk_count; ++i) {
        ht_release(memory, writer->chunks[i], HT_H_CHUNK_SLOTS * sizeof(ht_h_node));
    }
    ht_release(memory, writer->chunks, writer->chunk_capacity * sizeof *writer->chunks);
}

htree_status ht_h_writer_finish(ht_h_writer *writer) {
    htree *tree = writer->builder->tree;
    tree->node_slots = ht_h_next_slot(writer);
    tree->node_slot_bytes = sizeof(ht_h_node);
    tree->stack = writer->deepest;
    tree->nodes = ht_allocate(&tree->memory, (uint64_t)tree->node_slots * sizeof(ht_h_node));
    if (!tree->nodes) return HTREE_ERROR_MEMORY;
    for (uint32_t i = 0; i < writer->chunk_count; ++i) {
        const uint32_t slots = i + 1 < writer->chunk_count ? HT_H_CHUNK_SLOTS : writer->used;
        memcpy((ht_h_node *)tree->nodes + (size_t)i * HT_H_CHUNK_SLOTS, writer->chunks[i],
               slots * sizeof(ht_h_node));
    }
    return HTREE_OK;
}

/* ---- Nodes ---- */

htree_status ht_h_write_skd(ht_h_writer *writer, uint32_t axis, ht_h_node **node) {
    HT_TRY(take_slots(writer, 1, node));
    (*node)->tag = HT_H_SKD + axis;
    return HTREE_OK;
}

htree_status ht_h_write_leaf(ht_h_writer *writer, uint32_t prim, uint32_t level) {
    ht_h_node *node;
    HT_TRY(take_slots(writer, 1, &node));
    node->child = prim;
    node->tag = HT_H_LEAF;
    if (level > writer->deepest) writer->deepest = level;
    return ht_progress_step(&writer->builder->progress, 1) ? HTREE_OK : HTREE_ERROR_CANCELLED;
}

htree_status ht_h_write_bound(ht_h_writer *writer, uint32_t planes, const htree_box *box,
                              ht_h_node **node) {
    const uint32_t axis = ht_slab_axis(planes);
    const uint32_t slots = ht_plane_count(planes) > 3 ? 2 : 1;
    HT_TRY(take_slots(writer, slots, node));
    if (axis < 3) {
        (*node)->tag = HT_H_BV2 + axis;
    } else if (planes == HT_ALL_PLANES) {
        (*node)->tag = HT_H_BV6;
    } else {
        (*node)->tag = HT_H_BVO | planes << HT_H_TAG_BITS;
    }
    ht_h_rebound(*node, box);
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
