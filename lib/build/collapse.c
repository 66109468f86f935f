/* collapse.c: a finished binary hierarchy becomes a wide tree: eight children a node and eight
 * prims a leaf, for vector units.
 *
 * Which joints become nodes and leaves is found from the bottom up: for each of them, what its
 * subtree is expected to cost as one child of a node, as at most two of them, and so on (H.
 * Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
 * Wide BVHs", HPG 2017). */
#include "collapse.h"
#include "joint.h"
#include "wide.h"

enum {
    BY_COST_LEVELS = 16 /* below, nodes open what holds most: the tree stays within its levels */
};

/* What eight boxes cost, and eight triangles. */
static const float node_cost = 1.0f, leaf_cost = 1.5f;

typedef struct collapsing {
    ht_joints joints;
    uint32_t *plans; /* of joints: see share_of */
    uint32_t *order; /* prims by leaf */
    uint32_t ordered;
    ht_wide_part part;
} collapsing;

static const ht_joint *joint_at(const collapsing *c, uint32_t i) {
    return ht_joint_at(&c->joints, i);
}

/* ---- The plan ------------------------------------------------------------------------------- */

/* cost[i]: of a subtree as at most i + 1 children of a node. */
typedef struct costs {
    float cost[HT_LANES];
} costs;

/* How many of at most 2 <= i <= 8 children are below the left one: three bits of the plan for
 * each i. 0: as with one child less. */
static uint32_t share_of(uint32_t plan, uint32_t i) {
    return plan >> 3 * (i - 2) & 7;
}

/* The best shares of i children; returns their cost. */
static float share_children(const costs *left, const costs *right, uint32_t i, uint32_t *share) {
    float least = INFINITY;
    *share = 1;
    for (uint32_t k = 1; k < i; ++k) {
        const float cost = left->cost[k - 1] + right->cost[i - k - 1];
        if (cost < least) {
            least = cost;
            *share = k;
        }
    }
    return least;
}

static costs plan_joint(const ht_joint *joint, const costs *left, const costs *right,
                        uint32_t *plan) {
    const float area = ht_box_area(&joint->box);
    costs all;
    uint32_t share;
    const float opened = share_children(left, right, HT_LANES, &share);
    *plan = share << 3 * (HT_LANES - 2);
    all.cost[0] = area * (joint->prims > HT_LANES ? node_cost : leaf_cost);
    if (joint->prims > HT_LANES) all.cost[0] += opened;
    for (uint32_t i = 2; i < HT_LANES; ++i) {
        const float cost = share_children(left, right, i, &share);
        const bool cheaper = cost < all.cost[i - 2];
        all.cost[i - 1] = cheaper ? cost : all.cost[i - 2];
        *plan |= (cheaper ? share : 0) << 3 * (i - 2);
    }
    all.cost[HT_LANES - 1] = opened < all.cost[HT_LANES - 2] ? opened : all.cost[HT_LANES - 2];
    return all;
}

static costs plan_subtree(const collapsing *c, uint32_t index) {
    const ht_joint *joint = joint_at(c, index);
    if (ht_joint_is_prim(joint)) {
        costs one;
        for (uint32_t i = 0; i < HT_LANES; ++i) one.cost[i] = ht_box_area(&joint->box) * leaf_cost;
        return one;
    }
    const costs left = plan_subtree(c, joint->left), right = plan_subtree(c, joint->right);
    return plan_joint(joint, &left, &right, &c->plans[index]);
}

/* ---- Leaves --------------------------------------------------------------------------------- */

static void list_prims(collapsing *c, uint32_t index) {
    const ht_joint *joint = joint_at(c, index);
    if (ht_joint_is_prim(joint)) {
        c->order[c->ordered++] = joint->left;
        return;
    }
    list_prims(c, joint->left);
    list_prims(c, joint->right);
}

