/* wide_order.c: errands by Morton order: each has its place in the tree from the start. They are
 * run at once, on all threads; or, in a lazy tree, by the first ray that gets there.
 *
 * A lazy tree's nodes say HT_WIDE_PENDING | errand where the subtree may be missing. Whoever comes
 * there asks for its root: the first one builds it, others wait for the microseconds that it takes.
 * No node is ever written to while rays may read it, and no memory is asked for, so no query can
 * fail. The bytes do not depend on who came first. */
#include "wide.h"

#ifndef HTREE_NO_THREADS
#include <sched.h>
#endif

enum {
    GROUPS = 256,
    PRIMS_A_ROOM = 4096, /* at least: it is work for 40 us */
    MOST_LAZY_ROOMS = 16 /* they stay */
};

/* Instead of a root. */
#define UNTOUCHED   HT_WIDE_NONE
#define BEING_BUILT HT_WIDE_PENDING

/* Where subtrees are made: each takes more than the stack of a thread that traces may have left. Who
 * comes when all are taken waits for one. */
typedef struct room_list {
    char *memory;
    uint64_t bytes; /* of one */
    uint32_t count;
    uint8_t taken[HT_MOST_THREADS];
} room_list;

/* What is left of a build in a lazy tree. */
typedef struct lazy {
    ht_lazy hook;
    room_list rooms;
    ht_source source; /* the caller's arrays, which must stay as they are */
    ht_array cells, errands;
    uint32_t *order;
    uint32_t *roots; /* child words of the errands that are built */
    uint32_t prims;
} lazy;

static lazy *lazy_of(const htree *tree) {
    return (lazy *)(void *)tree->lazy;
}

/* ---- Places --------------------------------------------------------------------------------- */

static htree_status place_errands(ht_wide_build *build) {
    htree *tree = build->builder->tree;
    uint32_t node = (uint32_t)build->top.part.nodes.count, leaf = 0;
    tree->stack = build->top.part.deepest;
    for (uint32_t i = 0; i < build->top.errands.count; ++i) {
        ht_wide_errand *e = ht_wide_errand_at(build, i);
        const uint32_t prims = e->cells.prims;
        const uint32_t stack = e->waiting + ht_wide_morton_stack(prims);
        e->node = node;
        e->leaf = leaf;
        e->child = prims <= HT_LANES ? HT_WIDE_LEAF | leaf : node;
        node += ht_wide_morton_nodes(prims);
        leaf += ht_wide_morton_leaves(prims);
        if (stack > tree->stack) tree->stack = stack;
    }
    HT_TRY(ht_wide_allocate(tree, node, leaf));
    memcpy(tree->nodes, build->top.part.nodes.items,
           (size_t)build->top.part.nodes.count * sizeof(ht_wide_node));
    return HTREE_OK;
}

/* ---- Rooms ---------------------------------------------------------------------------------- */

static void pause_thread(void) {
#ifndef HTREE_NO_THREADS
    sched_yield();
#endif
}

static htree_status begin_rooms(room_list *r, ht_memory *memory, uint32_t prims, uint32_t most) {
    const uint32_t wanted = prims / PRIMS_A_ROOM + 1;
    memset(r, 0, sizeof *r);
    r->bytes = ht_wide_morton_room();
    r->count = wanted < most ? wanted : most;
    r->memory = (char *)ht_allocate(memory, r->bytes * r->count);
    return r->memory ? HTREE_OK : HTREE_ERROR_MEMORY;
}

static void end_rooms(room_list *r, ht_memory *memory) {
    ht_release(memory, r->memory, r->bytes * r->count);
}

static uint32_t take_room(room_list *r) {
    for (;; pause_thread()) {
        for (uint32_t i = 0; i < r->count; ++i) {
            if (__atomic_load_n(&r->taken[i], __ATOMIC_RELAXED)) continue;
            if (!__atomic_exchange_n(&r->taken[i], 1, __ATOMIC_ACQUIRE)) return i;
        }
    }
}

static void leave_room(room_list *r, uint32_t i) {
    __atomic_store_n(&r->taken[i], 0, __ATOMIC_RELEASE);
}

static void *room_at(const room_list *r, uint32_t i) {
    return r->memory + i * r->bytes;
}

/* ---- At once -------------------------------------------------------------------------------- */

/* Inlined for sure: gcc drops calls of functions that do nothing but prefetch. */
HT_INLINE void prefetch_errand(const ht_wide_build *build, const ht_wide_errand *e) {
    for (uint32_t i = 0; i < e->cells.count; ++i) {
        const ht_prim *cell = &e->cells.items[i];
        const uint32_t *ids = build->cells.order + ht_cell_first(cell);
        const uint32_t count = ht_cell_prims(cell);
        for (uint32_t k = 0; k < count; ++k) ht_source_prefetch(&build->source, ids[k]);
    }
}

typedef struct running {
    const ht_wide_build *build;
    room_list rooms;
} running;

static void run_group(void *data, uint32_t index) {
    running *r = (running *)data;
    const ht_wide_build *build = r->build;
    const htree *tree = build->builder->tree;
    const uint64_t count = build->top.errands.count;
    const uint32_t end = (uint32_t)(count * (index + 1) / GROUPS);
    const uint32_t room = take_room(&r->rooms);
    uint64_t prims = 0;
    for (uint32_t i = (uint32_t)(count * index / GROUPS); i < end; ++i) {
        const ht_wide_errand *e = ht_wide_errand_at(build, i);
        if (i + 1 < end) prefetch_errand(build, e + 1);
        ht_wide_run_morton(tree, &build->source, build->cells.order, e, room_at(&r->rooms, room));
        ht_wide_set_parent(tree, e, e->child);
        prims += e->cells.prims;
    }
    leave_room(&r->rooms, room);
    ht_progress_step(&build->builder->progress, prims);
}

