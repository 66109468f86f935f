/* conformance.c: writes the conformance file that the tests of every binding read: scenes, rays and
 * the right answers, floats as their bits; the numbers of the statuses; and calls that must fail.
 *
 *     conformance [FILE]        writes to stdout without FILE
 *
 * Nothing is written unless every kind, alone and on threads, gives the oracle's answers bit for
 * bit, also lazily and after updates, and unless every misuse is refused here with the status that
 * the file promises. */
#include "misuse.h"
#include "oracle.h"
#include "rays.h"

#include <math.h>

enum {
    RAYS_MIXED = 27 * RAY_FAMILIES,
    RAYS_CHOSEN = 22,
    RAYS = RAYS_MIXED + RAYS_CHOSEN,
    COPIES = 12, /* of the rays in one batch, enough for several threads */
    NUMBERS_A_LINE = 24,
};

/* ---- Scenes --------------------------------------------------------------------------------- */

typedef struct scene {
    const char *name;
    shape s;
    htree_mesh mesh;
    uint64_t invalid, degenerate;
    htree_box bounds;
    htree_ray rays[RAYS];
    htree_hit hits[RAYS];
    uint8_t occluded[RAYS];
} scene;

/* Every triangle gets three vertices of its own, and the indices go. */
static void drop_indices(shape *s) {
    float *const xyz = (float *)take(s->triangle_count * 9 * sizeof *xyz);
    for (uint64_t i = 0; i < 3 * s->triangle_count; ++i)
        memcpy(xyz + 3 * i, s->positions + 3 * (uint64_t)s->indices[i], 3 * sizeof *xyz);
    free(s->positions);
    free(s->indices);
    s->positions = xyz;
    s->indices = NULL;
    s->vertex_count = 3 * s->triangle_count;
}

/* Every fourth triangle of a soup becomes one that no ray may hit. */
static void break_triangles(shape *s) {
    const float bad[] = {NAN, INFINITY, -INFINITY, 1.2e18f, -3.4e38f, -NAN};
    for (uint64_t i = 0; i < s->triangle_count; i += 4) {
        float *const corners = s->positions + 9 * i; /* a soup shares no vertices */
        const uint64_t turn = i / 4;
        switch (turn % 4) {
        case 0: corners[turn % 9] = bad[turn / 4 % COUNT_OF(bad)]; break;
        case 1: memcpy(corners + 3, corners, 3 * sizeof *corners); break;
        case 2: s->indices[3 * i + 2] = s->indices[3 * i]; break;
        default: /* three points on a line, exactly */
            for (int k = 0; k < 9; ++k) corners[k] = (float)(k / 3);
        }
    }
}

static const struct {
    const char *name, *from;
    uint64_t triangles;
    void (*change)(shape *s);
} scene_table[] = {
    {"soup", "soup", 150, NULL},          /* loose triangles */
    {"sphere", "sphere", 180, NULL},      /* closed, shared vertices */
    {"stack", "stack", 80, NULL},         /* equal t: the lowest prim wins */
    {"plain", "knot", 120, drop_indices}, /* no indices */
    {"broken", "soup", 120, break_triangles},
    {"far", "far", 100, NULL}, /* far from the origin: what a float resolves shows */
    {"one", "one", 1, NULL},
    {"empty", "none", 0, NULL},
    {"many", "knot", 2500, NULL}, /* enough for a lazy tree to leave some to the rays */
};
enum { SCENES = COUNT_OF(scene_table), SOUP = 0, MANY = SCENES - 1 };

/* ---- Rays ----------------------------------------------------------------------------------- */

static uint32_t family_of(const char *name) {
    uint32_t family = 0;
    while (family < RAY_FAMILIES && strcmp(ray_family_name(family), name) != 0) ++family;
    DEMAND(family < RAY_FAMILIES, "no family of rays is called %s", name);
    return family;
}

/* Intervals that begin or end near a hit at t = 1, on it, or the wrong way round. A call that rolls
 * the dice stands alone: compilers differ in which argument they evaluate first. */
