/* survey.c: whether the tree's leaves can take a mesh as it is now.
 *
 * Where everything is in range, triangles without area are all that could be new, and those do no
 * harm in a leaf. So it is enough to read the arrays in their order, which is faster than triangle
 * by triangle, and to judge the few prims that the tree does not refer to. */
#include "survey.h"

#ifndef HTREE_NO_THREADS
#include <sched.h>
#endif

enum { CHUNKS = 64 };

typedef struct range {
    uint64_t first, end;
} range;

static range chunk_of(uint64_t count, uint32_t index) {
    const range r = {count * index / CHUNKS, count * (index + 1) / CHUNKS};
    return r;
}

/* ---- In the order of the arrays ------------------------------------------------------------- */

/* last - index is negative, or index is, for every index beyond. */
static bool have_vertices(const ht_source *source, range triangles) {
    const uint32_t last = (uint32_t)(source->vertex_count - 1);
    uint32_t signs = 0;
    if (!source->indices) return true;
    if (source->vertex_count > INT32_MAX) return false;
    for (uint64_t i = 3 * triangles.first; i < 3 * triangles.end; ++i)
        signs |= (last - source->indices[i]) | source->indices[i];
    return !(signs >> 31);
}

static bool are_in_range(const ht_source *source, range vertices) {
    const ht_f4 limit = ht_f4_all(HTREE_COORDINATE_MAX);
    uint32_t in = HT_XYZ;
    for (uint64_t i = vertices.first; i < vertices.end; ++i)
        in &= ht_f4_at_most(ht_f4_magnitude(ht_source_any_position(source, i)), limit);
    return in == HT_XYZ;
}

static bool are_valid(const ht_source *source, range boxes) {
    bool valid = true;
    for (uint64_t i = boxes.first; i < boxes.end; ++i) valid &= ht_box_is_valid(&source->boxes[i]);
    return valid;
}

static bool is_skipped(const ht_source *source, uint32_t i) {
    if (i >= source->triangle_count)
        return !ht_box_is_valid(&source->boxes[i - source->triangle_count]);
    const ht_corners corners = ht_source_corners(source, i);
    return ht_corners_judge(&corners) != HT_HITTABLE;
}

/* Of prims whose vertices may not be there. */
static bool are_skipped(const ht_source *source, const uint32_t *prims, range all) {
    bool skipped = true;
    for (uint64_t i = all.first; i < all.end && skipped; ++i) {
        const bool there =
            prims[i] >= source->triangle_count || ht_source_has_corners(source, prims[i]);
        skipped = !there || is_skipped(source, prims[i]);
    }
    return skipped;
}

static void survey_chunk(ht_survey *s, uint32_t index) {
    const ht_source source = s->source;
    const bool plain = have_vertices(&source, chunk_of(source.triangle_count, index)) &&
                       are_in_range(&source, chunk_of(source.vertex_count, index)) &&
                       are_valid(&source, chunk_of(source.object_count, index));
    const range skipped = chunk_of(s->tree->skipped_count, index);
    if (!plain) __atomic_store_n(&s->odd, 1, __ATOMIC_RELAXED);
    if (!are_skipped(&source, s->tree->skipped, skipped))
        __atomic_store_n(&s->returning, 1, __ATOMIC_RELAXED);
}

static void pause_thread(void) {
#ifndef HTREE_NO_THREADS
    sched_yield();
#endif
}

bool ht_survey_help(ht_survey *s) {
    uint32_t chunk;
    while ((chunk = __atomic_fetch_add(&s->taken, 1, __ATOMIC_RELAXED)) < CHUNKS) {
        survey_chunk(s, chunk);
        __atomic_add_fetch(&s->done, 1, __ATOMIC_RELEASE);
    }
    while (__atomic_load_n(&s->done, __ATOMIC_ACQUIRE) < CHUNKS) pause_thread();
    return !s->odd && !s->returning;
}

/* ---- What the tree was built without -------------------------------------------------------- */

