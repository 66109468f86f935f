/* paper_table.h: Table 1 of V. Havran, R. Herzog, H.-P. Seidel, "On the Fast Construction of
 * Spatial Hierarchies for Ray Tracing", 2006, to be compared with: one core of an Athlon 64 X2
 * 3800+. */
#ifndef EXAMPLES_PAPER_TABLE_H
#define EXAMPLES_PAPER_TABLE_H

#include "htree.h"

typedef struct paper_row {
    htree_kind kind;
    double nodes, leaves, references; /* in thousands */
    double intersections, traversal_steps, leaf_steps;
    double build, trace, total; /* seconds */
    double build_speedup, trace_speedup, total_speedup;
} paper_row;

typedef struct paper_scene {
    const char *name; /* "Bunny" */
    uint32_t primitives, width, height;
    paper_row rows[6]; /* the paper prints no row for the pure SKD-tree */
} paper_scene;

/* NULL if the paper has no scene of that name. */
const paper_scene *paper_find_scene(const char *name);

/* NULL for a NULL scene, and for a kind that the table lacks. */
const paper_row *paper_find_row(const paper_scene *scene, htree_kind kind);

#endif
