/* args.h: the command line of htree-render. */
#ifndef EXAMPLES_ARGS_H
#define EXAMPLES_ARGS_H

#include "camera.h"
#include "option.h"
#include "htree.h"

typedef enum render_mode {
    MODE_SHADED,
    MODE_NORMALS,
    MODE_DEPTH,
    MODE_PRIMS,
    MODE_STEPS,
    MODE_TESTS
} render_mode;

typedef struct render_args {
    const char *mesh_path; /* NULL: the built-in scene */
    char scene[32];
    uint64_t triangles;
    const char *output, *json; /* NULL: none */
    const char *device;        /* NULL: the CPU answers the rays */
    htree_kind kind;
    render_mode mode;
    uint32_t width, height, spp, threads, seed;
    double heat_max; /* 0: from the picture */
    camera_wish camera;
    bool stats, quiet, list_devices; /* list_devices: and nothing else */
} render_args;

/* ARGS_DONE: help, version or the list of scenes was asked for and is printed. ARGS_WRONG: a
 * line on stderr says what to do. The strings of *out point into argv. */
args_result args_parse(render_args *out, int argc, char **argv);

#endif
