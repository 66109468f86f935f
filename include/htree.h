/* htree.h: ray queries over hierarchies that are cheap enough to build anew for every frame.
 *
 *     htree_mesh mesh = {.positions = xyz, .vertex_count = n, .indices = abc, .triangle_count = m};
 *     htree *tree = NULL;
 *     if (htree_build(&tree, &mesh, NULL) != HTREE_OK) puts(htree_error_text());
 *     htree_intersect(tree, rays, ray_count, hits, NULL);
 *     htree_free(tree);
 *
 * Data takes one way: mesh -> htree_build -> htree -> htree_intersect -> hits. A finished tree
 * never changes, so any number of threads may query one. Structures after V. Havran, R. Herzog,
 * H.-P. Seidel, "On the Fast Construction of Spatial Hierarchies for Ray Tracing", 2006 (below:
 * "the paper").
 *
 * One answer. The closest hit is the minimum of (t, prim) over one triangle test that every kind,
 * thread count and device shares: the same bits everywhere. No ray through a shared edge or vertex
 * of a closed mesh is lost. Calls compute in the default floating-point environment, and call hooks
 * in it, whatever the thread has set; then it has its own again.
 *
 * Errors. Every call that can fail returns an htree_status; on failure it writes nothing but NULL
 * through its out-pointer, and htree_error_text() says in words what was wrong. Nothing here exits,
 * prints, or keeps global state beyond that text, which is per thread.
 *
 * SPDX-License-Identifier: MIT */
#ifndef HTREE_HEADER
#define HTREE_HEADER

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32) && defined(HTREE_BUILDING)
#define HTREE_API __declspec(dllexport)
#elif defined(__GNUC__)
#define HTREE_API __attribute__((visibility("default")))
#else
#define HTREE_API
#endif

/* ---- Version -------------------------------------------------------------------------------- */

#define HTREE_VERSION_MAJOR 0
#define HTREE_VERSION_MINOR 1
#define HTREE_VERSION_PATCH 0

/* Version of the library that is linked: major * 10000 + minor * 100 + patch. */
HTREE_API uint32_t htree_version(void);

/* ---- Status --------------------------------------------------------------------------------- */

typedef int32_t htree_status;

enum {
    HTREE_OK = 0,
    HTREE_ERROR_ARGUMENT = 1,  /* a NULL, a size, a flag or a number that the call does not take */
    HTREE_ERROR_MEMORY = 2,    /* the allocator returned NULL */
    HTREE_ERROR_LIMIT = 3,     /* more objects than the structure can address */
    HTREE_ERROR_GEOMETRY = 4,  /* an index beyond the vertices; with HTREE_STRICT bad numbers too */
    HTREE_ERROR_CANCELLED = 5, /* the progress hook asked to stop */
    HTREE_ERROR_UNSUPPORTED = 6,  /* this build of the library lacks the kind that was asked for */
    HTREE_ERROR_CORRUPT = 7,      /* htree_check found a broken tree, htree_load broken bytes */
    HTREE_ERROR_NO_DEVICE = 8,    /* htree_cl.h: no OpenCL here, or no device of that name */
    HTREE_ERROR_DEVICE = 9,       /* htree_cl.h: a call to the device failed */
    HTREE_ERROR_DEVICE_LOST = 10, /* htree_cl.h: the device is gone, with all that was on it */
    HTREE_ERROR_KERNEL = 11 /* htree_cl.h: the device's compiler refused a kernel, or it is wrong */
};

/* Name of a status, for logs. Never NULL, static. Any thread. */
HTREE_API const char *htree_status_name(htree_status status);

/* What was wrong, in a sentence: the text of the last call that failed on the calling thread, "" if
 * none did. Never NULL; stays valid until the next call that fails on this thread. */
HTREE_API const char *htree_error_text(void);

/* ---- Rays and hits: the same bytes in C, in OpenCL C and in every binding ------------------- */

/* A point of the ray is org + t * dir; dir need not be normalised, and t is in lengths of dir.
 * Hits count for tmin <= t <= tmax; tmin may be negative, tmax may be infinite.
 * A ray misses in constant time when a field is NaN, when tmin > tmax, when a component of org
 * exceeds HTREE_COORDINATE_MAX, or when the largest component of dir is outside
 * [1 / HTREE_COORDINATE_MAX, HTREE_COORDINATE_MAX]. */
typedef struct htree_ray {
    float org[3];
    float tmin;
    float dir[3];
    float tmax;
} htree_ray;

