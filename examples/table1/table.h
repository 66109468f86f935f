/* table.h: rows of measure.h as the paper's Table 1, as JSON and as CSV. */
#ifndef EXAMPLES_TABLE_H
#define EXAMPLES_TABLE_H

#include "measure.h"
#include "paper_table.h"

#include <stddef.h>
#include <stdio.h>

enum { TABLE_MAX_WAYS = 16 };

/* A scene and its rows. */
typedef struct table_block {
    char name[64], note[160];
    const char *label;
    const paper_scene *paper;
    uint64_t triangles;
    uint32_t width, height, threads, row_count;
    measure_row rows[TABLE_MAX_WAYS];
} table_block;

/* As the paper calls a structure: "H-tree". */
const char *table_method_name(htree_kind kind);

/* A heading, a line per row, and below each the paper's own figures where it has the scene. */
void table_print_block(FILE *out, const table_block *block);

/* Mean, least and greatest of the three speed-ups over all blocks. */
void table_print_averages(FILE *out, const table_block *blocks, uint32_t count);

/* {"machine": ..., "command": ..., "rows": [...]}, a flat object per row; numbers that are not
 * finite become null. False writes one line to `error`. */
bool table_write_json(const table_block *blocks, uint32_t count, const char *machine,
                      const char *command, const char *path, char *error, size_t size);

/* The same rows below a line of names. */
bool table_write_csv(const table_block *blocks, uint32_t count, const char *path, char *error,
                     size_t size);

#endif
