/* visible_args.h: the command line of htree-visibility. */
#ifndef EXAMPLES_VISIBLE_ARGS_H
#define EXAMPLES_VISIBLE_ARGS_H

#include "args.h"

typedef struct visible_args {
    const char *mesh_path; /* NULL: the built-in scene */
    char scene[32];
    uint64_t triangles, lines;
    const char *output; /* NULL: none */
    htree_kind kind;
    uint32_t width, height, segments, threads, seed;
    camera_wish camera;
    bool cell_given, quiet;
    htree_box cell;
} visible_args;

/* As args_parse. */
args_result visible_args_parse(visible_args *out, int argc, char **argv);

#endif
