/* duel_table.h: a duel as tables and as JSON. */
#ifndef EXAMPLES_DUEL_TABLE_H
#define EXAMPLES_DUEL_TABLE_H

#include "duel.h"

#include <stdio.h>

/* What is said of a scene above its tables. */
typedef struct duel_title {
    const char *scene, *note;
    uint64_t triangles;
    ray_wish wish;
    double reach; /* in units of the scene */
} duel_title;

/* The scene, builds, a table for each set of rays, and who agrees with whom. */
void duel_print(FILE *out, const duel *d, const duel_title *title);

/* An object per contender and set of rays that is not empty, with commas between; *first says
 * whether none stands before them. Numbers that are not finite become null. */
void duel_write_rows(FILE *file, const duel *d, const duel_title *title, bool *first);

#endif
