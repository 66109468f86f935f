/* anim_args.h: the command line of htree-animate. */
#ifndef EXAMPLES_ANIM_ARGS_H
#define EXAMPLES_ANIM_ARGS_H

#include "args.h"
#include "film.h"

typedef struct anim_args {
    film_wish film;
    htree_kind kind;
    uint32_t width, height, threads, samples; /* samples: a side of the grid in a pixel */
    uint32_t frames, every;                   /* frames 0: as the film says */
    bool has_from, has_to;
    double from, to;
    const char *output, *webp, *json; /* NULL: none */
    bool lazy, pipeline, check, stats, quiet;
} anim_args;

/* As args_parse. */
args_result anim_args_parse(anim_args *out, int argc, char **argv);

/* The name of picture `index`: `pattern` has one %d, maybe with a width as in %04d. */
void anim_file_name(char *out, size_t size, const char *pattern, uint32_t index);

#endif
