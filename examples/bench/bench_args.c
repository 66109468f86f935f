#include "bench_args.h"

#include "decimal.h"
#include "option.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char program[] = "htree-bench";

static const char help[] =
    "usage: htree-bench [OPTION]... [MESH]...\n"
    "\n"
    "Measures builds and rays over MESH (PLY; with assimp also OBJ, STL, glTF, ...) and built-in\n"
    "scenes: builds into a new handle, into the memory of the one before, and by refitting; "
    "bytes;\n"
    "T_T, a build and one frame; rays a second: primary, ambient occlusion and shadow (any hit),\n"
    "diffuse. Every contender gets the same rays, threads and cores, and its turn in every round;\n"
    "figures are medians over the rounds. The hits of all structures and devices must be equal.\n"
    "\n"
    "      --scene NAME[:N]    a built-in scene of about N triangles, or one of htree-table1's\n"
    "                          (bunny, conference, ...); may be repeated (default: knot, city)\n"
    "      --scenes DIR        where bunny.ply and the others are (default: $HTREE_SCENES)\n"
    "      --camera C          of MESH and built-in scenes: outside, inside, or\n"
    "                          ex,ey,ez,lx,ly,lz[,fov]; by default what suits the scene\n"
    "      --up x|y|z          which axis points up (default y)\n"
    "      --kind NAME,...     structures and efforts; +lazy, +morton, +compact and\n"
    "                          +collapse after a name (default fast,balanced,best,fast+lazy,\n"
    "                          balanced+compact)\n"
    "      --device NAME       on an OpenCL device too: its index, part of its name, or default\n"
    "      --list-devices      print the OpenCL devices\n"
    "      --peer NAME,...     another ray tracer too, ray by ray and by packets of 16:\n"
    "                          embree[-low|-medium|-high|-refit][-robust][-compact]\n"
    "      --threads N,...     threads, 0 for all cores (default 0); PoCL takes as many\n"
    "      --size WxH          primary rays (default 1024x1024)\n"
    "      --frame N           T_T's frame is NxN rays (default 500)\n"
    "      --tile N            primary rays go by tiles of NxN, 1: by rows (default 4)\n"
    "      --ambient N         ambient rays for every hit of the frame (default 8)\n"
    "      --reach PERCENT     length of ambient rays, of the scene's diagonal (default 10)\n"
    "      --save-rays FILE    write the rays of the scene, for others to trace\n"
    "      --load-rays FILE    trace these instead\n"
    "      --rounds N          (default 5)\n"
    "      --seconds S         for each contender, set of rays and round, at least (default 0.2)\n"
    "      --seed N            of directions (default 1)\n"
    "      --json FILE         write the figures, an object per contender and scene\n"
    "  -q, --quiet             no progress bar\n"
    "  -h, --help   -V, --version\n"
    "\n"
    "  htree-bench bunny.ply\n"
    "  htree-bench --kind wide --device default --json bench.json bunny.ply\n"
    "  htree-bench --threads 1,2 --peer embree-low,embree-medium conference.ply\n"
    "  htree-bench --kind fast,fast+lazy --scene terrain:10000000 --rounds 7\n";

enum {
    OPTION_SCENE = 256,
    OPTION_SCENES,
    OPTION_CAMERA,
    OPTION_UP,
    OPTION_KIND,
    OPTION_DEVICE,
    OPTION_LIST_DEVICES,
    OPTION_PEER,
    OPTION_THREADS,
    OPTION_SIZE,
    OPTION_FRAME,
    OPTION_TILE,
    OPTION_AMBIENT,
    OPTION_REACH,
    OPTION_SAVE_RAYS,
    OPTION_LOAD_RAYS,
    OPTION_ROUNDS,
    OPTION_SECONDS,
    OPTION_SEED,
    OPTION_JSON
};

