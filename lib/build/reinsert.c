/* reinsert.c: moves subtrees to where they cost less. The sum of all areas is what a random ray
 * is expected to visit; a move takes a joint out, which saves its parent, and puts it beside
 * another one.
 *
 * Each round looks for the best places of the subtrees with the largest boxes, all at once: from
 * the parent up, and below every sibling on the way as far as something can still be gained (J.
 * Bittner, M. Hapala, V. Havran, "Fast Insertion-Based Optimization of Bounding Volume
 * Hierarchies", CGF 2013; D. Meister, J. Bittner, "Parallel Reinsertion for Bounding Volume
 * Hierarchy Optimization", CGF 2018). Then moves are made in turn, the best first, but where an
 * earlier one has changed the joints around: so the result does not depend on threads. */
#include "joint.h"

enum {
    ROUNDS = 6,
    SHARE = 20,       /* one of so many joints is searched a place for */
    CHUNK = 256,      /* searches a task */
    WAITING = 256,    /* joints of a search that wait; more are left out */
    KEYS = 1 << 16,   /* areas by their leading bits */
    FEWEST_JOINTS = 7 /* there is nothing to gain from fewer */
};

typedef struct move {
    float gain; /* of area */
    uint32_t from, beside;
} move;

typedef struct reinsertion {
    ht_joint *joints;
    uint32_t count, root;
    float *areas;     /* of boxes, by joint */
    uint8_t *changed; /* in this round, by joint */
    uint32_t *keys;   /* joints by leading bits of their areas */
    move *moves;
    uint32_t move_count;
} reinsertion;

static uint32_t sibling_of(const reinsertion *r, uint32_t i) {
    const ht_joint *parent = &r->joints[r->joints[i].parent];
    return parent->left == i ? parent->right : parent->left;
}

/* ---- Which subtrees ------------------------------------------------------------------------- */

static uint32_t key_of(float area) {
    uint32_t bits;
    memcpy(&bits, &area, sizeof bits);
    return bits >> 16;
}

/* The least key of no more joints than the share. */
static uint32_t find_least_key(const reinsertion *r) {
    uint32_t key = KEYS, found = 0;
    memset(r->keys, 0, KEYS * sizeof *r->keys);
    for (uint32_t i = 0; i < r->count; ++i) ++r->keys[key_of(r->areas[i])];
    while (key > 0 && found + r->keys[key - 1] <= r->count / SHARE) found += r->keys[--key];
    return key;
}

static void choose_subtrees(reinsertion *r) {
    const uint32_t least = find_least_key(r);
    r->move_count = 0;
    for (uint32_t i = 0; i < r->count; ++i) {
        const uint32_t parent = r->joints[i].parent;
        if (key_of(r->areas[i]) < least || parent == HTREE_NONE || parent == r->root) continue;
        r->moves[r->move_count++].from = i;
    }
}

/* ---- The best place for one ----------------------------------------------------------------- */

typedef struct place {
    uint32_t joint;
    float saved; /* before the subtree is put in here, or below */
} place;

static void search_below(const reinsertion *r, uint32_t top, float saved, move *best) {
    const htree_box *box = &r->joints[best->from].box;
    const float area = r->areas[best->from];
    const place first = {top, saved};
    place waiting[WAITING];
    uint32_t count = 0;
    waiting[count++] = first;
    while (count > 0) {
        const place at = waiting[--count];
        if (!(at.saved - area > best->gain)) continue;
        const ht_joint *joint = &r->joints[at.joint];
        htree_box both = joint->box;
        ht_box_add(&both, box);
        const float gain = at.saved - ht_box_area(&both);
        if (gain > best->gain) {
            best->gain = gain;
            best->beside = at.joint;
        }
        const float below = gain + r->areas[at.joint];
        if (ht_joint_is_prim(joint) || !(below - area > best->gain) || count + 2 > WAITING)
            continue;
        const place left = {joint->left, below}, right = {joint->right, below};
        waiting[count++] = left;
        waiting[count++] = right;
    }
}

static void find_place(const reinsertion *r, move *best) {
    const uint32_t parent = r->joints[best->from].parent;
    uint32_t sibling = sibling_of(r, best->from), above = parent;
    htree_box rest = r->joints[sibling].box; /* of what is below `above` without the subtree */
    float saved = r->areas[parent];
    best->gain = 0;
    best->beside = HTREE_NONE;
    for (;;) {
        const ht_joint *joint = &r->joints[sibling];
        if (above != parent) {
            search_below(r, sibling, saved, best);
            ht_box_add(&rest, &joint->box);
            saved += r->areas[above] - ht_box_area(&rest);
        } else if (!ht_joint_is_prim(joint)) { /* which would grow to what the parent was */
            search_below(r, joint->left, r->areas[sibling], best);
            search_below(r, joint->right, r->areas[sibling], best);
        }
        if (above == r->root) return;
        sibling = sibling_of(r, above);
        above = r->joints[above].parent;
    }
}

static void find_places(void *data, uint32_t index) {
    const reinsertion *r = (const reinsertion *)data;
    const uint32_t first = index * CHUNK;
    for (uint32_t i = first; i < first + CHUNK && i < r->move_count; ++i)
        find_place(r, &r->moves[i]);
}

