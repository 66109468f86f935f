/* film_burst.c: a mesh that holds for a moment and then flies apart, every triangle for itself:
 * nothing that a tree of the last frame knew is true in the next. */
#include "film_made.h"
#include "loop.h"
#include "shape_build.h"

#include <string.h>

static const double hold = 0.5; /* seconds before it bursts */

/* How one triangle flies; lengths in units of the mesh's size. */
typedef struct shard {
    double centre[3], velocity[3], axis[3], turns; /* turns per second */
} shard;

typedef struct burst {
    double size, floor;
    shard *shards; /* behind the struct, in one allocation */
} burst;

static void spin(const shard *s, double turns, const float *p, double *out) {
    const double c = cos_turns(turns), w = sin_turns(turns);
    double v[3], side[3], along = 0;
    for (int i = 0; i < 3; ++i) v[i] = (double)p[i] - s->centre[i];
    for (int i = 0; i < 3; ++i) along += s->axis[i] * v[i];
    cross(s->axis, v, side);
    for (int i = 0; i < 3; ++i) out[i] = c * v[i] + w * side[i] + (1 - c) * along * s->axis[i];
}

/* What reaches the floor stays there; the time of landing stops the turning too. */
static double landing(const burst *b, const shard *s, double t) {
    const double g = 1.5 * b->size, v = s->velocity[1], drop = s->centre[1] - b->floor;
    const double land = (v + sqrt(v * v + 2 * g * (drop > 0 ? drop : 0))) / g;
    return t < land ? t : land;
}

typedef struct posing {
    const film_made *made;
    double time; /* since it burst */
    float *out;
} posing;

static void pose_some(void *data, uint64_t first, uint64_t end) {
    const posing *p = (const posing *)data;
    const burst *b = (const burst *)p->made->parts;
    for (uint64_t i = first; i < end; ++i) {
        const shard *s = &b->shards[i];
        const double u = landing(b, s, p->time), fall = 0.75 * b->size * u * u;
        for (uint64_t k = 9 * i; k < 9 * i + 9; k += 3) {
            double at[3];
            spin(s, s->turns * u, p->made->rest.positions + k, at);
            for (int a = 0; a < 3; ++a)
                p->out[k + (uint64_t)a] =
                    (float)(at[a] + s->centre[a] + s->velocity[a] * u - (a == 1 ? fall : 0));
        }
    }
}

static bool pose(const film *f, double time, uint32_t threads, film_frame *frame) {
    const film_made *made = (const film_made *)f->data;
    posing p = {made, time - hold, frame->positions};
    memcpy(frame->positions, made->rest.positions, (size_t)f->vertex_count * 3 * sizeof(float));
    if (p.time > 0) loop_run(threads, f->triangle_count - 2, pose_some, &p);
    return true;
}

static shard make_shard(const float *p, const double *centre, double size, random_stream *dice) {
    shard s;
    double away[3];
    for (int i = 0; i < 3; ++i) {
        s.centre[i] = ((double)p[i] + (double)p[3 + i] + (double)p[6 + i]) / 3;
        away[i] = s.centre[i] - centre[i] + 0.2 * size * random_range(dice, -1, 1);
        s.axis[i] = random_range(dice, -1, 1) + 1e-3;
    }
    away[1] += 0.25 * size;
    const double speed = random_range(dice, 0.6, 1.8);
    for (int i = 0; i < 3; ++i) s.velocity[i] = speed * away[i];
    normalise(s.axis);
    s.turns = random_range(dice, 0.2, 2);
    return s;
}

/* Triangles with corners of their own; a corner that is not finite makes its triangle a point. */
static void copy_soup(shape *s, const shape *mesh) {
    for (uint64_t i = 0; i < mesh->triangle_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const float *p = mesh->positions + 3 * (size_t)mesh->indices[3 * i + (uint64_t)k];
            add_vertex(s, (double)p[0], (double)p[1], (double)p[2]);
        }
        add_triangle(s, 3 * i, 3 * i + 1, 3 * i + 2);
    }
}

static void add_floor(shape *s, const double *centre, double y, double wide) {
    const uint64_t a = s->vertex_count;
    for (int i = 0; i < 4; ++i)
        add_vertex(s, centre[0] + (i == 1 || i == 2 ? wide : -wide), y,
                   centre[2] + (i < 2 ? wide : -wide));
    add_quad(s, a, a + 1, a + 2, a + 3);
}

static void set_view(film *f, film_made *made, double size) {
    for (int i = 0; i < 3; ++i) made->eye[i] = made->centre[i];
    made->eye[1] += 0.7 * size;
    made->eye[2] += 2.6 * size;
    made->orbit = 0.15;
    f->name = "explode";
    f->pose = pose;
}

bool film_make_burst(film *f, film_made *made, const shape *mesh) {
    const htree_box box = mesh_bounds(mesh);
    const uint64_t n = mesh->triangle_count;
    shape *s = &made->rest;
    double size = 0;
    for (int i = 0; i < 3; ++i) {
        made->centre[i] = ((double)box.lo[i] + (double)box.hi[i]) / 2;
        size = fmax(size, (double)box.hi[i] - (double)box.lo[i]);
    }
    if (n > UINT32_MAX / 4 || !reserve(s, 3 * n + 4, n + 2)) return false;
    burst *b = (burst *)malloc(sizeof *b + ((size_t)n + 1) * sizeof(shard));
    made->parts = b;
    made->material = (uint32_t *)calloc((size_t)n + 2, sizeof(uint32_t));
    if (!b || !made->material) return false;
    b->size = size;
    b->floor = (double)box.lo[1];
    b->shards = (shard *)(b + 1);
    random_stream dice = random_start(1);
    copy_soup(s, mesh);
    for (uint64_t i = 0; i < n; ++i) {
        b->shards[i] = make_shard(s->positions + 9 * i, made->centre, size, &dice);
        made->material[i] = 3 + (uint32_t)(hash64(i) % 2);
    }
    add_floor(s, made->centre, b->floor - 0.02 * size, 6 * size);
    set_view(f, made, size);
    return true;
}
