/* table1_args.c: options by getopt_long; what is left out is filled in at the end, because it
 * depends on the mode. */
#include "table1_args.h"

#include "measure.h"
#include "option.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "htree-table1";

static const char help[] =
    "usage: htree-table1 [OPTION]... [MESH]...\n"
    "\n"
    "Builds and traces every structure over every scene, in the layout of Table 1 of\n"
    "\"On the Fast Construction of Spatial Hierarchies for Ray Tracing\" (2006), with the\n"
    "paper's own figures below ours. Without MESH and --scene: the paper's static scenes\n"
    "and their stand-ins.\n"
    "\n"
    "      --scenes DIR        where bunny.ply and the others are (default: $HTREE_SCENES,\n"
    "                          else ./scenes); built-in scenes take the place of missing ones\n"
    "      --scene NAME[:N]    one of the table's (bunny, conference, ...) or a built-in scene\n"
    "                          (knot, city, ...) of about N triangles; may be repeated\n"
    "      --subdivide K       levels of Loop subdivision for MESH (default 0)\n"
    "      --camera C          for MESH and built-in scenes: outside, inside, or\n"
    "                          ex,ey,ez,lx,ly,lz[,fov]\n"
    "      --method NAME,...   of kd ug bvh-median bvh-sah skd h ah (default: all)\n"
    "      --repeat N          builds and frames to take medians of (default 3)\n"
    "      --threads N         threads, 0 for all cores (default 1)\n"
    "      --size WxH          pixels (default 500x500)\n"
    "      --json FILE   --csv FILE\n"
    "      --quick             bunny and a crowd only\n"
    "      --growth NAME,...   instead: times to build these built-in scenes against size,\n"
    "                          --from N --to N triangles (default 10000 to 10000000), until\n"
    "                          a build takes more than --patience SECONDS (default 4)\n"
    "      --precision         instead: H-trees by buckets and AH-trees by cells\n"
    "  -q, --quiet   -h, --help   -V, --version\n"
    "\n"
    "  htree-table1 --scenes ~/meshes --json table1.json\n"
    "  htree-table1 --method kd,h,ah --repeat 5 dragon.ply buddha.ply\n"
    "  htree-table1 --growth soup,waves --to 1000000 > growth.dat\n";

enum {
    OPTION_SCENES = 256,
    OPTION_SCENE,
    OPTION_SUBDIVIDE,
    OPTION_CAMERA,
    OPTION_METHOD,
    OPTION_REPEAT,
    OPTION_THREADS,
    OPTION_SIZE,
    OPTION_JSON,
    OPTION_CSV,
    OPTION_QUICK,
    OPTION_GROWTH,
    OPTION_FROM,
    OPTION_TO,
    OPTION_PATIENCE,
    OPTION_PRECISION
};

static const struct option long_options[] = {
    {"scenes", required_argument, NULL, OPTION_SCENES},
    {"scene", required_argument, NULL, OPTION_SCENE},
    {"subdivide", required_argument, NULL, OPTION_SUBDIVIDE},
    {"camera", required_argument, NULL, OPTION_CAMERA},
    {"method", required_argument, NULL, OPTION_METHOD},
    {"repeat", required_argument, NULL, OPTION_REPEAT},
    {"threads", required_argument, NULL, OPTION_THREADS},
    {"size", required_argument, NULL, OPTION_SIZE},
    {"json", required_argument, NULL, OPTION_JSON},
    {"csv", required_argument, NULL, OPTION_CSV},
    {"quick", no_argument, NULL, OPTION_QUICK},
    {"growth", required_argument, NULL, OPTION_GROWTH},
    {"from", required_argument, NULL, OPTION_FROM},
    {"to", required_argument, NULL, OPTION_TO},
    {"patience", required_argument, NULL, OPTION_PATIENCE},
    {"precision", no_argument, NULL, OPTION_PRECISION},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'V'},
    {NULL, 0, NULL, 0},
};

/* ---- Values --------------------------------------------------------------------------------- */

static scene_wish *next_scene(table1_args *out) {
    return bench_scene_next(program, out->scenes, &out->scene_count, TABLE1_MAX_SCENES);
}

static bool take_scene(table1_args *out, const char *text) {
    return bench_scene_add(program, text, out->scenes, &out->scene_count, TABLE1_MAX_SCENES);
}

static bool take_growth_scene(void *user, const char *name) {
    scene_wish *wish = next_scene((table1_args *)user);
    if (!wish) return false;
    return (bench_scene_parse(wish, name) && wish->source == SCENE_SHAPE && !strchr(name, ':')) ||
           option_wrong(program, "--growth %s: no such built-in scene, such as soup or waves",
                        name);
}

