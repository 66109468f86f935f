/* event.h: the boundaries of boxes along an axis, in order: what the kd-tree's plane sweep
 * reads. */
#ifndef HT_EVENT_H
#define HT_EVENT_H

#include "base/arena.h"
#include "build.h"

/* The order of types at one position: what ends there is not right of the plane, what starts
 * there is not left of it. */
enum { KD_END = 0, KD_PLANAR = 1, KD_START = 2 };

typedef struct kd_event {
    float position;
    uint32_t prim_and_type; /* index into the builder's prims << 2 | type */
} kd_event;

HT_INLINE uint32_t kd_event_type(const kd_event *event) {
    return event->prim_and_type & 3;
}

HT_INLINE uint32_t kd_event_prim(const kd_event *event) {
    return event->prim_and_type >> 2;
}

/* Puts the boundaries of all prims along `axis` onto the stack, sorted by position, then type.
 * O(N). */
htree_status kd_sorted_events(const ht_builder *builder, uint32_t axis, ht_stack_memory *stack,
                              kd_event **events, uint32_t *count);

#endif
