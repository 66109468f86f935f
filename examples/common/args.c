/* args.c: options by getopt_long. Every number is checked here, so that the program behind can take
 * its arguments as they are. */
#include "args.h"

#include <errno.h>
#include <getopt.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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
    "      --seed N            of built-in scenes and of sampling (default 1)\n"
    "      --json FILE         write the figures of --stats as one JSON object\n"
    "      --stats             print figures of the tree and its rays\n"
    "  -q, --quiet             print errors only\n"
    "  -h, --help   -V, --version\n"
    "\n"
    "  htree-render bunny.ply -o bunny.png --stats\n"
    "  htree-render --scene city --mode steps -o heat.png\n"
    "  htree-render house.obj --camera inside --size 1280x720 --spp 16 -o house.png\n";

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
    {"seed", required_argument, NULL, OPTION_SEED},
    {"json", required_argument, NULL, OPTION_JSON},
    {"stats", no_argument, NULL, OPTION_STATS},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'V'},
    {NULL, 0, NULL, 0},
};

/* ---- Values ----------------------------------------------------------------------------------- */

static bool wrong(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("htree-render: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    return false;
}

/* Reads digits up to `end`'s character; strtoull alone would take signs and blanks. */
static bool parse_number(const char *text, char stop, uint64_t lo, uint64_t hi, uint64_t *value) {
    char *end = NULL;
    if (*text < '0' || *text > '9') return false;
    errno = 0;
    *value = strtoull(text, &end, 10);
    return errno == 0 && *end == stop && *value >= lo && *value <= hi;
}

static bool parse_u32(const char *option, const char *text, uint64_t lo, uint64_t hi,
                      uint32_t *value) {
    uint64_t number;
    if (!parse_number(text, 0, lo, hi, &number))
        return wrong("--%s %s: give a whole number from %llu to %llu", option, text,
                     (unsigned long long)lo, (unsigned long long)hi);
    *value = (uint32_t)number;
    return true;
}

static bool parse_size(render_args *out, const char *text) {
    uint64_t width, height;
    const char *x = strchr(text, 'x');
    if (!x || !parse_number(text, 'x', 1, 16384, &width) ||
        !parse_number(x + 1, 0, 1, 16384, &height))
        return wrong("--size %s: give WIDTHxHEIGHT, each from 1 to 16384, such as 640x480", text);
    out->width = (uint32_t)width;
    out->height = (uint32_t)height;
    return true;
}

static bool parse_scene(render_args *out, const char *text) {
    const size_t length = strcspn(text, ":");
    snprintf(out->scene, sizeof out->scene, "%.*s", (int)(length < 31 ? length : 31), text);
    if (!shape_text(out->scene))
        return wrong("--scene %s: no such scene; --list-scenes prints them", text);
    out->triangles = shape_default_triangles(out->scene);
    if (text[length] && !parse_number(text + length + 1, 0, 0, 1 << 30, &out->triangles))
        return wrong("--scene %s: after ':' give a number of triangles up to 2^30", text);
    return true;
}

static bool parse_kind(render_args *out, const char *text) {
    char known[128] = "";
    out->kind = htree_kind_from_name(text);
    if (out->kind) return true;
    for (htree_kind kind = 1; htree_kind_name(kind); ++kind) {
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, " %s", htree_kind_name(kind));
    }
    return wrong("--kind %s: no such structure; choose from%s", text, known);
}

static bool parse_mode(render_args *out, const char *text) {
    static const char *const names[] = {"shaded", "normals", "depth", "prims", "steps", "tests"};
    for (int i = 0; i < 6; ++i)
        if (strcmp(text, names[i]) == 0) return out->mode = (render_mode)i, true;
    return wrong("--mode %s: choose from shaded normals depth prims steps tests", text);
}

static bool parse_heat_max(render_args *out, const char *text) {
    uint64_t value;
    if (!parse_number(text, 0, 1, UINT32_MAX, &value))
        return wrong("--heat-max %s: give a whole number of at least 1", text);
    out->heat_max = (double)value;
    return true;
}

