/* film_crowd.c: people who walk in rings around a square. Limbs swing and bend, bodies twist, so
 * that no part moves rigidly. */
#include "film_made.h"
#include "loop.h"
#include "shape_build.h"

enum { SKIN = 1, TROUSERS = 2, SHIRT = 3, SHIRTS = 5, LIMBS = 6, SLICES = 8, RINGS = 9 };

/* A limb hangs from a joint at height `top` down to `bottom`, `side` off the middle. */
typedef struct limb {
    double top, bottom, radius, side;
    double swing; /* in turns, with the sign of the phase; 0: part of the trunk */
    uint32_t material;
} limb;

static const limb limbs[LIMBS] = {
    {1.48, 0.85, 0.200, 0, 0, SHIRT},          {1.80, 1.50, 0.125, 0, 0, SKIN},
    {0.92, 0.02, 0.095, 0.11, 0.09, TROUSERS}, {0.92, 0.02, 0.095, -0.11, -0.09, TROUSERS},
    {1.45, 0.75, 0.060, 0.26, -0.08, SHIRT},   {1.45, 0.75, 0.060, -0.26, 0.08, SHIRT},
};

/* Where a person walks. */
typedef struct walker {
    double ring, start, pace, size; /* metres, turns, metres per second, 1 = 1.8 m */
} walker;

static const uint64_t person_vertices = LIMBS * (2 + RINGS * SLICES);
static const uint64_t person_triangles = LIMBS * 2 * RINGS * SLICES;

/* ---- Moving --------------------------------------------------------------------------------- */

/* Turns (y, z) around a joint at height y0. */
static void bend(double *p, double y0, double turns) {
    const double c = cos_turns(turns), s = sin_turns(turns), y = p[1] - y0, z = p[2];
    p[1] = y0 + c * y + s * z;
    p[2] = c * z - s * y;
}

/* Legs bend at the knee while they swing back, arms at the elbow while they swing forward. */
static void swing(const limb *part, double phase, double *p) {
    const double angle = part->swing * sin_turns(phase), middle = (part->top + part->bottom) / 2;
    const bool leg = part->material == TROUSERS;
    const double lower = (middle - p[1]) / (part->top - part->bottom) * 2;
    const double fold = leg ? -0.10 * (1 + cos_turns(phase + (part->swing < 0 ? 0.5 : 0))) / 2
                            : 0.08 * (1 + sin_turns(phase) * (part->swing < 0 ? -1 : 1)) / 2;
    if (lower > 0) bend(p, middle, fold * fmin(1, 3 * lower));
    bend(p, part->top, angle);
}

static void place(const walker *w, double time, const float *rest, const limb *part, float *out) {
    const double walked = w->pace * time, turn = w->start + walked / (6.2831853 * w->ring);
    const double phase = walked / (1.5 * w->size);
    double p[3] = {(double)rest[0], (double)rest[1], (double)rest[2]};
    if (part->swing != 0) swing(part, phase + w->start, p);
    const double twist = 0.03 * sin_turns(phase + w->start) * (p[1] - 0.9);
    const double c = cos_turns(twist), s = sin_turns(twist);
    const double x = w->size * (c * p[0] + s * p[2]), z = w->size * (c * p[2] - s * p[0]);
    const double y = w->size * (p[1] + 0.02 * cos_turns(2 * (phase + w->start)));
    const double cr = cos_turns(turn), sr = sin_turns(turn);
    /* Facing along the ring. */
    out[0] = (float)(cr * (w->ring + x) - sr * z);
    out[1] = (float)y;
    out[2] = (float)(sr * (w->ring + x) + cr * z);
}

typedef struct posing {
    const film_made *made;
    double time;
    float *out;
} posing;

static void pose_some(void *data, uint64_t first, uint64_t end) {
    const posing *p = (const posing *)data;
    const walker *walkers = (const walker *)p->made->parts;
    for (uint64_t i = first; i < end; ++i) {
        const uint64_t within = i % person_vertices;
        place(&walkers[i / person_vertices], p->time, p->made->rest.positions + 3 * i,
              &limbs[within / (person_vertices / LIMBS)], p->out + 3 * i);
    }
}

static bool pose(const film *f, double time, uint32_t threads, film_frame *frame) {
    const film_made *made = (const film_made *)f->data;
    const uint64_t ground = f->vertex_count / person_vertices * person_vertices;
    posing p = {made, time, frame->positions};
    loop_run(threads, ground, pose_some, &p);
    for (uint64_t i = 3 * ground; i < 3 * f->vertex_count; ++i)
        frame->positions[i] = made->rest.positions[i];
    return true;
}

/* ---- Making --------------------------------------------------------------------------------- */

/* An egg of revolution for every limb, blunter than an ellipse. */
static void add_person(film_made *made, uint64_t seed) {
    shape *s = &made->rest;
    for (int k = 0; k < LIMBS; ++k) {
        const limb *part = &limbs[k];
        const double origin[3] = {part->side, part->bottom, 0};
        double profile[RINGS + 2][2];
        for (int i = 0; i < RINGS + 2; ++i) {
            const double x = 0.5 * i / (RINGS + 1);
            profile[i][0] = part->radius * sqrt(sin_turns(x));
            profile[i][1] = (part->top - part->bottom) * (1 - cos_turns(x)) / 2;
        }
        const uint64_t first = s->triangle_count;
        add_lathe(s, (const double(*)[2])profile, RINGS + 2, SLICES, origin, 1);
        const uint32_t shirt = SHIRT + (uint32_t)(hash64(seed) % SHIRTS);
        for (uint64_t i = first; i < s->triangle_count; ++i)
            made->material[i] = part->material == SHIRT ? shirt : part->material;
    }
}

bool film_make_crowd(film *f, film_made *made, uint64_t triangles) {
    const uint64_t people = at_least(triangles / person_triangles, 1);
    const double reach = 2.5 + 0.75 * sqrt((double)people);
    walker *walkers = (walker *)malloc((size_t)people * sizeof *walkers);
    made->parts = walkers;
    made->material = (uint32_t *)calloc((size_t)(people * person_triangles) + 2, 4);
    if (!walkers || !made->material ||
        !reserve(&made->rest, people * person_vertices + 4, people * person_triangles + 2))
        return false;
    random_stream dice = random_start(3);
    for (uint64_t i = 0; i < people; ++i) {
        walkers[i].ring = 1.5 + (reach - 1.5) * sqrt(random_unit(&dice));
        walkers[i].start = random_unit(&dice);
        walkers[i].pace = random_range(&dice, 0.9, 1.7);
        walkers[i].size = random_range(&dice, 0.85, 1.1);
        add_person(made, i);
    }
    const uint64_t a = made->rest.vertex_count;
    const double wide = 4 * reach;
    for (int i = 0; i < 4; ++i)
        add_vertex(&made->rest, i == 1 || i == 2 ? wide : -wide, 0, i < 2 ? wide : -wide);
    add_quad(&made->rest, a, a + 1, a + 2, a + 3);
    made->centre[1] = 0.5;
    made->eye[1] = 0.45 * reach + 1;
    made->eye[2] = 1.7 * reach + 2;
    made->orbit = 0.1;
    f->name = "crowd";
    f->pose = pose;
    return true;
}
