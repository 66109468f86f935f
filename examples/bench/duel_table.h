/* duel_table.h: a duel as tables. */
#ifndef EXAMPLES_DUEL_TABLE_H
#define EXAMPLES_DUEL_TABLE_H

#include "duel.h"

#include <stdio.h>

/* What is said of a scene above its tables. */
typedef struct duel_title {
    const char *scene, *note;
    uint64_t triangles;
    uint32_t threads, seed;
} duel_title;

/* The scene, builds, a table for each set of rays, and who agrees with whom. */
void duel_print(FILE *out, const duel *d, const duel_title *title);

#endif
