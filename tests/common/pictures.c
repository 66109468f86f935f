#include "pictures.h"

#include <math.h>

static void cross(const float *a, const float *b, float *out) {
    for (int i = 0; i < 3; ++i)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

picture picture_of(uint32_t width, uint32_t height, uint32_t more) {
    picture p = {width, height, more, (uint64_t)width * height + more, NULL};
    p.rays = (htree_ray *)take(p.count * sizeof *p.rays);
    return p;
}

/* Two directions across `forward`, a step of the picture long. */
static void make_steps(const float *forward, float step, float *right, float *down) {
    const float up[3] = {0.1f, 1, 0.2f};
    cross(forward, up, right);
    cross(forward, right, down);
    for (int i = 0; i < 3; ++i) {
        right[i] *= step;
        down[i] *= step;
    }
}

picture picture_pinhole(uint32_t width, uint32_t height, uint32_t more, const float *eye,
                        const float *forward, float step) {
    picture p = picture_of(width, height, more);
    float right[3], down[3];
    make_steps(forward, step, right, down);
    for (uint64_t i = 0; i < p.count; ++i) {
        const float x = (float)(i % width) - 0.5f * (float)(width - 1);
        const float y = (float)(i / width) - 0.5f * (float)(height - 1);
        htree_ray *ray = &p.rays[i];
        ray->tmin = 0;
        ray->tmax = INFINITY;
        for (int k = 0; k < 3; ++k) {
            ray->org[k] = eye[k];
            ray->dir[k] = forward[k] + x * right[k] + y * down[k];
        }
    }
    return p;
}

picture picture_parallel(uint32_t width, uint32_t height, const float *eye, const float *forward,
                         float step) {
    picture p = picture_pinhole(width, height, 0, eye, forward, step);
    for (uint64_t i = 0; i < p.count; ++i) {
        for (int k = 0; k < 3; ++k) {
            p.rays[i].org[k] += p.rays[i].dir[k] - forward[k];
            p.rays[i].dir[k] = forward[k];
        }
    }
    return p;
}

picture picture_shadows(const htree *tree, const picture *seen, const float *light) {
    picture p = picture_of(seen->width, seen->height, seen->more);
    for (uint64_t i = 0; i < p.count; ++i) {
        const htree_ray *ray = &seen->rays[i];
        htree_hit hit;
        assert_int_equal(htree_intersect(tree, ray, 1, &hit, NULL), HTREE_OK);
        const float t = hit.prim == HTREE_NONE ? 1 : 0.999f * hit.t;
        p.rays[i].tmin = 0;
        p.rays[i].tmax = 1;
        for (int k = 0; k < 3; ++k) {
            p.rays[i].org[k] = ray->org[k] + t * ray->dir[k];
            p.rays[i].dir[k] = light[k] - p.rays[i].org[k];
        }
    }
    return p;
}

void picture_view(const ray_target *target, dice *d, float *eye, float *forward) {
    random_unit(d, forward);
    for (int k = 0; k < 3; ++k) {
        const float middle = 0.5f * (target->box.lo[k] + target->box.hi[k]);
        eye[k] = middle - 1.5f * target->size * forward[k];
    }
}

void picture_cells(picture *p, uint32_t side) {
    const uint64_t seen = (uint64_t)p->width * p->height;
    htree_ray *const rows = p->rays, *to = (htree_ray *)take((size_t)(p->count + 1) * sizeof *to);
    p->rays = to;
    for (uint32_t top = 0; top < p->height; top += side)
        for (uint32_t left = 0; left < p->width; left += side)
            for (uint32_t y = top; y < top + side; ++y)
                for (uint32_t x = left; x < left + side; ++x)
                    *to++ = rows[(uint64_t)y * p->width + x];
    memcpy(to, rows + seen, (size_t)(p->count - seen) * sizeof *to);
    free(rows);
}

void picture_shuffle(picture *p, dice *d) {
    for (uint64_t i = p->count; i > 1; --i) {
        const uint64_t k = dice_below(d, (uint32_t)i);
        const htree_ray kept = p->rays[i - 1];
        p->rays[i - 1] = p->rays[k];
        p->rays[k] = kept;
    }
}

static const float odd_numbers[] = {NAN, INFINITY, -INFINITY, 0, -0.0f, 1e-30f, 1e30f, -1, 1, 2};

void picture_disturb(picture *p, dice *d) {
    for (uint64_t i = 0; i < p->count; ++i) {
        htree_ray *ray = &p->rays[i];
        const uint32_t what = dice_below(d, 200);
        const float odd = odd_numbers[dice_below(d, COUNT_OF(odd_numbers))];
        if (what < 3) ray->org[what] = odd;
        if (what >= 3 && what < 6) ray->dir[what - 3] = odd;
        if (what == 6) ray->tmin = odd;
        if (what == 7) ray->tmax = odd;
        if (what > 120) ray->tmin = dice_between(d, what == 121 ? -1 : 0, 1.5f);
        if (what > 160) ray->tmax = ray->tmin + dice_unit(d);
    }
}
