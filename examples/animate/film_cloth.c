/* film_cloth.c: a flag on its pole: waves that run away from the pole and grow on the way, and the
 * smaller ones of the wind across them. */
#include "film_made.h"
#include "loop.h"
#include "shape_build.h"

enum { GROUND = 0, POLE = 7, FLAG = 3, STRIPE = 7 };

static const double width = 3, height = 2;

typedef struct posing {
    const film_made *made;
    double time, sway;
    float *out;
} posing;

static void pose_some(void *data, uint64_t first, uint64_t end) {
    const posing *p = (const posing *)data;
    const uint64_t grid = *(const uint64_t *)p->made->parts;
    for (uint64_t i = first; i < end; ++i) {
        const float *rest = p->made->rest.positions + 3 * i;
        float *out = p->out + 3 * i;
        for (int k = 0; k < 3; ++k) out[k] = rest[k];
        if (i >= grid) continue;
        const double x = (double)rest[0] / width, y = (double)rest[1] / height;
        const double along = sin_turns(1.6 * x - 0.9 * p->time + 0.25 * y);
        const double across = sin_turns(3.1 * x + 1.3 * y - 1.7 * p->time);
        out[0] -= (float)(0.22 * x * x * p->sway);
        out[1] -= (float)(0.25 * x * x + 0.03 * x * across);
        out[2] = (float)((0.42 * along + 0.09 * across) * x * (1.5 - 0.5 * x));
    }
}

static bool pose(const film *f, double time, uint32_t threads, film_frame *frame) {
    posing p = {(const film_made *)f->data, time, 1 + 0.5 * sin_turns(0.35 * time),
                frame->positions};
    loop_run(threads, f->vertex_count, pose_some, &p);
    return true;
}

static void add_flag(film_made *made, uint64_t columns, uint64_t rows) {
    shape *s = &made->rest;
    for (uint64_t j = 0; j <= rows; ++j)
        for (uint64_t i = 0; i <= columns; ++i)
            add_vertex(s, width * (double)i / (double)columns, height * (double)j / (double)rows,
                       0);
    for (uint64_t j = 0; j < rows; ++j) {
        for (uint64_t i = 0; i < columns; ++i) {
            const uint64_t a = j * (columns + 1) + i, c = a + columns + 1;
            const bool stripe = 5 * j / rows % 2 == 1;
            made->material[s->triangle_count] = stripe ? STRIPE : FLAG;
            made->material[s->triangle_count + 1] = stripe ? STRIPE : FLAG;
            add_quad(s, a, a + 1, c + 1, c);
        }
    }
}

bool film_make_cloth(film *f, film_made *made, uint64_t triangles) {
    const uint64_t rows = at_least(root((double)triangles / 3), 1);
    const uint64_t columns = at_least(triangles / 2 / rows, 1);
    const double pole_lo[3] = {-0.1, -2.5, -0.05}, pole_hi[3] = {0, 2.2, 0.05};
    const double eye[3] = {3.2, 0.6, 6.5}, centre[3] = {1.3, 0.2, 0};
    shape *s = &made->rest;
    uint64_t *grid = (uint64_t *)malloc(sizeof *grid);
    made->parts = grid;
    made->material = (uint32_t *)calloc((size_t)(2 * rows * columns + 14), sizeof(uint32_t));
    if (!grid || !made->material ||
        !reserve(s, (rows + 1) * (columns + 1) + 12, 2 * rows * columns + 14))
        return false;
    add_flag(made, columns, rows);
    *grid = s->vertex_count;
    for (uint64_t i = 0; i < 12; ++i) made->material[s->triangle_count + i] = POLE;
    add_box(s, pole_lo, pole_hi);
    const uint64_t a = s->vertex_count;
    for (int i = 0; i < 4; ++i) add_vertex(s, i == 1 || i == 2 ? 9 : -9, -2.5, i < 2 ? 9 : -9);
    add_quad(s, a, a + 1, a + 2, a + 3);
    for (int i = 0; i < 3; ++i) {
        made->eye[i] = eye[i];
        made->centre[i] = centre[i];
    }
    made->orbit = 0.08;
    f->name = "cloth";
    f->pose = pose;
    return true;
}