static void make_intervals(const ray_target *target, dice *d, htree_ray *ray) {
    static const float ends[] = {-INFINITY, -2, -0.0f, 0, 0.5f, 1, 1, 1, 2, INFINITY};
    rays_make(target, family_of("vertices"), d, ray, 1);
    const float tmin = ends[dice_below(d, COUNT_OF(ends))];
    const float tmax = ends[dice_below(d, COUNT_OF(ends))];
    ray->tmin = nudged(tmin, (int)dice_below(d, 7) - 3);
    ray->tmax = dice_below(d, 4) == 0 ? ray->tmin : tmax;
}

/* All families in turn, as rays_make_mixed, but for the one above. */
static void make_rays(const ray_target *target, dice *d, htree_ray *rays, uint32_t count) {
    const uint32_t intervals = family_of("intervals");
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t family = i % RAY_FAMILIES;
        if (family == intervals) {
            make_intervals(target, d, &rays[i]);
        } else {
            rays_make(target, family, d, &rays[i], 1);
        }
    }
}

/* Each edge of the contract for certain, where the families meet it by chance. */
static void choose_rays(const scene *sc, const ray_target *target, htree_ray *rays) {
    const float above[3] = {target->box.hi[0] + target->size, target->box.hi[1] + target->size,
                            target->box.hi[2] + target->size};
    const bool some = sc->mesh.triangle_count > 1;
    const float *const corner = some ? mesh_corner(&sc->mesh, 1, 0) : target->box.lo;
    const float *const next = some ? mesh_corner(&sc->mesh, 1, 1) : target->box.hi;
    const htree_ray at_vertex = ray_through(above, corner);
    const float middle[3] = {0.5f * (corner[0] + next[0]), 0.5f * (corner[1] + next[1]),
                             0.5f * (corner[2] + next[2])};
    for (int i = 0; i < RAYS_CHOSEN; ++i) rays[i] = at_vertex;
    for (int k = 0; k < 8; ++k) { /* a NaN in every field */
        const float nan = k % 2 ? -NAN : NAN;
        memcpy((char *)&rays[k] + 4 * k, &nan, sizeof nan);
    }
    for (int k = 0; k < 3; ++k) {
        rays[8].dir[k] = 0;
        rays[9].dir[k] = -0.0f;
        rays[10].dir[k] = -rays[10].dir[k]; /* behind: hit at negative t only */
        rays[11].dir[k] = -rays[11].dir[k];
    }
    rays[10].tmin = -2;
    rays[11].tmin = -INFINITY;
    rays[12].tmin = 2;
    rays[12].tmax = 1;
    rays[13].tmin = INFINITY;
    rays[14].tmax = -INFINITY;
    rays[15].org[0] = INFINITY;
    rays[16].org[1] = 2 * HTREE_COORDINATE_MAX;
    rays[17].dir[2] = 2 * HTREE_COORDINATE_MAX;
    rays[18].tmax = 0.999f;
    rays[19] = ray_through(above, middle);
    rays[20].tmin = -0.0f;
    rays[20].tmax = 3.4e38f;
}

/* ---- Answers -------------------------------------------------------------------------------- */

static void answer(scene *sc) {
    oracle o = oracle_of(&sc->mesh);
    const uint64_t found = oracle_batch(&o, sc->rays, RAYS, sc->hits);
    for (int i = 0; i < RAYS; ++i) sc->occluded[i] = sc->hits[i].prim != HTREE_NONE;
    sc->invalid = o.invalid;
    sc->degenerate = o.degenerate;
    sc->bounds = oracle_bounds(&o);
    DEMAND(o.count == 0 ? found == 0 : found >= RAYS / 8 && found <= RAYS * 7 / 8,
           "scene %s: %d of %d rays hit: too few to tell right from wrong", sc->name, (int)found,
           RAYS);
    oracle_free(&o);
}

static void check_facts(const scene *sc, const htree *tree, const char *kind) {
    const htree_stats stats = stats_of(tree);
    htree_box bounds;
    DEMAND(htree_get_bounds(tree, &bounds) == HTREE_OK, "bounds: %s", htree_error_text());
    DEMAND(memcmp(&bounds, &sc->bounds, sizeof bounds) == 0, "%s, %s: bounds", sc->name, kind);
    DEMAND(stats.triangles == sc->mesh.triangle_count && stats.objects == 0 &&
               stats.invalid == sc->invalid && stats.degenerate == sc->degenerate,
           "%s, %s: statistics differ from the oracle's", sc->name, kind);
}