static htree_status run_all(ht_wide_build *build) {
    const ht_builder *builder = build->builder;
    htree *tree = builder->tree;
    running r;
    r.build = build;
    HT_TRY(begin_rooms(&r.rooms, &tree->memory, build->prims,
                       ht_thread_count(&tree->tasks, tree->threads)));
    ht_builder_run(builder, GROUPS, run_group, &r);
    end_rooms(&r.rooms, &tree->memory);
    return builder->progress.cancelled ? HTREE_ERROR_CANCELLED : HTREE_OK;
}

/* ---- When a ray comes ----------------------------------------------------------------------- */

static uint32_t touch(const htree *tree, uint32_t errand) {
    lazy *l = lazy_of(tree);
    uint32_t *root = &l->roots[errand], seen = __atomic_load_n(root, __ATOMIC_ACQUIRE);
    if (seen == UNTOUCHED && __atomic_compare_exchange_n(root, &seen, BEING_BUILT, false,
                                                         __ATOMIC_ACQUIRE, __ATOMIC_ACQUIRE)) {
        const ht_wide_errand *e = (const ht_wide_errand *)ht_array_at(&l->errands, errand);
        const uint32_t room = take_room(&l->rooms);
        ht_wide_run_morton(tree, &l->source, l->order, e, room_at(&l->rooms, room));
        leave_room(&l->rooms, room);
        __atomic_store_n(root, e->child, __ATOMIC_RELEASE);
        return e->child;
    }
    for (; seen == BEING_BUILT; seen = __atomic_load_n(root, __ATOMIC_ACQUIRE)) pause_thread();
    return seen;
}

static void end_lazy(htree *tree) {
    lazy *l = lazy_of(tree);
    /* The tree may have moved since: htree_update. */
    l->cells.memory = l->errands.memory = &tree->memory;
    ht_array_end(&l->errands);
    ht_array_end(&l->cells);
    end_rooms(&l->rooms, &tree->memory);
    ht_release(&tree->memory, l->order, l->prims * sizeof *l->order);
    ht_release(&tree->memory, l, sizeof *l + (uint64_t)l->hook.subtrees * sizeof *l->roots);
    tree->lazy = NULL;
}

static void complete_group(void *data, uint32_t index) {
    const htree *tree = (const htree *)data;
    const lazy *l = lazy_of(tree);
    const uint64_t count = l->errands.count;
    const uint32_t end = (uint32_t)(count * (index + 1) / GROUPS);
    for (uint32_t i = (uint32_t)(count * index / GROUPS); i < end; ++i) {
        const ht_wide_errand *e = (const ht_wide_errand *)ht_array_at(&l->errands, i);
        ht_wide_set_parent(tree, e, touch(tree, i));
    }
}

static void complete(htree *tree) {
    ht_parallel_for(&tree->tasks, tree->threads, GROUPS, complete_group, tree);
    end_lazy(tree);
}

static uint32_t prims_of(const htree *tree, uint32_t errand) {
    return ((const ht_wide_errand *)ht_array_at(&lazy_of(tree)->errands, errand))->cells.prims;
}

static uint32_t child_of(const htree *tree, uint32_t errand) {
    const uint32_t root = __atomic_load_n(&lazy_of(tree)->roots[errand], __ATOMIC_ACQUIRE);
    return root == BEING_BUILT ? HT_WIDE_NONE : root;
}

static uint32_t count_built(const htree *tree) {
    uint32_t built = 0;
    for (uint32_t i = 0; i < tree->lazy->subtrees; ++i) built += child_of(tree, i) != HT_WIDE_NONE;
    return built;
}

/* Takes what errands need over from the build. */
static htree_status become_lazy(ht_wide_build *build) {
    htree *tree = build->builder->tree;
    const uint32_t subtrees = (uint32_t)build->top.errands.count;
    lazy *l = (lazy *)ht_allocate(&tree->memory, sizeof *l + (uint64_t)subtrees * sizeof *l->roots);
    if (!l) return HTREE_ERROR_MEMORY;
    memset(l, 0, sizeof *l);
    if (begin_rooms(&l->rooms, &tree->memory, build->prims, MOST_LAZY_ROOMS) != HTREE_OK) {
        ht_release(&tree->memory, l, sizeof *l + (uint64_t)subtrees * sizeof *l->roots);
        return HTREE_ERROR_MEMORY;
    }
    const ht_lazy hook = {subtrees, touch, prims_of, child_of, count_built, complete, end_lazy};
    l->hook = hook;
    l->source = build->source;
    l->source.boxes = tree->object_boxes;
    l->prims = build->prims;
    l->roots = (uint32_t *)(void *)(l + 1);
    l->cells = build->cells.cells;
    l->errands = build->top.errands;
    l->order = build->cells.order;
    ht_array_begin(&build->cells.cells, &tree->memory, sizeof(ht_prim));
    ht_array_begin(&build->top.errands, &tree->memory, sizeof(ht_wide_errand));
    build->cells.order = NULL;
    tree->lazy = &l->hook;
    for (uint32_t i = 0; i < subtrees; ++i) {
        const ht_wide_errand *e = (const ht_wide_errand *)ht_array_at(&l->errands, i);
        ht_wide_set_parent(tree, e, HT_WIDE_PENDING | i);
        l->roots[i] = UNTOUCHED;
    }
    return HTREE_OK;
}

htree_status ht_wide_finish_by_order(ht_wide_build *build) {
    HT_TRY(place_errands(build));
    if (build->builder->options->flags & HTREE_LAZY) return become_lazy(build);
    return run_all(build);
}