static bool take_method(void *user, const char *name) {
    table1_args *out = (table1_args *)user;
    return option_kind_add(program, "method", name, out->kinds, &out->kind_count, TABLE1_MAX_KINDS);
}

static bool take_triangles(const char *option, const char *text, uint64_t *value) {
    return option_number(text, 0, 1, 1 << 28, value) ||
           option_wrong(program, "--%s %s: give a number of triangles up to 2^28", option, text);
}

static bool take_option(table1_args *out, int option, const char *value) {
    switch (option) {
    case 'q': return out->quiet = true;
    case OPTION_SCENES: return out->folder = value, true;
    case OPTION_SCENE: return take_scene(out, value);
    case OPTION_SUBDIVIDE: return option_u32(program, "subdivide", value, 0, 8, &out->levels);
    case OPTION_METHOD: return option_list(program, "method", value, take_method, out);
    case OPTION_REPEAT:
        return option_u32(program, "repeat", value, 1, MEASURE_MAX_REPEAT, &out->repeat);
    case OPTION_THREADS: return option_u32(program, "threads", value, 0, 1024, &out->threads);
    case OPTION_SIZE: return option_size(program, value, &out->width, &out->height);
    case OPTION_JSON: return option_output(program, "json", value, &out->json);
    case OPTION_CSV: return option_output(program, "csv", value, &out->csv);
    case OPTION_QUICK: return take_scene(out, "bunny") && take_scene(out, "crowd:100000");
    case OPTION_GROWTH:
        out->mode = TABLE1_GROWTH;
        return option_list(program, "growth", value, take_growth_scene, out);
    case OPTION_FROM: return take_triangles("from", value, &out->from);
    case OPTION_TO: return take_triangles("to", value, &out->to);
    case OPTION_PATIENCE: return option_u32(program, "patience", value, 1, 3600, &out->patience);
    case OPTION_PRECISION: return out->mode = TABLE1_PRECISION, true;
    case OPTION_CAMERA:
        return camera_parse(&out->camera, value) ||
               option_wrong(program, "--camera %s: give outside, inside or ex,ey,ez,lx,ly,lz[,fov]",
                            value);
    default: return false;
    }
}

/* ---- What is left out ----------------------------------------------------------------------- */

static table1_args default_args(void) {
    table1_args args;
    memset(&args, 0, sizeof args);
    const char *folder = getenv("HTREE_SCENES");
    args.folder = folder && *folder ? folder : "scenes";
    args.from = 10000;
    args.to = 10000000;
    args.patience = 4;
    args.width = args.height = 500;
    args.threads = 1;
    args.repeat = 3;
    args.camera.up = 1;
    return args;
}

static bool fill_in(table1_args *out) {
    static const htree_kind order[] = {HTREE_KD,  HTREE_UG, HTREE_BVH_MEDIAN, HTREE_BVH_SAH,
                                       HTREE_SKD, HTREE_H,  HTREE_AH};
    enum { COUNT = sizeof order / sizeof *order };
    if (!out->kind_count) {
        memcpy(out->kinds, order, sizeof order);
        out->kind_count = COUNT;
    }
    if (!out->scene_count && out->mode == TABLE1_PRECISION)
        return take_scene(out, "bunny") && take_scene(out, "conference");
    if (out->scene_count) return true;
    for (uint32_t i = 0; bench_scene_name(i); ++i)
        if (!take_scene(out, bench_scene_name(i))) return false;
    return true;
}

static bool check(const table1_args *out) {
    if (out->mode != TABLE1_TABLE && (out->json || out->csv))
        return option_wrong(program, "--json and --csv are for the table; the studies print data");
    if (out->mode == TABLE1_GROWTH && out->from > out->to)
        return option_wrong(program, "--from is greater than --to");
    for (uint32_t i = 0; out->mode == TABLE1_GROWTH && i < out->scene_count; ++i)
        if (out->scenes[i].source != SCENE_SHAPE)
            return option_wrong(program, "--growth makes its own scenes; leave out the others");
    return true;
}

args_result table1_args_parse(table1_args *out, int argc, char **argv) {
    *out = default_args();
    const option_syntax syntax = {program, help, ":qhV", long_options};
    args_result result;
    for (int option; (option = option_next(&syntax, argc, argv, &result)) != -1;) {
        if (!take_option(out, option, optarg)) return ARGS_WRONG;
    }
    if (result != ARGS_RUN) return result;
    out->threads = option_threads(out->threads);
    for (; optind < argc; ++optind) {
        scene_wish *wish = next_scene(out);
        if (!wish) return ARGS_WRONG;
        wish->source = SCENE_MESH;
        wish->path = argv[optind];
    }
    return fill_in(out) && check(out) ? ARGS_RUN : ARGS_WRONG;
}