/* The closest hit. On a triangle (v0, v1, v2) the point is (1 - u - v) v0 + u v1 + v v2. A miss has
 * prim == HTREE_NONE, t == tmax of the ray, u == v == 0. Of hits with equal t the lowest prim wins.
 */
typedef struct htree_hit {
    float t, u, v;
    uint32_t prim; /* triangle i of the mesh is i; object j is triangle_count + j */
} htree_hit;

#define HTREE_NONE           UINT32_MAX
#define HTREE_COORDINATE_MAX 1152921504606846976.0f /* 2^60 */

typedef struct htree_box {
    float lo[3], hi[3];
} htree_box;

/* ---- Geometry ------------------------------------------------------------------------------- */

/* Intersects object `object` (0-based) with the ray: returns nonzero and fills t, u, v of *hit if
 * the object is hit with tmin <= t <= tmax, at its smallest such t; the library sets prim. Must be
 * a pure function of its arguments, and org + t * dir must lie in the object's box, up to rounding;
 * hits outside [tmin, tmax] or with a NaN are ignored. Called from any thread that works for a
 * query. */
typedef int32_t (*htree_object_intersect)(void *user, uint32_t object, const htree_ray *ray,
                                          htree_hit *hit);

/* Objects of the caller's own ("user geometry"): cones, spheres, ... known by box and callback. */
typedef struct htree_objects {
    const htree_box *boxes; /* `count` boxes that contain the objects; copied by htree_build */
    uint64_t count;
    htree_object_intersect intersect;
    void *user; /* handed to `intersect`; must live as long as the tree */
} htree_objects;

/* Triangles, and objects if any. Start from zero: `htree_mesh mesh = {0};`. Every array is borrowed
 * until htree_build returns, and nothing past its end is read. */
typedef struct htree_mesh {
    const float *positions;   /* x y z of vertex i, i * position_stride bytes from here */
    uint64_t position_stride; /* bytes, a multiple of 4, at least 12; 0 means 12 */
    uint64_t vertex_count;
    const uint32_t *indices; /* three per triangle; NULL: triangle i is vertices 3i, 3i+1, 3i+2 */
    uint64_t triangle_count;
    const htree_objects *objects; /* NULL: none */
    uint64_t reserved[2];         /* 0 */
} htree_mesh;

/* ---- Hooks: all optional, a zeroed hook means the library's own way ------------------------- */

/* Memory. allocate returns `bytes` bytes at a multiple of `alignment` (a power of two) or NULL;
 * release gets the same `bytes` back. Called from any thread that works for the call. */
typedef struct htree_allocator {
    void *(*allocate)(void *user, uint64_t bytes, uint64_t alignment);
    void (*release)(void *user, void *memory, uint64_t bytes);
    void *user;
} htree_allocator;

/* Parallel for. run calls task(data, i) once for every 0 <= i < count, in any order, on any
 * threads, and returns when all are done. Without it the library starts threads for the length of a
 * call. */
typedef struct htree_tasks {
    void (*run)(void *user, uint32_t count, void (*task)(void *data, uint32_t index), void *data);
    void *user;
} htree_tasks;

/* Progress. report gets 0 <= fraction <= 1, 0 at first, not decreasing within a call, and returns
 * nonzero to cancel the call. It is called on the thread that made the call, and on no other. */
typedef struct htree_progress {
    int32_t (*report)(void *user, double fraction);
    void *user;
} htree_progress;

/* ---- Options -------------------------------------------------------------------------------- */

typedef int32_t htree_kind;

enum {
    HTREE_UG = 1,         /* uniform grid */
    HTREE_KD = 2,         /* kd-tree by the surface area heuristic (SAH) */
    HTREE_BVH_MEDIAN = 3, /* bounding volume hierarchy, spatial median */
    HTREE_BVH_SAH = 4,    /* bounding volume hierarchy, SAH over buckets of centroids */
    HTREE_SKD = 5,        /* spatial kd-tree: two planes a node */
    HTREE_H = 6,          /* H-tree: spatial kd-tree with sparse bounding volumes */
    HTREE_AH = 7,         /* H-tree by a 3D grid and a summed-area table: O(N log log N) */
    HTREE_WIDE = 8,       /* eight children a node, eight triangles a leaf: for vector units */

    /* For those who do not want to choose; htree_options_init puts one of the kinds in their
     * place. */
    HTREE_FAST = 101,     /* build every frame, trace a few rays a triangle */
    HTREE_BALANCED = 102, /* the default */
    HTREE_BEST = 103      /* build once, trace for long */
};

/* "h", "bvh-sah", "fast", ... or NULL for a number that is no kind, static; and back, 0 for
 * NULL or a name that is none. Any thread. */