static bool parse_up(render_args *out, const char *text) {
    if (text[0] < 'x' || text[0] > 'z' || text[1]) return wrong("--up %s: give x, y or z", text);
    out->camera.up = text[0] - 'x';
    return true;
}

/* ---- Options ---------------------------------------------------------------------------------- */

static void list_scenes(void) {
    for (const char *const *name = shape_names(); *name; ++name)
        printf("%-8s %7llu  %s\n", *name, (unsigned long long)shape_default_triangles(*name),
               shape_text(*name));
}

static bool take_option(render_args *out, int option, const char *value) {
    switch (option) {
    case 'o': return out->output = value, true;
    case 'q': return out->quiet = true;
    case OPTION_JSON: return out->json = value, true;
    case OPTION_STATS: return out->stats = true;
    case OPTION_SCENE: return parse_scene(out, value);
    case OPTION_KIND: return parse_kind(out, value);
    case OPTION_MODE: return parse_mode(out, value);
    case OPTION_HEAT_MAX: return parse_heat_max(out, value);
    case OPTION_UP: return parse_up(out, value);
    case OPTION_SIZE: return parse_size(out, value);
    case OPTION_SPP: return parse_u32("spp", value, 1, 4096, &out->spp);
    case OPTION_THREADS: return parse_u32("threads", value, 0, 1024, &out->threads);
    case OPTION_SEED: return parse_u32("seed", value, 0, UINT32_MAX, &out->seed);
    case OPTION_CAMERA:
        return camera_parse(&out->camera, value) ||
               wrong("--camera %s: give outside, inside or ex,ey,ez,lx,ly,lz[,fov]", value);
    default: return false;
    }
}

static render_args default_args(void) {
    render_args args;
    memset(&args, 0, sizeof args);
    parse_scene(&args, "knot");
    args.kind = HTREE_H;
    args.width = args.height = 500;
    args.spp = 4;
    args.seed = 1;
    args.camera.up = 1;
    return args;
}

/* 0 is for all cores; the figures name the number that this comes to. */
static uint32_t resolve_threads(uint32_t threads) {
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    return threads ? threads : cores > 0 ? (uint32_t)cores : 1;
}

/* getopt names a short option by its letter, and leaves a long one at the word before optind. */
static void complain(int option, char **argv) {
    const char letter[3] = {'-', (char)optopt, 0};
    const bool is_short = optopt > 0 && optopt < OPTION_SCENE && argv[optind - 1][1] != '-';
    wrong(option == ':' ? "option %s needs a value; see --help" : "unknown option %s; see --help",
          is_short ? letter : argv[optind - 1]);
}

args_result args_parse(render_args *out, int argc, char **argv) {
    bool scene = false;
    *out = default_args();
    opterr = 0;
    for (;;) {
        const int option = getopt_long(argc, argv, ":o:qhV", long_options, NULL);
        if (option == -1) break;
        if (option == 'h') return fputs(help, stdout), ARGS_DONE;
        if (option == OPTION_LIST) return list_scenes(), ARGS_DONE;
        if (option == 'V') {
            printf("htree-render %d.%d.%d\n", HTREE_VERSION_MAJOR, HTREE_VERSION_MINOR,
                   HTREE_VERSION_PATCH);
            return ARGS_DONE;
        }
        if (option == ':' || option == '?') return complain(option, argv), ARGS_WRONG;
        if (!take_option(out, option, optarg)) return ARGS_WRONG;
        scene = scene || option == OPTION_SCENE;
    }
    out->threads = resolve_threads(out->threads);
    if (optind < argc) out->mesh_path = argv[optind];
    if (argc - optind > 1)
        return wrong("one mesh at a time, not '%s' too", argv[optind + 1]), ARGS_WRONG;
    if (out->mesh_path && scene) return wrong("give a mesh or --scene, not both"), ARGS_WRONG;
    return ARGS_RUN;
}
