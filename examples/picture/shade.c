/* shade.c: the picture is made in bands of rows, and each band in stages: primary rays, shadow
 * rays, ambient rays. A stage is one array of rays and one call, because batches are what the
 * library spreads over cores. Only + - * / and sqrt touch a colour: equal pictures on every
 * machine. */
#include "shade.h"

#include "lamp.h"
#include "numbers.h"
#include "surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BAND_PIXELS = 1 << 15 };

/* What a primary ray has hit. */
typedef struct seen {
    surface at;
    double to_lamp[3];
    uint32_t pixel; /* of the band */
} seen;

typedef struct painter {
    const shade_scene *scene;
    double lamp[3], lift, reach; /* reach: how far away things occlude the sky */
    uint32_t ambient;            /* rays per sample */

    /* Arrays for one band. */
    htree_ray *rays;
    htree_hit *hits;
    uint8_t *blocked;
    seen *surfaces;
    float (*sum)[3]; /* linear light of each pixel over the samples so far */
} painter;

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalise(double *v) {
    const double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; ++i) v[i] = length > 0 ? v[i] / length : 0;
}

/* ---- Light ---------------------------------------------------------------------------------- */

static void place_lamp(painter *p, const htree_box *box) {
    htree_hit hit = {INFINITY, 0, 0, HTREE_NONE};
    const htree_ray probe = lamp_probe(p->scene->view);
    const double size = lamp_diagonal(box);
    if (tracer_intersect(p->scene->by, &probe, 1, &hit) != HTREE_OK) hit.t = INFINITY;
    const bool inside = lamp_place(p->lamp, p->scene->view, box, (double)hit.t);
    p->reach = size * (inside ? 0.08 : 0.3);
    p->lift = surface_lift(size);
}

/* Warm clay under a warm lamp, a cool sky above and a warm floor below. */
static void add_light(float *sum, double lamp, double sky, double facing_up) {
    static const double clay[3] = {.83, .70, .56}, sun[3] = {.86, .80, .70};
    static const double above[3] = {.27, .33, .42}, below[3] = {.17, .14, .13};
    const double up = 0.5 + 0.5 * facing_up;
    for (int i = 0; i < 3; ++i) {
        const double ambient = sky * (below[i] + up * (above[i] - below[i]));
        sum[i] += (float)(clay[i] * (ambient + lamp * sun[i]));
    }
}

static void add_background(float *sum, double height) {
    static const double top[3] = {.20, .29, .40}, bottom[3] = {.80, .80, .77};
    for (int i = 0; i < 3; ++i) sum[i] += (float)(top[i] + height * (bottom[i] - top[i]));
}

/* ---- Stages --------------------------------------------------------------------------------- */

/* Direction i of n: a spiral of equal areas, turned by a random angle per pixel. */
static void ambient_direction(const surface *s, uint32_t i, uint32_t n, uint64_t bits,
                              double *out) {
    const double area = ((double)i + unit_from_bits(hash64(bits))) / (double)n;
    surface_cosine(s, area, 0.6180339887498949 * (double)i + unit_from_bits(bits), out);
}

/* The bits that decide everything random about one sample of one pixel. */
static uint64_t sample_bits(const painter *p, uint64_t pixel, uint32_t sample) {
    return hash_pair(hash_pair(p->scene->args->seed, pixel), sample);
}

/* One sample sits in the centre; more are jittered. */
static htree_status trace_primary(painter *p, uint64_t first, uint32_t count, uint32_t sample,
                                  uint32_t *surface_count) {
    const render_args *args = p->scene->args;
    for (uint32_t i = 0; i < count; ++i) {
        const uint64_t pixel = first + i, bits = sample_bits(p, pixel, sample);
        const double jx = args->spp > 1 ? unit_from_bits(bits) : 0.5;
        const double jy = args->spp > 1 ? unit_from_bits(hash64(bits)) : 0.5;
        p->rays[i] = camera_ray(p->scene->view, (double)(pixel % args->width) + jx,
                                (double)(pixel / args->width) + jy, args->width, args->height);
    }
    const htree_status status = tracer_intersect(p->scene->by, p->rays, count, p->hits);
    *surface_count = 0;
    if (status != HTREE_OK) return status;
    for (uint32_t i = 0; i < count; ++i) {
        if (p->hits[i].prim == HTREE_NONE) {
            const double row = (double)((first + i) / args->width);
            add_background(p->sum[i], args->mode == MODE_SHADED ? row / args->height : 0);
            continue;
        }
        seen *s = &p->surfaces[(*surface_count)++];
        surface_find(&s->at, p->scene->mesh, &p->hits[i], &p->rays[i], p->lift);
        for (int k = 0; k < 3; ++k) s->to_lamp[k] = p->lamp[k] - s->at.point[k];
        s->pixel = i;
    }
    return HTREE_OK;
}

/* Shadow rays come first in the batch, then the ambient rays of each surface together. The
 * samples of a pixel share one spiral, of which each takes a part: its rays spread better than
 * n spirals. */