static void mark(const htree *tree, uint8_t *known) {
    for (uint32_t i = 0; i < tree->leaf_count; ++i) {
        const uint32_t *prim = tree->leaves[i].prim;
        for (uint32_t k = 0; k < HT_LANES && prim[k] != HT_WIDE_NONE; ++k)
            known[prim[k] >> 3] = (uint8_t)(known[prim[k] >> 3] | 1u << (prim[k] & 7));
    }
}

/* How many prims are not marked, and which, unless list is NULL. */
static uint32_t list_unmarked(const uint8_t *known, uint32_t prims, uint32_t *list) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < prims; ++i) {
        if (known[i >> 3] >> (i & 7) & 1) continue;
        if (list) list[count] = i;
        ++count;
    }
    return count;
}

static htree_status find_skipped(htree *tree) {
    const uint32_t prims = tree->triangle_count + tree->object_count;
    const uint64_t bytes = prims / 8 + 1;
    ht_memory memory = {tree->memory.hook, 0, 0, NULL};
    uint8_t *known = (uint8_t *)ht_allocate(&memory, bytes);
    if (!known) return HTREE_ERROR_MEMORY;
    memset(known, 0, (size_t)bytes);
    mark(tree, known);
    const uint32_t count = list_unmarked(known, prims, NULL);
    tree->skipped = (uint32_t *)ht_allocate(&tree->memory, count * sizeof *tree->skipped);
    if (tree->skipped) {
        tree->skipped_count = count;
        list_unmarked(known, prims, tree->skipped);
    }
    ht_release(&memory, known, bytes);
    return tree->skipped ? HTREE_OK : HTREE_ERROR_MEMORY;
}

htree_status ht_survey_begin(ht_survey *survey, htree *tree, const ht_source *source) {
    memset(survey, 0, sizeof *survey);
    survey->tree = tree;
    survey->source = *source;
    if (tree->prim_count == tree->triangle_count + tree->object_count || tree->skipped)
        return HTREE_OK;
    return find_skipped(tree);
}

/* ---- Prim by prim --------------------------------------------------------------------------- */

typedef struct closer_look {
    const ht_survey *survey;
    uint32_t bad[CHUNKS];  /* the first prim that has no vertex */
    uint32_t gone[CHUNKS]; /* whether a leaf's prim can no longer be hit */
} closer_look;

static void look_for_bad(void *data, uint32_t index) {
    closer_look *l = (closer_look *)data;
    const ht_source source = l->survey->source;
    const range triangles = chunk_of(source.triangle_count, index);
    uint32_t i = (uint32_t)triangles.first;
    while (i < triangles.end && ht_source_has_corners(&source, i)) ++i;
    l->bad[index] = i < triangles.end ? i : HTREE_NONE;
}

static void look_for_gone(void *data, uint32_t index) {
    closer_look *l = (closer_look *)data;
    const htree *tree = l->survey->tree;
    const range leaves = chunk_of(tree->leaf_count, index);
    bool gone = false;
    for (uint64_t i = leaves.first; i < leaves.end && !gone; ++i) {
        const uint32_t *prims = tree->leaves[i].prim;
        for (uint32_t k = 0; k < HT_LANES && prims[k] != HT_WIDE_NONE; ++k)
            gone |= is_skipped(&l->survey->source, prims[k]);
    }
    l->gone[index] = gone;
}

htree_status ht_survey_closely(const ht_survey *survey, bool *same) {
    const htree *tree = survey->tree;
    closer_look look;
    look.survey = survey;
    ht_parallel_for(&tree->tasks, tree->threads, CHUNKS, look_for_bad, &look);
    for (uint32_t i = 0; i < CHUNKS; ++i) {
        if (look.bad[i] != HTREE_NONE) return ht_refuse_prim(&survey->source, look.bad[i], true);
    }
    *same = !survey->returning;
    if (!*same) return HTREE_OK;
    ht_parallel_for(&tree->tasks, tree->threads, CHUNKS, look_for_gone, &look);
    for (uint32_t i = 0; i < CHUNKS; ++i) *same &= !look.gone[i];
    return HTREE_OK;
}