static htree_status add_leaf(collapsing *c, uint32_t index, uint32_t *child) {
    const uint32_t first = c->ordered;
    list_prims(c, index);
    return ht_wide_add_leaf(&c->part, first, c->ordered - first, child);
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

/* Adds the at most `most` children that the plan makes of a subtree; returns their new count. */
static uint32_t add_planned(const collapsing *c, uint32_t index, uint32_t most, uint32_t *children,
                            uint32_t count) {
    const ht_joint *joint = joint_at(c, index);
    while (most > 1 && !ht_joint_is_prim(joint) && share_of(c->plans[index], most) == 0) --most;
    if (most == 1 || ht_joint_is_prim(joint)) {
        children[count] = index;
        return count + 1;
    }
    const uint32_t share = share_of(c->plans[index], most);
    count = add_planned(c, joint->left, share, children, count);
    return add_planned(c, joint->right, most - share, children, count);
}

/* Opens what holds most, until there are eight. */
static uint32_t open_largest(const collapsing *c, uint32_t index, uint32_t *children) {
    uint32_t count = 1;
    children[0] = index;
    while (count < HT_LANES) {
        uint32_t most = 0;
        for (uint32_t i = 1; i < count; ++i)
            if (joint_at(c, children[i])->prims > joint_at(c, children[most])->prims) most = i;
        const ht_joint *joint = joint_at(c, children[most]);
        if (joint->prims <= HT_LANES) break;
        children[most] = joint->left;
        children[count++] = joint->right;
    }
    return count;
}

static htree_status add_node(collapsing *c, uint32_t index, uint32_t level, uint32_t waiting,
                             uint32_t *slot) {
    uint32_t children[HT_LANES], lane[HT_LANES];
    ht_wide_run runs[HT_LANES];
    const bool planned = level < BY_COST_LEVELS && joint_at(c, index)->prims > HT_LANES;
    const uint32_t count =
        planned ? add_planned(c, index, HT_LANES, children, 0) : open_largest(c, index, children);
    for (uint32_t i = 0; i < count; ++i) runs[i].box = ht_box4_of(&joint_at(c, children[i])->box);
    const ht_box4 box = ht_box4_of(&joint_at(c, index)->box);
    HT_TRY(ht_wide_write_node(&c->part, runs, count, &box, lane, slot));
    waiting += count - 1;
    if (waiting > c->part.deepest) c->part.deepest = waiting;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t child;
        HT_TRY(joint_at(c, children[i])->prims > HT_LANES
                   ? add_node(c, children[i], level + 1, waiting, &child)
                   : add_leaf(c, children[i], &child));
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

static htree_status collapse(collapsing *c, const ht_builder *builder) {
    ht_memory *memory = &builder->tree->memory;
    uint32_t slot;
    HT_TRY(ht_joints_read(&c->joints, builder->tree));
    HT_TRY(ht_reinsert(builder, &c->joints));
    const uint64_t plan_bytes = c->joints.all.count * sizeof *c->plans;
    c->plans = (uint32_t *)ht_allocate(memory, plan_bytes);
    if (!c->plans) return HTREE_ERROR_MEMORY;
    (void)plan_subtree(c, c->joints.root);
    const htree_status status = add_node(c, c->joints.root, 0, 0, &slot);
    ht_release(memory, c->plans, plan_bytes);
    return status;
}

htree_status ht_collapse(const ht_builder *builder) {
    htree *tree = builder->tree;
    ht_memory *memory = &tree->memory;
    const uint64_t order_bytes = tree->prim_count * sizeof(uint32_t);
    htree_status status = HTREE_ERROR_MEMORY;
    collapsing c;
    memset(&c, 0, sizeof c);
    ht_wide_part_begin(&c.part, memory);
    ht_array_begin(&c.joints.all, memory, sizeof(ht_joint));
    c.order = (uint32_t *)ht_allocate(memory, order_bytes);
    if (c.order) status = collapse(&c, builder);
    ht_array_end(&c.joints.all);
    if (status == HTREE_OK) status = write_tree(&c, builder);
    ht_release(memory, c.order, order_bytes);
    ht_wide_part_end(&c.part);
    return status;
}