HTREE_API const char *htree_kind_name(htree_kind kind);
HTREE_API htree_kind htree_kind_from_name(const char *name);

/* Flags of htree_options. */
enum {
    HTREE_STRICT = 1, /* refuse NaN, infinite and oversize coordinates instead of skipping them */
    HTREE_ANY_PLANES = 2, /* H, AH: bounding nodes of any of 63 plane sets, not BV2 and BV6 only */
    HTREE_LOOSE_PLANES = 4, /* AH: planes as the grid gives them, half a cell wide (section 7.1) */
    HTREE_MORTON = 8, /* WIDE: Morton order below the grid: faster to build, slower to trace */
    HTREE_LAZY = 16,  /* WIDE: only the top is built, the rest by the first ray that gets there; the
                         mesh's arrays must stay as they are until htree_complete or htree_free.
                         A mesh too small for a top is built at once */
    HTREE_COMPACT =
        32, /* WIDE: less than half of the memory, slower to build and to trace; not with
                           HTREE_LAZY */
    HTREE_COLLAPSE = 64 /* BVH, SKD, H, AH: collapses the finished tree into one of kind WIDE */
};

/* How to build. htree_options_init writes every default; change what you need after it. */
typedef struct htree_options {
    uint32_t size; /* sizeof(htree_options), written by htree_options_init */
    htree_kind kind;
    uint32_t flags;   /* HTREE_STRICT, ... */
    uint32_t threads; /* of the build and of queries: 0 all cores, 1 the caller's, n at most n */

    uint32_t buckets; /* M of the paper's section 5, 2 to 64: cost is evaluated at M - 1 planes */
    uint32_t axes;    /* 1: split along the widest extent of centroids only; 3: try all axes */

    /* Costs of section 6.3 in any common unit. Fixed defaults: a tree must not depend on timing. */
    float cost_skd;       /* C_SKD^T, traversing a node with two separating planes (eq. 2) */
    float cost_bv2;       /* C_2PN^T, clipping by two planes (eq. 3) */
    float cost_bv6;       /* C_6PN^T, clipping by six planes (eq. 4) */
    float cost_intersect; /* C_IT, one ray-object test */

    /* The AH-tree's grid, section 7.1. */
    float cells_per_prim; /* cells for each object, 1/64 to 64: c^3 of M = c N^(1/3) */
    uint32_t few_prims;   /* ranges of no more objects are built as an H-tree, 1 to 2^20 */

    htree_allocator allocator;
    htree_tasks tasks;
    htree_progress progress; /* of htree_build only */
} htree_options;

/* Writes the defaults of `kind` into *options; size is sizeof(htree_options).
 * Errors     ARGUMENT: NULL, another size, no kind; then *options is as it was. */
HTREE_API htree_status htree_options_init(htree_options *options, uint64_t size, htree_kind kind);

/* Measures the four costs on this machine, as in section 6.3 of the paper, and writes them to
 * *options, in units of cost_skd. Takes some milliseconds. What it finds depends on timing, and
 * so will the tree.
 *
 * Errors     ARGUMENT, MEMORY. */
HTREE_API htree_status htree_calibrate(htree_options *options);

/* ---- Build ---------------------------------------------------------------------------------- */

typedef struct htree htree;

/* Builds a tree over the mesh; the caller frees *out with htree_free. The tree keeps no pointer into
 * the mesh but `objects->user` and the hooks' `user`.
 * Geometry   triangles and boxes with a NaN, infinite or larger coordinate than
 *            HTREE_COORDINATE_MAX, and boxes with lo > hi, are skipped (HTREE_STRICT: refused);
 *            triangles without area are never hit. Both are counted in htree_stats. No triangles
 *            at all is fine: every ray misses.
 * Lazy       with HTREE_LAZY a query may build parts of the tree, on its own threads and in memory that
 *            the build has set aside, so it cannot fail for it.
 * Threads    independent builds may run at once.
 * Errors     ARGUMENT, MEMORY, LIMIT, GEOMETRY, CANCELLED, UNSUPPORTED; then *out is NULL.
 * NULL       options: the defaults of HTREE_BALANCED. Nothing else may be NULL. */
HTREE_API htree_status htree_build(htree **out, const htree_mesh *mesh,
                                   const htree_options *options);

/* Builds what rays have not reached yet of a tree with HTREE_LAZY, which from then on is as any other,
 * and has the bytes that HTREE_MORTON gives; does nothing to any other tree. On all cores. No query may
 * be running on it. Hits are the same before and after.
 * Errors     ARGUMENT. */
HTREE_API htree_status htree_complete(htree *tree);

