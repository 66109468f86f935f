/* check.c: htree_check: proves what walks rely on, so that a walk needs no checks of its own. */
#include "visit.h"
#include "base/float_env.h"

typedef struct proof {
    const htree *tree;
    uint8_t *slot_seen; /* a bit per slot */
    uint8_t *prim_seen; /* a bit per prim */
    uint64_t prims_seen, references;
} proof;

/* Cells of a divided space share the objects that reach into several; object hierarchies share
 * none. */
static bool is_space_divided(const htree *tree) {
    return tree->kind == HTREE_KD || tree->kind == HTREE_UG;
}

/* Sets bit i and returns whether it was set before. */
static bool mark(uint8_t *bits, uint32_t i) {
    const uint8_t bit = (uint8_t)(1u << (i & 7));
    const bool before = (bits[i >> 3] & bit) != 0;
    bits[i >> 3] = (uint8_t)(bits[i >> 3] | bit);
    return before;
}

/* The box of prim i of a leaf; empty if it cannot be hit: it was skipped, or is none. */
static htree_box box_of(const htree *tree, const ht_node_view *view, uint32_t i) {
    const uint32_t prim = view->prims[i];
    htree_box box = ht_box_empty();
    if (prim >= tree->triangle_count) {
        const uint32_t object = prim - tree->triangle_count;
        return object < tree->object_count ? tree->object_boxes[object] : box;
    }
    /* A refit may leave triangles without area in the leaves of a wide tree. */
    const ht_triangle t = ht_view_triangle(tree, view, i);
    if (!ht_triangle_is_valid(&t)) return box;
    if (!view->block && ht_triangle_is_degenerate(t.v[0], t.v[1], t.v[2])) return box;
    for (int k = 0; k < 3; ++k) ht_box_add_point(&box, t.v[k]);
    return box;
}

static htree_status check_prim(proof *p, const ht_place *place, const ht_node_view *view,
                               uint32_t i) {
    const htree *tree = p->tree;
    const uint32_t prim = view->prims[i];
    const htree_box box = box_of(tree, view, i);
    if (!(box.lo[0] <= box.hi[0])) {
        return ht_fail(HTREE_ERROR_CORRUPT,
                       "slot %lu refers to prim %lu, which was skipped or is none",
                       (unsigned long)place->slot, (unsigned long)prim);
    }
    const bool seen = mark(p->prim_seen, prim);
    if (seen && !is_space_divided(tree)) {
        return ht_fail(HTREE_ERROR_CORRUPT, "two leaves refer to prim %lu", (unsigned long)prim);
    }
    p->prims_seen += !seen;
    if (is_space_divided(tree) ? !ht_box_touches(&place->box, &box)
                               : !ht_box_contains(&place->box, &box)) {
        return ht_fail(HTREE_ERROR_CORRUPT, "prim %lu is not where its leaf is, at slot %lu",
                       (unsigned long)prim, (unsigned long)place->slot);
    }
    return HTREE_OK;
}

static htree_status check_node(void *data, const ht_place *place, const ht_node_view *view) {
    proof *p = (proof *)data;
    for (uint32_t i = 0; i < view->slots; ++i) {
        if (mark(p->slot_seen, place->slot + i)) {
            return ht_fail(HTREE_ERROR_CORRUPT, "slot %lu is reached twice",
                           (unsigned long)(place->slot + i));
        }
    }
    if (place->branches > p->tree->stack) {
        return ht_fail(HTREE_ERROR_CORRUPT, "slot %lu lies %lu branches deep, the tree states %lu",
                       (unsigned long)place->slot, (unsigned long)place->branches,
                       (unsigned long)p->tree->stack);
    }
    if (view->role == HT_PENDING) {
        p->prims_seen += view->prim_count;
        return HTREE_OK;
    }
    /* Leaves that share references could make the proof take their product's time. */
    p->references += view->prim_count;
    if (is_space_divided(p->tree) && p->references > p->tree->ref_count) {
        return ht_fail(HTREE_ERROR_CORRUPT, "two leaves share references, one at slot %lu",
                       (unsigned long)place->slot);
    }
    /* Objects hang below a node only through its children, so boxes need proof at the leaves alone:
     * every traversal box on the way there contains the leaf's. */
    for (uint32_t i = 0; i < view->prim_count; ++i) HT_TRY(check_prim(p, place, view, i));
    return HTREE_OK;
}

static htree_status run_proof(proof *p) {
    HT_TRY(ht_visit_nodes(p->tree, check_node, p));
    if (p->prims_seen != p->tree->prim_count) {
        return ht_fail(HTREE_ERROR_CORRUPT, "leaves refer to %llu of %lu prims",
                       (unsigned long long)p->prims_seen, (unsigned long)p->tree->prim_count);
    }
    if (is_space_divided(p->tree) && p->references != p->tree->ref_count) {
        return ht_fail(HTREE_ERROR_CORRUPT, "%llu of %lu references are in no leaf",
                       (unsigned long long)(p->tree->ref_count - p->references),
                       (unsigned long)p->tree->ref_count);
    }
    return HTREE_OK;
}

static htree_status check(const htree *tree) {
    HT_TRY(ht_tree_verify(tree));
    if (tree->stack > ht_stack_limit(tree->kind)) {
        return ht_fail(HTREE_ERROR_CORRUPT, "the tree states a stack of %lu",
                       (unsigned long)tree->stack);
    }
    /* A copy of the hook with its own count: a query may not change the tree. */
    ht_memory memory = {tree->memory.hook, 0, 0, NULL};
    const uint64_t slot_bytes = ht_slot_count(tree) / 8 + 1;
    const uint64_t prim_bytes = ((uint64_t)tree->triangle_count + tree->object_count) / 8 + 1;
    proof p = {tree, NULL, NULL, 0, 0};
    p.slot_seen = (uint8_t *)ht_allocate(&memory, slot_bytes);
    p.prim_seen = (uint8_t *)ht_allocate(&memory, prim_bytes);
    htree_status status = HTREE_ERROR_MEMORY;
    if (p.slot_seen && p.prim_seen) {
        memset(p.slot_seen, 0, (size_t)slot_bytes);
        memset(p.prim_seen, 0, (size_t)prim_bytes);
        status = run_proof(&p);
    }
    ht_release(&memory, p.prim_seen, prim_bytes);
    ht_release(&memory, p.slot_seen, slot_bytes);
    return status;
}

htree_status htree_check(const htree *tree) {
    HT_RETURN_IN_DEFAULT_ENV(check(tree));
}
