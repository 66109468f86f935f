/* wide_morton.c: the subtree over the prims of an errand without a cost function: prims in Morton
 * order, eights in a row become leaves and eights of leaves nodes. How many of each there will be
 * follows from the number of prims alone, so every subtree has its place before it is built. Cells
 * are small: the order costs rays little. */
#include "wide.h"

enum {
    KEYS = 64,                /* two bits an axis */
    FEW = HT_LANES * HT_LANES /* most errands have no more prims */
};

/* Prims of each child but the last. */
static uint32_t share_of(uint32_t prims) {
    uint32_t share = HT_LANES;
    while (share * HT_LANES < prims) share *= HT_LANES;
    return share;
}

uint32_t ht_wide_morton_nodes(uint32_t prims) {
    if (prims <= HT_LANES) return 0;
    const uint32_t share = share_of(prims);
    return 1 + prims / share * ht_wide_morton_nodes(share) + ht_wide_morton_nodes(prims % share);
}

uint32_t ht_wide_morton_leaves(uint32_t prims) {
    return (prims + HT_LANES - 1) / HT_LANES;
}

uint32_t ht_wide_morton_stack(uint32_t prims) {
    if (prims <= HT_LANES) return 0;
    const uint32_t share = share_of(prims);
    return (prims - 1) / share + ht_wide_morton_stack(share);
}

typedef struct building {
    const ht_source *source;
    ht_isa isa;
    ht_wide_node *nodes;
    ht_wide_leaf *leaves;
    uint32_t next_node, next_leaf;
    uint32_t count;
    bool few; /* triangles alone, and so few that corners has room */
    ht_box4 centroids;
    uint32_t id[HT_WIDE_CELL_PRIMS];
    ht_f4 centroid[HT_WIDE_CELL_PRIMS];
    ht_corners corners[FEW]; /* if few */
    uint16_t order[HT_WIDE_CELL_PRIMS];
} building;

/* ---- The order ------------------------------------------------------------------------------ */

/* With `few`, corners are kept: a leaf needs them soon. Indices and leaves are asked for before they
 * are needed. */
HT_INLINE void gather(building *b, const uint32_t *order, const ht_wide_run *cells,
                      const bool few) {
    const ht_source source = *b->source; /* which no store can change */
    const ht_wide_leaf *leaves = b->leaves + b->next_leaf;
    ht_box4 centroids = ht_box4_empty();
    uint32_t n = 0;
    for (uint32_t i = 0; i < cells->count; ++i) {
        const uint32_t *ids = order + ht_cell_first(&cells->items[i]);
        const uint32_t count = ht_cell_prims(&cells->items[i]);
        for (uint32_t k = 0; k < count; ++k) ht_source_prefetch(&source, ids[k]);
        for (uint32_t k = 0; k < count; ++k, ++n) {
            ht_box4 box;
            HT_PREFETCH((const char *)leaves + n * (sizeof *leaves / HT_LANES));
            if (few) {
                b->corners[n] = ht_source_corners(&source, ids[k]);
                box = ht_corners_box(&b->corners[n]);
            } else {
                box = ht_source_box(&source, ids[k]);
            }
            b->id[n] = ids[k];
            b->centroid[n] = ht_f4_add(box.lo, box.hi);
            ht_box4_add(&centroids, b->centroid[n], b->centroid[n]);
        }
    }
    b->count = n;
    b->centroids = centroids;
}

/* A counting sort by Morton codes of four cells an axis: above or below the middle of each axis,
 * and then of that half. */
static void sort_prims(building *b) {
    uint16_t next[KEYS + 1] = {0};
    uint8_t key[HT_WIDE_CELL_PRIMS];
    const ht_f4 half = ht_f4_all(0.5f);
    const ht_f4 lo = ht_f4_mul(b->centroids.lo, half), hi = ht_f4_mul(b->centroids.hi, half);
    const ht_f4 middle = ht_f4_add(lo, hi), quarter = ht_f4_mul(ht_f4_sub(hi, lo), half);
    const ht_f4 lower = ht_f4_sub(middle, quarter), upper = ht_f4_add(middle, quarter);
    for (uint32_t i = 0; i < b->count; ++i) {
        const ht_f4 c = b->centroid[i];
        const uint32_t high = ht_f4_above(c, middle) & 7;
        const ht_f4 quarters = ht_f4_by_sign(ht_f4_sub(middle, c), upper, lower);
        key[i] = (uint8_t)(high << 3 | (ht_f4_above(c, quarters) & 7));
        ++next[key[i] + 1];
    }
    for (uint32_t k = 0; k < KEYS; ++k) next[k + 1] = (uint16_t)(next[k + 1] + next[k]);
    for (uint32_t i = 0; i < b->count; ++i) b->order[next[key[i]]++] = (uint16_t)i;
}