/* The scene's rays, several times over, in one batch. */
static void check_answers(const scene *sc, const htree *tree, const char *kind, uint32_t threads) {
    static htree_ray rays[COPIES * RAYS];
    static htree_hit hits[COPIES * RAYS];
    static uint8_t occluded[COPIES * RAYS];
    htree_query query;
    DEMAND(htree_query_init(&query, sizeof query) == HTREE_OK, "query");
    query.threads = threads;
    for (int c = 0; c < COPIES; ++c) memcpy(rays + c * RAYS, sc->rays, sizeof sc->rays);
    memset(hits, 0x5a, sizeof hits);
    memset(occluded, 0x5a, sizeof occluded);
    DEMAND(htree_intersect(tree, rays, COUNT_OF(rays), hits, &query) == HTREE_OK &&
               htree_occluded(tree, rays, COUNT_OF(rays), occluded, &query) == HTREE_OK,
           "%s, %s: %s", sc->name, kind, htree_error_text());
    for (int c = 0; c < COPIES; ++c) {
        const uint64_t differ = hits_differ(hits + c * RAYS, sc->hits, RAYS);
        DEMAND(differ == 0, "%s, %s, %u threads: %d hits differ from the oracle's", sc->name, kind,
               (unsigned)threads, (int)differ);
        DEMAND(memcmp(occluded + c * RAYS, sc->occluded, RAYS) == 0,
               "%s, %s, %u threads: occlusion differs from the oracle's", sc->name, kind,
               (unsigned)threads);
    }
}

static void check_kinds(const scene *sc) {
    static const uint32_t threads[] = {1, 0, 2, 7};
    uint32_t kinds = 0;
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind), ++kinds) {
        for (uint32_t i = 0; i < COUNT_OF(threads); ++i) {
            htree_options options = options_of(kind);
            options.threads = threads[i];
            htree *const tree = tree_of(&sc->mesh, &options);
            check_facts(sc, tree, htree_kind_name(kind));
            check_answers(sc, tree, htree_kind_name(kind), threads[i]);
            htree_free(tree);
        }
    }
    DEMAND(kinds > 0, "the library builds no kind");
}

static void check_lazy(const scene *sc) {
    htree_options options = options_of(HTREE_WIDE);
    options.flags = HTREE_LAZY;
    htree *const tree = tree_of(&sc->mesh, &options);
    DEMAND(stats_of(tree).subtrees > 0 || sc->mesh.triangle_count < 2000, "%s is not lazy",
           sc->name);
    check_answers(sc, tree, "lazy", 0);
    check_facts(sc, tree, "lazy");
    DEMAND(htree_complete(tree) == HTREE_OK, "%s: %s", sc->name, htree_error_text());
    check_facts(sc, tree, "complete");
    check_answers(sc, tree, "complete", 0);
    htree_free(tree);
}

static void update(htree *tree, const htree_mesh *mesh, int32_t how) {
    double quality = 0;
    DEMAND(htree_update(tree, mesh, how, &quality) == HTREE_OK, "update: %s", htree_error_text());
    DEMAND(quality > 0 && (how != HTREE_REBUILD || quality == 1), "quality is %g", quality);
}

/* To the scene from the one before, and by refitting to a stretched one and back. */
static void check_updates(const scene *sc, htree *tree, const char *kind) {
    const uint64_t floats = 3 * sc->mesh.vertex_count;
    float *const stretched = (float *)take(floats * sizeof *stretched);
    htree_mesh mesh = sc->mesh;
    for (uint64_t i = 0; i < floats; ++i)
        stretched[i] = sc->mesh.positions[i] * (i % 3 == 0 ? 3.0f : 1.0f);
    mesh.positions = stretched;
    update(tree, &sc->mesh, HTREE_REBUILD);
    check_facts(sc, tree, kind);
    update(tree, &mesh, HTREE_REFIT);
    update(tree, &sc->mesh, HTREE_REFIT);
    check_facts(sc, tree, kind);
    check_answers(sc, tree, kind, 0);
    free(stretched);
}

static void check_all_updates(const scene *scenes) {
    for (htree_kind kind = next_kind(0); kind != 0; kind = next_kind(kind)) {
        htree *const tree = tree_of_kind(&scenes[0].mesh, kind);
        for (uint32_t i = 0; i < SCENES; ++i)
            check_updates(&scenes[i], tree, htree_kind_name(kind));
        htree_free(tree);
    }
}

