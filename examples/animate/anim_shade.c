/* anim_shade.c: rows at a time: primary rays in one batch, then one batch of shadow rays per light,
 * as the library spreads batches over threads. */
#include "anim_shade.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_LIGHTS = 16, BAND = 1 << 16 }; /* rays in a batch, about */

typedef struct sample {
    double point[3], normal[3]; /* unit normal, to the side of the eye */
    float light[3];
} sample;

typedef struct painter {
    const film *f;
    const film_frame *frame;
    const htree *tree;
    const camera *view;
    uint32_t side; /* samples along a side of a pixel */
    float dim;     /* of all lights, so that together they do not burn out the picture */
    htree_query query;
    htree_ray *rays, *shadows;
    htree_hit *hits;
    uint8_t *dark;
    sample *samples;
} painter;

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* ---- Surfaces ------------------------------------------------------------------------------- */

static void face_normal(const painter *p, uint32_t prim, const double *point, double *out) {
    const film *f = p->f;
    if (prim >= f->triangle_count) {
        cone_normal(&p->frame->cones[prim - f->triangle_count], point, out);
        return;
    }
    double e[2][3];
    const uint32_t *corner = f->indices + 3 * (size_t)prim;
    const float *a = p->frame->positions + 3 * (size_t)corner[0];
    for (int k = 0; k < 2; ++k)
        for (int i = 0; i < 3; ++i)
            e[k][i] =
                (double)p->frame->positions[3 * (size_t)corner[k + 1] + (size_t)i] - (double)a[i];
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = e[0][j] * e[1][k] - e[0][k] * e[1][j];
    }
}

static void take_surface(const painter *p, size_t i) {
    const htree_ray *ray = &p->rays[i];
    sample *s = &p->samples[i];
    double dir[3];
    for (int k = 0; k < 3; ++k) {
        dir[k] = (double)ray->dir[k];
        s->point[k] = (double)ray->org[k] + (double)p->hits[i].t * dir[k];
    }
    face_normal(p, p->hits[i].prim, s->point, s->normal);
    const double length = sqrt(dot(s->normal, s->normal)), facing = dot(s->normal, dir);
    const double scale = (facing > 0 ? -1 : 1) / (length > 0 ? length : 1);
    for (int k = 0; k < 3; ++k) s->normal[k] *= scale;
    /* Light from everywhere, a little more of it from where the eye is, so that edges show where
     * no lamp shines. */
    const double front = fabs(facing) / (length > 0 ? length : 1) / sqrt(dot(dir, dir));
    for (int k = 0; k < 3; ++k) s->light[k] = p->f->ambient * (float)(0.5 + 0.5 * front);
}

/* ---- Light ---------------------------------------------------------------------------------- */

/* The ray starts a hair off the surface, in proportion to how coarse floats are there. */
static void aim(const painter *p, size_t i, const film_light *light) {
    const sample *s = &p->samples[i];
    htree_ray *ray = &p->shadows[i];
    memset(ray, 0, sizeof *ray);
    ray->tmin = 1;
    ray->tmax = 0;
    if (p->hits[i].prim == HTREE_NONE) return;
    double to[3], reach = 0;
    for (int k = 0; k < 3; ++k) {
        to[k] = light->at[k] - s->point[k];
        reach = fmax(reach, fabs(s->point[k]) + fabs((double)ray->org[k]));
    }
    if (!(dot(to, s->normal) > 0)) return;
    const double hair = 2e-5 * reach;
    for (int k = 0; k < 3; ++k) {
        const double from = s->point[k] + hair * s->normal[k];
        ray->org[k] = (float)from;
        ray->dir[k] = (float)(light->at[k] - from);
    }
    ray->tmin = 0;
    ray->tmax = 0.9999f;
}

static htree_status add_light(painter *p, const film_light *light, size_t count) {
    for (size_t i = 0; i < count; ++i) aim(p, i, light);
    const htree_status status = htree_occluded(p->tree, p->shadows, count, p->dark, &p->query);
    for (size_t i = 0; status == HTREE_OK && i < count; ++i) {
        const htree_ray *ray = &p->shadows[i];
        if (p->dark[i] || ray->tmin > ray->tmax) continue;
        const double dir[3] = {(double)ray->dir[0], (double)ray->dir[1], (double)ray->dir[2]};
        const double cosine = dot(dir, p->samples[i].normal) / sqrt(dot(dir, dir));
        for (int k = 0; k < 3; ++k)
            p->samples[i].light[k] += p->dim * light->colour[k] * (float)fmax(cosine, 0);
    }
    return status;
}

