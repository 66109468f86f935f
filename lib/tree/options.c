/* options.c: the kinds by name, the defaults, and the check of every option. */
#include "options.h"
#include "base/sized.h"

static const struct {
    htree_kind kind;
    const char *name;
} kinds[] = {
    {HTREE_UG, "ug"},
    {HTREE_KD, "kd"},
    {HTREE_BVH_MEDIAN, "bvh-median"},
    {HTREE_BVH_SAH, "bvh-sah"},
    {HTREE_SKD, "skd"},
    {HTREE_H, "h"},
    {HTREE_AH, "ah"},
    {HTREE_WIDE, "wide"},
    {HTREE_FAST, "fast"},
    {HTREE_BALANCED, "balanced"},
    {HTREE_BEST, "best"},
};
enum { KIND_COUNT = sizeof kinds / sizeof *kinds };

static const uint32_t KNOWN_FLAGS = HTREE_STRICT | HTREE_ANY_PLANES | HTREE_LOOSE_PLANES |
                                    HTREE_MORTON | HTREE_LAZY | HTREE_COMPACT | HTREE_COLLAPSE;

/* The struct as version 0.1 knew it. */
enum { FIRST_OPTIONS_SIZE = sizeof(htree_options) };

const char *htree_kind_name(htree_kind kind) {
    for (int i = 0; i < KIND_COUNT; ++i) {
        if (kinds[i].kind == kind) return kinds[i].name;
    }
    return NULL;
}

htree_kind htree_kind_from_name(const char *name) {
    for (int i = 0; name && i < KIND_COUNT; ++i) {
        if (strcmp(kinds[i].name, name) == 0) return kinds[i].kind;
    }
    return 0;
}

/* What the presets stand for: chosen by measurement over objects and interiors. Wide trees are
 * ahead of all others in tracing; a BVH by all axes, without a grid, collapsed, is the best of them
 * and seven times the work. */
static void resolve_preset(htree_options *options) {
    switch (options->kind) {
    case HTREE_FAST: options->flags |= HTREE_MORTON; break;
    case HTREE_BALANCED: break;
    case HTREE_BEST:
        options->axes = 3;
        options->flags |= HTREE_COLLAPSE;
        options->kind = HTREE_BVH_SAH;
        return;
    default: return;
    }
    options->kind = HTREE_WIDE;
}

static void write_defaults(htree_options *options, htree_kind kind) {
    memset(options, 0, sizeof *options);
    options->size = sizeof *options;
    options->kind = kind;
    options->buckets = 32;
    options->axes = 1;
    options->cost_skd = 1.0f;
    options->cost_bv2 = 1.0f;
    options->cost_bv6 = 1.2f;
    options->cost_intersect = 1.2f;
    options->cells_per_prim = 0.5f;
    options->few_prims = 64;
    resolve_preset(options);
}

htree_status htree_options_init(htree_options *options, uint64_t size, htree_kind kind) {
    if (!options) return ht_fail(HTREE_ERROR_ARGUMENT, "options is NULL");
    if (!htree_kind_name(kind))
        return ht_fail(HTREE_ERROR_ARGUMENT, "%ld is no htree_kind", (long)kind);
    if (size < FIRST_OPTIONS_SIZE || size > 65536) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "size is %llu: pass sizeof(htree_options)",
                       (unsigned long long)size);
    }
    htree_options defaults;
    write_defaults(&defaults, kind);
    defaults.size = (uint32_t)size;
    memset(options, 0, (size_t)size);
    memcpy(options, &defaults, sizeof defaults < size ? sizeof defaults : (size_t)size);
    return HTREE_OK;
}

static htree_status check_cost(const char *name, float cost) {
    if (cost > 0 && cost <= 1e6f) return HTREE_OK;
    return ht_fail(HTREE_ERROR_ARGUMENT, "options.%s is %g: must be above 0 and at most 1e6", name,
                   (double)cost);
}

static htree_status check_hooks(const htree_options *options) {
    if (!options->allocator.allocate != !options->allocator.release) {
        return ht_fail(HTREE_ERROR_ARGUMENT,
                       "options.allocator needs both allocate and release, or neither");
    }
    return HTREE_OK;
}

htree_status ht_options_read(const htree_options *given, htree_options *options) {
    write_defaults(options, HTREE_BALANCED);
    if (!given) return HTREE_OK;
    HT_TRY(
        ht_sized_read(options, sizeof *options, FIRST_OPTIONS_SIZE, given, given->size, "options"));
    if (!htree_kind_name(options->kind)) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "options.kind is %ld: no htree_kind",
                       (long)options->kind);
    }
    if (options->flags & ~KNOWN_FLAGS) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "options.flags is %#lx: unknown bits",
                       (unsigned long)options->flags);
    }
    if ((options->flags & HTREE_LAZY) && (options->flags & HTREE_COMPACT)) {
        return ht_fail(HTREE_ERROR_ARGUMENT,
                       "options.flags: a tree is HTREE_LAZY or HTREE_COMPACT, not both");
    }
    if (options->buckets < 2 || options->buckets > 64) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "options.buckets is %lu: must be 2 to 64",
                       (unsigned long)options->buckets);
    }
    if (options->axes != 1 && options->axes != 3) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "options.axes is %lu: must be 1 or 3",
                       (unsigned long)options->axes);
    }
    if (!(options->cells_per_prim >= 1.0f / 64 && options->cells_per_prim <= 64)) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "options.cells_per_prim is %g: must be 1/64 to 64",
                       (double)options->cells_per_prim);
    }
    if (options->few_prims < 1 || options->few_prims > 1 << 20) {
        return ht_fail(HTREE_ERROR_ARGUMENT, "options.few_prims is %lu: must be 1 to 2^20",
                       (unsigned long)options->few_prims);
    }
    resolve_preset(options);
    HT_TRY(check_cost("cost_skd", options->cost_skd));
    HT_TRY(check_cost("cost_bv2", options->cost_bv2));
    HT_TRY(check_cost("cost_bv6", options->cost_bv6));
    HT_TRY(check_cost("cost_intersect", options->cost_intersect));
    return check_hooks(options);
}
