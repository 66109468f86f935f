/* suite.h: what every test program starts from: seeded dice, the scale of a run, kinds, meshes,
 * trees.
 *
 * HTREE_TEST_SCALE scales the counts of a run, 1 by default; the runner lowers it for slow builds.
 */
#ifndef SUITE_H
#define SUITE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "htree.h"
#include "shapes.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SUITE_ASAN 1
#endif
#if __has_feature(thread_sanitizer)
#define SUITE_TSAN 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define SUITE_ASAN 1
#endif
#if defined(__SANITIZE_THREAD__)
#define SUITE_TSAN 1
#endif
#if defined(SUITE_ASAN) || defined(SUITE_TSAN)
#define SUITE_SANITIZED 1
#endif

/* The stack that the library promises to keep to is that of optimised code without sanitizers. */
#if defined(__OPTIMIZE__) && !defined(SUITE_SANITIZED)
#define SUITE_SMALL_STACK 1
#endif

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/* ---- Dice: the same numbers on every machine ------------------------------------------------ */

typedef struct dice {
    uint64_t state;
} dice;

uint32_t dice_u32(dice *d);
uint32_t dice_below(dice *d, uint32_t limit); /* 0 for a limit of 0 */
float dice_unit(dice *d);                     /* in [0, 1) */
float dice_between(dice *d, float lo, float hi);

/* The float `ulps` steps above x, or below for a negative count. */
float nudged(float x, int ulps);

/* ---- Runs ----------------------------------------------------------------------------------- */

/* count * HTREE_TEST_SCALE, at least 1. */
uint64_t scaled(uint64_t count);

/* Prints a line that the runner shows: what was counted. */
void say(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Prints a line that the runner adds up over all programs and holds against tests/bars.txt; `what` is
 * a name that stands there. */
void tally(const char *what, uint64_t count);

/* malloc that fails the test instead of returning NULL; exactly `bytes`, so that ASan sees the end.
 */
void *take(uint64_t bytes);

/* The kind after `kind` that this build of the library has, 0 after the last; starts from 0. */
htree_kind next_kind(htree_kind kind);

/* ---- Meshes and trees ----------------------------------------------------------------------- */

/* A shape that must be made; fails the test otherwise. */
shape shape_of(const char *name, uint64_t triangles, uint32_t seed);
htree_mesh mesh_of(const shape *s);

/* A mesh without indices: nine floats a triangle, borrowed. */
htree_mesh plain_mesh(const float *xyz, uint64_t triangles);

/* Corner 0, 1 or 2 of a triangle: three floats inside the mesh. */
const float *mesh_corner(const htree_mesh *mesh, uint64_t triangle, uint32_t corner);

/* An object that no ray meets. */
int32_t never_hit(void *user, uint32_t object, const htree_ray *ray, htree_hit *hit);

htree_options options_of(htree_kind kind);

/* Builds and proves the tree with htree_check; fails the test if either does not return HTREE_OK.
 */
htree *tree_of(const htree_mesh *mesh, const htree_options *options);
htree *tree_of_kind(const htree_mesh *mesh, htree_kind kind); /* default options, one thread */

htree_stats stats_of(const htree *tree);

htree_view view_of(const htree *tree);

/* The same bytes. */
void assert_same_trees(const htree *a, const htree *b);

/* Number of hits that are not the same 16 bytes. */
uint64_t hits_differ(const htree_hit *a, const htree_hit *b, uint64_t count);

/* Traces a batch, closest and any; returns how many answers are not what the hits in `truth` say. */
uint64_t batch_differs(const htree *tree, const htree_ray *rays, const htree_hit *truth,
                       uint64_t count);

#endif
