/* trace.c: htree_intersect and htree_occluded: the arguments, the batch on all cores, and every
 * ray's way from the caller's bytes to the walk of the tree's kind. */
#include "trace.h"
#include "base/float_env.h"
#include "base/sized.h"
#include "coherence.h"

static const struct {
    htree_kind kind;
    const ht_walks *walks;
} walkers[] = {
    {HTREE_UG, &ht_ug_walks},       {HTREE_KD, &ht_kd_walks},     {HTREE_BVH_MEDIAN, &ht_bvh_walks},
    {HTREE_BVH_SAH, &ht_bvh_walks}, {HTREE_SKD, &ht_h_walks},     {HTREE_H, &ht_h_walks},
    {HTREE_AH, &ht_h_walks},        {HTREE_WIDE, &ht_wide_walks},
};

static const ht_walks *find_walks(htree_kind kind) {
    size_t i = 0;
    while (walkers[i].kind != kind) ++i;
    return walkers[i].walks;
}

/* The one place that chooses among instruction sets; NULL: rays go one by one. */
static const ht_block_walks *find_block_walks(const htree *tree) {
#ifdef HT_X86
    if (tree->kind == HTREE_WIDE && tree->isa == HT_AVX512) return &ht_wide_avx512_walks;
    if (tree->kind == HTREE_WIDE && tree->isa == HT_AVX2) return &ht_wide_avx2_walks;
#endif
#ifdef HT_ARM
    if (tree->kind == HTREE_WIDE && tree->isa == HT_NEON) return &ht_wide_neon_walks;
#endif
    (void)tree;
    return NULL;
}

/* NULL: rays that agree with their neighbours go as the others do. */
static const ht_tile_walks *find_tile_walks(const htree *tree) {
#ifdef HT_X86
    if (tree->kind != HTREE_WIDE || tree->object_count || ht_is_compact(tree) ||
        tree->stack + 1 > HT_PACKET_STACK)
        return NULL;
    if (tree->isa == HT_AVX512) return &ht_packet_avx512_walks;
    if (tree->isa == HT_AVX2) return &ht_packet_avx2_walks;
#endif
    (void)tree;
    return NULL;
}

bool ht_intersect_object(const htree *tree, uint32_t prim, const htree_ray *ray, htree_hit *hit) {
    memset(hit, 0, sizeof *hit);
    const uint32_t object = prim - tree->triangle_count;
    return tree->intersect(tree->intersect_user, object, ray, hit) && ray->tmin <= hit->t &&
           hit->t <= ray->tmax && hit->u == hit->u && hit->v == hit->v;
}

/* ---- One ray -------------------------------------------------------------------------------- */

HT_INLINE void trace_ray(const htree *tree, ht_walk *walk, const htree_ray *ray, htree_hit *hit,
                         htree_counters *counters) {
    const htree_hit miss = {ray->tmax, 0, 0, HTREE_NONE};
    ht_ray r;
    *hit = miss;
    if (tree->prim_count == 0 || !ht_ray_init(&r, ray, &tree->bounds)) return;
    walk(tree, ray, &r, hit, counters);
}

/* ---- A batch -------------------------------------------------------------------------------- */

/* Rays a task: long against its beginning and its end, when fewer rays are in flight; in small batches
 * shorter, so that there are tasks for all threads. */
enum { BLOCK = 2048, SHORTEST_BLOCK = 256, TASKS_A_THREAD = 8 };

typedef struct batch {
    const htree *tree;
    ht_walk *walk;
    ht_block_walk *block_walk; /* if there is one for this tree, on this machine */
    ht_tile_walk *tile_walk;   /* if there is one, and the rays are coherent: by */
    ht_rows rows;              /* these */
    const htree_ray *rays;
    uint64_t count;
    uint32_t block;
    htree_hit *hits;   /* closest */
    uint8_t *occluded; /* any */
    htree_counters *counters;
    ht_progress progress;
} batch;

static void trace_block(void *data, uint32_t index) {
    batch *b = (batch *)data;
    const uint64_t first = (uint64_t)index * b->block;
    const uint64_t end = first + b->block < b->count ? first + b->block : b->count;
    if (!ht_progress_step(&b->progress, 0)) return;
    if (b->block_walk) {
        const ht_block block = {b->rays + first, end - first, b->hits ? b->hits + first : NULL,
                                b->occluded ? b->occluded + first : NULL};
        b->block_walk(b->tree, &block);
        ht_progress_step(&b->progress, end - first);
        return;
    }
    for (uint64_t i = first; i < end; ++i) {
        htree_counters counters = {0, 0, 0, 0};
        htree_hit hit;
        trace_ray(b->tree, b->walk, &b->rays[i], &hit, &counters);
        if (b->hits) {
            b->hits[i] = hit;
        } else {
            b->occluded[i] = hit.prim != HTREE_NONE;
        }
        if (b->counters) b->counters[i] = counters;
    }
    ht_progress_step(&b->progress, end - first);
}

/* ---- A batch of coherent rays --------------------------------------------------------------- */

enum { STRIP = 512 }; /* rays of a row a task */

static uint64_t strips_across(const batch *b) {
    return (b->rows.row + b->block - 1) / b->block;
}