static htree_status light_surfaces(painter *p, uint64_t first, uint32_t sample, uint32_t count) {
    const uint32_t n = p->ambient, spp = p->scene->args->spp;
    for (uint32_t i = 0; i < count; ++i) {
        const seen *s = &p->surfaces[i];
        const uint64_t bits = sample_bits(p, first + s->pixel, UINT32_MAX);
        p->rays[i] = surface_ray(&s->at, s->to_lamp, 1);
        for (uint32_t k = 0; k < n; ++k) {
            double direction[3];
            ambient_direction(&s->at, k * spp + sample, n * spp, bits, direction);
            p->rays[count + (size_t)i * n + k] = surface_ray(&s->at, direction, p->reach);
        }
    }
    const htree_status status =
        tracer_occluded(p->scene->by, p->rays, (uint64_t)count * (n + 1), p->blocked);
    if (status != HTREE_OK) return status;
    const int up = p->scene->args->camera.up;
    for (uint32_t i = 0; i < count; ++i) {
        seen *s = &p->surfaces[i];
        uint32_t open = 0;
        for (uint32_t k = 0; k < n; ++k) open += !p->blocked[count + (size_t)i * n + k];
        normalise(s->to_lamp);
        const double lamp = p->blocked[i] ? 0 : fmax(0, dot(s->at.normal, s->to_lamp));
        add_light(p->sum[s->pixel], lamp, (double)open / n, s->at.normal[up]);
    }
    return HTREE_OK;
}

/* Normals as colours, or a colour per triangle, which a hash makes as different as can be. */
static void label_surfaces(painter *p, uint32_t count) {
    const bool normals = p->scene->args->mode == MODE_NORMALS;
    for (uint32_t i = 0; i < count; ++i) {
        const seen *s = &p->surfaces[i];
        const uint64_t bits = hash64(s->at.prim);
        for (int k = 0; k < 3; ++k) {
            const double random = 0.25 + 0.75 * (double)(bits >> (8 * k) & 255) / 255;
            const double c = normals ? 0.5 + 0.5 * s->at.normal[k] : random;
            p->sum[s->pixel][k] += (float)(c * c);
        }
    }
}

/* ---- Pictures ------------------------------------------------------------------------------- */

static htree_status paint_band(painter *p, picture *out, uint64_t first, uint32_t count) {
    const render_args *args = p->scene->args;
    memset(p->sum, 0, count * sizeof *p->sum);
    for (uint32_t sample = 0; sample < args->spp; ++sample) {
        uint32_t surfaces = 0;
        htree_status status = trace_primary(p, first, count, sample, &surfaces);
        if (status == HTREE_OK && args->mode == MODE_SHADED)
            status = light_surfaces(p, first, sample, surfaces);
        else if (status == HTREE_OK)
            label_surfaces(p, surfaces);
        if (status != HTREE_OK) return status;
    }
    for (uint32_t i = 0; i < count; ++i) {
        /* Gamma 2: a square root rounds alike everywhere, a power need not. */
        const float scale = 1 / (float)args->spp;
        const colour c = {sqrtf(p->sum[i][0] * scale), sqrtf(p->sum[i][1] * scale),
                          sqrtf(p->sum[i][2] * scale)};
        const uint64_t pixel = first + i;
        picture_set(out, (int64_t)(pixel % args->width), (int64_t)(pixel / args->width), c);
    }
    return HTREE_OK;
}

static bool painter_start(painter *p, const shade_scene *scene) {
    const render_args *args = scene->args;
    const htree_box box = mesh_bounds(scene->mesh);
    memset(p, 0, sizeof *p);
    p->scene = scene;
    /* Some 20 per pixel make a smooth shadow; a single sample has to do with fewer. */
    p->ambient = args->spp < 4 ? 16 : 5;
    place_lamp(p, &box);
    const size_t rays = (size_t)BAND_PIXELS * (p->ambient + 1);
    p->rays = (htree_ray *)malloc(rays * sizeof *p->rays);
    p->blocked = (uint8_t *)malloc(rays);
    p->hits = (htree_hit *)malloc(BAND_PIXELS * sizeof *p->hits);
    p->surfaces = (seen *)malloc(BAND_PIXELS * sizeof *p->surfaces);
    p->sum = (float(*)[3])malloc(BAND_PIXELS * sizeof *p->sum);
    return p->rays && p->blocked && p->hits && p->surfaces && p->sum;
}

htree_status shade_picture(picture *out, const shade_scene *scene, progress *bar) {
    painter p;
    const uint64_t pixels = (uint64_t)scene->args->width * scene->args->height;
    htree_status status = painter_start(&p, scene) ? HTREE_OK : HTREE_ERROR_MEMORY;
    for (uint64_t first = 0; first < pixels && status == HTREE_OK; first += BAND_PIXELS) {
        const uint64_t left = pixels - first;
        progress_report(bar, (double)first / (double)pixels);
        status = paint_band(&p, out, first, left < BAND_PIXELS ? (uint32_t)left : BAND_PIXELS);
    }
    free(p.rays);
    free(p.blocked);
    free(p.hits);
    free(p.surfaces);
    free(p.sum);
    return status;
}
