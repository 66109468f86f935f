/* file.c: htree_save, and what saving and loading share. */
#include "file.h"

const char ht_file_magic[8] = {'\x89', 'h', 't', 'r', 'e', 'e', '\r', '\n'};

/* ---- The checksum --------------------------------------------------------------------------- */

enum { LANES = 4 };

/* One to one in either argument, so that no single change is lost. */
HT_INLINE uint64_t mix(uint64_t sum, uint64_t word) {
    sum = (sum ^ word) * 0x9e3779b97f4a7c15u;
    return sum ^ sum >> 29;
}

uint64_t ht_file_checksum(const void *file, uint64_t bytes) {
    const char *at = (const char *)file + offsetof(ht_file_header, kind);
    const char *const end = (const char *)file + bytes;
    uint64_t lane[LANES] = {1, 2, 3, 4}, word[LANES], sum = 0;
    for (; at < end; at += sizeof word) {
        memcpy(word, at, sizeof word);
        for (int i = 0; i < LANES; ++i) lane[i] = mix(lane[i], word[i]);
    }
    for (int i = 0; i < LANES; ++i) sum = mix(sum, lane[i]);
    return sum;
}

/* ---- Where things lie ----------------------------------------------------------------------- */

static uint64_t aligned(uint64_t bytes) {
    return (bytes + HT_ALIGNMENT - 1) / HT_ALIGNMENT * HT_ALIGNMENT;
}

ht_file_plan ht_file_plan_of(const ht_file_header *header) {
    const bool compact = header->vertex_count > 0;
    const uint64_t slot = compact ? sizeof(ht_compact_node) : ht_slot_bytes(header->kind);
    const uint64_t leaf = compact ? sizeof(ht_compact_leaf) : sizeof(ht_wide_leaf);
    const uint64_t bytes[HT_FILE_PARTS] = {
        header->kind == HTREE_WIDE ? 0 : header->triangle_count * (uint64_t)sizeof(ht_triangle),
        header->object_count * (uint64_t)sizeof(htree_box),
        header->node_slots * slot,
        header->leaf_count * leaf,
        header->ref_count * (uint64_t)sizeof(uint32_t),
        header->vertex_count * (uint64_t)(3 * sizeof(float)),
    };
    ht_file_plan plan;
    plan.end = aligned(sizeof *header);
    for (int i = 0; i < HT_FILE_PARTS; ++i) {
        plan.offset[i] = plan.end;
        plan.bytes[i] = bytes[i];
        plan.end = aligned(plan.end + bytes[i]);
    }
    /* A wide tree holds nothing of the triangles that it skips, but its proof marks them. */
    const uint64_t marks = ((uint64_t)header->triangle_count + header->object_count) / 8;
    if (plan.end < marks) plan.end = aligned(marks);
    return plan;
}

/* ---- Save ----------------------------------------------------------------------------------- */

static ht_file_header header_of(const htree *tree) {
    ht_file_header h;
    memset(&h, 0, sizeof h);
    memcpy(h.magic, ht_file_magic, sizeof h.magic);
    h.order = HT_FILE_ORDER;
    h.format = HT_FILE_FORMAT;
    h.kind = tree->kind;
    h.stack = tree->stack;
    h.triangle_count = tree->triangle_count;
    h.object_count = tree->object_count;
    h.node_slots = tree->node_slots;
    h.leaf_count = tree->leaf_count;
    h.ref_count = tree->ref_count;
    h.vertex_count = tree->vertex_count;
    h.invalid = tree->invalid;
    h.degenerate = tree->degenerate;
    h.cost[0] = tree->cost_skd;
    h.cost[1] = tree->cost_bv2;
    h.cost[2] = tree->cost_bv6;
    h.cost[3] = tree->cost_intersect;
    h.grid = tree->grid;
    h.built_as = tree->options.kind;
    h.flags = tree->options.flags;
    h.buckets = tree->options.buckets;
    h.axes = tree->options.axes;
    h.few_prims = tree->options.few_prims;
    h.cells_per_prim = tree->options.cells_per_prim;
    return h;
}

static void write_parts(const htree *tree, const ht_file_plan *plan, char *file) {
    const void *const leaves =
        ht_is_compact(tree) ? (const void *)tree->compact_leaves : (const void *)tree->leaves;
    const void *const part[HT_FILE_PARTS] = {tree->triangles, tree->object_boxes, tree->nodes,
                                             leaves,          tree->refs,         tree->vertices};
    for (int i = 0; i < HT_FILE_PARTS; ++i) {
        const uint64_t end = i + 1 < HT_FILE_PARTS ? plan->offset[i + 1] : plan->end;
        const uint64_t gap = end - plan->offset[i] - plan->bytes[i];
        if (plan->bytes[i]) memcpy(file + plan->offset[i], part[i], (size_t)plan->bytes[i]);
        memset(file + end - gap, 0, (size_t)gap);
    }
}

htree_status htree_save(const htree *tree, void *file, uint64_t size, uint64_t *bytes) {
    HT_TRY(ht_tree_verify(tree));
    if (!bytes) return ht_fail(HTREE_ERROR_ARGUMENT, "bytes is NULL");
    if (tree->lazy) {
        return ht_fail(HTREE_ERROR_UNSUPPORTED, "a lazy tree is saved after htree_complete");
    }
    ht_file_header header = header_of(tree);
    const ht_file_plan plan = ht_file_plan_of(&header);
    if (file && size < plan.end) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "size is %llu: the tree takes %llu bytes",
                       (unsigned long long)size, (unsigned long long)plan.end);
    }
    *bytes = plan.end;
    if (!file) return HTREE_OK;
    header.bytes = plan.end;
    memcpy(file, &header, sizeof header);
    write_parts(tree, &plan, (char *)file);
    header.checksum = ht_file_checksum(file, plan.end);
    memcpy(file, &header, sizeof header);
    return HTREE_OK;
}