static const struct option long_options[] = {
    {"scene", required_argument, NULL, OPTION_SCENE},
    {"scenes", required_argument, NULL, OPTION_SCENES},
    {"camera", required_argument, NULL, OPTION_CAMERA},
    {"up", required_argument, NULL, OPTION_UP},
    {"kind", required_argument, NULL, OPTION_KIND},
    {"device", required_argument, NULL, OPTION_DEVICE},
    {"list-devices", no_argument, NULL, OPTION_LIST_DEVICES},
    {"peer", required_argument, NULL, OPTION_PEER},
    {"threads", required_argument, NULL, OPTION_THREADS},
    {"size", required_argument, NULL, OPTION_SIZE},
    {"frame", required_argument, NULL, OPTION_FRAME},
    {"tile", required_argument, NULL, OPTION_TILE},
    {"ambient", required_argument, NULL, OPTION_AMBIENT},
    {"reach", required_argument, NULL, OPTION_REACH},
    {"save-rays", required_argument, NULL, OPTION_SAVE_RAYS},
    {"load-rays", required_argument, NULL, OPTION_LOAD_RAYS},
    {"rounds", required_argument, NULL, OPTION_ROUNDS},
    {"seconds", required_argument, NULL, OPTION_SECONDS},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"json", required_argument, NULL, OPTION_JSON},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'V'},
    {NULL, 0, NULL, 0},
};

/* ---- Values --------------------------------------------------------------------------------- */

static scene_wish *next_scene(bench_args *out) {
    return bench_scene_next(program, out->scenes, &out->scene_count, BENCH_MAX_SCENES);
}

static bool take_scene(bench_args *out, const char *text) {
    return bench_scene_add(program, text, out->scenes, &out->scene_count, BENCH_MAX_SCENES);
}

static bool take_kind(void *user, const char *name) {
    bench_args *out = (bench_args *)user;
    tree_config config;
    if (!tree_config_read(program, &config, name)) return false;
    for (uint32_t i = 0; i < out->tree_count; ++i)
        if (strcmp(out->trees[i].name, config.name) == 0) return true;
    if (out->tree_count == DUEL_MAX_TREES)
        return option_wrong(program, "more than %d structures", DUEL_MAX_TREES);
    out->trees[out->tree_count++] = config;
    return true;
}

static bool take_peer(void *user, const char *name) {
    bench_args *out = (bench_args *)user;
    peer_config config;
    if (!peer_config_read(program, &config, name)) return false;
    for (uint32_t i = 0; i < out->peer_count; ++i)
        if (strcmp(out->peers[i].name, config.name) == 0) return true;
    if (out->peer_count == DUEL_MAX_PEERS)
        return option_wrong(program, "more than %d peers", DUEL_MAX_PEERS);
    out->peers[out->peer_count++] = config;
    return true;
}

static bool take_threads(void *user, const char *text) {
    bench_args *out = (bench_args *)user;
    uint32_t threads;
    if (!option_u32(program, "threads", text, 0, 256, &threads)) return false;
    threads = option_threads(threads);
    for (uint32_t i = 0; i < out->thread_count; ++i)
        if (out->threads[i] == threads) return true;
    if (out->thread_count == BENCH_MAX_THREADS)
        return option_wrong(program, "more than %d numbers of threads", BENCH_MAX_THREADS);
    out->threads[out->thread_count++] = threads;
    if (threads > out->most_threads) out->most_threads = threads;
    return true;
}

static bool take_decimal(const char *option, const char *text, double hi, double *value) {
    const char *end = text + strlen(text);
    if (decimal_parse(text, end, value) == end && *value >= 0 && *value <= hi) return true;
    return option_wrong(program, "--%s %s: give a number from 0 to %g", option, text, hi);
}

static bool take_up(bench_args *out, const char *text) {
    if (text[0] < 'x' || text[0] > 'z' || text[1])
        return option_wrong(program, "--up %s: give x, y or z", text);
    out->camera.up = text[0] - 'x';
    return out->has_camera = true;
}

static bool take_camera(bench_args *out, const char *text) {
    out->has_camera = true;
    return camera_parse(&out->camera, text) ||
           option_wrong(program, "--camera %s: give outside, inside or ex,ey,ez,lx,ly,lz[,fov]",
                        text);
}

static bool take_reach(bench_args *out, const char *text) {
    double percent;
    if (!take_decimal("reach", text, 1000, &percent)) return false;
    out->wish.reach = percent / 100;
    return true;
}

