#include "contender.h"

#include "device.h"

#include <math.h>
#include <string.h>

htree_status contender_trace(contender *c, const ray_set *set, ray_set_name name, void *answers) {
    if (c->place != PLACE_PEER) {
        return name == RAYS_AMBIENT
                   ? tracer_occluded(&c->by, set->rays, set->count, (uint8_t *)answers)
                   : tracer_intersect(&c->by, set->rays, set->count, (htree_hit *)answers);
    }
    if (name == RAYS_AMBIENT)
        peer_occluded(c->other, set->rays, set->count, (uint8_t *)answers);
    else
        peer_intersect(c->other, set->rays, set->count, set->row, (htree_hit *)answers);
    return HTREE_OK;
}

static bool same_hit(contender_place place, bool exact, const htree_hit *a, const htree_hit *b) {
    if (place == PLACE_PEER) return (a->prim == HTREE_NONE) == (b->prim == HTREE_NONE);
    if (exact) return memcmp(a, b, sizeof *a) == 0;
    /* 2^-16, see htree_cl.h; infinities are equal. */
    return a->t == b->t || fabsf(a->t - b->t) <= 1.52587890625e-5f * fabsf(b->t);
}

uint64_t contender_differ(const contender *c, uint64_t count, ray_set_name name,
                          const void *answers, const void *expected) {
    const bool any = name == RAYS_AMBIENT;
    const bool exact = c->place == PLACE_CPU || (c->by.device && device_exact(c->by.device));
    const htree_hit *a = (const htree_hit *)answers, *b = (const htree_hit *)expected;
    uint64_t differ = 0;
    if (memcmp(answers, expected, (size_t)count * (any ? 1 : sizeof *a)) == 0) return 0;
    for (uint64_t i = 0; i < count; ++i) {
        const bool same = any ? ((const uint8_t *)answers)[i] == ((const uint8_t *)expected)[i]
                              : same_hit(c->place, exact, &a[i], &b[i]);
        differ += !same;
    }
    return differ;
}
