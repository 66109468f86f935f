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
    "Measures rays a second over MESH (PLY; with assimp also OBJ, STL, glTF, ...) and built-in\n"
    "scenes, for three sets of rays: primary; ambient, any hit; diffuse, closest hit. Every\n"
    "contender gets the same rays, threads and cores, and its turn in every round; figures are\n"
    "medians over the rounds. The hits of all structures and devices must be equal.\n"
    "\n"
    "      --scene NAME[:N]    a built-in scene of about N triangles, or one of htree-table1's\n"
    "                          (bunny, conference, ...); may be repeated (default: knot, city)\n"
    "      --scenes DIR        where bunny.ply and the others are (default: $HTREE_SCENES)\n"
    "      --camera C          of MESH and built-in scenes: outside, inside, or\n"
    "                          ex,ey,ez,lx,ly,lz[,fov]; by default what suits the scene\n"
    "      --up x|y|z          which axis points up (default y)\n"
    "      --kind NAME,...     structures to measure (default wide,h,bvh-sah)\n"
    "      --device NAME       on an OpenCL device too: its index, part of its name, or default\n"
    "      --list-devices      print the OpenCL devices\n"
    "      --peer NAME,...     another ray tracer too: embree, embree-robust, and\n"
    "                          embree-packet: primary rays by 16, tiles of 4x4\n"
    "      --threads N         threads, 0 for all cores (default 0); PoCL takes as many\n"
    "      --size WxH          primary rays (default 1024x1024)\n"
    "      --tile N            primary rays go by tiles of NxN, 1: by rows (default 4)\n"
    "      --reach PERCENT     length of ambient rays, of the scene's diagonal (default 10)\n"
    "      --rounds N          (default 5)\n"
    "      --seconds S         for each contender and round, at least (default 0.2)\n"
    "      --seed N            of scenes and directions (default 1)\n"
    "      --json FILE         write the figures, an object per contender and set of rays\n"
    "  -q, --quiet             no progress bar\n"
    "  -h, --help   -V, --version\n"
    "\n"
    "  htree-bench bunny.ply\n"
    "  htree-bench --kind wide --device default --json bench.json bunny.ply\n"
    "  htree-bench --threads 1 --peer embree --camera inside conference.ply\n"
    "  htree-bench --scene soup:1000000 --kind ah,h --size 512x512 --rounds 3\n";

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
    OPTION_TILE,
    OPTION_REACH,
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
    {"tile", required_argument, NULL, OPTION_TILE},
    {"reach", required_argument, NULL, OPTION_REACH},
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
    return option_kind_add(program, "kind", name, out->kinds, &out->kind_count, DUEL_MAX_KINDS);
}

static bool take_peer(void *user, const char *name) {
    bench_args *out = (bench_args *)user;
    for (const char *const *known = peer_names(); *known; ++known) {
        if (strcmp(*known, name) != 0) continue;
        for (uint32_t i = 0; i < out->peer_count; ++i)
            if (out->peers[i] == *known) return true;
        out->peers[out->peer_count++] = *known;
        return true;
    }
    return option_wrong(program, "--peer %s: choose from embree embree-robust embree-packet", name);
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
    case OPTION_THREADS: return option_u32(program, "threads", value, 0, 256, &out->threads);
    case OPTION_SIZE: return option_size(program, value, &out->wish.width, &out->wish.height);
    case OPTION_TILE: return option_u32(program, "tile", value, 1, 1024, &out->wish.tile);
    case OPTION_REACH: return take_reach(out, value);
    case OPTION_ROUNDS:
        return option_u32(program, "rounds", value, 1, BENCH_MAX_ROUNDS, &out->rounds);
    case OPTION_SECONDS: return take_decimal("seconds", value, 3600, &out->seconds);
    case OPTION_SEED: return option_u32(program, "seed", value, 0, UINT32_MAX, &out->wish.seed);
    case OPTION_JSON: return out->json = value, true;
    default: return false;
    }
}

/* ---- What is left out ----------------------------------------------------------------------- */

static bench_args default_args(void) {
    bench_args args;
    memset(&args, 0, sizeof args);
    const char *folder = getenv("HTREE_SCENES");
    args.folder = folder && *folder ? folder : "scenes";
    args.wish.width = args.wish.height = 1024;
    args.wish.tile = 4;
    args.wish.seed = 1;
    args.wish.reach = 0.1;
    args.camera.up = 1;
    args.rounds = 5;
    args.seconds = 0.2;
    return args;
}

args_result bench_args_parse(bench_args *out, int argc, char **argv) {
    *out = default_args();
    const option_syntax syntax = {program, help, ":qhV", long_options};
    args_result result;
    for (int option; (option = option_next(&syntax, argc, argv, &result)) != -1;)
        if (!take_option(out, option, optarg)) return ARGS_WRONG;
    if (result != ARGS_RUN) return result;
    out->threads = option_threads(out->threads);
    for (; optind < argc; ++optind) {
        scene_wish *wish = next_scene(out);
        if (!wish) return ARGS_WRONG;
        wish->source = SCENE_MESH;
        wish->path = argv[optind];
    }
    if (!out->kind_count) option_list(program, "kind", "wide,h,bvh-sah", take_kind, out);
    if (!out->scene_count && (!take_scene(out, "knot") || !take_scene(out, "city")))
        return ARGS_WRONG;
    return ARGS_RUN;
}
