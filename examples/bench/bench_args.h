/* bench_args.h: the command line of htree-bench. */
#ifndef EXAMPLES_BENCH_ARGS_H
#define EXAMPLES_BENCH_ARGS_H

#include "args.h"
#include "bench_scene.h"
#include "duel.h"

enum { BENCH_MAX_SCENES = 64 };

typedef struct bench_args {
    scene_wish scenes[BENCH_MAX_SCENES];
    uint32_t scene_count;
    const char *folder; /* of the catalogue's scenes */
    htree_kind kinds[DUEL_MAX_KINDS];
    uint32_t kind_count;
    const char *device;                /* NULL: none */
    const char *peers[DUEL_MAX_PEERS]; /* of peer_names */
    uint32_t peer_count;
    ray_wish wish;
    camera_wish camera;
    bool has_camera;
    uint32_t threads, rounds;
    double seconds;
    const char *json; /* NULL: none */
    bool quiet, list_devices;
} bench_args;

/* As args_parse. Scenes and kinds that were not named are filled in. */
args_result bench_args_parse(bench_args *out, int argc, char **argv);

#endif