static void trace_strip(void *data, uint32_t index) {
    batch *b = (batch *)data;
    const ht_rows *rows = &b->rows;
    const uint64_t across = strips_across(b);
    const uint64_t left = index % across * b->block, top = index / across * rows->height;
    const uint64_t right = rows->row - left, below = rows->count - top;
    const uint64_t first = ht_ray_at(rows->row, rows->cell, left, top);
    const ht_tile tile = {b->rays + first,
                          rows->row,
                          rows->cell,
                          right < b->block ? (uint32_t)right : b->block,
                          below < rows->height ? (uint32_t)below : rows->height,
                          b->hits ? b->hits + first : NULL,
                          b->occluded ? b->occluded + first : NULL};
    if (!ht_progress_step(&b->progress, 0)) return;
    b->tile_walk(b->tree, &tile);
    ht_progress_step(&b->progress, (uint64_t)tile.width * tile.height);
}

static htree_status read_query(const htree *tree, const htree_query *given, htree_query *query) {
    HT_TRY(htree_query_init(query, sizeof *query));
    query->threads = tree->threads;
    if (!given) return HTREE_OK;
    HT_TRY(ht_sized_read(query, sizeof *query, sizeof *query, given, given->size, "query"));
    if (query->flags || query->reserved)
        return ht_fail(HTREE_ERROR_ARGUMENT, "query.flags and query.reserved must be 0");
    return HTREE_OK;
}

/* All rays in whole rows. Returns how many they are. */
static uint64_t run_strips(batch *b, uint32_t threads) {
    const uint64_t down = (b->rows.count + b->rows.height - 1) / b->rows.height;
    for (b->block = STRIP; strips_across(b) * down >= UINT32_MAX / 4;) b->block *= 2;
    ht_parallel_for(&b->tree->tasks, threads, (uint32_t)(strips_across(b) * down), trace_strip, b);
    return b->rows.row * b->rows.count;
}

static uint64_t block_size(const batch *b, uint32_t threads) {
    if (b->count <= SHORTEST_BLOCK) return SHORTEST_BLOCK;
    const uint32_t wanted = TASKS_A_THREAD * ht_thread_count(&b->tree->tasks, threads);
    uint64_t block = BLOCK;
    while (block > SHORTEST_BLOCK && b->count / block < wanted) block /= 2;
    while (b->count / block >= UINT32_MAX / 4) block *= 2;
    return block;
}

static void run_blocks(batch *b, uint32_t threads) {
    const uint64_t block = block_size(b, threads);
    b->block = (uint32_t)block;
    const uint32_t blocks = (uint32_t)((b->count + block - 1) / block);
    ht_parallel_for(&b->tree->tasks, threads, blocks, trace_block, b);
}

static htree_status run_batch(batch *b, const htree_query *query) {
    ht_progress_begin(&b->progress, &query->progress, b->count);
    if (b->tile_walk)
        b->rows = ht_find_rows(b->rays, b->count, &b->tree->bounds, b->tree->prim_count);
    if (b->rows.row) {
        const uint64_t done = run_strips(b, query->threads);
        b->rays += done;
        b->count -= done;
        if (b->hits) b->hits += done;
        if (b->occluded) b->occluded += done;
    }
    run_blocks(b, query->threads);
    if (b->progress.cancelled)
        return ht_fail(HTREE_ERROR_CANCELLED, "the progress hook cancelled the query");
    return HTREE_OK;
}

static htree_status trace_batch(const htree *tree, const htree_ray *rays, uint64_t count,
                                htree_hit *hits, uint8_t *occluded, const htree_query *given) {
    htree_query query;
    HT_TRY(ht_tree_verify(tree));
    HT_TRY(read_query(tree, given, &query));
    if (count == 0) return HTREE_OK;
    if (!rays) return ht_fail(HTREE_ERROR_ARGUMENT, "rays is NULL");
    if (!hits && !occluded)
        return ht_fail(HTREE_ERROR_ARGUMENT, "the array for the answers is NULL");
    if (count > UINT64_MAX / sizeof *rays)
        return ht_fail(HTREE_ERROR_ARGUMENT, "count exceeds the address space");
    const ht_walks *walks = find_walks(tree->kind);
    batch b;
    memset(&b, 0, sizeof b);
    b.tree = tree;
    b.rays = rays;
    b.count = count;
    b.hits = hits;
    b.occluded = occluded;
    b.counters = query.counters;
    if (hits) {
        b.walk = query.counters ? walks->closest_counted : walks->closest;
    } else {
        b.walk = query.counters ? walks->any_counted : walks->any;
    }
    const ht_block_walks *block = find_block_walks(tree);
    if (block && !query.counters && tree->prim_count)
        b.block_walk = hits ? block->closest : block->any;
    const ht_tile_walks *tile = find_tile_walks(tree);
    if (tile && b.block_walk) b.tile_walk = hits ? tile->closest : tile->any;
    return run_batch(&b, &query);
}

htree_status htree_query_init(htree_query *query, uint64_t size) {
    if (!query) return ht_fail(HTREE_ERROR_ARGUMENT, "query is NULL");
    if (size < sizeof *query || size > 65536) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "size is %llu: pass sizeof(htree_query)",
                       (unsigned long long)size);
    }
    memset(query, 0, (size_t)size);
    query->size = (uint32_t)size;
    return HTREE_OK;
}

htree_status htree_intersect(const htree *tree, const htree_ray *rays, uint64_t count,
                             htree_hit *hits, const htree_query *query) {
    HT_RETURN_IN_DEFAULT_ENV(trace_batch(tree, rays, count, hits, NULL, query));
}

htree_status htree_occluded(const htree *tree, const htree_ray *rays, uint64_t count,
                            uint8_t *occluded, const htree_query *query) {
    HT_RETURN_IN_DEFAULT_ENV(trace_batch(tree, rays, count, NULL, occluded, query));
}
