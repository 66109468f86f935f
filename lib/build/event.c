/* event.c: a radix sort of boundaries: three passes of 11 bits over the bits of the position. */
#include "event.h"

enum { RADIX_BITS = 11, RADIX = 1 << RADIX_BITS };

/* Orders floats as unsigned integers: negative ones are flipped whole, others get the sign bit. */
static uint32_t sort_key(float position) {
    uint32_t bits;
    position += 0.0f; /* -0 and 0 are one position */
    memcpy(&bits, &position, sizeof bits);
    return bits ^ (bits >> 31 ? 0xffffffffu : 0x80000000u);
}

/* A stable pass: events that are equal so far keep their order. */
static void radix_pass(const kd_event *from, kd_event *to, uint32_t count, uint32_t shift) {
    uint32_t start[RADIX] = {0};
    for (uint32_t i = 0; i < count; ++i) ++start[sort_key(from[i].position) >> shift & (RADIX - 1)];
    uint32_t sum = 0;
    for (uint32_t i = 0; i < RADIX; ++i) {
        const uint32_t size = start[i];
        start[i] = sum;
        sum += size;
    }
    for (uint32_t i = 0; i < count; ++i) {
        to[start[sort_key(from[i].position) >> shift & (RADIX - 1)]++] = from[i];
    }
}

/* Ends, then planars, then starts: the sort is stable, so this stays the order within a
 * position. */
static uint32_t write_events(const ht_builder *builder, uint32_t axis, kd_event *events) {
    uint32_t count = 0;
    for (uint32_t type = KD_END; type <= KD_START; ++type) {
        for (uint32_t i = 0; i < builder->tree->prim_count; ++i) {
            const ht_prim *prim = &builder->prims[i];
            const bool planar = prim->lo[axis] == prim->hi[axis];
            if (planar != (type == KD_PLANAR)) continue;
            events[count].position = type == KD_END ? prim->hi[axis] : prim->lo[axis];
            events[count].prim_and_type = i << 2 | type;
            ++count;
        }
    }
    return count;
}

htree_status kd_sorted_events(const ht_builder *builder, uint32_t axis, ht_stack_memory *stack,
                              kd_event **events, uint32_t *count) {
    const uint64_t bytes = 2 * (uint64_t)builder->tree->prim_count * sizeof(kd_event);
    kd_event *a = (kd_event *)ht_stack_push(stack, bytes);
    const ht_stack_mark mark = ht_stack_top(stack);
    kd_event *b = a ? (kd_event *)ht_stack_push(stack, bytes) : NULL;
    if (!b) return HTREE_ERROR_MEMORY;
    *count = write_events(builder, axis, b);
    radix_pass(b, a, *count, 0);
    radix_pass(a, b, *count, RADIX_BITS);
    radix_pass(b, a, *count, 2 * RADIX_BITS);
    ht_stack_pop(stack, mark);
    *events = a;
    return HTREE_OK;
}
