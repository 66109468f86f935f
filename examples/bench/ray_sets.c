#include "ray_sets.h"

#include "lamp.h"
#include "numbers.h"
#include "surface.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *ray_set_text(ray_set_name name) {
    static const char *const names[RAY_SETS] = {"primary", "frame", "ambient", "diffuse", "shadow"};
    return names[name];
}

bool ray_set_any(ray_set_name name) {
    return name == RAYS_AMBIENT || name == RAYS_SHADOW;
}

static bool reserve(ray_set *set, uint64_t count) {
    set->rays = (htree_ray *)malloc((size_t)(count + 1) * sizeof *set->rays);
    return set->rays != NULL;
}

/* ---- Pictures ------------------------------------------------------------------------------- */

static uint32_t least(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

/* Neighbours in the batch are neighbours in the picture: what a group of a device traces together. */
static htree_status make_picture(ray_set *set, const camera *view, uint32_t width, uint32_t height,
                                 uint32_t tile) {
    if (!reserve(set, (uint64_t)width * height)) return HTREE_ERROR_MEMORY;
    htree_ray *ray = set->rays;
    for (uint32_t top = 0; top < height; top += tile)
        for (uint32_t left = 0; left < width; left += tile)
            for (uint32_t y = top; y < least(top + tile, height); ++y)
                for (uint32_t x = left; x < least(left + tile, width); ++x)
                    *ray++ = camera_ray(view, x + 0.5, y + 0.5, width, height);
    set->count = (uint64_t)width * height;
    set->row = tile > 1 ? tile : width;
    snprintf(set->note, sizeof set->note, "%ux%u in tiles of %ux%u: closest hit", width, height,
             tile, tile);
    return HTREE_OK;
}

/* ---- From the hits -------------------------------------------------------------------------- */

typedef struct source {
    const ray_wish *wish;
    const shape *mesh;
    const htree *tree;
    double diagonal, lamp[3];
} source;

static htree_ray make_ray(const source *from, const surface *at, ray_set_name name, uint64_t bits) {
    double direction[3];
    if (name == RAYS_SHADOW) {
        for (int i = 0; i < 3; ++i) direction[i] = from->lamp[i] - at->point[i];
        return surface_ray(at, direction, 1);
    }
    surface_cosine(at, unit_from_bits(hash64(bits)), unit_from_bits(bits), direction);
    return surface_ray(at, direction,
                       name == RAYS_AMBIENT ? from->wish->reach * from->diagonal : INFINITY);
}

static void describe(ray_set *set, const source *from, ray_set_name name) {
    const ray_wish *wish = from->wish;
    if (name == RAYS_AMBIENT)
        snprintf(set->note, sizeof set->note,
                 "%u a hit of the frame, cosine-distributed, %g %% of the diagonal (%.4g) long: "
                 "any hit",
                 wish->ambient, 100 * wish->reach, wish->reach * from->diagonal);
    else if (name == RAYS_DIFFUSE)
        snprintf(set->note, sizeof set->note, "one a primary hit, cosine-distributed: closest hit");
    else
        snprintf(set->note, sizeof set->note, "one a primary hit, to the lamp: any hit");
}

/* `each` rays for every one of `seen` that hits. */
static htree_status make_onward(ray_set *set, const source *from, ray_set_name name,
                                const ray_set *seen, const htree_hit *hits, uint32_t each) {
    const double lift = surface_lift(from->diagonal);
    uint64_t found = 0;
    for (uint64_t i = 0; i < seen->count; ++i) found += hits[i].prim != HTREE_NONE;
    if (!reserve(set, found * each)) return HTREE_ERROR_MEMORY;
    for (uint64_t i = 0; i < seen->count; ++i) {
        surface at;
        if (hits[i].prim == HTREE_NONE) continue;
        surface_find(&at, from->mesh, &hits[i], &seen->rays[i], lift);
        for (uint32_t k = 0; k < each; ++k) {
            const uint64_t seed = hash_pair(hash_pair(from->wish->seed, i * each + k), name);
            set->rays[set->count++] = make_ray(from, &at, name, seed);
        }
    }
    describe(set, from, name);
    return HTREE_OK;
}

static htree_status make_all_onward(ray_set *sets, const source *from, ray_set_name seen,
                                    htree_hit *hits) {
    const ray_set *rays = &sets[seen];
    htree_status status = htree_intersect(from->tree, rays->rays, rays->count, hits, NULL);
    for (int name = RAYS_AMBIENT; status == HTREE_OK && name < RAY_SETS; ++name) {
        const bool of_frame = name == RAYS_AMBIENT;
        if (of_frame != (seen == RAYS_FRAME)) continue;
        status = make_onward(&sets[name], from, (ray_set_name)name, rays, hits,
                             of_frame ? from->wish->ambient : 1);
    }
    return status;
}

static htree_status place_light(source *from, const camera *view) {
    const htree_box box = mesh_bounds(from->mesh);
    const htree_ray probe = lamp_probe(view);
    htree_hit hit;
    from->diagonal = lamp_diagonal(&box);
    const htree_status status = htree_intersect(from->tree, &probe, 1, &hit, NULL);
    if (status == HTREE_OK) lamp_place(from->lamp, view, &box, (double)hit.t);
    return status;
}

htree_status ray_sets_make(ray_set *sets, const ray_wish *wish, const shape *mesh,
                           const camera_wish *view, const htree *tree) {
    const camera wide = camera_place(view, mesh, wish->width, wish->height);
    const camera square = camera_place(view, mesh, wish->frame, wish->frame);
    source from = {wish, mesh, tree, 0, {0, 0, 0}};
    memset(sets, 0, RAY_SETS * sizeof *sets);
    htree_status status = place_light(&from, &wide);
    if (status == HTREE_OK)
        status = make_picture(&sets[RAYS_PRIMARY], &wide, wish->width, wish->height, wish->tile);
    if (status == HTREE_OK)
        status = make_picture(&sets[RAYS_FRAME], &square, wish->frame, wish->frame, wish->tile);
    if (status != HTREE_OK) return status;
    const uint64_t most = sets[RAYS_PRIMARY].count + sets[RAYS_FRAME].count;
    htree_hit *hits = (htree_hit *)malloc((size_t)most * sizeof *hits);
    status = hits ? make_all_onward(sets, &from, RAYS_PRIMARY, hits) : HTREE_ERROR_MEMORY;
    if (status == HTREE_OK) status = make_all_onward(sets, &from, RAYS_FRAME, hits);
    free(hits);
    return status;
}

void ray_sets_free(ray_set *sets) {
    for (int i = 0; i < RAY_SETS; ++i) free(sets[i].rays);
    memset(sets, 0, RAY_SETS * sizeof *sets);
}
