/* survey.h: what a mesh's arrays hold, before a refit changes anything in the tree. */
#ifndef HT_SURVEY_H
#define HT_SURVEY_H

#include "source.h"

/* The arrays in chunks, which any thread may take. */
typedef struct ht_survey {
    const htree *tree;
    ht_source source;
    uint32_t taken, done; /* chunks */
    uint32_t odd;         /* an index without vertex, or a coordinate or box out of range */
    uint32_t returning;   /* a prim that the tree was built without can be hit */
} ht_survey;

/* Finds the prims that the tree was built without, once for all surveys of it. */
htree_status ht_survey_begin(ht_survey *survey, htree *tree, const ht_source *source);

/* Surveys chunks until all are taken, and waits for those that other threads are at. Whether all
 * that the tree refers to is in range, and nothing else can be hit. */
bool ht_survey_help(ht_survey *survey);

/* After that, where something was odd: prim by prim whether the same prims as ever can be hit.
 * GEOMETRY if an index has no vertex. On all cores. */
htree_status ht_survey_closely(const ht_survey *survey, bool *same);

#endif
