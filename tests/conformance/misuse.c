/* misuse.c: every case is a good call and one change, and says with what status it must fail. */
#include "misuse.h"

#include <math.h>

/* ---- Statuses ------------------------------------------------------------------------------- */

static const struct {
    const char *name;
    htree_status status;
} statuses[] = {
    {"OK", HTREE_OK},
    {"ARGUMENT", HTREE_ERROR_ARGUMENT},
    {"MEMORY", HTREE_ERROR_MEMORY},
    {"LIMIT", HTREE_ERROR_LIMIT},
    {"GEOMETRY", HTREE_ERROR_GEOMETRY},
    {"CANCELLED", HTREE_ERROR_CANCELLED},
    {"UNSUPPORTED", HTREE_ERROR_UNSUPPORTED},
    {"CORRUPT", HTREE_ERROR_CORRUPT},
    {"NO_DEVICE", HTREE_ERROR_NO_DEVICE},
    {"DEVICE", HTREE_ERROR_DEVICE},
    {"DEVICE_LOST", HTREE_ERROR_DEVICE_LOST},
    {"KERNEL", HTREE_ERROR_KERNEL},
};

static const char *status_word(htree_status status) {
    for (uint32_t i = 0; i < COUNT_OF(statuses); ++i)
        if (statuses[i].status == status) return statuses[i].name;
    return "?";
}

void check_statuses(void) {
    const char *const unknown = htree_status_name(-1);
    for (htree_status s = 0; s < 256; ++s)
        DEMAND((strcmp(status_word(s), "?") == 0) == (strcmp(htree_status_name(s), unknown) == 0),
               "status %d: the table of misuse.c and the library differ", (int)s);
}

/* ---- Misuse --------------------------------------------------------------------------------- */

/* What a case spoils: a good mesh, good options, a good query over a good tree. */
typedef struct stage {
    float xyz[9];
    uint32_t abc[3];
    htree_mesh mesh;
    htree_options options;
    htree *tree;
    htree_query query;
    uint64_t rays;
    htree_ray ray;
    htree_hit hit;
    htree_stats stats;
    htree_view view;
} stage;

