/* anim_args.c: options by getopt_long; every value is checked before the film is opened. */
#include "anim_args.h"

#include "decimal.h"
#include "option.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char program[] = "htree-animate";

static const char help[] =
    "usage: htree-animate [OPTION]... SCENE\n"
    "Builds the tree anew for every frame of SCENE, traces one ray per pixel, and prints\n"
    "what that cost on average. SCENE is an AFF file (as BART's), or crowd, explode or\n"
    "cloth, with an optional :TRIANGLES.\n"
    "\n"
    "  --kind KIND        ug kd bvh-median bvh-sah skd h ah wide, fast balanced best [h]\n"
    "  --lazy             wide and the presets: build only what rays reach\n"
    "  --frames N         N frames, evenly spaced in time [as many as the scene says]\n"
    "  --from S, --to S   the range of time in seconds [as the scene says]\n"
    "  --every N          of these frames only every N-th [1]\n"
    "  --size WxH         pixels [400x300]\n"
    "  --threads N        for building and tracing, 0 for all cores [1]\n"
    "  --pipeline         also build frame n+1 on one core while another traces frame n\n"
    "  --check            compare every 37th pixel with a test of all triangles\n"
    "  --mesh FILE        the mesh that explodes\n"
    "  --split N          AFF: split animated triangles 4-way N times [0]\n"
    "  --keep-coincident  AFF: keep triangles with two corners in one place\n"
    "  -o, --output PNG   pictures, such as frame%04d.png\n"
    "  --webp FILE        an animated picture\n"
    "  --spp N            samples per pixel of pictures: 1, 4, 9, ... [4]\n"
    "  --json FILE        the figures, of all frames and of each\n"
    "  --stats            the averages as a list, with what they mean\n"
    "  -q, --quiet        print nothing but errors\n"
    "\n"
    "  htree-animate crowd --webp crowd.webp\n"
    "  htree-animate kitchen.aff --kind ah --frames 20 --check -o kitchen%02d.png\n"
    "  htree-animate museum5.aff --split 3 --pipeline --stats\n";

enum {
    OPTION_KIND = 256,
    OPTION_LAZY,
    OPTION_FRAMES,
    OPTION_FROM,
    OPTION_TO,
    OPTION_EVERY,
    OPTION_SIZE,
    OPTION_THREADS,
    OPTION_PIPELINE,
    OPTION_CHECK,
    OPTION_MESH,
    OPTION_SPLIT,
    OPTION_KEEP,
    OPTION_WEBP,
    OPTION_SPP,
    OPTION_JSON,
    OPTION_STATS
};

static const struct option long_options[] = {{"kind", required_argument, NULL, OPTION_KIND},
                                             {"lazy", no_argument, NULL, OPTION_LAZY},
                                             {"frames", required_argument, NULL, OPTION_FRAMES},
                                             {"from", required_argument, NULL, OPTION_FROM},
                                             {"to", required_argument, NULL, OPTION_TO},
                                             {"every", required_argument, NULL, OPTION_EVERY},
                                             {"size", required_argument, NULL, OPTION_SIZE},
                                             {"threads", required_argument, NULL, OPTION_THREADS},
                                             {"pipeline", no_argument, NULL, OPTION_PIPELINE},
                                             {"check", no_argument, NULL, OPTION_CHECK},
                                             {"mesh", required_argument, NULL, OPTION_MESH},
                                             {"split", required_argument, NULL, OPTION_SPLIT},
                                             {"keep-coincident", no_argument, NULL, OPTION_KEEP},
                                             {"output", required_argument, NULL, 'o'},
                                             {"webp", required_argument, NULL, OPTION_WEBP},
                                             {"spp", required_argument, NULL, OPTION_SPP},
                                             {"json", required_argument, NULL, OPTION_JSON},
                                             {"stats", no_argument, NULL, OPTION_STATS},
                                             {"quiet", no_argument, NULL, 'q'},
                                             {"help", no_argument, NULL, 'h'},
                                             {"version", no_argument, NULL, 'V'},
                                             {NULL, 0, NULL, 0}};

/* ---- Values --------------------------------------------------------------------------------- */

static bool parse_time(const char *option, const char *text, bool *given, double *out) {
    const char *end = text + strlen(text);
    *given = true;
    return (decimal_parse(text, end, out) == end && *text && fabs(*out) <= 1e9) ||
           option_wrong(program, "--%s %s: give a time in seconds", option, text);
}

