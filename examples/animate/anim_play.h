/* anim_play.h: frames posed, built and traced, one after the other or two at once. */
#ifndef EXAMPLES_ANIM_PLAY_H
#define EXAMPLES_ANIM_PLAY_H

#include "anim_report.h"
#include "progress.h"

/* One frame under way: filled by anim_build, then by anim_trace. */
typedef struct anim_slot {
    film_frame frame;
    htree *tree;
    camera view;
    htree_ray *rays;
    htree_hit *hits;
    anim_figures figures;
    char error[256]; /* "" if all is well */
} anim_slot;

typedef struct anim_stage {
    const anim_args *args;
    const film *f;
    const double *times;
    uint32_t count;
} anim_stage;

bool anim_slot_make(anim_slot *slot, const anim_stage *stage);
void anim_slot_free(anim_slot *slot);

/* Poses frame `index` and builds its tree, which replaces the one before; then traces it. False:
 * the slot's error says why. */
bool anim_build(anim_slot *slot, const anim_stage *stage, uint32_t index);
bool anim_trace(anim_slot *slot, const anim_stage *stage);

/* What tracing costs in steps; not part of any time. */
bool anim_count(anim_slot *slot, const anim_stage *stage);

/* Plays all frames with two slots and two threads, one that builds and one that traces; writes the
 * seconds that it took. */
bool anim_pipeline(anim_slot *slots, const anim_stage *stage, double *seconds);

#endif
