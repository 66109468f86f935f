/* collapse.c: a finished binary hierarchy becomes a wide tree: eight children a node and eight
 * prims a leaf, for vector units. A node opens the largest of its boxes until it has eight; what
 * holds no more than eight prims becomes a leaf. Boxes are made tight, whatever the planes above
 * had left of them. / */
#include "collapse.h"
#include "wide.h"
#include "tree/visit.h"

enum {
    BY_AREA_LEVELS = 16, /* below, nodes open what holds most: the tree stays within its levels */
    CHILDREN = 3         /* that a binary node has at most, its shelf included */
};

/* What hangs below a slot. */
typedef struct subtree {
    htree_box box;
    uint32_t prims;
} subtree;

typedef struct collapsing {
    const htree *tree;
    subtree *subtrees; /* by slot */
    uint32_t *order;   /* prims by leaf */
    uint32_t ordered;
    ht_wide_part part;
} collapsing;

/* ---- What there is -------------------------------------------------------------------------- */

static htree_box box_of_prim(const htree *tree, uint32_t prim) {
    htree_box box = ht_box_empty();
    if (prim >= tree->triangle_count) return tree->object_boxes[prim - tree->triangle_count];
    for (int k = 0; k < 3; ++k) ht_box_add_point(&box, tree->triangles[prim].v[k]);
    return box;
}

/* Writes the children of a node and returns how many; *own is what its own leaf holds. Apart from
 * the recursion, whose frames are small so. */
static HT_NOINLINE uint32_t view_children(const htree *tree, const ht_place *place, ht_place *child,
                                          subtree *own) {
    ht_node_view view;
    (void)ht_view_node(tree, place, NULL, &view);
    own->box = ht_box_empty();
    own->prims = view.prim_count;
    for (uint32_t i = 0; i < view.prim_count; ++i) {
        const htree_box box = box_of_prim(tree, view.prims[i]);
        ht_box_add(&own->box, &box);
    }
    memcpy(child, view.child, view.child_count * sizeof *child);
    return view.child_count;
}

static subtree measure(collapsing *c, const ht_place *place) {
    ht_place child[CHILDREN];
    subtree all;
    const uint32_t count = view_children(c->tree, place, child, &all);
    for (uint32_t i = 0; i < count; ++i) {
        const subtree below = measure(c, &child[i]);
        ht_box_add(&all.box, &below.box);
        all.prims += below.prims;
    }
    c->subtrees[place->slot] = all;
    return all;
}

/* ---- Leaves --------------------------------------------------------------------------------- */

static void list_prims(collapsing *c, const ht_place *place) {
    ht_node_view view;
    (void)ht_view_node(c->tree, place, NULL, &view);
    for (uint32_t i = 0; i < view.prim_count; ++i) c->order[c->ordered++] = view.prims[i];
    for (uint32_t i = 0; i < view.child_count; ++i) list_prims(c, &view.child[i]);
}

