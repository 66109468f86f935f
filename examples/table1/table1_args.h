/* table1_args.h: the command line of htree-table1. */
#ifndef EXAMPLES_TABLE1_ARGS_H
#define EXAMPLES_TABLE1_ARGS_H

#include "args.h"
#include "bench_scene.h"

enum { TABLE1_MAX_SCENES = 64, TABLE1_MAX_KINDS = 16 };

typedef enum table1_mode { TABLE1_TABLE, TABLE1_GROWTH, TABLE1_PRECISION } table1_mode;

typedef struct table1_args {
    table1_mode mode;
    scene_wish scenes[TABLE1_MAX_SCENES];
    uint32_t scene_count;
    htree_kind kinds[TABLE1_MAX_KINDS]; /* in the order of the paper's table */
    uint32_t kind_count;
    const char *folder;     /* of the scenes */
    const char *json, *csv; /* NULL: none */
    uint64_t from, to;      /* sizes of TABLE1_GROWTH */
    uint32_t patience, width, height, threads, repeat, levels;
    camera_wish camera;
    bool quiet;
} table1_args;

/* As args_parse. Scenes that were not named are filled in. */
args_result table1_args_parse(table1_args *out, int argc, char **argv);

#endif
