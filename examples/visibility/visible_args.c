/* visible_args.c: options by getopt_long. */
#include "visible_args.h"

#include "decimal.h"
#include "option.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char program[] = "htree-visibility";

static const char help[] =
    "usage: htree-visibility [OPTION]... [MESH]\n"
    "\n"
    "Finds the triangles that can be seen from anywhere in a box, the view cell, by sampled\n"
    "lines: preprocessing for occlusion culling. Prints how the number found grows with the\n"
    "number of lines; then sends segments to the triangles that no line has hit.\n"
    "\n"
    "      --cell x,y,z,X,Y,Z  the view cell, by two corners (default: a small cube where\n"
    "                          much is seen; with --camera inside, around the camera)\n"
    "      --lines N           random lines from the cell (default 4194304)\n"
    "      --segments K        segments to each triangle that is not seen yet (default 16)\n"
    "  -o, --output FILE       picture (PNG): seen triangles orange, those found by segments\n"
    "                          alone blue, unseen ones grey; the cell as a wire frame\n"
    "      --scene NAME[:N]    built-in scene of about N triangles (default city)\n"
    "      --kind NAME         h, bvh-sah, ...: the structure (default h)\n"
    "      --camera C          outside (default), inside, or ex,ey,ez,lx,ly,lz[,fov]\n"
    "      --up x|y|z          which axis points up (default y)\n"
    "      --size WxH          pixels (default 800x600)\n"
    "      --threads N         threads, 0 for all cores (default 0)\n"
    "      --seed N            of the scene and the lines (default 1)\n"
    "  -q, --quiet             print the last figures only\n"
    "  -h, --help   -V, --version\n"
    "\n"
    "  htree-visibility -o city.png\n"
    "  htree-visibility house.ply --camera inside --lines 1000000 -o house.png\n"
    "  htree-visibility --scene crowd --cell -1,0.5,-1,1,1.5,1 --segments 64\n";

enum {
    OPTION_CELL = 256,
    OPTION_LINES,
    OPTION_SEGMENTS,
    OPTION_SCENE,
    OPTION_KIND,
    OPTION_CAMERA,
    OPTION_UP,
    OPTION_SIZE,
    OPTION_THREADS,
    OPTION_SEED
};

static const struct option long_options[] = {
    {"cell", required_argument, NULL, OPTION_CELL},
    {"lines", required_argument, NULL, OPTION_LINES},
    {"segments", required_argument, NULL, OPTION_SEGMENTS},
    {"output", required_argument, NULL, 'o'},
    {"scene", required_argument, NULL, OPTION_SCENE},
    {"kind", required_argument, NULL, OPTION_KIND},
    {"camera", required_argument, NULL, OPTION_CAMERA},
    {"up", required_argument, NULL, OPTION_UP},
    {"size", required_argument, NULL, OPTION_SIZE},
    {"threads", required_argument, NULL, OPTION_THREADS},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'V'},
    {NULL, 0, NULL, 0},
};

static bool read_cell(htree_box *cell, const char *text) {
    const char *end = text + strlen(text);
    for (int i = 0; i < 6; ++i) {
        double number;
        const char *next = decimal_parse(text, end, &number);
        if (!next || !(fabs(number) < 1e18) || *next != (i < 5 ? ',' : 0)) return false;
        (i < 3 ? cell->lo : cell->hi)[i % 3] = (float)number;
        text = next + 1;
    }
    return cell->lo[0] <= cell->hi[0] && cell->lo[1] <= cell->hi[1] && cell->lo[2] <= cell->hi[2];
}

static bool take_cell(visible_args *out, const char *text) {
    out->cell_given = true;
    return read_cell(&out->cell, text) ||
           option_wrong(program, "--cell %s: give x,y,z,X,Y,Z with x <= X, y <= Y, z <= Z", text);
}

static bool take_lines(visible_args *out, const char *text) {
    return option_number(text, 0, 1, UINT64_C(1) << 40, &out->lines) ||
           option_wrong(program, "--lines %s: give a whole number from 1 to 2^40", text);
}

static bool take_up(visible_args *out, const char *text) {
    if (text[0] < 'x' || text[0] > 'z' || text[1])
        return option_wrong(program, "--up %s: give x, y or z", text);
    out->camera.up = text[0] - 'x';
    return true;
}

static bool take_option(visible_args *out, int option, const char *value) {
    switch (option) {
    case 'o': return option_output(program, "output", value, &out->output);
    case 'q': return out->quiet = true;
    case OPTION_CELL: return take_cell(out, value);
    case OPTION_LINES: return take_lines(out, value);
    case OPTION_SEGMENTS: return option_u32(program, "segments", value, 0, 4096, &out->segments);
    case OPTION_UP: return take_up(out, value);
    case OPTION_SIZE: return option_size(program, value, &out->width, &out->height);
    case OPTION_THREADS: return option_u32(program, "threads", value, 0, 1024, &out->threads);
    case OPTION_SEED: return option_u32(program, "seed", value, 0, UINT32_MAX, &out->seed);
    case OPTION_SCENE: return option_scene(program, value, out->scene, &out->triangles);
    case OPTION_KIND: return option_kind(program, "kind", value, &out->kind);
    case OPTION_CAMERA:
        return camera_parse(&out->camera, value) ||
               option_wrong(program, "--camera %s: give outside, inside or ex,ey,ez,lx,ly,lz[,fov]",
                            value);
    default: return false;
    }
}

static visible_args default_args(void) {
    visible_args args;
    memset(&args, 0, sizeof args);
    option_shape("city", args.scene, &args.triangles);
    args.kind = HTREE_H;
    args.lines = UINT64_C(1) << 22;
    args.segments = 16;
    args.width = 800;
    args.height = 600;
    args.seed = 1;
    args.camera.up = 1;
    return args;
}

args_result visible_args_parse(visible_args *out, int argc, char **argv) {
    bool scene = false;
    *out = default_args();
    const option_syntax syntax = {program, help, ":o:qhV", long_options};
    args_result result;
    for (int option; (option = option_next(&syntax, argc, argv, &result)) != -1;) {
        if (!take_option(out, option, optarg)) return ARGS_WRONG;
        scene = scene || option == OPTION_SCENE;
    }
    if (result != ARGS_RUN) return result;
    out->threads = option_threads(out->threads);
    return option_one_mesh(program, argc, argv, scene, &out->mesh_path) ? ARGS_RUN : ARGS_WRONG;
}
