/* peer_pack.c: rays in Embree's layout for packets of 16, and its answers back. */
#include "embree.h"

#include <stdlib.h>
#include <string.h>

static uint64_t packets_across(uint64_t row) {
    return (row + PEER_SIDE - 1) / PEER_SIDE;
}

/* Writes which rays are in packet `number` of a picture, the last row of which may be short, and
 * returns how many. */
static uint32_t find_packet(const peer_packets *p, uint64_t number, uint64_t *index) {
    const uint64_t left = number % packets_across(p->row) * PEER_SIDE;
    const uint64_t top = number / packets_across(p->row) * PEER_SIDE;
    uint32_t count = 0;
    for (uint64_t y = top; y < top + PEER_SIDE; ++y)
        for (uint64_t x = left; x < left + PEER_SIDE && x < p->row; ++x)
            if (y * p->row + x < p->rays) index[count++] = y * p->row + x;
    return count;
}

static void fill(peer_packet *out, const htree_ray *rays, const uint64_t *index, uint32_t count) {
    memset(out, 0, sizeof *out);
    for (uint32_t i = 0; i < count; ++i) {
        const htree_ray *ray = &rays[index[i]];
        out->valid[i] = -1;
        out->ray.org_x[i] = ray->org[0];
        out->ray.org_y[i] = ray->org[1];
        out->ray.org_z[i] = ray->org[2];
        out->ray.dir_x[i] = ray->dir[0];
        out->ray.dir_y[i] = ray->dir[1];
        out->ray.dir_z[i] = ray->dir[2];
        out->ray.tnear[i] = ray->tmin;
        out->ray.tfar[i] = ray->tmax;
        out->ray.mask[i] = UINT32_MAX;
    }
}

static void *take(uint64_t count, size_t bytes) {
    void *memory = NULL;
    return posix_memalign(&memory, 64, (size_t)(count + 1) * bytes) == 0 ? memory : NULL;
}

peer_packets *peer_pack(const htree_ray *rays, uint64_t count, uint32_t row) {
    peer_packets *p = (peer_packets *)calloc(1, sizeof *p);
    if (!p) return NULL;
    p->row = row;
    p->rays = count;
    p->count = packets_across(row) * packets_across((count + row - 1) / row);
    p->in = (peer_packet *)take(p->count, sizeof *p->in);
    p->out = (peer_answer *)take(p->count, sizeof *p->out);
    for (uint64_t i = 0; p->in && p->out && i < p->count; ++i) {
        uint64_t index[PEER_PACKET];
        fill(&p->in[i], rays, index, find_packet(p, i, index));
    }
    if (p->in && p->out) return p;
    peer_packets_free(p);
    return NULL;
}

void peer_packets_free(peer_packets *packets) {
    if (!packets) return;
    free(packets->in);
    free(packets->out);
    free(packets);
}

void peer_unpack(const peer_packets *p, htree_hit *hits) {
    for (uint64_t i = 0; i < p->count; ++i) {
        const peer_answer *a = &p->out[i];
        uint64_t index[PEER_PACKET];
        const uint32_t count = find_packet(p, i, index);
        for (uint32_t k = 0; k < count; ++k) {
            const bool miss = a->geometry[k] == RTC_INVALID_GEOMETRY_ID;
            const htree_hit hit = {a->t[k], miss ? 0 : a->u[k], miss ? 0 : a->v[k],
                                   miss ? HTREE_NONE : a->prim[k]};
            hits[index[k]] = hit;
        }
    }
}