/* ---- The subtree ---------------------------------------------------------------------------- */

static ht_box4 write_triangles(const building *b, const uint16_t *order, uint32_t count,
                               ht_wide_leaf *leaf) {
    ht_corners corners[HT_LANES];
    ht_box4 box = ht_box4_empty();
    for (uint32_t i = 0; i < HT_LANES; ++i) {
        corners[i] = i < count ? b->corners[order[i]] : ht_no_corners();
        leaf->prim[i] = i < count ? b->id[order[i]] : HT_WIDE_NONE;
    }
    for (uint32_t i = 0; i < count; ++i) {
        const ht_box4 one = ht_corners_box(&corners[i]);
        ht_box4_add(&box, one.lo, one.hi);
    }
    ht_wide_write_corners(corners, leaf);
    return box;
}

static ht_box4 write_any(const building *b, const uint16_t *order, uint32_t count,
                         ht_wide_leaf *leaf) {
    uint32_t prims[HT_LANES];
    for (uint32_t i = 0; i < count; ++i) prims[i] = b->id[order[i]];
    return ht_wide_write_leaf(b->isa, b->source, prims, count, leaf);
}

static uint32_t add_leaf(building *b, uint32_t start, uint32_t count, ht_box4 *box) {
    ht_wide_leaf *leaf = &b->leaves[b->next_leaf];
    *box = b->few ? write_triangles(b, b->order + start, count, leaf)
                  : write_any(b, b->order + start, count, leaf);
    return HT_WIDE_LEAF | b->next_leaf++;
}

/* Morton order is an order of octants, and so is that of the lanes. */
static uint32_t add_node(building *b, uint32_t start, uint32_t count, ht_box4 *box) {
    const uint32_t share = share_of(count), slot = b->next_node++;
    ht_box4 parts[HT_LANES];
    uint32_t child[HT_LANES], children = 0, done = 0;
    *box = ht_box4_empty();
    do {
        const uint32_t here = count - done < share ? count - done : share;
        ht_box4 *part = &parts[children];
        child[children++] = here <= HT_LANES ? add_leaf(b, start + done, here, part)
                                             : add_node(b, start + done, here, part);
        ht_box4_add(box, part->lo, part->hi);
        done += here;
    } while (done < count);
    ht_wide_fill_in_order(&b->nodes[slot], parts, child, children);
    return slot;
}

uint64_t ht_wide_morton_room(void) {
    uint64_t bytes = sizeof(building);
#ifdef HT_X86
    if (ht_wide_morton_avx512_room() > bytes) bytes = ht_wide_morton_avx512_room();
#endif
    return (bytes + HT_ALIGNMENT - 1) / HT_ALIGNMENT * HT_ALIGNMENT;
}

void ht_wide_run_morton(const htree *tree, const ht_source *source, const uint32_t *order,
                        const ht_wide_errand *errand, void *room) {
    building *b = (building *)room;
    ht_box4 box;
#ifdef HT_X86
    if (tree->isa == HT_AVX512 && ht_wide_run_morton_avx512(tree, source, order, errand, room))
        return;
#endif
    b->source = source;
    b->isa = tree->isa;
    b->nodes = (ht_wide_node *)tree->nodes;
    b->leaves = tree->leaves;
    b->next_node = errand->node;
    b->next_leaf = errand->leaf;
    b->few = errand->cells.prims <= FEW && source->object_count == 0;
    if (b->few)
        gather(b, order, &errand->cells, true);
    else
        gather(b, order, &errand->cells, false);
    sort_prims(b);
    const uint32_t child =
        b->count <= HT_LANES ? add_leaf(b, 0, b->count, &box) : add_node(b, 0, b->count, &box);
    assert(child == errand->child);
    (void)child;
}