static htree_status add_leaf(collapsing *c, const ht_place *place, uint32_t *child) {
    const uint32_t first = c->ordered;
    list_prims(c, place);
    return ht_wide_add_leaf(&c->part, first, c->ordered - first, child);
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

static uint32_t choose_place(const collapsing *c, const ht_place *places, uint32_t count,
                             bool by_area) {
    uint32_t best = count;
    float most = -1;
    for (uint32_t i = 0; i < count; ++i) {
        const subtree *s = &c->subtrees[places[i].slot];
        const float worth = by_area ? ht_box_area(&s->box) : (float)s->prims;
        if (s->prims > HT_LANES && worth > most) {
            most = worth;
            best = i;
        }
    }
    return best;
}

/* The nearest node below, or the place itself, that branches. */
static void view_branch(const collapsing *c, ht_place place, ht_node_view *view) {
    (void)ht_view_node(c->tree, &place, NULL, view);
    while (view->child_count == 1) {
        place = view->child[0];
        (void)ht_view_node(c->tree, &place, NULL, view);
    }
}

static uint32_t open_places(const collapsing *c, const ht_place *place, uint32_t level,
                            ht_place *places) {
    uint32_t count = 1;
    places[0] = *place;
    while (count + CHILDREN - 1 <= HT_LANES) {
        const uint32_t chosen = choose_place(c, places, count, level < BY_AREA_LEVELS);
        ht_node_view view;
        if (chosen == count) break;
        view_branch(c, places[chosen], &view);
        places[chosen] = view.child[0];
        for (uint32_t i = 1; i < view.child_count; ++i) places[count++] = view.child[i];
    }
    return count;
}

static htree_status add_node(collapsing *c, const ht_place *place, uint32_t level, uint32_t waiting,
                             uint32_t *slot) {
    ht_place places[HT_LANES];
    ht_wide_run runs[HT_LANES];
    uint32_t lane[HT_LANES];
    const uint32_t count = open_places(c, place, level, places);
    for (uint32_t i = 0; i < count; ++i) runs[i].box = ht_box4_of(&c->subtrees[places[i].slot].box);
    const ht_box4 box = ht_box4_of(&c->subtrees[place->slot].box);
    HT_TRY(ht_wide_write_node(&c->part, runs, count, &box, lane, slot));
    waiting += count - 1;
    if (waiting > c->part.deepest) c->part.deepest = waiting;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t child;
        HT_TRY(c->subtrees[places[i].slot].prims > HT_LANES
                   ? add_node(c, &places[i], level + 1, waiting, &child)
                   : add_leaf(c, &places[i], &child));
        ht_wide_set_child(&c->part, *slot, lane[i], child);
    }
    return HTREE_OK;
}

/* ---- All of it ------------------------------------------------------------------------------ */

static void release_binary(htree *tree) {
    ht_release(&tree->memory, tree->nodes, tree->node_bytes);
    ht_release(&tree->memory, tree->triangles, tree->triangle_count * sizeof *tree->triangles);
    tree->nodes = NULL;
    tree->triangles = NULL;
    tree->kind = HTREE_WIDE;
}

static htree_status write_tree(const collapsing *c, const ht_builder *builder) {
    htree *tree = builder->tree;
    const ht_source source = ht_source_of(builder->mesh);
    const ht_wide_leaf_run *runs = (const ht_wide_leaf_run *)c->part.leaves.items;
    release_binary(tree);
    HT_TRY(ht_wide_allocate(tree, c->part.nodes.count, c->part.leaves.count));
    memcpy(tree->nodes, c->part.nodes.items, (size_t)tree->node_bytes);
    for (uint32_t i = 0; i < tree->leaf_count; ++i)
        ht_wide_write_leaf(tree->isa, &source, c->order + runs[i].first, runs[i].count,
                           &tree->leaves[i]);
    tree->stack = c->part.deepest;
    return HTREE_OK;
}

htree_status ht_collapse(const ht_builder *builder) {
    htree *tree = builder->tree;
    ht_memory *memory = &tree->memory;
    const ht_place root = ht_root_place(tree);
    const uint64_t subtree_bytes = tree->node_slots * sizeof(subtree);
    const uint64_t order_bytes = tree->prim_count * sizeof(uint32_t);
    htree_status status = HTREE_ERROR_MEMORY;
    collapsing c;
    uint32_t slot;
    if ((uint64_t)tree->triangle_count + tree->object_count >= HT_WIDE_PRIMS)
        return ht_fail(HTREE_ERROR_LIMIT, "a wide tree holds fewer than 2^30 - 1 objects");
    memset(&c, 0, sizeof c);
    c.tree = tree;
    ht_wide_part_begin(&c.part, memory);
    c.subtrees = (subtree *)ht_allocate(memory, subtree_bytes);
    c.order = (uint32_t *)ht_allocate(memory, order_bytes);
    if (c.subtrees && c.order) {
        measure(&c, &root);
        status = add_node(&c, &root, 0, 0, &slot);
    }
    if (status == HTREE_OK) status = write_tree(&c, builder);
    ht_release(memory, c.order, order_bytes);
    ht_release(memory, c.subtrees, subtree_bytes);
    ht_wide_part_end(&c.part);
    return status;
}