static stage stage_of(const htree_mesh *mesh) {
    static const float xyz[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    stage g;
    memset(&g, 0, sizeof g);
    memcpy(g.xyz, xyz, sizeof xyz);
    for (uint32_t k = 0; k < 3; ++k) g.abc[k] = k;
    g.options = options_of(HTREE_BALANCED);
    g.tree = tree_of(mesh, &g.options);
    DEMAND(htree_query_init(&g.query, sizeof g.query) == HTREE_OK, "query");
    g.query.threads = 1;
    return g;
}

static htree_status build(const stage *g) {
    htree *tree = g->tree; /* not NULL: the call must write it */
    const htree_status status = htree_build(&tree, &g->mesh, &g->options);
    DEMAND(status == HTREE_OK || tree == NULL, "a failed build left its out-pointer");
    htree_free(tree);
    return status;
}

static htree_status view_lazy(stage *g) {
    htree *tree = NULL;
    g->options.flags = HTREE_LAZY;
    g->view.size = sizeof g->view;
    DEMAND(htree_build(&tree, &g->mesh, &g->options) == HTREE_OK, "%s", htree_error_text());
    const htree_status status = htree_get_view(tree, &g->view);
    htree_free(tree);
    return status;
}

/* Nothing is written where a query is refused; a cancelled one may have written anything. */
static htree_status query(const stage *g) {
    static htree_ray rays[100000];
    static htree_hit hits[COUNT_OF(rays)], before;
    static uint8_t occluded[COUNT_OF(rays)];
    memset(hits, 0x5a, sizeof hits);
    memset(&before, 0x5a, sizeof before);
    const htree_status status = htree_intersect(g->tree, rays, g->rays, hits, &g->query);
    DEMAND(htree_occluded(g->tree, rays, g->rays, occluded, &g->query) == status,
           "htree_occluded and htree_intersect refuse differently");
    DEMAND(status == HTREE_ERROR_CANCELLED || memcmp(hits, &before, sizeof before) == 0,
           "a refused query wrote a hit");
    return status;
}

static int32_t stop(void *user, double fraction) {
    (void)user;
    return fraction >= 0;
}

/* A case is a good call and one change. */
#define SPOIL(name, change, call)                                                                  \
    static htree_status name(stage *g) {                                                           \
        change;                                                                                    \
        return call;                                                                               \
    }

SPOIL(index_out_of_range, g->abc[2] = 3, build(g))
SPOIL(strict_nan, (g->xyz[4] = NAN, g->options.flags = HTREE_STRICT), build(g))
SPOIL(kind_unknown, g->options.kind = 99, build(g))
SPOIL(buckets_1, g->options.buckets = 1, build(g))
SPOIL(axes_2, g->options.axes = 2, build(g))
SPOIL(flags_unknown, g->options.flags = 0x80000000u, build(g))
SPOIL(cost_nan, g->options.cost_skd = NAN, build(g))
SPOIL(cost_zero, g->options.cost_intersect = 0, build(g))
SPOIL(cells_huge, g->options.cells_per_prim = 1e9f, build(g))
SPOIL(few_prims_0, g->options.few_prims = 0, build(g))
SPOIL(stride_8, g->mesh.position_stride = 8, build(g))
SPOIL(too_few_vertices, (g->mesh.indices = NULL, g->mesh.triangle_count = 2), build(g))
SPOIL(positions_null, g->mesh.positions = NULL, build(g))
SPOIL(build_cancelled, g->options.progress.report = stop, build(g))
SPOIL(query_cancelled, (g->query.progress.report = stop, g->rays = 100000), query(g))
SPOIL(query_flags, g->query.flags = 1, query(g))
SPOIL(options_size_0, (void)g, htree_options_init(&g->options, 0, HTREE_H))
SPOIL(query_size_0, (void)g, htree_query_init(&g->query, 0))
SPOIL(stats_size_0, g->stats.size = 0, htree_get_stats(g->tree, &g->stats))
SPOIL(view_size_0, g->view.size = 0, htree_get_view(g->tree, &g->view))
SPOIL(update_how_3, (void)g, htree_update(g->tree, &g->mesh, 3, NULL))
SPOIL(update_index, g->abc[2] = 3, htree_update(g->tree, &g->mesh, HTREE_REBUILD, NULL))
SPOIL(update_mesh_null, (void)g, htree_update(g->tree, NULL, HTREE_REFIT, NULL))
SPOIL(complete_null, (void)g, htree_complete(NULL))
SPOIL(rays_null, (void)g, htree_intersect(g->tree, NULL, 1, &g->hit, NULL))
SPOIL(hits_null, (void)g, htree_intersect(g->tree, &g->ray, 1, NULL, NULL))
SPOIL(tree_null, (htree_free(g->tree), g->tree = NULL), query(g))
SPOIL(out_null, (void)g, htree_build(NULL, &g->mesh, NULL))
SPOIL(mesh_null, htree *tree = g->tree, htree_build(&tree, NULL, NULL))

static const struct {
    const char *name;
    htree_status status;
    htree_status (*call)(stage *g);
} misuses[] = {
    {"build-index-out-of-range", HTREE_ERROR_GEOMETRY, index_out_of_range},
    {"build-strict-nan", HTREE_ERROR_GEOMETRY, strict_nan},
    {"build-kind-unknown", HTREE_ERROR_ARGUMENT, kind_unknown},
    {"build-buckets-1", HTREE_ERROR_ARGUMENT, buckets_1},
    {"build-axes-2", HTREE_ERROR_ARGUMENT, axes_2},
    {"build-flags-unknown", HTREE_ERROR_ARGUMENT, flags_unknown},
    {"build-cost-nan", HTREE_ERROR_ARGUMENT, cost_nan},
    {"build-cost-zero", HTREE_ERROR_ARGUMENT, cost_zero},
    {"build-cells-huge", HTREE_ERROR_ARGUMENT, cells_huge},
    {"build-few-prims-0", HTREE_ERROR_ARGUMENT, few_prims_0},
    {"build-stride-8", HTREE_ERROR_ARGUMENT, stride_8},
    {"build-too-few-vertices", HTREE_ERROR_GEOMETRY, too_few_vertices},
    {"build-positions-null", HTREE_ERROR_ARGUMENT, positions_null},
    {"build-cancelled", HTREE_ERROR_CANCELLED, build_cancelled},
    {"query-cancelled", HTREE_ERROR_CANCELLED, query_cancelled},
    {"query-flags-unknown", HTREE_ERROR_ARGUMENT, query_flags},
    {"options-size-0", HTREE_ERROR_ARGUMENT, options_size_0},
    {"query-size-0", HTREE_ERROR_ARGUMENT, query_size_0},
    {"stats-size-0", HTREE_ERROR_ARGUMENT, stats_size_0},
    {"view-size-0", HTREE_ERROR_ARGUMENT, view_size_0},
    {"view-lazy", HTREE_ERROR_UNSUPPORTED, view_lazy},
    {"update-how-3", HTREE_ERROR_ARGUMENT, update_how_3},
    {"update-index-out-of-range", HTREE_ERROR_GEOMETRY, update_index},
    {"update-mesh-null", HTREE_ERROR_ARGUMENT, update_mesh_null},
    {"complete-null", HTREE_ERROR_ARGUMENT, complete_null},
    {"rays-null", HTREE_ERROR_ARGUMENT, rays_null},
    {"hits-null", HTREE_ERROR_ARGUMENT, hits_null},
    {"tree-null", HTREE_ERROR_ARGUMENT, tree_null},
    {"out-null", HTREE_ERROR_ARGUMENT, out_null},
    {"mesh-null", HTREE_ERROR_ARGUMENT, mesh_null},
};

/* The good mesh is one triangle. */
void check_misuses(const htree_mesh *soup, const htree_mesh *many) {
    for (uint32_t i = 0; i < COUNT_OF(misuses); ++i) {
        stage g = stage_of(soup);
        g.mesh.positions = g.xyz;
        g.mesh.vertex_count = 3;
        g.mesh.indices = g.abc;
        g.mesh.triangle_count = 1;
        g.rays = 1;
        DEMAND(build(&g) == HTREE_OK, "the good build fails: %s", htree_error_text());
        if (misuses[i].call == build_cancelled) g.mesh = *soup;
        if (misuses[i].call == view_lazy) g.mesh = *many;
        const htree_status status = misuses[i].call(&g);
        DEMAND(status == misuses[i].status, "%s: status %d, not %s", misuses[i].name, (int)status,
               status_word(misuses[i].status));
        DEMAND(strlen(htree_error_text()) > 5, "%s: no words for it", misuses[i].name);
        htree_free(g.tree);
    }
}

/* ---- JSON ----------------------------------------------------------------------------------- */

void put_statuses(FILE *to) {
    fprintf(to, "\"statuses\":{");
    for (uint32_t i = 0; i < COUNT_OF(statuses); ++i)
        fprintf(to, "%s\"%s\":%d", i == 0 ? "" : ",", statuses[i].name, (int)statuses[i].status);
    fprintf(to, "},\n\"status_names\":{");
    for (uint32_t i = 0; i < COUNT_OF(statuses); ++i)
        fprintf(to, "%s\"%d\":\"%s\"", i == 0 ? "" : ",", (int)statuses[i].status,
                htree_status_name(statuses[i].status));
    fprintf(to, "}");
}

void put_misuses(FILE *to) {
    fprintf(to, "\"misuse\":[\n");
    for (uint32_t i = 0; i < COUNT_OF(misuses); ++i)
        fprintf(to, "%s{\"case\":\"%s\",\"status\":\"%s\"}", i == 0 ? "" : ",\n", misuses[i].name,
                status_word(misuses[i].status));
    fprintf(to, "]");
}