static float dim_lights(const film *f) {
    float sum = 0;
    for (uint32_t i = 0; i < f->light_count && i < MAX_LIGHTS; ++i) {
        const float *c = f->lights[i].colour;
        sum += fmaxf(c[0], fmaxf(c[1], c[2]));
    }
    return sum > 1 ? 1 / sum : 1;
}

/* ---- Rows ----------------------------------------------------------------------------------- */

static void make_rays(painter *p, const picture *out, uint32_t first, uint32_t rows) {
    htree_ray *ray = p->rays;
    for (uint32_t y = first; y < first + rows; ++y)
        for (uint32_t x = 0; x < out->width; ++x)
            for (uint32_t k = 0; k < p->side * p->side; ++k)
                *ray++ = camera_ray(p->view, x + (k % p->side + 0.5) / p->side,
                                    y + (k / p->side + 0.5) / p->side, out->width, out->height);
}

static void add_colour(const painter *p, size_t i, float *sum) {
    const film *f = p->f;
    const uint32_t prim = p->hits[i].prim;
    for (int k = 0; k < 3; ++k)
        sum[k] += prim == HTREE_NONE
                      ? f->background[k]
                      : f->materials[f->material[prim]].colour[k] * p->samples[i].light[k];
}

static void set_pixels(const painter *p, picture *out, uint32_t first, uint32_t rows) {
    const uint32_t each = p->side * p->side;
    for (uint32_t i = 0; i < rows * out->width; ++i) {
        float sum[3] = {0, 0, 0};
        for (uint32_t k = 0; k < each; ++k) add_colour(p, (size_t)i * each + k, sum);
        for (int k = 0; k < 3; ++k) sum[k] = powf(sum[k] / (float)each, 1 / 2.2f);
        const colour c = {sum[0], sum[1], sum[2]};
        picture_set(out, i % out->width, first + i / out->width, c);
    }
}

static htree_status paint_rows(painter *p, picture *out, uint32_t first, uint32_t rows) {
    const size_t count = (size_t)rows * out->width * p->side * p->side;
    make_rays(p, out, first, rows);
    htree_status status = htree_intersect(p->tree, p->rays, count, p->hits, &p->query);
    for (size_t i = 0; status == HTREE_OK && i < count; ++i)
        if (p->hits[i].prim != HTREE_NONE) take_surface(p, i);
    for (uint32_t i = 0; status == HTREE_OK && i < p->f->light_count && i < MAX_LIGHTS; ++i)
        status = add_light(p, &p->f->lights[i], count);
    if (status == HTREE_OK) set_pixels(p, out, first, rows);
    return status;
}

static htree_status paint(painter *p, picture *out, size_t room, uint32_t rows) {
    p->rays = (htree_ray *)malloc(room * sizeof *p->rays);
    p->shadows = (htree_ray *)malloc(room * sizeof *p->shadows);
    p->hits = (htree_hit *)malloc(room * sizeof *p->hits);
    p->dark = (uint8_t *)malloc(room);
    p->samples = (sample *)malloc(room * sizeof *p->samples);
    htree_status status = HTREE_OK;
    if (!p->rays || !p->shadows || !p->hits || !p->dark || !p->samples) status = HTREE_ERROR_MEMORY;
    for (uint32_t y = 0; status == HTREE_OK && y < out->height; y += rows)
        status = paint_rows(p, out, y, rows < out->height - y ? rows : out->height - y);
    free(p->rays);
    free(p->shadows);
    free(p->hits);
    free(p->dark);
    free(p->samples);
    return status;
}

htree_status anim_shade(picture *out, const film *f, const film_frame *frame, const htree *tree,
                        const camera *view, uint32_t samples, uint32_t threads) {
    painter p;
    memset(&p, 0, sizeof p);
    p.f = f;
    p.frame = frame;
    p.tree = tree;
    p.view = view;
    p.side = samples;
    p.dim = dim_lights(f);
    const htree_status status = htree_query_init(&p.query, sizeof p.query);
    if (status != HTREE_OK) return status;
    p.query.threads = threads;
    const size_t row = (size_t)out->width * samples * samples;
    const uint32_t rows = row < BAND ? (uint32_t)(BAND / row) : 1;
    return paint(&p, out, row * rows, rows);
}
