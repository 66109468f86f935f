/* shade.h: colours for hits. Light is a lamp with a hard shadow, and a sky that ambient occlusion
 * dims. */
#ifndef EXAMPLES_SHADE_H
#define EXAMPLES_SHADE_H

#include "args.h"
#include "picture.h"
#include "progress.h"
#include "tracer.h"

typedef struct shade_scene {
    tracer *by; /* answers every ray */
    const shape *mesh;
    const camera *view;
    const render_args *args;
} shade_scene;

/* Paints modes shaded, normals and prims with args->spp samples per pixel. Every random number is a
 * hash of pixel, sample and seed, so the bytes do not depend on threads, kind or exact device.
 * HTREE_ERROR_MEMORY may also be the painter's own. */
htree_status shade_picture(picture *out, const shade_scene *scene, progress *bar);

#endif
