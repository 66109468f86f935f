/* wide_morton.c: the subtree over the prims of an errand without a cost function: prims in Morton
 * order, eights in a row become leaves and eights of leaves nodes. How many of each there will be
 * follows from the number of prims alone, so every subtree has its place before it is built. Cells
 * are small: the order costs rays little. */
#include "prims.h"
#include "wide.h"

enum { CELLS_AN_AXIS = 4, KEYS = CELLS_AN_AXIS * CELLS_AN_AXIS * CELLS_AN_AXIS };

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
    ht_wide_node *nodes;
    ht_wide_leaf *leaves;
    uint32_t next_node, next_leaf;
    ht_prim prims[HT_WIDE_CELL_PRIMS];
    uint16_t order[HT_WIDE_CELL_PRIMS];
} building;

/* Spreads two bits, so that those of three axes fit between each other. */
static uint32_t spread(int32_t x) {
    return (uint32_t)((x & 1) | (x & 2) << 2);
}

/* A counting sort, by the Morton codes of centroids. */
static void sort_prims(building *b, uint32_t count) {
    uint16_t next[KEYS + 1] = {0}, key[HT_WIDE_CELL_PRIMS];
    const htree_box centroids = ht_centroid_bounds(b->prims, count);
    ht_wide_grid grid;
    ht_wide_grid_cut(&grid, &centroids, CELLS_AN_AXIS);
    for (uint32_t i = 0; i < count; ++i) {
        int32_t at[4];
        const ht_box4 box = ht_prim_box4(&b->prims[i]);
        ht_wide_grid_at(&grid, box.lo, box.hi, at);
        key[i] = (uint16_t)(spread(at[0]) | spread(at[1]) << 1 | spread(at[2]) << 2);
        ++next[key[i] + 1];
    }
    for (uint32_t k = 0; k < KEYS; ++k) next[k + 1] = (uint16_t)(next[k + 1] + next[k]);
    for (uint32_t i = 0; i < count; ++i) b->order[next[key[i]]++] = (uint16_t)i;
}

static uint32_t add_leaf(building *b, uint32_t start, uint32_t count, ht_box4 *box) {
    uint32_t prims[HT_LANES];
    for (uint32_t i = 0; i < count; ++i) prims[i] = ht_prim_id(&b->prims[b->order[start + i]]);
    *box = ht_wide_write_leaf(b->source, prims, count, &b->leaves[b->next_leaf]);
    return HT_WIDE_LEAF | b->next_leaf++;
}

static uint32_t add_node(building *b, uint32_t start, uint32_t count, ht_box4 *box) {
    const uint32_t share = share_of(count), slot = b->next_node++;
    ht_wide_run runs[HT_LANES];
    uint32_t lane[HT_LANES], child[HT_LANES], children = 0, done = 0;
    *box = ht_box4_empty();
    do {
        const uint32_t here = count - done < share ? count - done : share;
        ht_box4 part;
        child[children] = here <= HT_LANES ? add_leaf(b, start + done, here, &part)
                                           : add_node(b, start + done, here, &part);
        runs[children++].box = ht_box4_box(&part);
        ht_box4_add(box, part.lo, part.hi);
        done += here;
    } while (done < count);
    const htree_box all = ht_box4_box(box);
    ht_wide_fill_node(&b->nodes[slot], runs, children, &all, lane);
    for (uint32_t i = 0; i < children; ++i) b->nodes[slot].child[lane[i]] = child[i];
    return slot;
}

void ht_wide_run_morton(const htree *tree, const ht_source *source, const uint32_t *order,
                        const ht_wide_errand *errand) {
    const uint32_t count = errand->cells.prims;
    building b;
    ht_box4 box;
    b.source = source;
    b.nodes = (ht_wide_node *)tree->nodes;
    b.leaves = tree->leaves;
    b.next_node = errand->node;
    b.next_leaf = errand->leaf;
    ht_wide_gather(source, order, &errand->cells, b.prims);
    sort_prims(&b, count);
    const uint32_t child =
        count <= HT_LANES ? add_leaf(&b, 0, count, &box) : add_node(&b, 0, count, &box);
    assert(child == errand->child);
    (void)child;
}