/* ---- Options -------------------------------------------------------------------------------- */

static bool take_ray_option(bench_args *out, int option, const char *value) {
    ray_wish *wish = &out->wish;
    switch (option) {
    case OPTION_SIZE: return option_size(program, value, &wish->width, &wish->height);
    case OPTION_FRAME: return option_u32(program, "frame", value, 1, 16384, &wish->frame);
    case OPTION_TILE: return option_u32(program, "tile", value, 1, 1024, &wish->tile);
    case OPTION_AMBIENT: return option_u32(program, "ambient", value, 1, 1024, &wish->ambient);
    case OPTION_REACH: return take_reach(out, value);
    case OPTION_SEED: return option_u32(program, "seed", value, 0, UINT32_MAX, &wish->seed);
    case OPTION_SAVE_RAYS: return option_output(program, "save-rays", value, &out->save_rays);
    case OPTION_LOAD_RAYS: return out->load_rays = value, true;
    default: return false;
    }
}

static bool take_option(bench_args *out, int option, const char *value) {
    switch (option) {
    case 'q': return out->quiet = true;
    case OPTION_SCENE: return take_scene(out, value);
    case OPTION_SCENES: return out->folder = value, true;
    case OPTION_CAMERA: return take_camera(out, value);
    case OPTION_UP: return take_up(out, value);
    case OPTION_KIND: return option_list(program, "kind", value, take_kind, out);
    case OPTION_DEVICE: return out->device = value, true;
    case OPTION_LIST_DEVICES: return out->list_devices = true;
    case OPTION_PEER: return option_list(program, "peer", value, take_peer, out);
    case OPTION_THREADS: return option_list(program, "threads", value, take_threads, out);
    case OPTION_ROUNDS:
        return option_u32(program, "rounds", value, 1, BENCH_MAX_ROUNDS, &out->rounds);
    case OPTION_SECONDS: return take_decimal("seconds", value, 3600, &out->seconds);
    case OPTION_JSON: return option_output(program, "json", value, &out->json);
    default: return take_ray_option(out, option, value);
    }
}

/* ---- What is left out ----------------------------------------------------------------------- */

static bench_args default_args(void) {
    bench_args args;
    memset(&args, 0, sizeof args);
    const char *folder = getenv("HTREE_SCENES");
    args.folder = folder && *folder ? folder : "scenes";
    args.wish.width = args.wish.height = 1024;
    args.wish.frame = 500;
    args.wish.tile = 4;
    args.wish.ambient = 8;
    args.wish.seed = 1;
    args.wish.reach = 0.1;
    args.camera.up = 1;
    args.rounds = 5;
    args.seconds = 0.2;
    return args;
}

/* What can be said only when all options are known. */
static bool complete(bench_args *out) {
    if (!out->thread_count) take_threads(out, "0");
    if (!out->tree_count)
        option_list(program, "kind", "fast,balanced,best,fast+lazy,balanced+compact", take_kind,
                    out);
    if (!out->scene_count && (!take_scene(out, "knot") || !take_scene(out, "city"))) return false;
    if (out->device && out->thread_count > 1)
        return option_wrong(program, "--device takes one number of --threads");
    if ((out->load_rays || out->save_rays) && out->scene_count > 1)
        return option_wrong(program, "--load-rays and --save-rays take one scene");
    return true;
}

args_result bench_args_parse(bench_args *out, int argc, char **argv) {
    *out = default_args();
    const option_syntax syntax = {program, help, ":qhV", long_options};
    args_result result;
    for (int option; (option = option_next(&syntax, argc, argv, &result)) != -1;)
        if (!take_option(out, option, optarg)) return ARGS_WRONG;
    if (result != ARGS_RUN) return result;
    for (; optind < argc; ++optind) {
        scene_wish *wish = next_scene(out);
        if (!wish) return ARGS_WRONG;
        wish->source = SCENE_MESH;
        wish->path = argv[optind];
    }
    return complete(out) ? ARGS_RUN : ARGS_WRONG;
}