/* Text goes to snprintf later, so it may hold one %d with a width and no other percent sign. */
static bool parse_pattern(anim_args *out, const char *text) {
    const char *sign = strchr(text, '%');
    size_t digits = sign ? strspn(sign + 1, "0123456789") : 0;
    if (!option_output(program, "output", text, &out->output)) return false;
    if (sign && digits <= 2 && sign[1 + digits] == 'd' && !strchr(sign + 1, '%')) return true;
    return option_wrong(program, "-o %s: give a name with a number in it, such as frame%%04d.png",
                        text);
}

static bool parse_samples(anim_args *out, const char *text) {
    uint32_t count;
    if (!option_u32(program, "spp", text, 1, 256, &count)) return false;
    for (out->samples = 1; out->samples * out->samples < count;) ++out->samples;
    return true;
}

void anim_file_name(char *out, size_t size, const char *pattern, uint32_t index) {
    const char *sign = strchr(pattern, '%');
    const int width = (int)strspn(sign + 1, "0123456789");
    const bool zero = sign[1] == '0';
    int places = 0;
    for (int i = 0; i < width; ++i) places = 10 * places + (sign[1 + i] - '0');
    snprintf(out, size, zero ? "%.*s%0*u%s" : "%.*s%*u%s", (int)(sign - pattern), pattern, places,
             (unsigned)index, sign + 2 + width);
}

/* ---- Options -------------------------------------------------------------------------------- */

static bool take_option(anim_args *out, int option, const char *value) {
    switch (option) {
    case 'o': return parse_pattern(out, value);
    case 'q': return out->quiet = true;
    case OPTION_KIND: return option_kind(program, "kind", value, &out->kind);
    case OPTION_LAZY: return out->lazy = true;
    case OPTION_FRAMES: return option_u32(program, "frames", value, 1, 1000000, &out->frames);
    case OPTION_FROM: return parse_time("from", value, &out->has_from, &out->from);
    case OPTION_TO: return parse_time("to", value, &out->has_to, &out->to);
    case OPTION_EVERY: return option_u32(program, "every", value, 1, 1000000, &out->every);
    case OPTION_SIZE: return option_size(program, value, &out->width, &out->height);
    case OPTION_THREADS: return option_u32(program, "threads", value, 0, 1024, &out->threads);
    case OPTION_SPLIT: return option_u32(program, "split", value, 0, 6, &out->film.split);
    case OPTION_SPP: return parse_samples(out, value);
    case OPTION_PIPELINE: return out->pipeline = true;
    case OPTION_CHECK: return out->check = true;
    case OPTION_KEEP: return out->film.keep_coincident = true;
    case OPTION_STATS: return out->stats = true;
    case OPTION_MESH: return out->film.mesh = value, true;
    case OPTION_WEBP: return option_output(program, "webp", value, &out->webp);
    case OPTION_JSON: return option_output(program, "json", value, &out->json);
    default: return false;
    }
}

static bool check_together(anim_args *out, int argc, char **argv) {
    if (optind == argc) return option_wrong(program, "give a scene; see --help");
    if (argc - optind > 1)
        return option_wrong(program, "one scene at a time, not '%s' too", argv[optind + 1]);
    out->film.scene = argv[optind];
    if (out->film.mesh && strcmp(out->film.scene, "explode") != 0)
        return option_wrong(program, "--mesh is for the scene explode");
    if (out->pipeline && out->threads != 1)
        return option_wrong(program, "--pipeline has two threads of its own; leave --threads away");
    return true;
}

args_result anim_args_parse(anim_args *out, int argc, char **argv) {
    memset(out, 0, sizeof *out);
    out->kind = HTREE_H;
    out->width = 400;
    out->height = 300;
    out->threads = out->every = 1;
    out->samples = 2;
    const option_syntax syntax = {program, help, ":o:qhV", long_options};
    args_result result;
    for (int option; (option = option_next(&syntax, argc, argv, &result)) != -1;) {
        if (!take_option(out, option, optarg)) return ARGS_WRONG;
    }
    if (result != ARGS_RUN) return result;
    if (!check_together(out, argc, argv)) return ARGS_WRONG;
    out->threads = option_threads(out->threads);
    return ARGS_RUN;
}
