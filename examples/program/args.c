/* args.c: options by getopt_long. Every number is checked here, so that the program behind can take
 * its arguments as they are. */
#include "args.h"

#include "option.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

static const char program[] = "htree-render";

static const char help[] =
    "usage: htree-render [OPTION]... [MESH]\n"
    "\n"
    "Renders MESH (PLY; with assimp also OBJ, STL, glTF, ...) or a built-in scene.\n"
    "\n"
    "  -o, --output FILE       picture to write (PNG); without it only rays are timed\n"
    "      --scene NAME[:N]    built-in scene of about N triangles (default knot)\n"
    "      --list-scenes       print the built-in scenes\n"
    "      --kind NAME         h, bvh-sah, ...: the structure to build (default h)\n"
    "      --mode MODE         shaded, normals, depth, prims; steps or tests for heat\n"
    "                          maps of nodes visited or triangles tested per ray\n"
    "      --heat-max N        value of the hottest colour (default: by picture)\n"
    "      --camera C          outside (default), inside, or ex,ey,ez,lx,ly,lz[,fov]:\n"
    "                          from e, looking at l, fov in degrees\n"
    "      --up x|y|z          which axis points up (default y)\n"
    "      --size WxH          pixels (default 500x500)\n"
    "      --spp N             samples per pixel (default 4)\n"
    "      --threads N         threads, 0 for all cores (default 0)\n"
    "      --device NAME       an OpenCL device traces every ray of the picture: its index, part\n"
    "                          of its name, or default, for the first GPU; counters (--stats,\n"
    "                          steps, tests) stay the CPU's, as devices do not count\n"
    "      --list-devices      print the OpenCL devices\n"
    "      --seed N            of built-in scenes and of sampling (default 1)\n"
    "      --json FILE         write the figures of --stats as one JSON object\n"
    "      --stats             print figures of the tree and its rays\n"
    "  -q, --quiet             print errors only\n"
    "  -h, --help   -V, --version\n"
    "\n"
    "  htree-render bunny.ply -o bunny.png --stats\n"
    "  htree-render --scene city --mode steps -o heat.png\n"
    "  htree-render house.obj --camera inside --size 1280x720 --spp 16 -o house.png\n"
    "  htree-render bunny.ply --device default --stats\n";

enum {
    OPTION_SCENE = 256,
    OPTION_LIST,
    OPTION_KIND,
    OPTION_MODE,
    OPTION_HEAT_MAX,
    OPTION_CAMERA,
    OPTION_UP,
    OPTION_SIZE,
    OPTION_SPP,
    OPTION_THREADS,
    OPTION_DEVICE,
    OPTION_LIST_DEVICES,
    OPTION_SEED,
    OPTION_JSON,
    OPTION_STATS
};

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"scene", required_argument, NULL, OPTION_SCENE},
    {"list-scenes", no_argument, NULL, OPTION_LIST},
    {"kind", required_argument, NULL, OPTION_KIND},
    {"mode", required_argument, NULL, OPTION_MODE},
    {"heat-max", required_argument, NULL, OPTION_HEAT_MAX},
    {"camera", required_argument, NULL, OPTION_CAMERA},
    {"up", required_argument, NULL, OPTION_UP},
    {"size", required_argument, NULL, OPTION_SIZE},
    {"spp", required_argument, NULL, OPTION_SPP},
    {"threads", required_argument, NULL, OPTION_THREADS},
    {"device", required_argument, NULL, OPTION_DEVICE},
    {"list-devices", no_argument, NULL, OPTION_LIST_DEVICES},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"json", required_argument, NULL, OPTION_JSON},
    {"stats", no_argument, NULL, OPTION_STATS},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'V'},
    {NULL, 0, NULL, 0},
};

/* ---- Values --------------------------------------------------------------------------------- */

static bool parse_mode(render_args *out, const char *text) {
    static const char *const names[] = {"shaded", "normals", "depth", "prims", "steps", "tests"};
    for (int i = 0; i < 6; ++i)
        if (strcmp(text, names[i]) == 0) return out->mode = (render_mode)i, true;
    return option_wrong(program, "--mode %s: choose from shaded normals depth prims steps tests",
                        text);
}

static bool parse_heat_max(render_args *out, const char *text) {
    uint64_t value;
    if (!option_number(text, 0, 1, UINT32_MAX, &value))
        return option_wrong(program, "--heat-max %s: give a whole number of at least 1", text);
    out->heat_max = (double)value;
    return true;
}

static bool parse_up(render_args *out, const char *text) {
    if (text[0] < 'x' || text[0] > 'z' || text[1])
        return option_wrong(program, "--up %s: give x, y or z", text);
    out->camera.up = text[0] - 'x';
    return true;
}

/* ---- Options -------------------------------------------------------------------------------- */

static void list_scenes(void) {
    for (const char *const *name = shape_names(); *name; ++name)
        printf("%-8s %7llu  %s\n", *name, (unsigned long long)shape_default_triangles(*name),
               shape_text(*name));
}

static bool take_option(render_args *out, int option, const char *value) {
    switch (option) {
    case 'o': return option_output(program, "output", value, &out->output);
    case 'q': return out->quiet = true;
    case OPTION_JSON: return option_output(program, "json", value, &out->json);
    case OPTION_STATS: return out->stats = true;
    case OPTION_DEVICE: return out->device = value, true;
    case OPTION_LIST_DEVICES: return out->list_devices = true;
    case OPTION_SCENE: return option_scene(program, value, out->scene, &out->triangles);
    case OPTION_KIND: return option_kind(program, "kind", value, &out->kind);
    case OPTION_MODE: return parse_mode(out, value);
    case OPTION_HEAT_MAX: return parse_heat_max(out, value);
    case OPTION_UP: return parse_up(out, value);
    case OPTION_SIZE: return option_size(program, value, &out->width, &out->height);
    case OPTION_SPP: return option_u32(program, "spp", value, 1, 4096, &out->spp);
    case OPTION_THREADS: return option_u32(program, "threads", value, 0, 1024, &out->threads);
    case OPTION_SEED: return option_u32(program, "seed", value, 0, UINT32_MAX, &out->seed);
    case OPTION_CAMERA:
        return camera_parse(&out->camera, value) ||
               option_wrong(program, "--camera %s: give outside, inside or ex,ey,ez,lx,ly,lz[,fov]",
                            value);
    default: return false;
    }
}

static render_args default_args(void) {
    render_args args;
    memset(&args, 0, sizeof args);
    option_shape("knot", args.scene, &args.triangles);
    args.kind = HTREE_H;
    args.width = args.height = 500;
    args.spp = 4;
    args.seed = 1;
    args.camera.up = 1;
    return args;
}

args_result args_parse(render_args *out, int argc, char **argv) {
    bool scene = false;
    *out = default_args();
    const option_syntax syntax = {program, help, ":o:qhV", long_options};
    args_result result;
    for (int option; (option = option_next(&syntax, argc, argv, &result)) != -1;) {
        if (option == OPTION_LIST) return list_scenes(), ARGS_DONE;
        if (!take_option(out, option, optarg)) return ARGS_WRONG;
        scene = scene || option == OPTION_SCENE;
    }
    if (result != ARGS_RUN) return result;
    out->threads = option_threads(out->threads);
    return option_one_mesh(program, argc, argv, scene, &out->mesh_path) ? ARGS_RUN : ARGS_WRONG;
}
