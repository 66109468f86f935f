#include "ray_sets.h"

#include "numbers.h"
#include "surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *ray_set_text(ray_set_name name) {
    static const char *const names[RAY_SETS] = {"primary", "ambient", "diffuse"};
    return names[name];
}

double ray_sets_diagonal(const shape *mesh) {
    const htree_box box = mesh_bounds(mesh);
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const double side = (double)box.hi[i] - (double)box.lo[i];
        sum += side * side;
    }
    return sqrt(sum);
}

static uint32_t least(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

/* Neighbours in the batch are neighbours in the picture: what a group of a device traces together. */
static void make_primary(ray_set *set, const ray_wish *wish, const camera *view) {
    const uint32_t tile = wish->tile, width = wish->width, height = wish->height;
    htree_ray *ray = set->rays;
    for (uint32_t top = 0; top < height; top += tile)
        for (uint32_t left = 0; left < width; left += tile)
            for (uint32_t y = top; y < least(top + tile, height); ++y)
                for (uint32_t x = left; x < least(left + tile, width); ++x)
                    *ray++ = camera_ray(view, x + 0.5, y + 0.5, width, height);
}

static void make_secondary(ray_set *sets, const ray_wish *wish, const shape *mesh,
                           const htree_hit *hits) {
    const double diagonal = ray_sets_diagonal(mesh), lift = surface_lift(diagonal);
    const double reach[RAY_SETS] = {0, wish->reach * diagonal, INFINITY};
    for (uint64_t i = 0; i < sets[RAYS_PRIMARY].count; ++i) {
        surface s;
        if (hits[i].prim == HTREE_NONE) continue;
        surface_find(&s, mesh, &hits[i], &sets[RAYS_PRIMARY].rays[i], lift);
        for (uint32_t k = RAYS_AMBIENT; k < RAY_SETS; ++k) {
            const uint64_t bits = hash_pair(hash_pair(wish->seed, i), k);
            double direction[3];
            surface_cosine(&s, unit_from_bits(hash64(bits)), unit_from_bits(bits), direction);
            sets[k].rays[sets[k].count++] = surface_ray(&s, direction, reach[k]);
        }
    }
}

static uint64_t count_hits(const htree_hit *hits, uint64_t count) {
    uint64_t found = 0;
    for (uint64_t i = 0; i < count; ++i) found += hits[i].prim != HTREE_NONE;
    return found;
}

static bool reserve(ray_set *set, uint64_t count) {
    set->rays = (htree_ray *)malloc((size_t)(count + 1) * sizeof *set->rays);
    return set->rays != NULL;
}

htree_status ray_sets_make(ray_set *sets, const ray_wish *wish, const shape *mesh,
                           const camera *view, const htree *tree) {
    const uint64_t pixels = (uint64_t)wish->width * wish->height;
    memset(sets, 0, RAY_SETS * sizeof *sets);
    htree_hit *hits = (htree_hit *)malloc((size_t)pixels * sizeof *hits);
    htree_status status =
        hits && reserve(&sets[RAYS_PRIMARY], pixels) ? HTREE_OK : HTREE_ERROR_MEMORY;
    if (status == HTREE_OK) {
        sets[RAYS_PRIMARY].count = pixels;
        sets[RAYS_PRIMARY].row = wish->tile > 1 ? wish->tile : wish->width;
        make_primary(&sets[RAYS_PRIMARY], wish, view);
        status = htree_intersect(tree, sets[RAYS_PRIMARY].rays, pixels, hits, NULL);
    }
    if (status == HTREE_OK) {
        const uint64_t found = count_hits(hits, pixels);
        if (reserve(&sets[RAYS_AMBIENT], found) && reserve(&sets[RAYS_DIFFUSE], found))
            make_secondary(sets, wish, mesh, hits);
        else
            status = HTREE_ERROR_MEMORY;
    }
    free(hits);
    return status;
}

void ray_sets_free(ray_set *sets) {
    for (int i = 0; i < RAY_SETS; ++i) free(sets[i].rays);
    memset(sets, 0, RAY_SETS * sizeof *sets);
}