/* ---- The order of moves --------------------------------------------------------------------- */

static bool is_better(const move *a, const move *b) {
    return a->gain > b->gain || (a->gain == b->gain && a->from < b->from);
}

/* Lets move i of a heap with the worst move on top sink to its place. */
static void sink(move *moves, uint32_t i, uint32_t count) {
    const move one = moves[i];
    for (uint32_t child; (child = 2 * i + 1) < count; i = child) {
        if (child + 1 < count && is_better(&moves[child], &moves[child + 1])) ++child;
        if (!is_better(&one, &moves[child])) break;
        moves[i] = moves[child];
    }
    moves[i] = one;
}

/* The best first; those that gain nothing are dropped. */
static void sort_moves(reinsertion *r) {
    move *moves = r->moves;
    uint32_t count = 0;
    for (uint32_t i = 0; i < r->move_count; ++i)
        if (moves[i].beside != HTREE_NONE) moves[count++] = moves[i];
    r->move_count = count;
    for (uint32_t i = count / 2; i-- > 0;) sink(moves, i, count);
    while (count > 1) {
        const move worst = moves[0];
        moves[0] = moves[--count];
        moves[count] = worst;
        sink(moves, 0, count);
    }
}

/* ---- Moves ---------------------------------------------------------------------------------- */

/* Whether all is as it was when the place was found, the place is not in the subtree itself, and no
 * way gets too long. */
static bool can_move(const reinsertion *r, const move *m) {
    const ht_joint *joints = r->joints, *from = &joints[m->from], *beside = &joints[m->beside];
    const uint8_t *changed = r->changed;
    uint32_t above = 1 + (from->height > beside->height ? from->height : beside->height);
    if (changed[m->from] || changed[from->parent] || changed[sibling_of(r, m->from)] ||
        changed[m->beside] || beside->parent == HTREE_NONE || changed[beside->parent])
        return false;
    for (uint32_t i = m->beside; i != HTREE_NONE; i = joints[i].parent, ++above)
        if (i == m->from) return false;
    return above <= HT_MAX_DEPTH;
}

static void replace_child(reinsertion *r, uint32_t parent, uint32_t child, uint32_t other) {
    ht_joint *joint = &r->joints[parent];
    *(joint->left == child ? &joint->left : &joint->right) = other;
    r->joints[other].parent = parent;
}

static void refit_from(reinsertion *r, uint32_t i) {
    for (; i != HTREE_NONE; i = r->joints[i].parent) {
        ht_joint *joint = &r->joints[i];
        ht_joint_refit(joint, &r->joints[joint->left], &r->joints[joint->right]);
        r->areas[i] = ht_box_area(&joint->box);
    }
}

/* The parent goes with the subtree, and the sibling takes its place. */
static void make_move(reinsertion *r, const move *m) {
    const uint32_t parent = r->joints[m->from].parent, sibling = sibling_of(r, m->from);
    const uint32_t above = r->joints[parent].parent, target = r->joints[m->beside].parent;
    r->changed[m->from] = r->changed[parent] = r->changed[sibling] = 1;
    r->changed[m->beside] = r->changed[target] = 1;
    replace_child(r, above, parent, sibling);
    replace_child(r, target, m->beside, parent);
    replace_child(r, parent, sibling, m->beside);
    refit_from(r, above);
    refit_from(r, parent);
}

/* ---- All of it ------------------------------------------------------------------------------ */

static void run_rounds(const ht_builder *builder, reinsertion *r) {
    for (uint32_t i = 0; i < r->count; ++i) r->areas[i] = ht_box_area(&r->joints[i].box);
    for (uint32_t round = 0; round < ROUNDS; ++round) {
        choose_subtrees(r);
        ht_builder_run(builder, (r->move_count + CHUNK - 1) / CHUNK, find_places, r);
        sort_moves(r);
        memset(r->changed, 0, r->count);
        for (uint32_t i = 0; i < r->move_count; ++i)
            if (can_move(r, &r->moves[i])) make_move(r, &r->moves[i]);
    }
}

htree_status ht_reinsert(const ht_builder *builder, ht_joints *joints) {
    ht_memory *memory = &builder->tree->memory;
    const uint64_t count = joints->all.count;
    reinsertion r;
    if (count < FEWEST_JOINTS) return HTREE_OK;
    memset(&r, 0, sizeof r);
    r.joints = ht_joint_at(joints, 0);
    r.count = (uint32_t)count;
    r.root = joints->root;
    r.areas = (float *)ht_allocate(memory, count * sizeof *r.areas);
    r.changed = (uint8_t *)ht_allocate(memory, count);
    r.keys = (uint32_t *)ht_allocate(memory, KEYS * sizeof *r.keys);
    r.moves = (move *)ht_allocate(memory, (count / SHARE + 1) * sizeof *r.moves);
    const bool all = r.areas && r.changed && r.keys && r.moves;
    if (all) run_rounds(builder, &r);
    ht_release(memory, r.moves, (count / SHARE + 1) * sizeof *r.moves);
    ht_release(memory, r.keys, KEYS * sizeof *r.keys);
    ht_release(memory, r.changed, count);
    ht_release(memory, r.areas, count * sizeof *r.areas);
    return all ? HTREE_OK : HTREE_ERROR_MEMORY;
}