static void make_scene(scene *sc, uint32_t index) {
    dice d = {2006 + index};
    sc->name = scene_table[index].name;
    sc->s = shape_of(scene_table[index].from, scene_table[index].triangles, 1 + index);
    if (scene_table[index].change != NULL) scene_table[index].change(&sc->s);
    sc->mesh = mesh_of(&sc->s);
    const ray_target target = ray_target_of(&sc->mesh);
    make_rays(&target, &d, sc->rays, RAYS_MIXED);
    choose_rays(sc, &target, sc->rays + RAYS_MIXED);
    answer(sc);
    check_kinds(sc);
    check_lazy(sc);
}

/* ---- JSON ----------------------------------------------------------------------------------- */

/* "name":[...] of 32-bit words: floats as their bits. */
static void put_words(FILE *to, const char *name, const void *words, uint64_t count) {
    fprintf(to, "\"%s\":[", name);
    for (uint64_t i = 0; i < count; ++i) {
        uint32_t word;
        memcpy(&word, (const char *)words + 4 * i, sizeof word);
        const char *const gap = i == 0 ? "" : i % NUMBERS_A_LINE == 0 ? ",\n" : ",";
        fprintf(to, "%s%lu", gap, (unsigned long)word);
    }
    fprintf(to, "]");
}

static void put_scene(FILE *to, const scene *sc) {
    uint32_t occluded[RAYS];
    for (int i = 0; i < RAYS; ++i) occluded[i] = sc->occluded[i];
    fprintf(to, "{\"name\":\"%s\",\n", sc->name);
    put_words(to, "positions", sc->mesh.positions, 3 * sc->mesh.vertex_count);
    if (sc->mesh.indices == NULL) {
        fprintf(to, ",\n\"indices\":null");
    } else {
        fprintf(to, ",\n");
        put_words(to, "indices", sc->mesh.indices, 3 * sc->mesh.triangle_count);
    }
    fprintf(to, ",\n");
    put_words(to, "bounds", &sc->bounds, 6);
    fprintf(to,
            ",\n\"stats\":{\"triangles\":%lu,\"objects\":0,\"invalid\":%lu,\"degenerate\":%lu},\n",
            (unsigned long)sc->mesh.triangle_count, (unsigned long)sc->invalid,
            (unsigned long)sc->degenerate);
    put_words(to, "rays", sc->rays, 8 * RAYS);
    fprintf(to, ",\n");
    put_words(to, "hits", sc->hits, 4 * RAYS);
    fprintf(to, ",\n");
    put_words(to, "occluded", occluded, RAYS);
    fprintf(to, "}");
}

static void put_tables(FILE *to) {
    fprintf(to, "\"kinds\":[");
    for (htree_kind kind = next_kind(0), first = kind; kind != 0; kind = next_kind(kind))
        fprintf(to, "%s\"%s\"", kind == first ? "" : ",", htree_kind_name(kind));
    fprintf(to, "],\n");
    put_statuses(to);
    fprintf(to, ",\n");
    put_misuses(to);
}

int main(int count, char **arguments) {
    static scene scenes[SCENES];
    DEMAND(count <= 2, "usage: conformance [FILE]");
    check_statuses();
    for (uint32_t i = 0; i < SCENES; ++i) make_scene(&scenes[i], i);
    check_all_updates(scenes);
    check_misuses(&scenes[SOUP].mesh, &scenes[MANY].mesh);

    FILE *const to = count == 2 ? fopen(arguments[1], "wb") : stdout;
    DEMAND(to != NULL, "cannot write %s", arguments[1]);
    const uint32_t version = htree_version();
    fprintf(to, "{\"format\":1,\"library\":\"%u.%u.%u\",\n\"scenes\":[\n",
            (unsigned)(version / 10000), (unsigned)(version / 100 % 100),
            (unsigned)(version % 100));
    for (uint32_t i = 0; i < SCENES; ++i) {
        if (i != 0) fprintf(to, ",\n");
        put_scene(to, &scenes[i]);
        shape_free(&scenes[i].s);
    }
    fprintf(to, "],\n");
    put_tables(to);
    fprintf(to, "}\n");
    const bool ok = ferror(to) == 0;
    DEMAND(fclose(to) == 0 && ok, "cannot write all of it");
    return 0;
}