/* How htree_update brings a tree to the mesh as it is now. */
enum {
    HTREE_REBUILD = 1, /* as htree_build would, in the memory of the builds before */
    HTREE_REFIT = 2    /* WIDE: the same nodes around the new positions */
};

/* Brings a tree to new positions, or with HTREE_REBUILD to any mesh at all, with the options and the
 * objects' boxes and callback given now; the tree stays where it is. From the first call on the tree
 * keeps the memory of its builds until htree_free.
 * Refit      for a mesh of as many triangles and objects. The tree is rebuilt where refitting cannot
 *            do: other kinds, a lazy, a compact or a borrowed tree, or other prims than before that can
 *            be hit.
 * quality    gets the expected cost of a ray now over that when the tree was built: 1 after a
 *            rebuild; from about 1.5 on rebuilding pays. NULL is allowed.
 * Threads    no query may be running on the tree.
 * Errors     ARGUMENT, MEMORY, LIMIT, GEOMETRY; then the tree is as it was. */
HTREE_API htree_status htree_update(htree *tree, const htree_mesh *mesh, int32_t how,
                                    double *quality);

/* Frees the tree. NULL is allowed. No query may be running on it. */
HTREE_API void htree_free(htree *tree);

/* ---- Query ---------------------------------------------------------------------------------- */

/* What one ray cost, in the paper's terms. */
typedef struct htree_counters {
    uint32_t traversal_steps; /* N_TS: nodes (cells) visited, leaves included */
    uint32_t leaf_steps;      /* N_ETS: leaves (cells) visited */
    uint32_t intersections;   /* N_IT: objects tested */
    uint32_t reserved;
} htree_counters;

/* How to query. htree_query_init writes every default. */
typedef struct htree_query {
    uint32_t size; /* sizeof(htree_query), written by htree_query_init */
    uint32_t flags;
    uint32_t threads; /* as in htree_options */
    uint32_t reserved;
    htree_counters *counters; /* one per ray, or NULL; counting costs a little time */
    htree_progress progress;
} htree_query;

/* Writes the defaults into *query; size is sizeof(htree_query).
 * Errors     ARGUMENT; then *query is as it was. */
HTREE_API htree_status htree_query_init(htree_query *query, uint64_t size);

/* Writes the closest hit of every ray: hits[i] of rays[i].
 * Threads    the library (or the tasks hook) spreads a batch over cores; a small batch and a single
 *            ray stay on the caller's thread. Any number of threads may call this on one tree. The
 *            hits do not depend on any of it.
 * Errors     ARGUMENT; CANCELLED, and then the hits are unspecified.
 * NULL       query: defaults, with the threads of the tree's options. rays and hits only if count
 *            is 0. Rays and hits may not overlap. */
HTREE_API htree_status htree_intersect(const htree *tree, const htree_ray *rays, uint64_t count,
                                       htree_hit *hits, const htree_query *query);

/* Writes 1 for every ray that hits anything, else 0. Otherwise as htree_intersect, and faster. */
HTREE_API htree_status htree_occluded(const htree *tree, const htree_ray *rays, uint64_t count,
                                      uint8_t *occluded, const htree_query *query);

/* ---- Files ---------------------------------------------------------------------------------- */

/* Writes the tree as bytes into `file`, which has room for `size`, and how many they are into
 * *bytes; with NULL for `file`, only how many. No other tree of the same mesh and options has other
 * bytes. Objects are saved as their boxes. Any thread.
 * Errors     ARGUMENT: a size that is too small; UNSUPPORTED for a lazy tree before htree_complete;
 *            then nothing is written.
 * NULL       file. */
HTREE_API htree_status htree_save(const htree *tree, void *file, uint64_t size, uint64_t *bytes);

/* Flags of htree_load_options. */
enum {
    HTREE_BORROW = 1 /* refer to the bytes of the file instead of copying them */
};

/* How to load. htree_load_options_init writes every default. */
typedef struct htree_load_options {
    uint32_t size;    /* sizeof(htree_load_options), written by htree_load_options_init */
    uint32_t flags;   /* HTREE_BORROW */
    uint32_t threads; /* of queries, as in htree_options */
    uint32_t reserved;
    htree_object_intersect intersect; /* of a tree that holds objects: as in htree_objects */
    void *user;
    htree_allocator allocator;
    htree_tasks tasks;
} htree_load_options;

/* Writes the defaults into *options; size is sizeof(htree_load_options).
 * Errors     ARGUMENT; then *options is as it was. */
HTREE_API htree_status htree_load_options_init(htree_load_options *options, uint64_t size);

