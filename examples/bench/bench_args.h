/* bench_args.h: the command line of htree-bench. */
#ifndef EXAMPLES_BENCH_ARGS_H
#define EXAMPLES_BENCH_ARGS_H

#include "args.h"
#include "bench_scene.h"
#include "duel.h"

enum { BENCH_MAX_SCENES = 64, BENCH_MAX_THREADS = 8 };

typedef struct bench_args {
    scene_wish scenes[BENCH_MAX_SCENES];
    uint32_t scene_count;
    const char *folder; /* of the catalogue's scenes */
    tree_config trees[DUEL_MAX_TREES];
    uint32_t tree_count;
    const char *device; /* NULL: none */
    peer_config peers[DUEL_MAX_PEERS];
    uint32_t peer_count;
    ray_wish wish;
    camera_wish camera;
    bool has_camera;
    uint32_t threads[BENCH_MAX_THREADS], thread_count, most_threads;
    uint32_t rounds;
    double seconds;
    const char *json, *load_rays, *save_rays; /* NULL: none */
    bool quiet, list_devices;
} bench_args;

/* As args_parse. Scenes, structures and threads that were not named are filled in. */
args_result bench_args_parse(bench_args *out, int argc, char **argv);

#endif