/* Makes a tree of what htree_save wrote, `size` bytes and no more; the caller frees *out with
 * htree_free. The hits are those of the tree that was saved. Any bytes may be given: a tree is
 * returned only if htree_check passes it, and no more memory is taken than twice the file and 1 KiB.
 * htree_update rebuilds such a tree with the options that it was built with; threads, allocator and
 * tasks are those given here.
 * With HTREE_BORROW the file, which may be mapped, lies at a multiple of 64 bytes, and stays as it
 * is until htree_free or the first htree_update.
 * Errors     ARGUMENT; CORRUPT; MEMORY; UNSUPPORTED: written by another version of the format, or
 *            by a machine with another byte order. Then *out is NULL.
 * NULL       options: the defaults, for a tree without objects. */
HTREE_API htree_status htree_load(htree **out, const void *file, uint64_t size,
                                  const htree_load_options *options);

/* ---- Inspect -------------------------------------------------------------------------------- */

/* Bounds of everything that can be hit; lo = +inf, hi = -inf if there is nothing. Any thread.
 * Errors     ARGUMENT. */
HTREE_API htree_status htree_get_bounds(const htree *tree, htree_box *bounds);

typedef struct htree_stats {
    uint32_t size; /* sizeof(htree_stats), set by the caller before htree_get_stats */
    htree_kind kind;
    uint64_t triangles;  /* as given */
    uint64_t objects;    /* as given */
    uint64_t invalid;    /* skipped: NaN, infinite or oversize coordinates */
    uint64_t degenerate; /* skipped: triangles without area, when the tree was built */

    uint64_t nodes;      /* N_NS, all nodes */
    uint64_t leaves;     /* N_E */
    uint64_t references; /* N_ER, references from leaves to triangles and objects */
    uint64_t skd_nodes, bv2_nodes, bv6_nodes, link_nodes; /* by type, H-tree and its kin */
    uint64_t bvo_nodes;     /* bounding nodes with another set of planes */
    uint64_t ternary_nodes; /* SKD nodes with a shelf of oversize objects */

    uint32_t depth;       /* nodes on the longest way from the root to a leaf */
    uint32_t stack;       /* entries that a traversal stack can need at most */
    uint64_t bytes;       /* memory of the finished tree, geometry included */
    uint64_t peak_bytes;  /* most memory held at any time of the build */
    double build_seconds; /* T_C, wall clock */
    double sah_cost; /* expected cost of a random ray that meets the bounds, in the options' unit */
    uint64_t subtrees, subtrees_built; /* HTREE_LAZY: left to rays, and built by now; else 0 */
} htree_stats;

/* Fills *stats, whose `size` the caller has set. Walks the tree: O(nodes). Any thread.
 * Errors     ARGUMENT, CORRUPT. */
HTREE_API htree_status htree_get_stats(const htree *tree, htree_stats *stats);

/* The arrays of a finished tree, for backends and tools of your own: devices, viewers, files.
 * They belong to the tree and live until htree_free. Nodes, leaves and grid are laid out as
 * lib/tree/layout.h says, which is no part of the stable ABI: it holds for one minor version. */
typedef struct htree_view {
    uint32_t size; /* sizeof(htree_view), set by the caller before htree_get_view */
    htree_kind kind;
    htree_box bounds;
    uint32_t prims;          /* that can be hit; 0: there are no nodes, and every ray misses */
    uint32_t triangle_count; /* of the mesh; prims from here on are objects */
    uint32_t object_count;
    uint32_t stack;         /* entries that a traversal stack can need at most */
    const float *triangles; /* nine floats a triangle, v0 v1 v2; a skipped one is all 0. WIDE: NULL,
                               its leaves hold the corners */
    const void *nodes;      /* root first */
    uint64_t node_bytes;
    const void *leaves; /* UG, KD: uint32_t prims by leaf; WIDE: blocks of triangles; else NULL */
    uint64_t leaf_bytes;
    const void *grid; /* UG: its shape; else NULL */
    uint64_t grid_bytes;
} htree_view;

/* Fills *view, whose `size` the caller has set. Any thread.
 * Errors     ARGUMENT; UNSUPPORTED for a lazy tree before htree_complete, and for a compact one. */
HTREE_API htree_status htree_get_view(const htree *tree, htree_view *view);

/* Proves the structure: every node is reached once, every box and plane contains what lies below
 * it, every object is referenced, depth and stack are as stated. O(nodes). Errors: CORRUPT, MEMORY.
 */
HTREE_API htree_status htree_check(const htree *tree);

#ifdef __cplusplus
}
#endif

#endif
